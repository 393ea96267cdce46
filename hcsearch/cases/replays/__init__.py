"""Motions as they are shown and handed on: a few states, named panels and hinges, and what is certified."""
