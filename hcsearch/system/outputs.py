"""Output files: written atomically, and never in place of a database."""

from __future__ import annotations

import os
import re
import secrets
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING
from zipfile import ZIP_DEFLATED, ZipInfo

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

from hcsearch.basics.errors import HcsearchError, OutputError

if TYPE_CHECKING:
    import pandas as pd

DEFAULT_OUTPUT_FOLDER = "reports"
"""The only folder, in the current one, that is created when an output needs it."""

TABLE_SUFFIXES = (".csv", ".npz", ".parquet")
"""File endings for tables."""
PICTURE_SUFFIXES = (".svg", ".png", ".pdf")

_SQLITE = b"SQLite format 3\0"
_OURS = b"hcSF"  # the application id in the header of our databases, `store.schema`
_OURS_AT = 68
_PART_NAME = re.compile(r"\.[0-9a-f]{16}\.part(\.\w+)?")
_COMPANIONS = ("-wal", "-shm", "-journal")


def check_output(path: str | Path, endings: tuple[str, ...] = ()) -> None:
    """Check, before anything is computed, that a file can be written.

    endings : allowed endings, such as `.csv`; any where empty. OutputError for another ending, a missing or read-only
    folder, and a path that must not be overwritten.
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
    """Check that a folder for outputs exists or can be created, and is writable; OutputError otherwise."""
    with _explained(path):
        target = _target(path)
        if target.is_dir():
            _check_access(target)
        elif os.path.lexists(target):
            raise OutputError(f"{path} is not a folder: name a folder")
        else:
            _check_parent(target, path)


def make_folder(path: str | Path) -> Path:
    """Create a folder for outputs unless it exists, and return its path."""
    check_folder(path)
    with _explained(path):
        Path(path).mkdir(parents=True, exist_ok=True)
    return Path(path)


@contextmanager
def replacing_file(path: str | Path, endings: tuple[str, ...] = ()) -> Iterator[Path]:
    """Yield a temporary file name; the file replaces `path` after the block, or is removed if the block fails.

    It has the ending of `path` and the mode of the file that it replaces; of a symbolic link, the target is replaced.
    OutputError as of `check_output`, and when the disk is full.
    """
    check_output(path, endings)
    target = _target(path)
    ending = Path(path).suffix if endings else ""
    created_folders: list[Path] = []
    part = None
    try:
        with _explained(path):
            created_folders = _make_parents(target)
            _remove_abandoned_parts(target.parent)
            part, lock = _new_part(target.parent, ending)
            with closing(lock):
                yield part
                _finish(part, target)
    except BaseException:
        _remove(part, created_folders)
        raise


def write_output(path: str | Path, text: str, endings: tuple[str, ...] = ()) -> None:
    """Write a text atomically to a UTF-8 file; characters that cannot be encoded become question marks."""
    with replacing_file(path, endings) as part:
        part.write_bytes(text.encode(errors="replace"))


def write_table(path: str | Path, table: pd.DataFrame, endings: tuple[str, ...] = TABLE_SUFFIXES) -> None:
    """Write a table atomically, in the format of the file's ending; Parquet needs the extra `parquet`."""
    with replacing_file(path, endings) as part:
        if part.suffix == ".csv":
            table.to_csv(part, index=False)
        elif part.suffix == ".npz":
            import numpy as np  # noqa: PLC0415 - commands start without it

            columns = {str(name): table[name].to_numpy() for name in table}
            texts = {name: values.astype(str) for name, values in columns.items() if values.dtype == object}
            np.savez_compressed(part, allow_pickle=False, **columns | texts)
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
    nearest_existing = next(place for place in (folder, *folder.parents) if os.path.lexists(place))
    default = Path(DEFAULT_OUTPUT_FOLDER).absolute()
    if not nearest_existing.is_dir() or (nearest_existing != folder and default not in (folder, *folder.parents)):
        raise OutputError(f"there is no folder {Path(path).parent}: make it, or write to another")
    _check_access(nearest_existing)


def _check_access(place: Path) -> None:
    if not os.access(place, os.W_OK):
        raise OSError(f"{place} may not be written")


def _check_place(target: Path) -> None:
    """Refuse devices, databases and their logs, which exchanged arguments would overwrite; OSError."""
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
    """Create the missing parent folders of a file, and return them, innermost first."""
    missing = [folder for folder in target.parents if not folder.exists()]
    target.parent.mkdir(parents=True, exist_ok=True)
    return missing


def _new_part(folder: Path, ending: str) -> tuple[Path, IO[bytes]]:
    """Create a temporary file, and return it with the open file that holds its lock where the system has such locks."""
    while True:
        part = folder / f".{secrets.token_hex(8)}.part{ending}"
        lock = part.open("xb")
        if fcntl is None:
            lock.close()  # Windows replaces no file that is open
            return part, lock
        with suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        if os.fstat(lock.fileno()).st_nlink:  # else another process took it for abandoned before it was locked
            return part, lock
        lock.close()


@cache  # once in a process: an export writes many files into a folder
def _remove_abandoned_parts(folder: Path) -> None:
    """Remove temporary files of killed processes from a folder: those whose lock nobody holds."""
    if fcntl is None:
        return
    with suppress(OSError):  # a folder whose names cannot be read
        for path in folder.iterdir():
            if _PART_NAME.fullmatch(path.name) and path.is_file() and not path.is_symlink():
                with suppress(OSError), path.open("rb") as lock:  # another process holds it
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    path.unlink()


def _finish(part: Path, target: Path) -> None:
    # a full disk may be reported only when buffers are flushed
    with part.open("rb+") as file:
        os.fsync(file.fileno())
    _check_place(target)  # checked again, since hours may have passed
    if target.exists():
        part.chmod(stat.S_IMODE(target.stat().st_mode))
    part.replace(target)


def _remove(part: Path | None, created_folders: list[Path]) -> None:
    with suppress(OSError):
        if part is not None:
            part.unlink()
    for folder in created_folders:
        with suppress(OSError):
            folder.rmdir()


_DATE = (1980, 1, 1, 0, 0, 0)  # the first that a zip archive can hold


def undated_entry(name: str) -> ZipInfo:
    """Return the entry of a zip archive for a compressed file, without a date, so that equal files make equal archives.

    Its owner may write the file, and all may read it.
    """
    entry = ZipInfo(name, _DATE)
    entry.compress_type = ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    return entry
