"""The one way this project compiles a loop: cached on disk, without the interpreter lock, typed for mypy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba; a kernel and all it calls live in one file, as the cache sees no other edits."""
    return cast(Kernel, numba.njit(cache=True, nogil=True)(function))
