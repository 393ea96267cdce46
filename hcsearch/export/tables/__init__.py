"""Motions as tables, and arrays as graphs."""
