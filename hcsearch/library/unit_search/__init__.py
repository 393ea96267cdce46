"""Search for single-DoF units, which are copies of one element that share panels and hinges, with their proofs."""
