"""Patterns of the user's own: FOLD files read, recognised as designs, and taken through every stage."""
