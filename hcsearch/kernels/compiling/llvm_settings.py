"""How hard LLVM works on our kernels: settings that hold while one of them is compiled, and for no other code."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numba

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
