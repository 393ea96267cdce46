"""Stamps of kernels: digests of everything that their machine code depends on.

A kernel is compiled together with all its callees. So its stamp covers its own code and constants, and those of every
kernel that it reaches: an edit changes the stamps of the edited kernels and of their callers only. Code is compared as
Python compiles it, without comments, docstrings, annotations and file locations.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.dispatcher import Dispatcher

from hcsearch.kernels.compiling.numba_internals import compiler_settings

_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(...), np.generic)


def kernel_stamp(kernel: Any) -> str:
    """Return the digest of a kernel, all kernels it reaches, versions of the compilers, and their settings.

    Raises TypeError if a kernel uses a global value that has no stable text form.
    """
    digests = sorted(_own_digest(reached)[0] for reached in reached_kernels(kernel))
    return _digest("\n".join([_environment_text(), _name(kernel), *digests]))


@cache
def reached_kernels(kernel: Any) -> tuple[Any, ...]:
    """Return a kernel and all its direct and indirect callees, which may be mutually recursive."""
    kernels = [kernel]
    for reached in kernels:  # which grows meanwhile
        kernels += [used for used in _own_digest(reached)[1] if not any(used is known for known in kernels)]
    return tuple(kernels)


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def _environment_text() -> str:
    versions = (numba.__version__, llvmlite.__version__, np.__version__, sys.version_info[:2], sys.implementation.name)
    return repr((versions, getattr(sys, "abiflags", ""), sorted(compiler_settings().items())))


@cache
def _own_digest(kernel: Any) -> tuple[str, tuple[Any, ...]]:
    """Return the digest of a single kernel or function, and the functions that it uses directly."""
    function: FunctionType = getattr(kernel, "py_func", kernel)
    names = sorted(_names(function.__code__))
    callees: list[Any] = []
    values = {name: function.__globals__[name] for name in names if name in function.__globals__}
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    values |= {name: cell.cell_contents for name, cell in cells}
    lines = [
        _name(kernel),
        repr(sorted(getattr(kernel, "targetoptions", {}).items())),
        _value_text(function.__code__, function, callees),
        _value_text((function.__defaults__, function.__kwdefaults__), function, callees),
        *(f"{name}={_value_text(value, function, callees)}" for name, value in values.items()),
    ]
    return _digest("\n".join(lines)), tuple(callees)


def _name(value: Any) -> str:
    return f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', value.__name__)}"


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and those of its comprehensions and inner functions."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _names(code: CodeType) -> set[str]:
    """Return the names that code looks up in its module or as attributes."""
    return {name for part in _codes(code) for name in part.co_names}


def _value_text(value: Any, user: FunctionType, used: list[Any]) -> str:
    """Return the text form of a value that a function uses; functions by name, and appended to `used`."""
    if isinstance(value, Dispatcher | FunctionType):
        used.append(value)
        return _name(value)
    if isinstance(value, _PLAIN):
        return f"{type(value).__name__} {value!r}"
    if isinstance(value, np.ndarray):
        return f"array {value.dtype} {value.shape} {hashlib.blake2b(value.tobytes()).hexdigest()}"
    if isinstance(value, CodeType):
        return _code_text(value, user, used)
    parts = [f"{name}={_value_text(part, user, used)}" for name, part in _parts(value, user)]
    return f"{_name(value if hasattr(value, '__name__') else type(value))} {parts}"


def _code_text(code: CodeType, user: FunctionType, used: list[Any]) -> str:
    flat = code.co_name, code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_flags
    counts = code.co_argcount, code.co_kwonlyargcount, code.co_posonlyargcount
    has_doc = code is user.__code__ and user.__doc__ is not None
    constants = (None, *code.co_consts[1:]) if has_doc else code.co_consts
    return repr((flat, counts, [_value_text(constant, user, used) for constant in constants]))


def _parts(value: Any, user: FunctionType) -> Iterable[tuple[object, Any]]:
    """Return the parts of a composite value, by name or index."""
    parts: Iterable[tuple[object, Any]] = ()
    if isinstance(value, dict):
        parts = value.items()
    elif isinstance(value, tuple | list):
        parts = enumerate(value)
    elif isinstance(value, slice):  # code of Python 3.14 and newer has them as constants
        parts = (("start", value.start), ("stop", value.stop), ("step", value.step))
    elif isinstance(value, frozenset):
        parts = enumerate(sorted(value, key=repr))
    elif isinstance(value, ModuleType):
        is_ours = value.__name__.partition(".")[0] == user.__module__.partition(".")[0]
        names = sorted(_names(user.__code__)) if is_ours else []
        parts = ((name, getattr(value, name)) for name in names if hasattr(value, name))
    elif isinstance(value, type):  # a named tuple, or a type of numbers
        parts = enumerate((*getattr(value, "_fields", ()), getattr(value, "_field_defaults", {})))
    elif not (callable(value) and hasattr(value, "__name__")):  # a function of C, or of numbers
        raise TypeError(f"{_name(user)} uses {value!r}, of which no stamp can be made: give it a constant instead")
    return parts
