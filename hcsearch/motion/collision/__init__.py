"""Distances between panels: how far they are apart, how deep they cut into each other, and when they first do."""
