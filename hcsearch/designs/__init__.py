"""Designs: grids, arrays, circuits, foldings and their twist."""
