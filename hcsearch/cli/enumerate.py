"""`hcsearch enumerate`: the main job."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext, suppress
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
    with ProgressMeter(SHARE if plan.scene_stages else "batch") as meter, _compiling_ahead(plan):
        report = _Report(plan, meter)
        done = run_enumeration(plan, db, report.progress, report.announce, report.listed, dry=dry_run)
        report.judged(done.summary.funnel)
    _print_summary(done)
    _announce_none(plan, done.summary.funnel)


def _compiling_ahead(plan: Plan) -> AbstractContextManager[None]:
    """Compile the kernels of the quick check of deployments beside a run that comes to deployments."""
    if not plan.scene_stages:
        return nullcontext()
    from hcsearch.api.compiling import compiling_ahead

    return compiling_ahead("check")


class _Report:
    """The lines printed during a run: first the search, then each row of the funnel once it is final.

    A run whose lines cannot be written goes on, as its results are in the database: a line after it ends the command.
    """

    def __init__(self, plan: Plan, meter: ProgressMeter) -> None:
        self._plan, self._meter, self._begun = plan, meter, False

    def _begin(self) -> None:
        """Say what is searched, once: not before the run can begin, as in a database that can be read."""
        if self._begun:
            return
        self._begun, plan = True, self._plan
        target = plan.search.target or f"all arrays of {plan.search.n} cells"
        stages = [stage.name for stage in (*plan.listing_stages, *plan.scene_stages)]
        through = f"in the {'stages' if len(stages) > 1 else 'stage'} {listed(stages, 'and')}"
        self._line(f"searching the {plan.search.grid.name} grid, {target}, n = {plan.search.n}, {through}")

    def progress(self, done: int, total: int, note: str) -> None:
        self._begin()
        self._meter(done, total, note)

    def announce(self, sentence: str) -> None:
        self._begin()
        self._meter.write(sentence, err=True)

    def listed(self, funnel: Funnel) -> None:
        self._write("circuits of the array" if self._plan.search.target else "fixed circuits", funnel.fixed_circuits)
        self._write("non-isomorphic circuits", funnel.circuits)
        self._write("arrays" if self._plan.keep == "all" else f"arrays ({self._plan.keep})", funnel.arrays)
        self._write("two-stack", funnel.two_stack)
        self._write("untwisted", funnel.untwisted)

    def judged(self, funnel: Funnel) -> None:
        self._write("movable", funnel.movable)
        self._write("deployed by springs", funnel.deploys)

    def _write(self, label: str, count: int | None) -> None:
        self._line(f"  {label:24}{'-' if count is None else f'{count:,}':>16}")

    def _line(self, text: str) -> None:
        with suppress(OSError):  # a closed pipe, or a full device
            self._meter.write(text)


def _announce_none(plan: Plan, funnel: Funnel) -> None:
    """Say why there are no circuits, or why none of them folds."""
    from hcsearch.designs.folding import no_folding_reason

    if funnel.circuits == 0:
        click.echo("no circuits: no closed walk from panel to panel goes through each of them once", err=True)
    elif funnel.two_stack == 0:
        click.echo(f"nothing folds: {no_folding_reason(plan.search.n)}", err=True)


def _print_summary(done: Enumeration) -> None:
    from hcsearch.basics.simulation_summaries import accuracy_sentences, undecided_sentences

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
