"""Distances between panels: how deep they cut into each other, and when they first do."""
