"""The designs and foldings of an atlas as Parquet files in folders by grid and number of panels."""

from __future__ import annotations

from pathlib import Path

from hcsearch.store import Database, select, stream, write_parquet_rows
from hcsearch.store.columns import VIEWS, Quantity
from hcsearch.web.atlas.atlas_request import AtlasRequest

TABLES = ("designs", "foldings")
"""The views that are written."""
_LEFT_OUT = ("grid", "n", "score")
"""Columns that the files lack: two stand in the names of folders, and scores are of a user's own rank."""


def table_columns(view: str) -> tuple[Quantity, ...]:
    """Return the columns of the files of a view."""
    return tuple(quantity for quantity in VIEWS[view] if quantity.name not in _LEFT_OUT)


def table_path(view: str, grid: str, n: int) -> Path:
    """Return the path of the file of a view for one size, in the layout of Hive partitions."""
    return Path(view, f"grid={grid}", f"n={n}", f"{view}.parquet")


def write_tables(database: Database, folder: Path, request: AtlasRequest, notes: dict[str, str]) -> list[Path]:
    """Write the files of all sizes that have designs, in the order of sizes; return their paths in the folder.

    notes : metadata of each file.
    """
    written = []
    for grid, n in request.sizes:
        size = f"grid={grid} n={n}"
        bounds = [select(database, size, columns="id", sort=sort, limit=1).rows for sort in ("id", "-id")]
        if not bounds[0]:
            continue
        # the designs of one size are numbered one after the other
        ((first,),), ((last,),) = bounds
        for view, query in zip(TABLES, (size, f"design_id>={first} design_id<={last}"), strict=True):
            path = table_path(view, grid, n)
            _write_table(database, view, query, folder / path, notes)
            written.append(path)
    return written


def _write_table(database: Database, view: str, query: str, path: Path, notes: dict[str, str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    columns = table_columns(view)
    described = {quantity.name: {"description": quantity.meaning, "unit": quantity.unit} for quantity in columns}
    with stream(database, query, view=view, columns=[quantity.name for quantity in columns]) as rows:
        write_parquet_rows(rows, path, described, notes)
