"""Deployments: a scene compiled to what it needs, simulated, certified, with one outcome and its reason."""

VERSION = 10
"""Raised when the same scene is simulated, certified or looked at otherwise: what is stored no longer counts."""
