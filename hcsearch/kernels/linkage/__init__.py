"""Compiled loops over linkages: closure, hinge lines, cones of velocities, where panels are."""
