"""Whether a folding can move: closed states, paths, locks, collisions, plans and certificates."""
