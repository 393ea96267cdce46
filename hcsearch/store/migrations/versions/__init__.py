"""One frozen file a schema version, numbered with four digits."""
