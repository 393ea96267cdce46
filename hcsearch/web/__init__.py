"""What is shown: pages of designs, the player of motions, and the server."""
