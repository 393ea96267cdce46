"""Results to files: a file is written whole under its name, or not at all."""

from __future__ import annotations

import secrets
from contextlib import suppress
from pathlib import Path

from hcsearch.errors import QueryError
from hcsearch.store.formats import format_rows
from hcsearch.store.parquet import write_parquet
from hcsearch.store.rows import Rows


def save_rows(rows: Rows, style: str, path: Path) -> None:
    """Write a result to a file, in the place of an older one; text is UTF-8.

    QueryError: the file cannot be written, is a database, or the style cannot hold the result.
    """
    target = path.resolve()  # through a link, to the file itself
    part = target.with_name(f".{secrets.token_hex(8)}.part")
    try:
        _check_place(target)
        if style == "parquet":
            write_parquet(rows, part)
        else:
            with part.open("w", encoding="utf-8", newline="") as file:
                file.writelines(format_rows(rows, style))
        part.replace(target)
    except OSError as error:
        reason = f"{error.strerror or error}: make room, or name another file"
        raise QueryError(f"cannot write {str(path)!r}, {reason}") from error
    finally:
        with suppress(OSError):
            part.unlink()


def _check_place(target: Path) -> None:
    if target.exists() and not target.is_file():
        raise OSError("it is not a file")
    if target.is_file():
        with target.open("rb") as file:
            if file.read(15) == b"SQLite format 3":  # a slip in the order of two names
                raise OSError("it is a database")
