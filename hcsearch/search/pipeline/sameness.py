"""Identity of the program across workers: each task names its program, and a worker with another program refuses it.

Many commits of hcsearch share a version, and a worker may start before or after an upgrade, so a program is identified
by its sources and the versions of its libraries. Modules are loaded on demand; one loaded after its file has changed
would belong to another program, so the sources are checked again whenever further modules have been loaded.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

P = TypeVar("P")
T = TypeVar("T")

ProgramVersions = dict[str, str]
"""Versions and digest on which results depend, by name; plain types, which a worker of any version can read."""

_LIBRARIES = ("numpy", "numba", "llvmlite", "scipy", "shapely")
_SOURCES = "sources"
_ROOT = Path(__file__).parents[2]

_checked: set[str] = set()
"""Modules of hcsearch that were loaded from the sources of `running_program`."""


@cache
def running_program() -> ProgramVersions:
    """Return the program of this process, determined once."""
    _states_at_start()
    versions = {name: _version(name) for name in ("hcsearch", *_LIBRARIES)}
    return versions | {"Python": f"{sys.version_info[0]}.{sys.version_info[1]}", _SOURCES: sources_digest()}


def _version(library: str) -> str:
    """Return the version of a library as it is loaded, which may differ from the version on disk."""
    return str(getattr(sys.modules.get(library), "__version__", None) or version(library))


def sources_digest() -> str:
    """Return a digest of the present source files of hcsearch."""
    digest = hashlib.blake2b(digest_size=16)
    for path in _source_files():
        text = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{path.relative_to(_ROOT).as_posix()} {len(text)}\n".encode() + text)
    return digest.hexdigest()


def are_sources_changed() -> bool:
    """Whether the source files of hcsearch have changed since `running_program` was determined.

    They are read again only where one has another size, time or place on the disk than it had then.
    """
    expected = running_program()[_SOURCES]
    return _file_states() != _states_at_start() and sources_digest() != expected


def _source_files() -> list[Path]:
    return sorted(path for path in _ROOT.rglob("*.py") if path.is_file())  # no dangling links, which editors make


def _file_states() -> list[tuple[Path, int, int, int, int]]:
    """Return the source files with the properties that change when one is written or replaced."""
    states = []
    for path in _source_files():
        state = path.stat()
        states.append((path, state.st_size, state.st_mtime_ns, state.st_ctime_ns, state.st_ino))
    return states


@cache
def _states_at_start() -> list[tuple[Path, int, int, int, int]]:
    return _file_states()


def are_sources_mixed() -> bool:
    """Whether modules may have been loaded from sources other than the sources of `running_program`."""
    running_program()
    loaded = {name for name in list(sys.modules) if name.partition(".")[0] == "hcsearch"}
    if loaded <= _checked:
        return False
    if are_sources_changed():
        return True
    _checked.update(loaded)
    return False


def program_difference(other: ProgramVersions) -> str:
    """Describe the difference of another program from this one; empty where they are equal."""
    current = running_program()
    parts = [f"{name} {other.get(name)} instead of {current[name]}" for name in current if name != _SOURCES]
    differences = [part for part, name in zip(parts, current, strict=False) if other.get(name) != current[name]]
    if not differences and other.get(_SOURCES) != current[_SOURCES]:
        return f"other sources of hcsearch {current['hcsearch']}"
    return ", ".join(differences)


@dataclass(frozen=True)
class ProgramRefusal:
    """The refusal of a task or of its results; program : the worker's program, None where its sources are mixed."""

    program: ProgramVersions | None


def packed_task(task: Callable[[P], Any], inputs: Sequence[P]) -> bytes:
    """Pickle a task with its inputs separately, so that a worker can compare programs before it unpickles them."""
    return pickle.dumps((task, inputs))


def run_packed_task(expected: ProgramVersions, packed_task: bytes) -> list[Any] | ProgramRefusal:
    """Execute a packed task on its inputs, or return a ProgramRefusal where this process runs another program."""
    if running_program() != expected:
        return ProgramRefusal(running_program())
    try:
        task, inputs = pickle.loads(packed_task)
        results = [task(item) for item in inputs]
    except Exception:
        if are_sources_mixed():
            return ProgramRefusal(None)  # the probable cause of the exception
        raise
    return ProgramRefusal(None) if are_sources_mixed() else results
