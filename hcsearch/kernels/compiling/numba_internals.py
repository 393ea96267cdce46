"""What is used of numba beyond its public API, and whether it has that; settings of LLVM for our kernels.

numba promises none of it. Where a part is missing, or takes other arguments, kernels are kept by numba's own cache.
"""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numba


class NumbaInternal(NamedTuple):
    """A part of numba's private API, by its module and its name there.

    arguments : those that it takes, as the cache passes them; None where it is not called. sets : attributes that it
    gives to an instance, where it is the function that makes one.
    """

    module: str
    name: str
    arguments: tuple[str, ...] | None = None
    sets: tuple[str, ...] = ()

    @property
    def is_present(self) -> bool:
        """Whether this numba has the part, as the cache takes it."""
        try:
            part: Any = importlib.import_module(self.module)
            for name in self.name.split("."):
                part = getattr(part, name)
        except (ImportError, AttributeError):
            return False
        if self.arguments is not None and not _takes(part, self.arguments):
            return False
        return set(self.sets) <= set(getattr(getattr(part, "__code__", None), "co_names", ()))


NUMBA_INTERNALS = (
    NumbaInternal("numba.core.caching", "NullCache.cache_path"),
    NumbaInternal("numba.core.caching", "NullCache.load_overload", ("self", "sig", "target_context")),
    NumbaInternal("numba.core.caching", "NullCache.save_overload", ("self", "sig", "cres")),
    NumbaInternal("numba.core.codegen", "CPUCodegen._init", ("self", "llvm_module"), ("_engine",)),
    # the code of a library, and what of it is linked into callers
    NumbaInternal("numba.core.codegen", "CPUCodeLibrary.__init__", sets=("_final_module", "_shared_module")),
    # the names of all functions that can be called
    NumbaInternal("numba.core.codegen", "JitEngine.__init__", sets=("_defined_symbols",)),
    NumbaInternal("numba.core.compiler", "CompileResult._reduce", ("self",)),
    NumbaInternal("numba.core.compiler", "CompileResult._rebuild"),
    NumbaInternal("numba.core.compiler", "Flags.no_cpython_wrapper"),
    NumbaInternal("numba.core.compiler_lock", "global_compiler_lock"),
    NumbaInternal("numba.core.cpu", "CPUTargetOptions._nrt"),
    NumbaInternal("numba.core.cpu", "CPUTargetOptions.forceinline"),
    NumbaInternal("numba.core.cpu", "CPUTargetOptions.no_cfunc_wrapper"),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.__init__", sets=("_cache", "_compiler")),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.add_overload", ("self", "cres")),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.compile", ("self", "sig")),
    NumbaInternal("numba.core.dispatcher", "_FunctionCompiler._customize_flags", ("self", "flags")),
    NumbaInternal("numba.core.serialize", "dumps", ("obj",)),
    NumbaInternal("numba.core.types", "BaseTuple"),
)


@cache
def has_internals() -> bool:
    """Whether this numba has all that the kernel cache rests on."""
    return all(internal.is_present for internal in NUMBA_INTERNALS)


def _takes(function: Callable[..., object], arguments: tuple[str, ...]) -> bool:
    """Whether a function can be called with so many arguments by place, and needs no others."""
    try:
        inspect.signature(function).bind(*arguments)
    except (TypeError, ValueError):
        return False
    return True


_OURS: Mapping[str, int] = {"OPT": 1, "LOOP_VECTORIZE": 0}
"""numba's own choice, 3 and 1, compiles the same kernels in nearly twice the time, and they run no faster."""
_OTHERS = ("SLP_VECTORIZE", "BOUNDSCHECK", "ENABLE_AVX", "DEBUGINFO_DEFAULT")
"""More of numba's configuration that changes the code it makes, and is left as it is."""


def compiler_settings() -> dict[str, Any]:
    """What our kernels are compiled with, by names of numba's configuration; environment variables NUMBA_... win."""
    config: Any = numba.config
    ours = {name: type(getattr(config, name))(value) for name, value in _OURS.items()}
    named = {name for name in ours if f"NUMBA_{name}" in os.environ}
    return {name: ours[name] for name in ours.keys() - named} | {
        name: getattr(config, name, None) for name in (*sorted(named), *_OTHERS)
    }


@contextmanager
def use_compiler_settings() -> Iterator[None]:
    """Let our settings hold while the block runs, which must hold numba's lock of compilation."""
    config: Any = numba.config
    before = {name: getattr(config, name) for name in _OURS}
    chosen = compiler_settings()
    for name in _OURS:
        setattr(config, name, chosen[name])
    try:
        yield
    finally:
        for name, value in before.items():
            setattr(config, name, value)
