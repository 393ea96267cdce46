"""Tuning of springs: stiffnesses with which an array comes flat without a collision (thesis 4.4)."""
