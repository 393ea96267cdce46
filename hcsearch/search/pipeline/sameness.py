"""Results come from one program: each task says which, and whoever works on it refuses another.

All commits of hcsearch may have one version, and a worker may have started before an upgrade, or join after one: so a
program is known by its sources and by what it computes with. Modules are loaded when they are needed. One that is
loaded after its file was changed would be part of another program, so files are looked at again when there are more.
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
"""What results hang on, by name: plain, as a worker of any version must be able to read it."""

_LIBRARIES = ("numpy", "numba", "llvmlite", "scipy", "shapely")
_SOURCES = "sources"
_ROOT = Path(__file__).parents[2]

_checked: set[str] = set()
"""Modules of hcsearch that were loaded from the sources of `running_program`."""


@cache
def running_program() -> ProgramVersions:
    """The program that this process runs, looked up once."""
    versions = {name: _version(name) for name in ("hcsearch", *_LIBRARIES)}
    return versions | {"Python": f"{sys.version_info[0]}.{sys.version_info[1]}", _SOURCES: sources_digest()}


def _version(library: str) -> str:
    """The version of a library: of what is loaded, which another may have replaced on disk."""
    return str(getattr(sys.modules.get(library), "__version__", None) or version(library))


def sources_digest() -> str:
    """A digest of the files of hcsearch as they are on disk now."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sorted(_ROOT.rglob("*.py")):
        text = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{path.relative_to(_ROOT).as_posix()} {len(text)}\n".encode() + text)
    return digest.hexdigest()


def are_sources_changed() -> bool:
    """Whether the files of hcsearch are others than they were for `running_program`."""
    return sources_digest() != running_program()[_SOURCES]


def are_sources_mixed() -> bool:
    """Whether modules may have been loaded from other sources than those of `running_program`."""
    running_program()
    loaded = {name for name in list(sys.modules) if name.partition(".")[0] == "hcsearch"}
    if loaded <= _checked:
        return False
    if are_sources_changed():
        return True
    _checked.update(loaded)
    return False


def program_difference(other: ProgramVersions) -> str:
    """How another program differs from this one, in words; empty where it does not."""
    own = running_program()
    parts = [f"{name} {other.get(name)} instead of {own[name]}" for name in own if name != _SOURCES]
    differ = [part for part, name in zip(parts, own, strict=False) if other.get(name) != own[name]]
    if not differ and other.get(_SOURCES) != own[_SOURCES]:
        return f"other sources of hcsearch {own['hcsearch']}"
    return ", ".join(differ)


@dataclass(frozen=True)
class ProgramRefusal:
    """Why a task was not worked on, or its results are not to be used. program : who refused; None of mixed sources."""

    program: ProgramVersions | None


def packed_task(task: Callable[[P], Any], inputs: Sequence[P]) -> bytes:
    """A task and inputs as they travel: another program can tell that it is another before it reads them."""
    return pickle.dumps((task, inputs))


def run_packed_task(expected: ProgramVersions, sent: bytes) -> list[Any] | ProgramRefusal:
    """Work on what `packed_task` gives, in a process that runs the expected program."""
    if running_program() != expected:
        return ProgramRefusal(running_program())
    try:
        task, inputs = pickle.loads(sent)
        results = [task(item) for item in inputs]
    except Exception:
        if are_sources_mixed():
            return ProgramRefusal(None)  # which is the reason for whatever has failed
        raise
    return ProgramRefusal(None) if are_sources_mixed() else results
