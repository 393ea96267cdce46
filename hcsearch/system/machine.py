"""The machine and the installation: processor cores, variables of the environment, disks, the release.

SQLite locks records of files, as `fcntl` does here. The library filelock locks files by `flock`, which a disk may have
without locks of records, or the other way round: it cannot tell.
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
    """Cores that this process may use, which can be fewer than the machine has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def default_database() -> str:
    """HCSEARCH_DB, else hcsearch.sqlite in the current folder."""
    return os.environ.get("HCSEARCH_DB") or "hcsearch.sqlite"


if sys.platform == "win32":

    def locks_files(_folder: Path) -> bool:
        """Whether files in a folder can be locked, which Windows does on every disk."""
        return True

else:
    import fcntl

    _LOCKLESS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)

    def locks_files(folder: Path) -> bool:
        """Whether files in a folder can be locked; True where that cannot be tried, as nothing can be written there.

        Network disks without a service for locks cannot.
        """
        with suppress(OSError), tempfile.TemporaryFile(dir=folder) as trial:
            try:
                fcntl.lockf(trial, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                return error.errno not in _LOCKLESS
        return True


__version__ = version("hcsearch")
