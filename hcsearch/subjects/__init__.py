"""Cases: the subjects of commands and calls, resolved once from names, files and ids of a database."""
