"""The bench `planning`: foldings settled against work, margin and thickness, and OMPL beside."""
