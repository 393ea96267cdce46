"""Deployments: a scene compiled to what it needs, simulated, certified, with one outcome and its reason."""

DEPLOYMENT_VERSION = 12
"""Raised when the same scene gives another result, reasons included: what is stored no longer counts."""
