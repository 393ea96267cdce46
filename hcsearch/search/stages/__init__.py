"""The stages of the search, each a pure function that adds columns to a batch of designs."""
