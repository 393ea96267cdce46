"""Decorators that compile kernels with numba: cached on disk, releasing the interpreter lock, typed for mypy."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher

from hcsearch.kernels.compiling.numba_internals import has_internals

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba."""
    return _compiled(function, counting=True)


def lean(function: Kernel) -> Kernel:
    """Compile a kernel without reference counting; it must neither create arrays nor receive any from its callees.

    At every call numba counts references to each array of a named tuple of arrays, which takes longer than a small
    kernel itself. The caller keeps the arrays alive meanwhile. Assigning one table to another counts as creating an
    array: they may share memory, so numba copies the source.
    """
    return _compiled(function, counting=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a lean kernel inline into its callers, where passing arrays takes as long as the work itself."""
    return _compiled(function, counting=False, forceinline=True)


def _compiled(function: Kernel, *, counting: bool, **options: bool) -> Kernel:
    """Compile a function and cache its machine code on disk, in numba's own cache if this numba lacks internals."""
    njit: Any = numba.njit  # has options that its types do not name
    if not has_internals():
        kernel = _kept_by_numba(function)
        return cast(Kernel, njit(nogil=True)(function) if kernel is None else kernel)
    from hcsearch.kernels.compiling.kernel_cache import KernelCache  # noqa: PLC0415 - imports what another numba may lack

    # kernels compiled on the way inherit the flag unless they set it
    kernel = njit(nogil=True, no_cfunc_wrapper=True, _nrt=counting, **options)(function)
    if isinstance(kernel, Dispatcher):  # with numba disabled, njit returns the function itself
        KernelCache.attach(kernel)
    return cast(Kernel, kernel)


def _kept_by_numba(function: Any) -> Any:
    """Compile a function with numba's own cache; None if others might have put code into it, or it has no folder."""
    from hcsearch.kernels.compiling.cache_folder import REMEDY, warn_once  # noqa: PLC0415
    from hcsearch.kernels.compiling.own_folders import is_own_folder  # noqa: PLC0415

    njit: Any = numba.njit
    with suppress(RuntimeError):  # no folder can be written
        kernel = njit(nogil=True, cache=True)(function)
        if not isinstance(kernel, Dispatcher) or is_own_folder(Path(str(kernel.stats.cache_path)), "*.nb[ci]"):
            return kernel
    warn_once(
        f"numba has no folder for compiled kernels that only you can write: they are compiled at every start; {REMEDY}"
    )
    return None
