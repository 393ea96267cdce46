"""Foundations of all other packages: errors, shared vocabulary, array types, equality by value."""
