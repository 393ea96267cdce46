"""The bench `collision`: distances of panels, beside coal."""
