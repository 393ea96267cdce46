"""Crease patterns for origami software."""
