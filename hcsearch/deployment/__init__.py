"""Deployment of a pattern in a scene: compiled to what it needs, simulated, and told as an outcome with its reason."""
