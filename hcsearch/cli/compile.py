"""`hcsearch compile`: the kernels of the main commands, beforehand, several at once."""

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

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.options import examples
from hcsearch.cli.progress import Meter

_FOLDING = "hex:023350:1"
_MOVABLE = "hex:0234550132:4"
_LOOK = 0.5  # s, between two looks


class Sample(NamedTuple):
    """A small job that needs the kernels of a part of the program: those that Python calls there, and the job."""

    kernels: tuple[str, ...]
    work: Callable[[], None]


def _list() -> None:
    _run("enumerate", "--grid", "hex", "--n", "8", "--until", "mobility", "--db", "arrays.sqlite")
    _run("enumerate", "--grid", "hex", "--n", "8", "--until", "twist", "--dry-run")


def _one_array() -> None:
    _run("enumerate", "--grid", "hex", "--array", "3-4-3", "--until", "mobility", "--dry-run")
    _run("count", "--grid", "square", "--array", "6x6")


def _check() -> None:
    from hcsearch.designs.folding import Folding
    from hcsearch.scenes import SCENES
    from hcsearch.springs.deployment.compiling import compile_scene
    from hcsearch.springs.deployment.play import play_of_deployment
    from hcsearch.springs.deployment.quick_check import check_deployments
    from hcsearch.springs.deployment.simulated_deployment import simulate_compiled

    compiled = compile_scene(Folding.from_notation(_FOLDING).linkage(), SCENES["default"])
    check_deployments([compiled], past_collisions=False)
    play_of_deployment(compiled, simulate_compiled(compiled, certified=False).motion)


def _plan() -> None:
    from hcsearch.designs.folding import Folding
    from hcsearch.designs.panel_sizes import default_panel
    from hcsearch.motion.planning.motion_search import plan_motion

    plan_motion(Folding.from_notation(_MOVABLE), default_panel("hex"), ("rigid",))


def _search_on() -> None:
    from hcsearch.designs.folding import Folding
    from hcsearch.motion.collision.shrunk_plates import plates_of
    from hcsearch.motion.locks.enclosures import enclose_ends
    from hcsearch.motion.planning.planner import Planner

    linkage = Folding.from_notation(_MOVABLE).linkage()
    Planner(linkage, 1e-4).plan(2, roots=2)
    enclose_ends(linkage, 10)
    enclose_ends(linkage, 10, plates_of(linkage, 1e-4))


def _deploy() -> None:
    _run("deploy", _FOLDING)


def _run(*words: str) -> None:
    from hcsearch.cli import hcsearch

    hcsearch.main(list(words), standalone_mode=False)


_LIST = (
    "circuits.polygons.walk_polygons",
    "circuits.folds.fold_words",
    "circuits.folds.twist_words",
    "linkage.hinge_lines.survey_ends",
    "linkage.loops.generic_states",
    "linkage.cones.settle_ends",
    "circuits.words.array_rows",
    "circuits.words.fingerprint_rows",
    "circuits.words.insert_fingerprints",
    "circuits.words.write_rows",
)
_ONE_ARRAY = (
    "circuits.frontier.advance_states",
    "circuits.frontier.add_counts",
    "circuits.frontier.carry_limbs",
    "circuits.frontier.count_completions",
    "circuits.frontier.list_completions",
    "circuits.frontier.list_masks",
    "circuits.frontier.permute_masks",
    "circuits.frontier.trace_masks",
    "circuits.words.canonicalise",
    "linkage.cones.cone_rays",
    "linkage.cones.nonnegative_least_squares",
    "linkage.loops.bend_loops",
)
_DEPLOY = (
    "multibody.simulation.simulate_motion",
    "multibody.events.refined_motion",
    "multibody.events.largest_opening",
    "multibody.events.open_state_share",
    "multibody.hinges.no_targets",
    "multibody.tree.work_for",
    "collision.dips.approach_speed",
    "collision.clearance_search.judge_clearance",
    "collision.least_gaps.least_pair_gap",
)
_CHECK = (
    "deployment_batch.check_foldings",
    "linkage.loops.close_loops",
    "linkage.reaches.pairs_between",
    "multibody.simulation.simulate_motion",
    "multibody.events.refined_motion",
    "multibody.events.largest_opening",
    "multibody.hinges.no_targets",
    "multibody.tree.work_for",
    "collision.clearance_search.judge_clearance",
    "collision.least_gaps.least_pair_gap",
)
_PLAN = (
    "planning.closed_states.close_state",
    "planning.closed_states.keep_closed",
    "planning.closed_states.new_closing",
    "planning.space.new_state_stack",
    "planning.space.new_space_work",
    "planning.tree_search.new_tree",
    "planning.tree_search.fan_out",
    "planning.tree_search.search_trees",
    "planning.path_smoothing.relax_path",
    "planning.path_smoothing.shorten_path",
    "planning.path_smoothing.thin_path",
    "planning.tubes.prove_tube",
    "planning.tubes.polishing_residual",
    "planning.series.write_series",
    "planning.series.centre_screws",
    "collision.gaps.deepest_overlap",
    "collision.clearance_search.judge_clearance",
)
_SEARCH_ON = (
    "planning.space.new_state_stack",
    "planning.space.new_space_work",
    "planning.space.pick_state",
    "planning.space.place_state",
    "planning.tree_search.new_tree",
    "planning.tree_search.fan_out",
    "planning.tree_search.search_trees",
    "enclosure.refutation.new_refutation",
    "enclosure.refutation.refutation_with",
    "enclosure.flooding.new_flood",
    "enclosure.flooding.spread_flood",
)
SAMPLES = {
    "plan": Sample(_PLAN, _plan),
    "check": Sample(_CHECK, _check),
    "list": Sample(_LIST, _list),
    "one array": Sample(_ONE_ARRAY, _one_array),
    "deploy": Sample(_DEPLOY, _deploy),
    "search on": Sample(_SEARCH_ON, _search_on),
}
"""In the order in which they are begun: what takes longest first."""


