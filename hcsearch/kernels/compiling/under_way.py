"""Which kernels are being compiled: k of n, in whichever process, and the one that this process is at."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from hcsearch.kernels.compiling.cache_folder import KERNEL_FILE_PATTERN, wanted_folder, writable_folder
from hcsearch.kernels.compiling.numba_internals import has_internals
from hcsearch.kernels.compiling.stamps import kernel_stamp, reached_kernels


class Compilation(NamedTuple):
    """How many kernels are compiled, of how many that are needed, and the name of the next."""

    done: int
    total: int
    name: str


class _State:
    """What this process compiles for a call from Python: kernels that were missing when it began, and where it is."""

    missing: frozenset[str] = frozenset()
    name: str = ""


def start_compilation(kernel: Any) -> None:
    """A kernel that Python calls is to be compiled, with all that it reaches."""
    _State.missing = missing_stamps([kernel])


def set_current_kernel(kernel: Any) -> None:
    """The kernel that this process is at."""
    _State.name = kernel.__name__


def end_compilation() -> None:
    """What Python called is compiled."""
    _State.missing, _State.name = frozenset(), ""


def compilation_under_way() -> Compilation | None:
    """What is being compiled in this process now, or waited for; None where it runs."""
    name, wanted = _State.name, _State.missing
    return Compilation(len(wanted - uncompiled_stamps(wanted)), len(wanted), name) if name and wanted else None


def missing_stamps(kernels: Iterable[Any]) -> frozenset[str]:
    """Stamps of the kernels that some reach, and that no process has compiled yet."""
    return uncompiled_stamps(
        frozenset(kernel_stamp(used) for used in {used for kernel in kernels for used in reached_kernels(kernel)})
    )


def is_ready(kernel: Any) -> bool:
    """Whether a kernel that Python calls is compiled, and so all that it calls; or numba's own cache keeps it."""
    if not has_internals():
        return True
    end = f"-{kernel_stamp(kernel)}-{kernel.__name__}.kernel"
    return any(path.name.endswith(end) for path in _files())


def uncompiled_stamps(stamps: frozenset[str]) -> frozenset[str]:
    """Those of some stamps that no process has compiled yet."""
    return stamps - {path.name.split("-")[1] for path in _files()}


def _files() -> list[Any]:
    folders = {wanted_folder(), writable_folder() or wanted_folder()}
    return [path for folder in folders for path in folder.glob(KERNEL_FILE_PATTERN)]
