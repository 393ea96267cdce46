"""Mobility and motion of linkages: ranks, closed states, paths, branches and locks."""
