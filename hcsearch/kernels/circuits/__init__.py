"""Compiled loops over circuits: listing, canonical words, half-chains, frontier states, foldings."""
