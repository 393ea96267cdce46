"""The folder of compiled kernels, in the user's cache, and file locks against compiling a kernel twice.

Kernels are kept where nobody but the user and root can write, since they are code: see `own_folders`.

The locks only save work: without them two processes may compile the same kernel at once, and one of two equal files
replaces the other.
"""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import suppress
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numba

from hcsearch.kernels.compiling.own_folders import check_own_folder, make_own_folder

if TYPE_CHECKING:
    from filelock import BaseFileLock

_MAX_FOLDER_SIZE = 512 * 2**20
"""Size (bytes) to which the folder is pruned: about ten sets of kernels."""
REMEDY = "set NUMBA_CACHE_DIR to a folder that only you can write"
KERNEL_FILE_PATTERN, PART_FILE_PATTERN, LOCK_FILE_PATTERN, CALLS_FILE_PATTERN = (
    "*.kernel",
    "*.part",
    "*.lock",
    "*.calls",
)
"""File patterns: finished kernels, partly written files, locks, and names of the kernels that a job calls."""


def wanted_folder() -> Path:
    """Return the preferred folder of compiled kernels: in `NUMBA_CACHE_DIR` if set, else in the user's cache."""
    config: Any = numba.config
    if config.CACHE_DIR:
        return Path(config.CACHE_DIR).absolute() / "hcsearch"
    from platformdirs import user_cache_path  # noqa: PLC0415 - many a run imports kernels and calls none

    try:
        return user_cache_path("hcsearch", appauthor=False, opinion=False) / "kernels"
    except RuntimeError:  # no home folder is known
        return Path("~/.cache/hcsearch/kernels")


def readable_folder() -> Path | None:
    """Return the preferred folder of compiled kernels; None if others might have put code into it."""
    return _readable(wanted_folder())


@cache  # while it is there, others cannot put another into its place
def _readable(preferred: Path) -> Path | None:
    try:
        check_own_folder(preferred)
    except OSError:
        return None
    return preferred


def writable_folder() -> Path | None:
    """Return the folder that new kernels are written to: the preferred one, or else a temporary folder.

    Returns None if neither can be written, or if others can write to both. A single warning on stderr names the remedy.
    """
    return _writable(wanted_folder())


@cache
def _writable(preferred: Path) -> Path | None:
    try:
        _prepare(preferred, 0o755)
    except OSError as error:
        problem = f"compiled kernels cannot be kept in {preferred} ({error.strerror or error})"
    else:
        return preferred
    fallback = Path(tempfile.gettempdir()) / f"hcsearch-{os.geteuid() if hasattr(os, 'geteuid') else 'kernels'}"
    try:
        _prepare(fallback, 0o700)
    except OSError:
        warn_once(f"{problem}: they are compiled at every start; {REMEDY}")
        return None
    warn_once(f"{problem} but are in {fallback}; {REMEDY}")
    return fallback


def _prepare(folder: Path, mode: int) -> None:
    """Create a folder, and check that files can be written there and by whom; raises OSError otherwise."""
    if not folder.is_absolute():
        raise FileNotFoundError(0, "the user has no home folder")
    make_own_folder(folder, mode)
    with tempfile.TemporaryFile(dir=folder):
        pass


@cache
def warn_once(line: str) -> None:
    """Write a warning to stderr, once per line, and from the main process only."""
    if parent_process() is None and sys.stderr is not None:
        with suppress(OSError):
            print(f"hcsearch: {line}", file=sys.stderr, flush=True)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file atomically; others may read it, as several users may share the folder of root, but not write it."""
    part = path.with_name(f"{path.stem}-{uuid4().hex}{PART_FILE_PATTERN[1:]}")
    try:
        with open(part, "xb", opener=lambda name, flags: os.open(name, flags, 0o644)) as file:
            file.write(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def prune_folder(folder: Path, max_size: int = _MAX_FOLDER_SIZE) -> None:
    """Delete the least recently used files until the rest take at most `max_size` bytes."""
    files = []
    for path in (
        path
        for pattern in (KERNEL_FILE_PATTERN, PART_FILE_PATTERN, LOCK_FILE_PATTERN, CALLS_FILE_PATTERN)
        for path in folder.glob(pattern)
    ):
        with suppress(OSError):  # another process may be pruning, too
            status = path.stat()
            files.append((status.st_mtime, status.st_size, path))
    total_size = 0
    for _, size, path in sorted(files, reverse=True):
        total_size += size
        if total_size > max_size:
            with suppress(OSError):
                path.unlink()


LOCK_TIMEOUT_SECONDS = 600.0
"""Seconds to wait for another process to compile a kernel; it may be suspended."""
_LOCK_POLL_INTERVAL = 0.02  # s, between two attempts


def claim_kernel(folder: Path, name: str) -> BaseFileLock:
    """Acquire the lock of a kernel's file, waiting until no other process holds it.

    Raises OSError if the file system has no locks, or after `LOCK_TIMEOUT_SECONDS`.
    """
    from filelock import FileLock  # noqa: PLC0415 - importing it takes as long as reading kernels, and few runs compile

    lock = FileLock(folder / f"{name}.lock", is_singleton=True)  # reentrant within a process
    lock.acquire(timeout=LOCK_TIMEOUT_SECONDS, poll_interval=_LOCK_POLL_INTERVAL)
    return lock


def release_kernel(lock: BaseFileLock) -> None:
    """Release the lock of a kernel's file, and delete the lock file."""
    lock.release()
    if not lock.is_locked:
        with suppress(OSError):
            Path(lock.lock_file).unlink()
