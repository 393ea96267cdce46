"""What a design looks like: patterns of panels, linkages in space, names and drawings."""
