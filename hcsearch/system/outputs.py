"""Files that commands write: each is whole under its name or is not there, and none takes the place of a database."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.basics.errors import HcsearchError, OutputError

if TYPE_CHECKING:
    import pandas as pd

DEFAULT_OUTPUT_FOLDER = "reports"
"""The only folder that is made for an output when it is missing, in the current folder."""

TABLE_SUFFIXES = (".csv", ".npz", ".parquet")
"""Endings of files that tables of a motion are written to."""
PICTURE_SUFFIXES = (".svg", ".png", ".pdf")

_SQLITE = b"SQLite format 3\0"
_OURS = b"hcSF"  # the application id in the header of our databases, `store.schema`
_OURS_AT = 68
_COMPANIONS = ("-wal", "-shm", "-journal")


def check_output(path: str | Path, endings: tuple[str, ...] = ()) -> None:
    """Refuse a file that could not be written, before anything is computed.

    endings : those that it may have, such as `.csv`; any where empty. OutputError: the ending, the folder, the place.
    """
    if endings and Path(path).suffix not in endings:
        raise OutputError(f"{path} has no known ending: write {', '.join(endings)}")
    with _explained(path):
        target = _target(path)
        if target.is_dir():
            raise OutputError(f"{Path(path)} is a folder: name a file")
        _check_parent(target, path)
        _check_place(target)


def check_folder(path: str | Path) -> None:
    """Refuse a folder of outputs that is a file, cannot be written, or lies in a folder that is missing."""
    with _explained(path):
        target = _target(path)
        if target.is_dir():
            _check_access(target)
        elif os.path.lexists(target):
            raise OutputError(f"{path} is not a folder: name a folder")
        else:
            _check_parent(target, path)


def make_folder(path: str | Path) -> Path:
    """Make a folder of outputs where it is missing, and return its path."""
    check_folder(path)
    with _explained(path):
        Path(path).mkdir(parents=True, exist_ok=True)
    return Path(path)


@contextmanager
def replacing_file(path: str | Path, endings: tuple[str, ...] = ()) -> Iterator[Path]:
    """Give the name of a file to write, which takes the place of `path` when the block is done; else it is removed.

    Its ending is that of `path`, its mode that of the file which it replaces; through a link, the file itself is
    replaced. OutputError, as from `check_output`, also when the block fails for want of room.
    """
    check_output(path, endings)
    target = _target(path)
    part = target.with_name(f".{secrets.token_hex(8)}.part{Path(path).suffix if endings else ''}")
    made: list[Path] = []
    try:
        with _explained(path):
            made = _make_parents(target)
            yield part
            _finish(part, target)
    except BaseException:
        _remove(part, made)
        raise


def write_output(path: str | Path, text: str, endings: tuple[str, ...] = ()) -> None:
    """Write a text as UTF-8 to a file, as `replacing_file` does; what is no text becomes a question mark."""
    with replacing_file(path, endings) as part:
        part.write_bytes(text.encode(errors="replace"))


def write_table(path: str | Path, table: pd.DataFrame, endings: tuple[str, ...] = TABLE_SUFFIXES) -> None:
    """Write a table to a file by its ending; Parquet needs the extra `parquet`."""
    with replacing_file(path, endings) as part:
        if part.suffix == ".csv":
            table.to_csv(part, index=False)
        elif part.suffix == ".npz":
            import numpy as np  # noqa: PLC0415 - commands start without it

            np.savez_compressed(part, allow_pickle=False, **{str(name): table[name].to_numpy() for name in table})
        else:
            try:
                table.to_parquet(part, index=False)
            except ImportError as error:
                raise HcsearchError("Parquet needs an extra: pip install 'hcsearch[parquet]', or write .csv") from error


@contextmanager
def _explained(path: str | Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _refusal(path, str(error.strerror or error)) from error


def _refusal(path: str | Path, reason: str) -> OutputError:
    return OutputError(f"cannot write {str(path)!r}, {reason}: make room, or name another file")


def _target(path: str | Path) -> Path:
    if "\0" in str(path):
        raise _refusal(path, "its name holds a zero byte")
    try:
        return Path(os.path.realpath(path))
    except UnicodeEncodeError as error:  # half of a character
        raise _refusal(path, "no file has such a name") from error


def _check_parent(target: Path, path: str | Path) -> None:
    folder = target.parent
    there = next(place for place in (folder, *folder.parents) if os.path.lexists(place))
    default = Path(DEFAULT_OUTPUT_FOLDER).absolute()
    if not there.is_dir() or (there != folder and default not in (folder, *folder.parents)):
        raise OutputError(f"there is no folder {Path(path).parent}: make it, or write to another")
    _check_access(there)


def _check_access(place: Path) -> None:
    if not os.access(place, os.W_OK):
        raise OSError(f"{place} may not be written")


def _check_place(target: Path) -> None:
    """Refuse devices, databases and their logs, which a slip in the order of two names would overwrite."""
    try:
        kind = target.lstat()
    except FileNotFoundError:
        kind = None
    if kind is not None:
        if not stat.S_ISREG(kind.st_mode):
            raise OSError("it is not a file")
        _check_access(target)
    for suffix in ("", *_COMPANIONS):
        owner = target.name.removesuffix(suffix)
        if owner and target.name.endswith(suffix) and _is_database(target.with_name(owner)):
            raise OSError("it belongs to a database" if suffix else "it is a database")


def _is_database(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(_OURS_AT + len(_OURS))
    return head.startswith(_SQLITE) or head[_OURS_AT:] == _OURS


def _make_parents(target: Path) -> list[Path]:
    """Make the folders above a file, and return those that were missing, innermost first."""
    missing = [folder for folder in target.parents if not folder.exists()]
    target.parent.mkdir(parents=True, exist_ok=True)
    return missing


def _finish(part: Path, target: Path) -> None:
    # A disk may refuse only now what it seemed to take.
    with part.open("rb+") as file:
        os.fsync(file.fileno())
    _check_place(target)  # again: hours may have passed
    if target.exists():
        part.chmod(stat.S_IMODE(target.stat().st_mode))
    part.replace(target)


def _remove(part: Path, made: list[Path]) -> None:
    with suppress(OSError):
        part.unlink()
    for folder in made:
        with suppress(OSError):
            folder.rmdir()
