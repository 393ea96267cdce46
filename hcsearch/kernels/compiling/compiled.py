"""The decorator that compiles kernels with numba: cached on disk, releasing the interpreter lock, typed for mypy.

numba is a quarter of the start of a command that looks results up. So it is loaded when the first kernel is called,
and small kernels run as Python before that.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial, update_wrapper
from pathlib import Path
from threading import RLock, local
from typing import Any, TypeVar, cast

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba, when it is called first if numba is not loaded yet."""
    make = partial(_made, function)
    if "numba" in sys.modules:
        end_waiting()
        return cast(Kernel, make())
    _waiting.append(_Waiting(function, make))
    return cast(Kernel, _waiting[-1])


def small(kernel: Kernel) -> Kernel:
    """Let a kernel, with its callees, run as Python until another one is called, or it has much to do.

    For mechanisms of few hinges, some calls take less time than it takes to load numba. The results are the same.
    """
    if isinstance(kernel, _Waiting):
        kernel.calls = 0
    return kernel


class _AsPython(local):
    """Whether a small kernel runs in this thread."""

    now = False


_as_python = _AsPython()
_MOST_CALLS, _MOST_ROWS = 200, 16
"""Calls of a small kernel as Python, which take about a millisecond each, and rows of its first argument."""


class _Waiting:
    """A kernel until numba is loaded, which its first call and the first look at it do."""

    def __init__(self, function: Any, make: Callable[[], Any]) -> None:
        update_wrapper(self, function)
        self._function, self._make = function, make
        self.calls = _MOST_CALLS

    def __call__(self, *arguments: Any) -> Any:
        if _as_python.now:
            return self._function(*arguments)
        self.calls += 1
        if self.calls > _MOST_CALLS or len(arguments[0]) > _MOST_ROWS or "made" in vars(self):
            return self._kernel()(*arguments)
        _as_python.now = True
        try:
            return self._function(*arguments)
        finally:
            _as_python.now = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._kernel(), name)

    def _kernel(self) -> Any:
        end_waiting()
        return self.__dict__["made"]

    def make_kernel(self) -> None:
        """Make the kernel from the function."""
        self.made = self._make()


_waiting: list[_Waiting] = []
_ending = RLock()  # a server calls kernels in threads


def end_waiting() -> None:
    """Make all kernels that wait, and put them into the modules that have their names: kernels call each other."""
    with _ending:
        packages = {kernel.__module__.partition(".")[0] for kernel in _waiting}
        for kernel in _waiting:
            kernel.make_kernel()
        _waiting.clear()
        for module in [module for name, module in sys.modules.items() if name.partition(".")[0] in packages]:
            for name, value in list(vars(module).items()):
                if isinstance(value, _Waiting):
                    setattr(module, name, value.made)


def loaded_kernels() -> set[Any]:
    """Return the kernels of all modules that have been imported."""
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

    end_waiting()
    modules = [module for name, module in sys.modules.items() if name.startswith("hcsearch.kernels.")]
    return {value for module in modules for value in vars(module).values() if isinstance(value, Dispatcher)}


def _made(function: Any) -> Any:
    """Compile a function and cache its machine code on disk, in numba's own cache if this numba lacks internals."""
    import numba  # noqa: PLC0415 - as the head of this module says
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

    from hcsearch.kernels.compiling.numba_internals import has_internals  # noqa: PLC0415

    njit: Any = numba.njit  # has options that its types do not name
    if not has_internals():
        kernel = _kept_by_numba(function)
        return njit(nogil=True)(function) if kernel is None else kernel
    # they import what another numba may lack
    from hcsearch.kernels.compiling.kernel_cache import KernelCache  # noqa: PLC0415
    from hcsearch.kernels.compiling.pipeline import KernelCompiler  # noqa: PLC0415

    kernel = njit(nogil=True, no_cfunc_wrapper=True, pipeline_class=KernelCompiler)(function)
    if isinstance(kernel, Dispatcher):  # with numba disabled, njit returns the function itself
        KernelCache.attach(kernel)
    return kernel


def _kept_by_numba(function: Any) -> Any:
    """Compile a function with numba's own cache; None if others might have put code into it, or it has no folder."""
    import numba  # noqa: PLC0415
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

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
