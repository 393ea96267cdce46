"""Web pages: reports on designs, the player of motions, and the server."""
