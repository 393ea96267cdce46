"""`hcsearch compile`: the kernels of the main commands, beforehand, several at once."""

from __future__ import annotations

import click

from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter


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


@click.command("compile", epilog=examples_epilog("hcsearch compile --jobs 2"))
@click.option("--jobs", type=click.IntRange(1, 16), default=2, show_default=True, help="The number of processes.")
def compile_(jobs: int) -> None:
    """Compile the numerical parts of the main commands now.

    Otherwise each command compiles the parts that it needs when it runs for the first time.
    """
    from hcsearch.api import compiling

    if not compiling.can_compile_ahead():
        click.echo("nothing is compiled beforehand: this version of numba keeps each kernel when it is called first")
        return
    with ProgressMeter("kernel") as meter:
        done = compiling.compile_kernels(jobs, meter)
    if done.samples:
        click.echo(f"{done.kernels} kernels compiled in {done.seconds:.0f} s")
    else:
        click.echo("nothing is left to compile")
