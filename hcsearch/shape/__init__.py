"""The shape of designs: patterns of panels, linkages in space, labels and drawings."""
