"""The bench `mobility`: time of a folding, locks, and what frees them."""
