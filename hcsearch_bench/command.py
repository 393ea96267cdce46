"""`hcsearch bench`: all benches as commands, each loaded when it runs."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from hcsearch.cli.options import Number
from hcsearch.system.outputs import check_folder, check_output

if TYPE_CHECKING:
    from hcsearch_bench.run.report import BenchReport

Command = Callable[..., Any]


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


_REPEATS = click.option(
    "--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="Runs to take medians of."
)


def _limit(default: str, what: str) -> Callable[[Command], Command]:
    return click.option("--limit", type=Number(min=0, min_open=True), help=f"Seconds for {what}.  [default: {default}]")


def _say(step: str) -> None:
    click.echo(step, err=True)


def _finish(report: BenchReport, output: Path, json_file: Path | None) -> None:
    """Print a report's tables, and save it."""
    from hcsearch_bench.run.tables import save_json, text

    click.echo(f"{report.machine}\n")
    for table in report.tables:
        click.echo(text(table))
    report.save(output)
    if json_file is not None:
        save_json(report.tables, report.machine, json_file)
    click.echo(f"saved in {output}")


_POSTGRESQL = click.option(
    "--postgresql",
    envvar="HCSEARCH_BENCH_POSTGRESQL",
    show_envvar=True,
    metavar="URL",
    help="A server to store into, where databases may be made and dropped.",
)


class _Bench(NamedTuple):
    """One bench: its folder, the help of its command, an example, and options beside the common ones."""

    name: str
    text: str
    example: str
    options: tuple[Callable[[Command], Command], ...] = ()


_BENCHES = (
    _Bench(
        "enumeration",
        "Circuits a second and memory against Graphillion, networkx and a plain backtracker, and cost as n grows.\n"
        "\n"
        "Every engine runs in a process of its own. Graphillion is an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench enumeration --output reports/bench-enumeration --json bench.json",
        (_REPEATS, _limit("60, quick: 2", "a peer")),
    ),
    _Bench(
        "folding",
        "Designs that fold, joined from half-chains, against listing all circuits and filtering them.",
        "hcsearch bench folding --quick",
        (_REPEATS, _limit("180, quick: 60", "a process")),
    ),
    _Bench(
        "scale",
        "The whole command with one and two processes, on a Dask cluster of two workers, and into databases.\n"
        "\n"
        "The cluster is started for it; Dask is an extra: pip install 'hcsearch[cluster]'.",
        "hcsearch bench scale --postgresql postgresql://USER@HOST/postgres",
        (_REPEATS, _POSTGRESQL),
    ),
    _Bench(
        "kinematics",
        "Motions of linkages: error against time of path methods, branches, descents, extreme scenes.",
        "hcsearch bench kinematics --quick",
        (_REPEATS,),
    ),
    _Bench(
        "mobility",
        "The stage mobility: time of a folding, which foldings are locked, and what frees them.",
        "hcsearch bench mobility --quick",
        (_REPEATS,),
    ),
    _Bench(
        "iftomm",
        "Dynamics on the IFToMM benchmark problems A01 to A05: error, energy and time, beside other engines.\n"
        "\n"
        "MuJoCo, Pinocchio and Exudyn are an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench iftomm --quick --json iftomm.json",
        (_REPEATS,),
    ),
    _Bench(
        "dynamics",
        "Deployments: error against run time beside other engines, whole ones, cost of a panel, the quick check.\n"
        "\n"
        "MuJoCo, Pinocchio and Exudyn are an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench dynamics --quick --output dynamics",
        (_REPEATS,),
    ),
    _Bench(
        "collision",
        "Distances of pairs of panels, random, degenerate and stacked, and of all pairs of deployments, beside coal.\n"
        "\n"
        "coal comes with Pinocchio, an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench collision --quick --json collision.json",
        (_REPEATS,),
    ),
    _Bench(
        "stability",
        "Dynamics of extreme scenes, each with a verdict: accurate, degraded by a bound, refused with its reason.\n"
        "\n"
        "Stiffness, damping, thickness, masses, panels, starts, tolerances and restitution over many decades; a heat "
        "map.\n"
        "Then branches and verdicts with the linear algebra for other processors, beside this one's.",
        "hcsearch bench stability --quick --json stability.json",
    ),
    _Bench(
        "planning",
        "The stage motion: share of foldings settled against work, margin and thickness, and searches beside OMPL.\n"
        "\n"
        "OMPL is an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench planning --quick",
    ),
    _Bench(
        "experiment",
        "The thesis's deployment of the 4x4 array: equal, tuned and catalogue springs; gravity and panel held tried.",
        "hcsearch bench experiment --quick",
    ),
    _Bench(
        "identification",
        "Springs and damping from made-up measurements with known laws: error against noise, and the error reported.",
        "hcsearch bench identification --quick --json identification.json",
    ),
    _Bench(
        "tables",
        "How many designs there are, on all arrays of n cells and on single arrays: docs/measurements/tables.md.",
        "hcsearch bench tables --output docs/measurements",
        (_limit("600, quick: 10", "a search"),),
    ),
    _Bench(
        "deployability",
        "Which untwisted foldings come flat without a collision, and what helps the others: "
        "docs/measurements/tables.md.",
        "hcsearch bench deployability --quick",
    ),
)


def _add(own: _Bench) -> None:
    """Add the command of a bench to the group."""

    def run(output: Path, quick: bool, json_file: Path | None, **options: Any) -> None:
        measure = import_module(f"hcsearch_bench.{own.name}.bench").measure
        _finish(measure(quick=quick, say=_say, **options), output, json_file)

    command: Command = run
    for option in reversed(own.options):
        command = option(command)
    command = _common(own.name)(command)
    bench.command(own.name, help=own.text, epilog=f"Example: {own.example}")(command)


for _one in _BENCHES:
    _add(_one)
