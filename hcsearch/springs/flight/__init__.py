"""Numbers by which an engineer of space mechanisms chooses a folding: margins, frequencies, shocks, shape, stowage."""
