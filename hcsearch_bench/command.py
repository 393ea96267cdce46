"""`hcsearch bench`: measurements."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from hcsearch.cli.options import Number
from hcsearch.outputs import check_folder, check_output

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hcsearch_bench.run.machine import Machine
    from hcsearch_bench.run.tables import Table
    from hcsearch_bench.tables.funnels import Pipeline

Command = Callable[..., Any]


class _Report(Protocol):
    """What every bench gives."""

    @property
    def machine(self) -> Machine: ...
    @property
    def tables(self) -> Sequence[Table]: ...


@click.group(epilog="Example: hcsearch bench enumeration --quick")
def bench() -> None:
    """Measure and compare: tables and plots of speed and memory, with machine and versions."""


def _checked(check: Callable[[Path], None]) -> Callable[[click.Context, click.Parameter, Path | None], Path | None]:
    """Refuse an output that could not be written before anything is measured."""

    def callback(_context: click.Context, _parameter: click.Parameter, path: Path | None) -> Path | None:
        if path is not None:
            check(path)
        return path

    return callback


def _common(name: str) -> Callable[[Command], Command]:
    """`--output`, `--quick` and `--json`, which every bench has."""
    output = click.option(
        "--output",
        type=Path,
        callback=_checked(check_folder),
        default=Path(f"reports/bench-{name}"),
        show_default=True,
        metavar="DIR",
        help="Folder for tables (CSV, Markdown), plots and machine.json.",
    )
    quick = click.option("--quick", is_flag=True, help="Small sizes, one run each: some seconds.")
    json_file = click.option(
        "--json",
        "json_file",
        type=Path,
        callback=_checked(check_output),
        metavar="FILE",
        help="All tables in one file.",
    )
    return lambda command: output(quick(json_file(command)))


_repeats = click.option(
    "--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="Runs to take medians of."
)


def _limit(default: str, what: str) -> Callable[[Command], Command]:
    return click.option("--limit", type=Number(min=0, min_open=True), help=f"Seconds for {what}.  [default: {default}]")


def _say(step: str) -> None:
    click.echo(step, err=True)


def _finish(report: _Report, save: Callable[[Path], None], output: Path, json_file: Path | None) -> None:
    """Print a report's tables, and save it."""
    from hcsearch_bench.run.tables import save_json, text

    click.echo(f"{report.machine}\n")
    for table in report.tables:
        click.echo(text(table))
    save(output)
    if json_file is not None:
        save_json(report.tables, report.machine, json_file)
    click.echo(f"saved in {output}")


@bench.command(epilog="Example: hcsearch bench enumeration --output reports/bench-enumeration --json bench.json")
@_common("enumeration")
@_repeats
@_limit("60, quick: 2", "a peer")
def enumeration(output: Path, quick: bool, repeats: int, limit: float | None, json_file: Path | None) -> None:
    """Circuits a second and memory against Graphillion, networkx and a plain backtracker, and cost as n grows.

    Every engine runs in a process of its own. Graphillion is an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch_bench.enumeration.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, limit=limit, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench folding --quick")
@_common("folding")
@_repeats
@_limit("180, quick: 60", "a process")
def folding(output: Path, quick: bool, repeats: int, limit: float | None, json_file: Path | None) -> None:
    """Designs that fold, joined from half-chains, against listing all circuits and filtering them."""
    from hcsearch_bench.folding.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, limit=limit, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench scale --postgresql postgresql://USER@HOST/postgres")
@_common("scale")
@_repeats
@click.option(
    "--postgresql",
    envvar="HCSEARCH_BENCH_POSTGRESQL",
    show_envvar=True,
    metavar="URL",
    help="A server to store into, where databases may be made and dropped.",
)
def scale(output: Path, quick: bool, repeats: int, postgresql: str | None, json_file: Path | None) -> None:
    """The whole command with one and two processes, on a Dask cluster of two workers, and into databases.

    The cluster is started for it; Dask is an extra: pip install 'hcsearch[cluster]'.
    """
    from hcsearch_bench.scale.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, postgresql=postgresql, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench kinematics --quick")
@_common("kinematics")
@_repeats
def kinematics(output: Path, quick: bool, repeats: int, json_file: Path | None) -> None:
    """Motions of linkages: error against time of path methods, branches, descents, extreme scenes."""
    from hcsearch_bench.kinematics.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench mobility --quick")
@_common("mobility")
@_repeats
def mobility(output: Path, quick: bool, repeats: int, json_file: Path | None) -> None:
    """The stage mobility: time of a folding, which foldings are locked, and what frees them."""
    from hcsearch_bench.mobility.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench iftomm --quick --json iftomm.json")
@_common("iftomm")
@_repeats
def iftomm(output: Path, quick: bool, repeats: int, json_file: Path | None) -> None:
    """Dynamics on the IFToMM benchmark problems A01 to A05: error, energy and time, beside other engines.

    MuJoCo, Pinocchio and Exudyn are an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch_bench.iftomm.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench dynamics --quick --output dynamics")
