"""The folder of compiled kernels, in the user's cache, and the locks by which processes write there one at a time.

They order nothing but work: without them a kernel may be compiled twice at once, and one of the same files replaces the
other.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from contextlib import suppress
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numba

if TYPE_CHECKING:
    from filelock import BaseFileLock

_TOTAL = 512 * 2**20
"""Bytes to which the folder is pruned: some ten sets of kernels."""
_REMEDY = "set NUMBA_CACHE_DIR to a folder that can be written"
KERNEL_FILE_PATTERN, PART_FILE_PATTERN, LOCK_FILE_PATTERN = "*.kernel", "*.part", "*.lock"
"""Patterns of the files: finished ones, those that are being written, and those of who writes."""


def wanted_folder() -> Path:
    """Where compiled kernels are looked for first; `NUMBA_CACHE_DIR` names another place than the user's folder."""
    config: Any = numba.config
    if config.CACHE_DIR:
        return Path(config.CACHE_DIR).absolute() / "hcsearch"
    from platformdirs import user_cache_path  # noqa: PLC0415 - many a run imports kernels and calls none

    try:
        return user_cache_path("hcsearch", appauthor=False, opinion=False) / "kernels"
    except RuntimeError:  # no home folder is known
        return Path("~/.cache/hcsearch/kernels")


def writable_folder() -> Path | None:
    """Where kernels that are compiled now are kept: a temporary folder where the wanted one cannot be written.

    None where there is neither; stderr names the remedy, once.
    """
    return _writable(wanted_folder())


@cache
def _writable(wanted: Path) -> Path | None:
    try:
        _make(wanted)
    except OSError as error:
        trouble = f"compiled kernels cannot be kept in {wanted} ({error.strerror or error})"
    else:
        return wanted
    spare = Path(tempfile.gettempdir()) / f"hcsearch-{os.getuid() if hasattr(os, 'getuid') else 'kernels'}"
    try:
        _make(spare, 0o700)
        _check_private(spare)
    except OSError:
        warn_once(f"{trouble}: they are compiled at every start; {_REMEDY}")
        return None
    warn_once(f"{trouble} but are in {spare}; {_REMEDY}")
    return spare


def _make(folder: Path, mode: int = 0o777) -> None:
    """Make a folder in which a file can be written; OSError where it cannot."""
    if not folder.is_absolute():
        raise FileNotFoundError(0, "the user has no home folder")
    folder.mkdir(parents=True, exist_ok=True, mode=mode)
    with tempfile.TemporaryFile(dir=folder):
        pass


def _check_private(folder: Path) -> None:
    """Refuse a folder in which another user can put files: what is read there is run."""
    status = folder.lstat()
    if hasattr(os, "getuid") and (
        not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or status.st_mode & 0o022
    ):
        raise PermissionError


@cache
def warn_once(line: str) -> None:
    """Write a line to stderr, once however often it is said and however many processes work."""
    if parent_process() is None and sys.stderr is not None:
        with suppress(OSError):
            print(f"hcsearch: {line}", file=sys.stderr, flush=True)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that nobody sees a part of it; as readable as any other, as a folder may serve more users."""
    part = path.with_name(f"{path.stem}-{uuid4().hex}{PART_FILE_PATTERN[1:]}")
    try:
        part.write_bytes(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def prune_folder(folder: Path, total: int = _TOTAL) -> None:
    """Delete the files that have not been used for longest, until the others take no more than a total of bytes."""
    files = []
    for path in (
        path for pattern in (KERNEL_FILE_PATTERN, PART_FILE_PATTERN, LOCK_FILE_PATTERN) for path in folder.glob(pattern)
    ):
        with suppress(OSError):  # another process prunes, too
            status = path.stat()
            files.append((status.st_mtime, status.st_size, path))
    taken = 0
    for _, size, path in sorted(files, reverse=True):
        taken += size
        if taken > total:
            with suppress(OSError):
                path.unlink()


LOCK_TIMEOUT_SECONDS = 600.0
"""Seconds after which a kernel is compiled although another process, which may be suspended, says that it does so."""
_LOOK = 0.02  # s, between two looks


def claim_kernel(folder: Path, name: str) -> BaseFileLock:
    """Wait until no other process holds the name of a kernel's file, and hold it.

    Raises OSError where the folder's disk has no locks, or another process holds the name for longer than PATIENCE.
    """
    from filelock import FileLock  # noqa: PLC0415 - takes as long to import as kernels to be read, and few runs compile

    lock = FileLock(folder / f"{name}.lock", is_singleton=True)  # one that a process may take twice
    lock.acquire(timeout=LOCK_TIMEOUT_SECONDS, poll_interval=_LOOK)
    return lock


def release_kernel(lock: BaseFileLock) -> None:
    """Give a name back, and leave no file; who waits meanwhile finds the kernel."""
    lock.release()
    if not lock.is_locked:
        with suppress(OSError):
            Path(lock.lock_file).unlink()
