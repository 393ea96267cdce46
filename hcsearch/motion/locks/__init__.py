"""Locks: proofs that one-sided hinges hold a linkage in its folded or its flat state."""
