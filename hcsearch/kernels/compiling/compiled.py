"""How this project compiles its loops: cached on disk, without the interpreter lock, typed for mypy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher

from hcsearch.kernels.compiling.numba_internals import has_internals

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba."""
    return _compiled(function, counting=True)


def lean(function: Kernel) -> Kernel:
    """Compile a kernel that makes no arrays, and is given none by what it calls, without counting references.

    numba counts those of every array of a table of arrays at every call, which takes longer than a small kernel does.
    Whoever calls holds the arrays meanwhile. The assignment of a table to another counts as making one: they may share
    memory, so numba copies the first.
    """
    return _compiled(function, counting=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a lean kernel into each that calls it: where handing arrays over takes as long as the work itself."""
    return _compiled(function, counting=False, forceinline=True)


def _compiled(function: Kernel, *, counting: bool, **options: bool) -> Kernel:
    """A kernel whose machine code is kept on disk, by numba itself where this numba lacks what our cache rests on."""
    njit: Any = numba.njit  # has options that its types do not name
    if not has_internals():
        return cast(Kernel, njit(nogil=True, cache=True)(function))
    from hcsearch.kernels.compiling.kernel_cache import KernelCache  # noqa: PLC0415 - imports what another numba may lack

    # the flag is passed on to kernels that are compiled on the way, unless they say themselves
    kernel = njit(nogil=True, no_cfunc_wrapper=True, _nrt=counting, **options)(function)
    if isinstance(kernel, Dispatcher):  # and not the function itself, where numba is switched off
        KernelCache.attach(kernel)
    return cast(Kernel, kernel)
