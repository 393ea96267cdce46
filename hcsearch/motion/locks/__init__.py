"""Locks: proofs that a linkage cannot leave an end of its motion, or cannot move from one end to the other."""
