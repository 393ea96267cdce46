"""One writer for each kernel: locks between processes, which the system takes back from one that ends in any way.

All are bytes of one file, so that nothing is left to clean up. They order nothing but work: without them a kernel may
be compiled twice at once, and one of the same files replaces the other.
"""

from __future__ import annotations

import os
import sys
import time
from functools import cache
from pathlib import Path

PATIENCE = 600.0
"""Seconds after which a kernel is compiled although another process, which may be suspended, says that it does so."""
_LOOK = 0.02  # s, between two looks

if sys.platform == "win32":
    import msvcrt

    def _try(handle: int, byte: int) -> bool:
        os.lseek(handle, byte, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _free(handle: int, byte: int) -> None:
        os.lseek(handle, byte, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    # locks of lockf end with the process, not with the last copy of a file that a forked one may hold
    def _try(handle: int, byte: int) -> bool:
        try:
            fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except (BlockingIOError, PermissionError):
            return False
        return True

    def _free(handle: int, byte: int) -> None:
        fcntl.lockf(handle, fcntl.LOCK_UN, 1, byte)


def claim(folder: Path, key: str) -> bool:
    """Wait until no other process holds a key, hexadecimal, and hold it; whether another one held it before.

    Raises OSError where the folder's disk has no locks.
    """
    handle = _open(folder)
    begin = time.monotonic()
    waited = False
    while not _try(handle, _byte(key)) and time.monotonic() < begin + PATIENCE:
        waited = True
        time.sleep(_LOOK)
    return waited


def release(folder: Path, key: str) -> None:
    """Give a key back."""
    _free(_open(folder), _byte(key))


@cache
def _open(folder: Path) -> int:
    """The open file, never closed: a process that closes any copy of it gives all its locks back."""
    return os.open(folder / "locks", os.O_RDWR | os.O_CREAT, 0o600)


def _byte(key: str) -> int:
    return int(key[:7], 16)
