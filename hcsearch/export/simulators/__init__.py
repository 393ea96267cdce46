"""Scenes as models of simulators."""
