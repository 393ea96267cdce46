"""Compiled loops that only measurements need."""
