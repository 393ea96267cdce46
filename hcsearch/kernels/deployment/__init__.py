"""Compiled loops over whole deployments: simulated, and certified."""
