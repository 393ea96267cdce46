"""The data card of an atlas: README.md for people, and datapackage.json, a Data Package of Frictionless Data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import metadata, version
from pathlib import Path
from typing import Any

from hcsearch.basics.vocabulary import listed
from hcsearch.store.quantity import Quantity
from hcsearch.web.atlas.atlas_counts import COUNTED, BFile, SizeCounts
from hcsearch.web.atlas.atlas_folder import REQUEST_KEY
from hcsearch.web.atlas.atlas_request import AtlasRequest
from hcsearch.web.atlas.atlas_tables import PLACE_COLUMNS, TABLES, table_columns

DATABASE_FILE = "atlas.sqlite"
LICENCE = "CC BY 4.0"
LICENCE_ADDRESS = "https://creativecommons.org/licenses/by/4.0/"
_TYPES = {"integer": "integer", "boolean": "integer", "real": "number", "text": "string"}
"""Types of Data Packages; booleans are stored as 0 and 1."""


def citation(request: AtlasRequest) -> str:
    """Return how to cite the atlas."""
    return f"{metadata('hcsearch')['Author']}: {request.title}, made by hcsearch {version('hcsearch')}"


def card_text(
    request: AtlasRequest, counts: Mapping[tuple[str, int], SizeCounts], made: Sequence[BFile], certificates: int | None
) -> str:
    """Return README.md. certificates : their number; None if the stages that give proofs have not run."""
    parts = [
        f"# {request.title}",
        "Flat arrays of equal thick panels that fold into two stacks. A design is a closed walk through all panels of "
        "an array (a Hamiltonian circuit), up to rotation and reflection. This atlas holds every design with "
        f"{request.sizes[0][1]} to {request.n} panels on {listed(request.grids, 'and')}, taken through the stages of "
        f"the program hcsearch up to `{request.until}`. Verdicts are those of the scene `default`.",
        _files(made, certificates),
        "## Counts\n\nWhere designs are undecided, the numbers of those that open are lower bounds.\n\n"
        + _count_table(request, counts),
        *(f"## Columns of {view}\n\n" + _column_table((*PLACE_COLUMNS, *table_columns(view))) for view in TABLES),
        f"## Licence and citation\n\nThe data are published under {LICENCE}, {LICENCE_ADDRESS}. Please cite:\n\n"
        f"> {citation(request)}\n\nThe SHA-256 checksum of the file "
        "`SHA256SUMS` names exactly these files.",
        "## Versions\n\nThe same versions give the same bytes on the same kind of processor; elsewhere, last digits of "
        "measured quantities may differ.\n\n" + _version_table(request),
    ]
    return "\n\n".join(parts) + "\n"


def _files(made: Sequence[BFile], certificates: int | None) -> str:
    rows = [
        ("`index.html`", "a page that searches and draws the designs; open it in a browser, without a server"),
        *(
            (f"`{view}/GRID-N.parquet`", f"{view}; pandas, Arrow and DuckDB read the folder as one table")
            for view in TABLES
        ),
        (
            f"`{DATABASE_FILE}`",
            "an SQLite database with the views `designs`, `foldings`, `motions` and `deployments`; "
            "`hcsearch query --db` takes it",
        ),
    ]
    if certificates is not None:
        rows.append(
            (
                "`certificates/grid=GRID/n=N.zip`",
                f"{certificates:,} certificates of paths and locks, with an index; `hcsearch verify` checks one. "
                "Congruent foldings of a design share one",
            )
        )
    rows += [
        ("`bfiles/`", "counts in the form of the OEIS, `n a(n)`, as listed below"),
        ("`datapackage.json`", "this description for machines (Data Package)"),
        ("`SHA256SUMS`", "checksums; `sha256sum --check SHA256SUMS` checks them"),
    ]
    listed = "\n".join(f"- `{one.name}`: {one.title}" for one in made)
    return f"## Files\n\n{_markdown(('file', 'content'), rows)}\n\nCounts of designs:\n\n{listed}"


def _count_table(request: AtlasRequest, counts: Mapping[tuple[str, int], SizeCounts]) -> str:
    names = [quantity.name for quantity in COUNTED if request.has_run(quantity.stage)]
    rows = [
        (grid, str(n), *(f"{sizes[name]:,}" for name in names))
        for (grid, n), sizes in counts.items()
        if sizes["classes"]
    ]
    return _markdown(("grid", "n", *(name.replace("_", "-") for name in names)), rows)


def _column_table(columns: Sequence[Quantity]) -> str:
    return _markdown(
        ("column", "type", "unit", "meaning"), [(f"`{q.name}`", q.kind, q.unit, q.meaning) for q in columns]
    )


def _version_table(request: AtlasRequest) -> str:
    return _markdown(("of", "version"), list(request.record()["versions"].items()))


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def description_text(request: AtlasRequest, tables: Sequence[Path], others: Mapping[str, Sequence[str]]) -> str:
    """Return datapackage.json.

    tables : paths of the Parquet files. others : paths of the other files, by the name of their kind.
    """
    resources: list[dict[str, Any]] = [
        {
            "name": view,
            "path": [path.as_posix() for path in tables if path.parts[0] == view],
            "format": "parquet",
            "schema": {"fields": [_field(quantity) for quantity in (*table_columns(view), *PLACE_COLUMNS)]},
        }
        for view in TABLES
    ]
    resources += [{"name": name, "path": list(paths)} for name, paths in others.items()]
    description = {
        "name": "hcsearch-atlas",
        "title": request.title,
        "description": citation(request),
        "licenses": [{"name": "CC-BY-4.0", "path": LICENCE_ADDRESS}],
        "resources": [resource for resource in resources if resource["path"]],
        REQUEST_KEY: request.record(),
    }
    return json.dumps(description, indent=1) + "\n"


def _field(quantity: Quantity) -> dict[str, str]:
    field = {"name": quantity.name, "type": _TYPES[quantity.kind], "description": quantity.meaning}
    return field | ({"unit": quantity.unit} if quantity.unit else {})
