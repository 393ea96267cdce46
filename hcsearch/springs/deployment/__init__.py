"""Deployments: a scene is compiled to the terms it needs, simulated and certified; one outcome with its reason."""

DEPLOYMENT_VERSION = 16
"""Increased when the same scene gives another result or reason, so that stored results no longer count."""
