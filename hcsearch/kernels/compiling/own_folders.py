"""Folders and files from which code may run: those that nobody but the user and root can write.

A compiled kernel is machine code, which runs whatever the format of its file: a file of another user must not be read.
"""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from functools import cache
from pathlib import Path

_MAX_LINKS = 40
"""Limit of the symbolic links on a way, as that of Linux."""


def check_own_folder(folder: Path) -> None:
    """Raise PermissionError where others might have put code into a folder, and FileNotFoundError where it is missing.

    The user or root must own the folder and each folder and symbolic link on the way to it, and nobody else may write
    to these. A folder on the way that all may write must be sticky, as /tmp is: nobody can exchange what belongs to
    others there.
    """
    if not folder.is_absolute():
        raise _refusal("it depends on the current folder")
    place, waiting, links = Path(folder.anchor), list(folder.parts[:0:-1]), 0
    while True:
        status = place.lstat()
        if _is_foreign(status):
            raise _refusal(f"{place} belongs to another user")
        if stat.S_ISLNK(status.st_mode):
            links += 1
            waiting += reversed(place.readlink().parts)
            place = place.parent
        elif not stat.S_ISDIR(status.st_mode):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        elif _is_open(status) and not (waiting and status.st_mode & stat.S_ISVTX):
            raise _refusal(f"others can write to {place}")
        if links > _MAX_LINKS:
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        if not waiting:
            return
        place /= waiting.pop()


def is_own_file(path: Path) -> bool:
    """Return whether a file in a folder without fault is one of the user or root, no link, that nobody else can write.

    Raises OSError for a file that is not there. It may have come from elsewhere, or at a time when others could write.
    """
    status = path.lstat()
    return stat.S_ISREG(status.st_mode) and not _is_foreign(status) and not _is_open(status)


@cache
def is_own_folder(folder: Path, files: str) -> bool:
    """Return whether nobody but the user and root might have written a folder and its files of a pattern."""
    try:
        check_own_folder(folder)
    except OSError:
        return False
    return all(map(is_own_file, folder.glob(files)))


def make_own_folder(folder: Path, mode: int) -> None:
    """Create a folder and those that lead to it, in which nobody else can write, whatever the umask.

    Raises PermissionError where others might have put code into it, and other kinds of OSError where it cannot be made.
    """
    with suppress(FileNotFoundError):
        check_own_folder(folder)  # nothing is made in the folders of others
    for place in (*reversed(folder.parents), folder):
        if not place.is_dir():
            place.mkdir(mode, exist_ok=True)
    check_own_folder(folder)


def _refusal(reason: str) -> PermissionError:
    return PermissionError(errno.EPERM, reason)


def _is_foreign(status: os.stat_result) -> bool:
    """Return whether another user but root owns a file; never on Windows, where a user's folders are private."""
    return hasattr(os, "geteuid") and status.st_uid not in (0, os.geteuid())


def _is_open(status: os.stat_result) -> bool:
    """Return whether the owner's group or all can write; access lists show as the group's."""
    return hasattr(os, "geteuid") and bool(status.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
