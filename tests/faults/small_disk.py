"""Little room to write: a small file system where mounting is allowed, else a limit on the size of files."""

from __future__ import annotations

import subprocess
import sys
from contextlib import contextmanager

# Python ignores SIGXFSZ, so a write beyond the limit fails with EFBIG, as it does with ENOSPC on a full disk.
_LIMITED = (
    "import os, resource, sys; hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]; "
    "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), hard)); os.execv(sys.argv[2], sys.argv[2:])"
)


def limited(line, size):
    """A command line under which no file grows beyond `size` bytes."""
    return [sys.executable, "-c", _LIMITED, str(size), *line]


def _mount(folder, options):
    try:
        line = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        return subprocess.run(line, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


@contextmanager
def small_disk(folder):
    """Give a function that sets the room in a folder and returns what is then to be run for a command line."""
    mounted = _mount(folder, "size=64k")

    def resize(size, line):
        if not mounted:
            return limited(line, size)
        assert _mount(folder, f"remount,size={size}")
        return line

    try:
        yield resize
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=True)
