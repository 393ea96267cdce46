"""What `from hcsearch import ...` gives beside values: one function for each job, which the commands call, too."""
