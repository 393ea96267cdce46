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
from typing import Any, NamedTuple

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.counting import count
from hcsearch.api.deploying import deploy
from hcsearch.api.enumerating import enumerate_into, plan_enumeration, run_enumeration
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.circuits.folds import fold_words, twist_words
from hcsearch.kernels.circuits.frontier import (
    add_counts,
    advance_states,
    carry_limbs,
    count_completions,
    list_completions,
    list_masks,
    permute_masks,
    trace_masks,
)
from hcsearch.kernels.circuits.polygons import walk_polygons
from hcsearch.kernels.circuits.words import array_rows, canonicalise, fingerprint_rows, insert_fingerprints, write_rows
from hcsearch.kernels.collision.clearance_search import judge_clearance
from hcsearch.kernels.collision.gaps import deepest_overlap
from hcsearch.kernels.collision.least_gaps import approach_speed, least_pair_gap
from hcsearch.kernels.compiling.numba_internals import has_internals
from hcsearch.kernels.compiling.under_way import is_ready, missing_stamps, uncompiled_stamps
from hcsearch.kernels.deployment_batch import check_foldings
from hcsearch.kernels.enclosure.flooding import new_flood, spread_flood
from hcsearch.kernels.enclosure.refutation import new_refutation, refutation_with
from hcsearch.kernels.linkage.closing_steps import damped_step
from hcsearch.kernels.linkage.cones import cone_rays, nonnegative_least_squares, settle_ends
from hcsearch.kernels.linkage.hinge_lines import survey_ends
from hcsearch.kernels.linkage.loops import bend_loops, close_loops, generic_states
from hcsearch.kernels.linkage.prisms import pairs_between
from hcsearch.kernels.multibody.events import largest_opening, open_state_share, refined_motion, step_openings
from hcsearch.kernels.multibody.hinges import no_targets
from hcsearch.kernels.multibody.simulation import simulate_motion
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.kernels.planning.closed_states import close_state, keep_closed, new_closing
from hcsearch.kernels.planning.path_smoothing import relax_path, shorten_path, thin_path
from hcsearch.kernels.planning.series import centre_screws, write_series
from hcsearch.kernels.planning.space import new_space_work, new_state_stack, pick_state, place_state
from hcsearch.kernels.planning.tree_search import fan_out, new_tree, search_trees
from hcsearch.kernels.planning.tubes import new_track, polishing_residual, prove_tube
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
from hcsearch.system.work_steps import Progress

_FOLDING = "hex:023350:1"
_MOVABLE = "hex:0234550132:4"
_POLL_PERIOD = 0.5  # s


class Sample(NamedTuple):
    """A small job, and the kernels that Python calls in it."""

    kernels: tuple[Any, ...]
    work: Callable[[], None]


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


def _plan() -> None:
    plan_motion(Folding.from_notation(_MOVABLE), default_panel("hex"), ("rigid",))


def _search_on() -> None:
    linkage = Folding.from_notation(_MOVABLE).linkage()
    Planner(linkage, 1e-4).plan(Budget(2), roots=2)
    enclose_ends(linkage, 10)
    enclose_ends(linkage, 10, plates_of(linkage, 1e-4))


def _deploy() -> None:
    deploy(_FOLDING).facts()


_LIST = (
    walk_polygons,
    fold_words,
    twist_words,
    survey_ends,
    generic_states,
    settle_ends,
    array_rows,
    fingerprint_rows,
    insert_fingerprints,
    write_rows,
)
_ONE_ARRAY = (
    advance_states,
    add_counts,
    carry_limbs,
    count_completions,
    list_completions,
    list_masks,
    permute_masks,
    trace_masks,
    canonicalise,
    cone_rays,
    nonnegative_least_squares,
    bend_loops,
)
_DEPLOY = (
    simulate_motion,
    refined_motion,
    largest_opening,
    step_openings,
    open_state_share,
    no_targets,
    work_for,
    approach_speed,
    judge_clearance,
    least_pair_gap,
)
_CHECK = (
    check_foldings,
    close_loops,
    damped_step,
    pairs_between,
    simulate_motion,
    refined_motion,
    largest_opening,
    step_openings,
    no_targets,
    work_for,
    judge_clearance,
    least_pair_gap,
)
_PLAN = (
    close_state,
    keep_closed,
    new_closing,
    new_state_stack,
    new_space_work,
    new_tree,
    fan_out,
    search_trees,
    relax_path,
    shorten_path,
    thin_path,
    new_track,
    prove_tube,
    polishing_residual,
    write_series,
    centre_screws,
    deepest_overlap,
    judge_clearance,
)
_SEARCH_ON = (
    new_state_stack,
    new_space_work,
    pick_state,
    place_state,
    new_tree,
    fan_out,
    search_trees,
    new_refutation,
    refutation_with,
    new_flood,
    spread_flood,
)
SAMPLES = {
    "plan": Sample(_PLAN, _plan),
    "check": Sample(_CHECK, _check),
    "list": Sample(_LIST, _list),
    "one array": Sample(_ONE_ARRAY, _one_array),
    "deploy": Sample(_DEPLOY, _deploy),
    "search on": Sample(_SEARCH_ON, _search_on),
}
"""In the order in which they are started: the longest first."""


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
    waiting = [name for name, sample in SAMPLES.items() if not _is_finished(sample)]
    samples, begin = len(waiting), time.monotonic()
    stamps = missing_stamps(kernel for name in waiting for kernel in SAMPLES[name].kernels)
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
    return CompiledKernels(samples, len(stamps), time.monotonic() - begin)


@contextmanager
def compiling_ahead(name: str) -> Iterator[None]:
    """Compile the kernels of a sample in another process while the block runs, if they are missing."""
    process = None if _is_finished(SAMPLES[name]) else _start(name)
    try:
        yield
    finally:
        if process is not None:
            _end(process)


def run_sample(name: str) -> None:
    """Run a sample in a temporary folder without output: only its compiled kernels are kept."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that started this one ends it
    with tempfile.TemporaryDirectory() as folder, chdir(folder), redirect_stdout(StringIO()):
        SAMPLES[name].work()


def _is_finished(sample: Sample) -> bool:
    return all(map(is_ready, sample.kernels))


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
