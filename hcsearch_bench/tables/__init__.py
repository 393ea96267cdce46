"""The bench `tables`: how many designs there are."""
