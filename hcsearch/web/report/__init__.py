"""Self-contained HTML pages on the designs of a query and on single designs. This package uses Jinja2."""
