"""Dynamics of panels and hinges: trees of bodies with closed loops, what acts on them, and their motion."""
