"""Compiled loops of motion planning: closed states, contact, trees of states, and proofs that a path is closed."""
