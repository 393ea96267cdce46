"""`python -m hcsearch` is the command line."""

from hcsearch.cli import main

main()
