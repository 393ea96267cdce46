"""The page of all columns: `python -m hcsearch.store.columns_page > docs/reference/columns.md`."""

from __future__ import annotations

from hcsearch.store.columns import VIEWS, Quantity

_HEAD = """# Columns

Views of the database and their columns. `make docs` writes this page from `hcsearch/store/columns.py`. A value is
NULL where its stage has not run. [Queries](queries.md) use the columns of `designs`; `hcsearch query --sql` reads all
views.
"""
_KINDS = {"integer": "whole number", "boolean": "0 or 1", "real": "number", "text": "text"}


def columns_page() -> str:
    """The page in Markdown: a table for each view."""
    tables = [_HEAD]
    for view, quantities in VIEWS.items():
        rows = "\n".join(map(_row, quantities))
        tables.append(f"## {view}\n\n| column | kind | unit | meaning |\n|---|---|---|---|\n{rows}\n")
    return "\n".join(tables)


def _row(quantity: Quantity) -> str:
    meaning = quantity.meaning + (f"; {quantity.better} is better" if quantity.better else "")
    return f"| `{quantity.name}` | {_KINDS[quantity.kind]} | {quantity.unit} | {meaning.replace('|', chr(92) + '|')} |"


if __name__ == "__main__":
    print(columns_page(), end="")
