"""Dynamics of panels and hinges: trees of bodies with closed loops, the forces on them, and their motion."""
