"""Closed states of linkages and the ranks of their closure."""
