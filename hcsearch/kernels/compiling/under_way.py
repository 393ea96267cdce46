"""Progress of compilation: kernels compiled by any process, k of n, and the current kernel of this process.

Which kernels Python calls in a job is recorded beside them, so that their compilation can begin before the job.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, NamedTuple

from hcsearch.kernels.compiling.cache_folder import (
    CALLS_FILE_PATTERN,
    KERNEL_FILE_PATTERN,
    readable_folder,
    writable_folder,
    write_atomically,
)
from hcsearch.kernels.compiling.numba_internals import has_internals
from hcsearch.kernels.compiling.own_folders import is_own_file
from hcsearch.kernels.compiling.stamps import kernel_stamp, reached_kernels


class Compilation(NamedTuple):
    """Progress of a compilation: kernels compiled, kernels needed, name of the current one, kernels compiled before."""

    done: int
    total: int
    name: str
    before: int


CALLED_BY_PYTHON: set[Any] = set()
"""The kernels that Python has called in this process."""


class _State:
    """Compilation for a call from Python: stamps missing at its start, name of the current kernel; kernels before.

    begun, seconds : start of the present compilation, and duration of those before, s.
    """

    missing: frozenset[str] = frozenset()
    name: str = ""
    before: int = 0
    begun: float = 0.0
    seconds: float = 0.0


def start_compilation(kernel: Any) -> None:
    """Start the compilation of a kernel that Python calls, with all kernels it reaches."""
    _State.missing, _State.begun = missing_stamps([kernel]), time.monotonic()


def set_current_kernel(kernel: Any) -> None:
    """Set the kernel that this process is compiling or waiting for."""
    _State.name = kernel.__name__


def end_compilation() -> None:
    """End the compilation for a call from Python."""
    if _State.missing:
        _State.before += _done(_State.missing)
        _State.seconds += time.monotonic() - _State.begun
    _State.missing, _State.name = frozenset(), ""


def compilation_under_way() -> Compilation | None:
    """Return the progress of the compilation in this process, waiting included; None if there is none."""
    name, missing = _State.name, _State.missing
    return Compilation(_done(missing), len(missing), name, _State.before) if name and missing else None


def compiled_before() -> tuple[int, float]:
    """Return how many kernels this process has waited for, whoever compiled them, and how long, s."""
    return _State.before, _State.seconds


def _done(stamps: frozenset[str]) -> int:
    """Return how many of some stamps a process has compiled."""
    return len(stamps - uncompiled_stamps(stamps)) if stamps else 0


def missing_stamps(kernels: Iterable[Any]) -> frozenset[str]:
    """Return the stamps of all kernels reached by some that no process has compiled yet."""
    return uncompiled_stamps(
        frozenset(
            kernel_stamp(reached) for reached in {reached for kernel in kernels for reached in reached_kernels(kernel)}
        )
    )


def is_ready(kernel: Any) -> bool:
    """Return whether a kernel can be called without compiling; always true with numba's own cache."""
    if not has_internals():
        return True
    end = f"-{kernel_stamp(kernel)}-{kernel.__name__}.kernel"
    return any(path.name.endswith(end) for path in _files())


def uncompiled_stamps(stamps: frozenset[str]) -> frozenset[str]:
    """Return the given stamps that no process has compiled yet."""
    return stamps - {path.name.split("-")[1] for path in _files()}


def _files() -> list[Any]:
    return [
        path for folder in {readable_folder(), writable_folder()} if folder for path in folder.glob(KERNEL_FILE_PATTERN)
    ]


def record_called_kernels(job: str) -> None:
    """Record the kernels that Python has called in this process as those of a job."""
    folder = writable_folder()
    if folder is not None:
        lines = sorted(f"{kernel.__module__} {kernel.__name__}" for kernel in CALLED_BY_PYTHON)
        write_atomically(folder / CALLS_FILE_PATTERN.replace("*", job), "\n".join(lines).encode())


def has_kernels_of(job: str) -> bool:
    """Return whether the kernels recorded for a job can be called without compiling; true with numba's own cache."""
    if not has_internals():
        return True
    for folder in (readable_folder(), writable_folder()):
        with suppress(OSError, ImportError, AttributeError):  # none was recorded, or a kernel is no more
            path = folder / CALLS_FILE_PATTERN.replace("*", job) if folder is not None else None
            if path is not None and is_own_file(path):
                names = (line.split() for line in path.read_text().splitlines())
                return all(is_ready(getattr(importlib.import_module(module), name)) for module, name in names)
    return False
