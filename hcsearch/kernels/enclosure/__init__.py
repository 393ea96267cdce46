"""Compiled proofs that a box of fold angles holds no closed state, and floods of such boxes."""
