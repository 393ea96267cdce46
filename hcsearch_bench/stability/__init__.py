"""The bench `stability`: scenes over many decades, each with a verdict."""
