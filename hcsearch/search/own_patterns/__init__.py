"""Patterns of users: FOLD files are read, recognised as designs, and taken through every stage."""
