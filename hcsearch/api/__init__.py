"""The public functions of `hcsearch`, one for each job; the commands call them, too."""
