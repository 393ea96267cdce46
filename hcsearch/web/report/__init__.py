"""Self-contained HTML pages: of the designs that a query selects, and of one design. The home of Jinja2."""
