"""The stages of the search, each a pure function from a batch to columns, in order."""
