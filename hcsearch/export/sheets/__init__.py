"""Sheets to cut and crease."""
