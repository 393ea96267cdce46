"""Metadata of the views for Datasette, as JSON: `python -m hcsearch.store.datasette_dump > db/datasette.json`."""

from __future__ import annotations

import json
import sys

from hcsearch.store.columns import VIEWS


def datasette_json(name: str = "hcsearch") -> str:
    """Meaning of each column of the views, and units of numbers; name : of the database, its file without ending."""
    tables = {
        view: {
            "columns": {quantity.name: quantity.note for quantity in quantities},
            # of numbers alone, as Datasette multiplies values by them
            "units": {
                quantity.name: quantity.unit for quantity in quantities if quantity.unit and quantity.kind == "real"
            },
        }
        for view, quantities in VIEWS.items()
    }
    about = {"title": "hcsearch: designs of flat arrays of thick panels that fold into two stacks"}
    metadata = {**about, "databases": {name: {"tables": tables}}}
    return json.dumps(metadata, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(datasette_json())
