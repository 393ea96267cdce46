"""Other engines on the same tasks: counters of circuits, multibody engines, distances, planners."""
