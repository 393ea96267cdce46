"""The designs and foldings of an atlas as Parquet files, one for each grid and number of panels.

Grid and number of panels are columns of the files. In names of folders (`n=8`) pandas would read them as categories,
which do not compare with numbers.
"""

from __future__ import annotations

from pathlib import Path

from hcsearch.store import Database, Rows, select, stream, write_parquet_rows
from hcsearch.store.columns import VIEWS
from hcsearch.store.quantity import Quantity
from hcsearch.web.atlas.atlas_request import AtlasRequest

TABLES = ("designs", "foldings")
"""The views that are written."""
PLACE_COLUMNS = (Quantity("grid", "text", "", "tiling"), Quantity("n", "integer", "", "number of panels"))
"""Columns of both tables after those of `table_columns`; the view `foldings` does not have them."""
_LEFT_OUT = (*(quantity.name for quantity in PLACE_COLUMNS), "score")
"""Scores are of a user's own rank."""


def table_columns(view: str) -> tuple[Quantity, ...]:
    """Return the columns of the files of a view, without `PLACE_COLUMNS`."""
    return tuple(quantity for quantity in VIEWS[view] if quantity.name not in _LEFT_OUT)


def table_path(view: str, grid: str, n: int) -> Path:
    """Return the path of the file of a view for one size; the order of names is that of the sizes."""
    return Path(view, f"{grid}-{n:03}.parquet")


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
            (folder / view).mkdir(exist_ok=True)
            _write_table(database, view, query, (grid, n), folder / path, notes)
            written.append(path)
    return written


def _write_table(
    database: Database, view: str, query: str, size: tuple[str, int], path: Path, notes: dict[str, str]
) -> None:
    columns = (*table_columns(view), *PLACE_COLUMNS)
    described = {quantity.name: {"description": quantity.meaning, "unit": quantity.unit} for quantity in columns}
    with stream(database, query, view=view, columns=[quantity.name for quantity in table_columns(view)]) as rows:
        kinds = (*rows.kinds, *(quantity.kind for quantity in PLACE_COLUMNS))
        placed = ([(*row, *size) for row in chunk] for chunk in rows.chunks)
        write_parquet_rows(Rows(tuple(described), kinds, placed), path, described, notes)
