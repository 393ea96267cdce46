"""Panels as solids, for CAD systems, printers and viewers."""
