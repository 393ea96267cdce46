"""The database: its schema and upgrades, recording finished work, and queries. The only home of SQLAlchemy and Alembic.

The names below are looked up on first use, so that reading `hcsearch.store.columns` (for --help) costs no SQLAlchemy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hcsearch.system.lazy import importing

if TYPE_CHECKING:
    from hcsearch.store.columns import VIEWS, Quantity, column_names
    from hcsearch.store.database import Database, open_database, open_readonly
    from hcsearch.store.files import save_rows
    from hcsearch.store.formats import FORMATS, format_rows
    from hcsearch.store.judgements import (
        StoredPath,
        StoredVerdict,
        best_creases,
        find_paths,
        find_verdict,
        foldings_with_paths,
    )
    from hcsearch.store.location import room_at
    from hcsearch.store.pages import SlowQueryError, count_rows, select_page
    from hcsearch.store.queries import (
        check_scene,
        find_circuit,
        find_design,
        grids_in,
        select,
        select_sql,
        stream,
        stream_sql,
    )
    from hcsearch.store.results import find_evaluations, record_evaluations, record_units, save_scores
    from hcsearch.store.rows import Result, Rows
    from hcsearch.store.summaries import Summary, rows_of_designs, summarize
    from hcsearch.store.verdicts import (
        find_scene,
        record_scene,
        record_settled,
        record_verdicts,
        scene_names,
        undecided,
    )
    from hcsearch.store.views import SCENIC, asks_for
    from hcsearch.store.writing import count_arrays, finish_run, finished_batches, record_batches, start_run

_HOMES = {
    "columns": ("VIEWS", "Quantity", "column_names"),
    "database": ("Database", "open_database", "open_readonly"),
    "files": ("save_rows",),
    "formats": ("FORMATS", "format_rows"),
    "judgements": (
        *("StoredPath", "StoredVerdict", "best_creases"),
        *("find_paths", "find_verdict", "foldings_with_paths"),
    ),
    "location": ("room_at",),
    "pages": ("SlowQueryError", "count_rows", "select_page"),
    "queries": (
        *("check_scene", "find_circuit", "find_design", "grids_in"),
        *("select", "select_sql", "stream", "stream_sql"),
    ),
    "results": ("find_evaluations", "record_evaluations", "record_units", "save_scores"),
    "rows": ("Result", "Rows"),
    "summaries": ("Summary", "rows_of_designs", "summarize"),
    "verdicts": ("find_scene", "record_scene", "record_settled", "record_verdicts", "scene_names", "undecided"),
    "views": ("SCENIC", "asks_for"),
    "writing": ("count_arrays", "finish_run", "finished_batches", "record_batches", "start_run"),
}

__all__ = [
    "FORMATS",
    "SCENIC",
    "VIEWS",
    "Database",
    "Quantity",
    "Result",
    "Rows",
    "SlowQueryError",
    "StoredPath",
    "StoredVerdict",
    "Summary",
    "asks_for",
    "best_creases",
    "check_scene",
    "column_names",
    "count_arrays",
    "count_rows",
    "find_circuit",
    "find_design",
    "find_evaluations",
    "find_paths",
    "find_scene",
    "find_verdict",
    "finish_run",
    "finished_batches",
    "foldings_with_paths",
    "format_rows",
    "grids_in",
    "open_database",
    "open_readonly",
    "record_batches",
    "record_evaluations",
    "record_scene",
    "record_settled",
    "record_units",
    "record_verdicts",
    "room_at",
    "rows_of_designs",
    "save_rows",
    "save_scores",
    "scene_names",
    "select",
    "select_page",
    "select_sql",
    "start_run",
    "stream",
    "stream_sql",
    "summarize",
    "undecided",
]

__getattr__ = importing(__name__, _HOMES)
