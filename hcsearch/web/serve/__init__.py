"""Read-only web pages on a database, for this machine. Only this package uses Werkzeug and waitress."""
