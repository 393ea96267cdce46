"""Tuning of springs: stiffnesses with which an array becomes flat without a collision (thesis 4.4)."""
