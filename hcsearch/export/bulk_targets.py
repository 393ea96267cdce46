"""Targets of the export of many designs: a folder, a zip archive, or one file of graphs.

All are written atomically: each file of a folder by itself, an archive or a file of graphs as a whole. A folder and an
archive have an index, `index.csv`, with a row for each design. The index of a folder tells which of its files are of
the same inputs, so that an interrupted export continues where it ended.
"""

from __future__ import annotations

import csv
import io
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import IO, Literal, Protocol
from zipfile import ZIP_DEFLATED, ZipFile

from hcsearch.basics.errors import OutputError
from hcsearch.export.formats import ExportFormat, export_format_of, format_named
from hcsearch.system.outputs import check_folder, check_output, make_folder, replacing_file, undated_entry, write_output
from hcsearch.system.reading import read_text_file

BulkKind = Literal["folder", "archive", "graphs"]
INDEX_FILE_NAME = "index.csv"
INDEX_SECONDS = 5.0
"""Time after which the index of a folder is written again, s: what a killed process has to write anew."""
_MAX_INDEX_BYTES = 2**30


@dataclass(frozen=True)
class IndexRow:
    """The row of a design in an index.

    file : name of its main file; empty where none was written. id : in the database. design : notation of the circuit
    or the folding. note : what users should know of the file, or why there is none. inputs : digest of all that the
    file depends on.
    """

    file: str
    id: int
    design: str
    note: str
    inputs: str


_COLUMNS = tuple(field.name for field in fields(IndexRow))


class BulkTarget(Protocol):
    """Where the files of designs are written."""

    def holds(self, row: IndexRow) -> bool:
        """Return whether a file was written before from the same inputs; if so, keep it."""

    def add(self, row: IndexRow, files: Mapping[str, bytes]) -> None:
        """Write the files of a design by name; none for a design that is left out."""


def bulk_kind_of(path: str, format_name: str | None) -> tuple[BulkKind, ExportFormat]:
    """Return the kind of a target and the format of its files; OutputError where they are unknown or do not fit.

    A path that ends in `.zip` is an archive; one with another ending is a file, unless it is a folder or ends in `/`.
    """
    is_archive = Path(path).suffix.lower() == ".zip"
    exists = os.path.isdir(path)  # noqa: PTH112 - a name that no file can have is none, and refused below
    is_folder = bool(path) and (exists or path.endswith(("/", "\\")) or not Path(path).suffix)
    if not is_archive and not is_folder:
        export_format = export_format_of(path, format_name)
        if not export_format.joins:
            raise OutputError(
                f"{path} is one file, and a query may have several designs: name a folder or a file .zip, and "
                f"--format {export_format.name}"
            )
        check_output(path)
        return "graphs", export_format
    if format_name is None:
        raise OutputError(f"{path} does not say which files it gets: choose their format with --format")
    export_format = format_named(format_name)
    if is_archive:
        check_output(path)
        return "archive", export_format
    check_folder(path)
    return "folder", export_format


@contextmanager
def open_bulk_target(path: str, kind: BulkKind) -> Iterator[BulkTarget]:
    """Open a target, and finish it after the block; what is a single file is removed if the block fails."""
    if kind == "folder":
        folder = _Folder(Path(path))
        try:
            yield folder
        finally:
            folder.write_index()
        return
    with replacing_file(path) as part:
        if kind == "graphs":
            with part.open("wb") as file:
                yield _Graphs(file)
        else:
            with ZipFile(part, "w", ZIP_DEFLATED) as archive:
                target = _Archive(archive)
                yield target
                target.write_index()


class _Folder:
    """A folder of files, with the index of those that are in it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._rows = {_key(row): row for row in _read_index(path / INDEX_FILE_NAME)}
        self._written_at = time.monotonic()

    def holds(self, row: IndexRow) -> bool:
        old = self._rows.get(_key(row))
        return old is not None and bool(row.file) and old.inputs == row.inputs and (self._path / row.file).is_file()

    def add(self, row: IndexRow, files: Mapping[str, bytes]) -> None:
        if files:
            make_folder(self._path)
        for name, content in reversed(list(files.items())):  # the main file last: where it is, the others are
            with replacing_file(self._path / name) as part:
                part.write_bytes(content)
        if row.file:
            self._rows.pop(str(row.id), None)  # the design may have been left out before
        self._rows[_key(row)] = row
        if time.monotonic() - self._written_at > INDEX_SECONDS:
            self.write_index()

    def write_index(self) -> None:
        if any(row.file for row in self._rows.values()):
            write_output(self._path / INDEX_FILE_NAME, _index_text(self._rows.values()))
        self._written_at = time.monotonic()


class _Archive:
    """A zip archive that is written anew, with an index as its last file."""

    def __init__(self, archive: ZipFile) -> None:
        self._archive = archive
        self._rows: list[IndexRow] = []

    def holds(self, row: IndexRow) -> bool:
        return False

    def add(self, row: IndexRow, files: Mapping[str, bytes]) -> None:
        for name, content in files.items():
            self._write(name, content)
        self._rows.append(row)

    def write_index(self) -> None:
        self._write(INDEX_FILE_NAME, _index_text(self._rows).encode())

    def _write(self, name: str, content: bytes) -> None:
        self._archive.writestr(undated_entry(name), content)


class _Graphs:
    """One file of graphs, one a line."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def holds(self, row: IndexRow) -> bool:
        return False

    def add(self, row: IndexRow, files: Mapping[str, bytes]) -> None:
        self._file.writelines(files.values())


def _key(row: IndexRow) -> str:
    """Return what distinguishes rows of an index: the file, or the design that has none."""
    return row.file or str(row.id)


def _index_text(rows: Iterable[IndexRow]) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    writer.writerows(astuple(row) for row in rows)
    return text.getvalue()


def _read_index(path: Path) -> Iterator[IndexRow]:
    """Read the index of an earlier export; OutputError for a file of the same name with other columns."""
    if not path.exists():
        return
    reader = csv.reader(io.StringIO(read_text_file(path, max_bytes=_MAX_INDEX_BYTES), newline=""))
    try:
        if tuple(next(reader, ())) != _COLUMNS:
            raise ValueError
        for file, number, design, note, inputs in reader:
            yield IndexRow(file, int(number), design, note, inputs)
    except (ValueError, csv.Error) as error:
        raise OutputError(f"{path} is no index of an export: move it, or name another folder") from error
