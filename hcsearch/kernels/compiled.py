"""How this project compiles its loops: cached on disk, without the interpreter lock, typed for mypy."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])

for _name, _value in (("NUMBA_OPT", "1"), ("NUMBA_LOOP_VECTORIZE", "0")):
    # numba's own choice, 3 and 1, compiles the same kernels in nearly twice the time, and they run no faster
    os.environ.setdefault(_name, _value)
config: Any = numba.config  # its types do not tell the kind
config.reload_config()


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba."""
    return _compiled(function, counting=True)


def lean(function: Kernel) -> Kernel:
    """Compile a kernel that makes no arrays, and calls nothing that does, without counting references.

    numba counts those of every array of a table of arrays at every call, which takes longer than a small kernel does.
    Whoever calls holds the arrays meanwhile.
    """
    return _compiled(function, counting=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a lean kernel into each that calls it: where handing arrays over takes as long as the work itself."""
    return _compiled(function, counting=False, forceinline=True)


def merged(function: Kernel) -> Kernel:
    """Compile a kernel as a part of the one that calls it: each of its own is compiled with all that it calls."""
    njit: Any = numba.njit
    return cast(Kernel, njit(inline="always")(function))


def _compiled(function: Kernel, *, counting: bool, **options: bool) -> Kernel:
    """A kernel, cached with a stamp.

    numba would compile again only when the file of the kernel itself has changed, and not those of the kernels that it
    calls; ours are stamped with the newest of all files.
    """
    # the flag is passed on to kernels that are compiled on the way, unless they say themselves
    njit: Any = numba.njit  # has options that its types do not tell
    dispatcher = njit(cache=True, nogil=True, _nrt=counting, **options)(function)
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
