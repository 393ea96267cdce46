"""Measurements of hcsearch: printed with the machine and versions, and never asserted in a test."""
