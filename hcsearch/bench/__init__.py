"""Measurements: speed is measured here, printed with the machine and versions, and never asserted in a test."""
