"""Compiled loops over pairs of panels: distances, overlaps, and clearance certified over motions."""