@_common("dynamics")
@_repeats
def dynamics(output: Path, quick: bool, repeats: int, json_file: Path | None) -> None:
    """Deployments: error against run time beside other engines, whole ones, cost of a panel, the quick check.

    MuJoCo, Pinocchio and Exudyn are an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch_bench.dynamics.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench collision --quick --json collision.json")
@_common("collision")
@_repeats
def collision(output: Path, quick: bool, repeats: int, json_file: Path | None) -> None:
    """Distances of pairs of panels, random, degenerate and stacked, and of all pairs of deployments, beside coal.

    coal comes with Pinocchio, an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch_bench.collision.bench import measure, save_report

    report = measure(quick=quick, repeats=repeats, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench stability --quick --json stability.json")
@_common("stability")
def stability(output: Path, quick: bool, json_file: Path | None) -> None:
    """Dynamics of extreme scenes, each with a verdict: accurate, degraded by a bound, refused with its reason.

    Stiffness, damping, thickness, masses, panels, starts, tolerances and restitution over many decades; a heat map.
    Then branches and verdicts with the linear algebra for other processors, beside this one's.
    """
    from hcsearch_bench.stability.bench import measure, save_report

    report = measure(quick=quick, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench planning --quick")
@_common("planning")
def planning(output: Path, quick: bool, json_file: Path | None) -> None:
    """The stage motion: share of foldings settled against work, margin and thickness, and searches beside OMPL.

    OMPL is an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch_bench.planning.bench import measure, save_report

    report = measure(quick=quick, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench experiment --quick")
@_common("experiment")
def experiment(output: Path, quick: bool, json_file: Path | None) -> None:
    """The thesis's deployment of the 4x4 array: equal, tuned and catalogue springs; gravity and panel held tried."""
    from hcsearch_bench.experiment.bench import measure, save_report

    report = measure(quick=quick, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench identification --quick --json identification.json")
@_common("identification")
def identification(output: Path, quick: bool, json_file: Path | None) -> None:
    """Springs and damping from made-up measurements with known laws: error against noise, and the error told."""
    from hcsearch_bench.identification.bench import measure, save_report

    report = measure(quick=quick, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench tables --output docs")
@_common("tables")
@_limit("600, quick: 10", "a search")
def tables(output: Path, quick: bool, limit: float | None, json_file: Path | None) -> None:
    """How many designs there are, on all arrays of n cells and on single arrays: docs/tables.md."""
    from hcsearch_bench.tables.bench import measure, save_report

    report = measure(_pipeline(), quick=quick, limit=limit, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


@bench.command(epilog="Example: hcsearch bench deployability --quick")
@_common("deployability")
def deployability(output: Path, quick: bool, json_file: Path | None) -> None:
    """Which untwisted foldings come flat without a collision, and what helps the others: docs/tables.md."""
    from hcsearch_bench.deployability.bench import measure, save_report

    report = measure(quick=quick, say=_say)
    _finish(report, lambda folder: save_report(report, folder), output, json_file)


def _pipeline() -> Pipeline:
    """What the rows of `tables` are made with."""
    from hcsearch.pipeline import Crew, Plan, count_designs, run_dry
    from hcsearch_bench.tables.funnels import Pipeline

    return Pipeline(
        funnel=lambda search, keep, progress: (
            run_dry(
                Plan(search, "twist", keep), lambda done, total, note, unit="batch": progress(done, total, note)
            ).funnel
        ),
        count=lambda search, keep, progress: count_designs(search, keep, Crew(), progress).classes,
    )
