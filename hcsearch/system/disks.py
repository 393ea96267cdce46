"""What a disk can do.

SQLite locks records of files, as `fcntl` does here. The library filelock locks files by `flock`, which a disk may have
without locks of records, or the other way round: it cannot tell.
"""

from __future__ import annotations

import errno
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

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
