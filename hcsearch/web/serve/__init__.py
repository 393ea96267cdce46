"""Read-only web pages over a database, for this machine. The only home of Werkzeug and waitress."""