@click.command("compile", epilog=examples("hcsearch compile --jobs 2"))
@click.option("--jobs", type=click.IntRange(1, 16), default=2, show_default=True, help="The number of processes.")
def compile_(jobs: int) -> None:
    """Compile the numerical parts of the main commands now.

    Otherwise each command compiles the parts that it needs when it runs for the first time.
    """
    from hcsearch.kernels.compiling.numba_internals import has_internals
    from hcsearch.kernels.compiling.under_way import kernels_named, missing_stamps, uncompiled_stamps

    if not has_internals():
        click.echo("nothing is compiled beforehand: this version of numba keeps each kernel when it is called first")
        return
    todo = [name for name in SAMPLES if not _is_finished(name)]
    if not todo:
        click.echo("nothing is left to compile")
        return
    begin = time.monotonic()
    wanted = missing_stamps(kernels_named(kernel for name in todo for kernel in SAMPLES[name].kernels))
    total = len(wanted)
    waiting, running = list(todo), dict[str, subprocess.Popen[str]]()
    try:
        with Meter("kernel") as meter:
            while waiting or running:
                while waiting and len(running) < jobs:
                    name = waiting.pop(0)
                    running[name] = _start(name)
                meter(total - len(uncompiled_stamps(wanted)), total, ", ".join(running))
                time.sleep(_LOOK)
                for name in [name for name, process in running.items() if process.poll() is not None]:
                    _check_ended(running.pop(name))
    finally:
        for process in running.values():
            _end(process)
    click.echo(f"{total} kernels compiled in {time.monotonic() - begin:.0f} s")


def _is_finished(name: str) -> bool:
    from hcsearch.kernels.compiling.under_way import is_ready, kernels_named

    return all(map(is_ready, kernels_named(SAMPLES[name].kernels)))


@contextmanager
def compiling_ahead(name: str, *, wanted: bool) -> Iterator[None]:
    """Compile the kernels of a sample in another process while the block runs, where they are wanted and not there."""
    process = _start(name) if wanted and not _is_finished(name) else None
    try:
        yield
    finally:
        if process is not None:
            _end(process)


def run_sample(name: str) -> None:
    """Run a sample in a folder of its own, in silence: what it is for is that its kernels are compiled."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started this process ends it
    with tempfile.TemporaryDirectory() as folder, chdir(folder), redirect_stdout(StringIO()):
        SAMPLES[name].work()


def _start(name: str) -> subprocess.Popen[str]:
    code = f"from hcsearch.cli.compile import run_sample; run_sample({name!r})"
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.DEVNULL, stderr=pipe, text=True)


def _end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


def _check_ended(process: subprocess.Popen[str]) -> None:
    lines = process.communicate()[1].strip().splitlines()
    if process.returncode != 0:
        raise HcsearchError(f"the kernels could not be compiled ({lines[-1] if lines else process.returncode})")
