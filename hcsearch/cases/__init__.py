"""Cases: what a command or a call works on, resolved from names, files and ids of a database once, at the door."""
