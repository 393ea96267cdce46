"""Search over many designs: enumeration of circuits, stages of checks, ranking, and storage."""
