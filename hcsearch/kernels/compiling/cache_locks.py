"""One writer for each kernel: locks between processes, which the system takes back from one that ends in any way.

They order nothing but work: without them a kernel may be compiled twice at once, and one of the same files replaces the
other.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from filelock import BaseFileLock

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
