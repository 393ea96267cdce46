"""The bench `dynamics`: error against run time of deployments, beside other engines."""
