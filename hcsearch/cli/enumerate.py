"""`hcsearch enumerate`: the main job."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.vocabulary import STAGE_NAMES, listed
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog, target_options, worker_options
from hcsearch.cli.progress import SHARE, ProgressMeter

if TYPE_CHECKING:
    from hcsearch.api.enumerating import Enumeration
    from hcsearch.search.pipeline import Funnel, Plan


@click.command(
    "enumerate",
    epilog=examples_epilog(
        "hcsearch enumerate --grid hex --n 12", "hcsearch enumerate --grid square --array 6x5 --panel 80x8"
    ),
)
@target_options
@database_option
@click.option(
    "--until",
    metavar="STAGE",
    help=f"The last stage: {listed(STAGE_NAMES, 'or')}.  [default: {STAGE_NAMES[-1]}]",
)
@scene_options
@click.option(
    "--budget",
    type=int,
    metavar="EFFORTS",
    help="Efforts of the search for the motion of each folding; undecided foldings in the database are included.",
)
@worker_options
@click.option("--dry-run", is_flag=True, help="Print how many designs pass each stage, without a database.")
def enumerate_(
    grid: str,
    n: int | None,
    array_spec: str | None,
    keep: str,
    db: str,
    jobs: int | None,
    scheduler: str | None,
    dry_run: bool,
    **limits: Any,
) -> None:
    """Search arrays for designs that fold, and store them.

    The search lists all circuits up to symmetry, finds their two-stack foldings and their twist, looks for locks, plans
    a motion for each folding that may open, and simulates how springs open it. It prints how many designs pass each
    stage. Finished work is stored: the same command continues an interrupted search.
    """
    from hcsearch.api.chosen_searches import chosen_search, chosen_workers
    from hcsearch.api.enumerating import plan_enumeration, run_enumeration

    search, workers = chosen_search(grid, n, array_spec, keep), chosen_workers(jobs, scheduler)
    plan = plan_enumeration(search, workers, db, keep=keep, **limits)
    click.echo(_subject(plan))
    with ProgressMeter(SHARE if plan.scene_stages else "batch") as meter, _compiling_ahead(plan):

        def show(rows: dict[str, str], funnel: Funnel) -> None:
            for column, label in rows.items():
                count = getattr(funnel, column)
                meter.write(f"  {label:24}{'-' if count is None else f'{count:,}':>16}")

        announce, listed = partial(meter.write, err=True), partial(show, _listed_rows(plan))
        done = run_enumeration(plan, db, announce=announce, progress=meter, listed=listed, dry=dry_run)
        show(_JUDGED_ROWS, done.summary.funnel)
    _print_summary(done)
    _announce_none(plan, done.summary.funnel)


def _compiling_ahead(plan: Plan) -> AbstractContextManager[None]:
    """Compile beside a run what the quick check of deployments needs, where the run comes to that."""
    if not plan.scene_stages:
        return nullcontext()
    from hcsearch.api.compiling import compiling_ahead

    return compiling_ahead("check")


def _subject(plan: Plan) -> str:
    """Return what is searched, as a sentence."""
    target = plan.search.target or f"all arrays of {plan.search.n} cells"
    stages = [stage.name for stage in (*plan.listing_stages, *plan.scene_stages)]
    grid = f"{plan.search.grid.name} grid, {target}, n = {plan.search.n}"
    return f"searching the {grid}, in the {'stages' if len(stages) > 1 else 'stage'} {listed(stages, 'and')}"


def _listed_rows(plan: Plan) -> dict[str, str]:
    """Return the labels of the columns of the funnel that are final once all circuits are listed."""
    return {
        "fixed_circuits": "circuits of the array" if plan.search.target else "fixed circuits",
        "circuits": "non-isomorphic circuits",
        "arrays": "arrays" if plan.keep == "all" else f"arrays ({plan.keep})",
        "two_stack": "two-stack",
        "untwisted": "untwisted",
    }


_JUDGED_ROWS = {"movable": "movable", "deploys": "deployed by springs"}


def _announce_none(plan: Plan, funnel: Funnel) -> None:
    """Say why there are no circuits, or why none of them folds."""
    from hcsearch.designs.folding import no_folding_reason

    if funnel.circuits == 0:
        click.echo("no circuits: no closed walk from panel to panel goes through each of them once", err=True)
    elif funnel.two_stack == 0:
        click.echo(f"nothing folds: {no_folding_reason(plan.search.n)}", err=True)


def _print_summary(done: Enumeration) -> None:
    from hcsearch.basics.simulation_accuracy import accuracy_sentences
    from hcsearch.basics.undecided_simulations import undecided_sentences

    plan, summary = done.plan, done.summary
    times = ", ".join(f"{stage} {seconds:.2f} s" for stage, seconds in summary.stage_times.items())
    click.echo(f"stages: {times}, summed over cores" if times else "stages: nothing to do")
    if plan.scene_stages:
        click.echo(f"scene: {plan.scene.name}, panels of {plan.panel} mm")
    click.echo(f"batches: {summary.batches_done} done, {summary.batches_reused} taken from before")
    accuracy = () if summary.accuracy is None else accuracy_sentences(summary.accuracy)
    for sentence in (*accuracy, *undecided_sentences(summary.not_decided)):
        click.echo(sentence)
    if summary.undecided:
        foldings = "1 folding is" if summary.undecided == 1 else f"{summary.undecided:,} foldings are"
        click.echo(f"{foldings} undecided: the same command with --budget {_next_budget(plan)} searches on")
    if done.location is not None:
        click.echo(f"database: {done.location}")


def _next_budget(plan: Plan) -> int:
    """The least budget by which more is done for a folding."""
    from hcsearch.motion.planning.schedule import DEFAULT_EFFORT_BUDGET

    return 1 + (DEFAULT_EFFORT_BUDGET if plan.budget is None else plan.budget)
