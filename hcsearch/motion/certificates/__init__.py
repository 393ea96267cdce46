"""Certificates of paths and of locks: plain data, and checkers that import nothing of the search."""
