"""The machine and the installation: processor cores, environment variables, file locking, the version.

File locking is tested with `fcntl` record locks, which SQLite uses. The library filelock uses `flock`, which a file
system may support without record locks or the other way round, so it cannot serve as the test.
"""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path


def usable_cores() -> int:
    """Return the number of cores that this process may use, at most those of the machine."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def default_database() -> str:
    """Return the path in HCSEARCH_DB, or else hcsearch.sqlite in the current folder."""
    return os.environ.get("HCSEARCH_DB") or "hcsearch.sqlite"


if sys.platform == "win32":

    def locks_files(_folder: Path) -> bool:
        """Whether files in a folder can be locked, which Windows does on every disk."""
        return True

else:
    import fcntl

    _LOCKLESS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)

    def locks_files(folder: Path) -> bool:
        """Whether files in a folder can be locked; True where this cannot be tested because the folder is read-only.

        Network disks without a lock service do not support it.
        """
        with suppress(OSError), tempfile.TemporaryFile(dir=folder) as trial:
            try:
                fcntl.lockf(trial, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                return error.errno not in _LOCKLESS
        return True


__version__ = version("hcsearch")
