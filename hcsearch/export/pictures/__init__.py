"""Moving pictures for web pages."""
