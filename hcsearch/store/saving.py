"""Results to files: a file is written whole under its name, or not at all."""

from __future__ import annotations

from pathlib import Path

from hcsearch.store.formats import format_rows
from hcsearch.store.parquet import write_parquet
from hcsearch.store.rows import Rows
from hcsearch.system.outputs import replacing


def save_rows(rows: Rows, style: str, path: Path) -> None:
    """Write a result to a file, in the place of an older one; text is UTF-8.

    OutputError: the file cannot be written, or is a database. QueryError: the style cannot hold the result.
    """
    with replacing(path) as part:
        if style == "parquet":
            write_parquet(rows, part)
        else:
            with part.open("w", encoding="utf-8", newline="") as file:
                file.writelines(format_rows(rows, style))
