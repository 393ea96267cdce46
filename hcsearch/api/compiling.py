"""Compile the kernels of the main commands beforehand: small jobs that need them, each in a separate process."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stdout
from io import StringIO
from typing import NamedTuple

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.counting import count
from hcsearch.api.deploying import deploy
from hcsearch.api.enumerating import enumerate_into, plan_enumeration, run_enumeration
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.compiling.compiled import loaded_kernels
from hcsearch.kernels.compiling.numba_internals import has_internals
from hcsearch.kernels.compiling.under_way import (
    has_kernels_of,
    missing_stamps,
    record_called_kernels,
    uncompiled_stamps,
)
from hcsearch.motion.collision.panel_prisms import plates_of
from hcsearch.motion.locks.enclosures import enclose_ends
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.searching import Budget
from hcsearch.scenes import SCENES
from hcsearch.search.enumeration import Search
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.play import play_of_deployment
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.flight.flight_figures import figures_of
from hcsearch.springs.flight.travel import travel_by_springs
from hcsearch.system.work_steps import Progress

_FOLDING = "hex:023350:1"
_MOVABLE = "hex:0234550132:4"
_POLL_PERIOD = 0.5  # s


def _list() -> None:
    enumerate_into("arrays.sqlite", grid="hex", n=8, until="mobility")
    _list_without_storing(chosen_search("hex", 8, None, "all"), "twist")


def _one_array() -> None:
    _list_without_storing(chosen_search("hex", None, "3-4-3", "all"), "mobility")
    count(grid="square", array="6x6")


def _list_without_storing(search: Search, until: str) -> None:
    run_enumeration(plan_enumeration(search, chosen_workers(None, None), until=until), dry=True)


def _check() -> None:
    compile_scene(Folding.from_notation(_MOVABLE).linkage(), SCENES["default"])  # its loops are closed by a step
    compiled = compile_scene(Folding.from_notation(_FOLDING).linkage(), SCENES["default"])
    check_deployments([compiled], past_collisions=False)
    play_of_deployment(compiled, simulate_compiled(compiled, certified=False).motion)
    figures_of(travel_by_springs(Folding.from_notation(_FOLDING).linkage(), SCENES["default"]))


def _plan() -> None:
    plan_motion(Folding.from_notation(_MOVABLE), default_panel("hex"), ("rigid",))


def _search_on() -> None:
    linkage = Folding.from_notation(_MOVABLE).linkage()
    Planner(linkage, 1e-4).plan(Budget(2), roots=2)
    enclose_ends(linkage, 10)
    enclose_ends(linkage, 10, plates_of(linkage, 1e-4))


def _deploy() -> None:
    deploy(_FOLDING).facts()


SAMPLES: dict[str, Callable[[], None]] = {
    "plan": _plan,
    "check": _check,
    "list": _list,
    "one array": _one_array,
    "deploy": _deploy,
    "search on": _search_on,
}
"""Small jobs in which Python calls the kernels of the main commands, the longest first, as they are started."""


class CompiledKernels(NamedTuple):
    """What `compile_kernels` did: the numbers of samples run and of kernels compiled, and the time in s."""

    samples: int
    kernels: int
    seconds: float


def can_compile_ahead() -> bool:
    """Whether this version of numba has the private API by which kernels are compiled beforehand."""
    return has_internals()


def compile_kernels(processes: int, progress: Progress | None = None) -> CompiledKernels:
    """Compile the kernels of all samples that are not in the cache, as `hcsearch compile` does.

    HcsearchError where a sample fails.
    """
    waiting = [name for name in SAMPLES if not has_kernels_of(name)]
    samples, begin = len(waiting), time.monotonic()
    stamps = missing_stamps(loaded_kernels())  # more than the samples need: which these are shows when they run
    running = dict[str, subprocess.Popen[str]]()
    try:
        while waiting or running:
            while waiting and len(running) < processes:
                name = waiting.pop(0)
                running[name] = _start(name)
            if progress is not None:
                progress(len(stamps) - len(uncompiled_stamps(stamps)), len(stamps), ", ".join(running))
            time.sleep(_POLL_PERIOD)
            for name in [name for name, process in running.items() if process.poll() is not None]:
                _check_ended(running.pop(name))
    finally:
        for process in running.values():
            _end(process)
    return CompiledKernels(samples, len(stamps) - len(uncompiled_stamps(stamps)), time.monotonic() - begin)


@contextmanager
def compiling_ahead(name: str) -> Iterator[None]:
    """Compile the kernels of a sample in another process while the block runs, if they are missing."""
    process = None if has_kernels_of(name) else _start(name)
    try:
        yield
    finally:
        if process is not None:
            _end(process)


def run_sample(name: str) -> None:
    """Run a sample in a temporary folder without output: only its compiled kernels are kept."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that started this one ends it
    with tempfile.TemporaryDirectory() as folder, chdir(folder), redirect_stdout(StringIO()):
        SAMPLES[name]()
    record_called_kernels(name)


def _start(name: str) -> subprocess.Popen[str]:
    code = f"from hcsearch.api.compiling import run_sample; run_sample({name!r})"
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.DEVNULL, stderr=pipe, text=True)


def _end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


def _check_ended(process: subprocess.Popen[str]) -> None:
    lines = process.communicate()[1].strip().splitlines()
    if process.returncode != 0:
        raise HcsearchError(f"the kernels could not be compiled ({lines[-1] if lines else process.returncode})")
