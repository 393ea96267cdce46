"""The one way this project compiles a loop: cached on disk, without the interpreter lock, typed for mypy."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba.

    numba would compile again only when the file of the kernel itself has changed, and not those of the kernels that it
    calls; ours are stamped with the newest of all files.
    """
    dispatcher = numba.njit(cache=True, nogil=True)(function)
    # numba has no public way to say this
    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if file is not None:
        file._source_stamp = _newest()
    return cast(Kernel, dispatcher)


@cache
def _newest() -> tuple[float, int]:
    """When the newest kernel was written, and the size of all."""
    files = [path.stat() for path in Path(__file__).parent.rglob("*.py")]
    return max(file.st_mtime for file in files), sum(file.st_size for file in files)
