"""`hcsearch bench`: all benches as commands, each loaded when it runs."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from hcsearch.cli.options import Number, examples
from hcsearch.system.outputs import check_folder, check_output

if TYPE_CHECKING:
    from hcsearch_bench.run.report import BenchReport

Command = Callable[..., Any]


@click.group(epilog=examples("hcsearch bench enumeration --quick"))
def bench() -> None:
    """Measure speed, memory and accuracy.

    Each command writes tables and plots, with the machine and the versions, and compares with other programs.
    """


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
        help="The folder for tables (CSV, Markdown), plots and machine.json.",
    )
    quick = click.option("--quick", is_flag=True, help="Measure small sizes once each, in some seconds.")
    json_file = click.option(
        "--json",
        "json_file",
        type=Path,
        callback=_checked(check_output),
        metavar="FILE",
        help="Also write all tables to one file.",
    )
    return lambda command: output(quick(json_file(command)))


_REPEATS = click.option(
    "--repeats",
    type=click.IntRange(min=1),
    default=3,
    show_default=True,
    help="The number of runs, of which medians are taken.",
)


def _limit(default: str, what: str) -> Callable[[Command], Command]:
    return click.option(
        "--limit", type=Number(min=0, min_open=True), help=f"The greatest time for {what}, s.  [default: {default}]"
    )


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
    help="A server on which databases may be made and dropped.",
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
        "Measure how fast circuits are listed. Compares with Graphillion, networkx and a plain backtracker.\n"
        "\n"
        "Each program runs in its own process. Graphillion comes with an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench enumeration --output reports/bench-enumeration --json bench.json",
        (_REPEATS, _limit("60, quick: 2", "a peer")),
    ),
    _Bench(
        "folding",
        "Measure how fast designs that fold are listed. Compares half-chains with filtering all circuits.",
        "hcsearch bench folding --quick",
        (_REPEATS, _limit("180, quick: 60", "a process")),
    ),
    _Bench(
        "scale",
        "Measure whole searches. Uses one and two processes, a Dask cluster of two workers, and databases.\n"
        "\n"
        "The command starts the cluster; Dask comes with an extra: pip install 'hcsearch[cluster]'.",
        "hcsearch bench scale --postgresql postgresql://USER@HOST/postgres",
        (_REPEATS, _POSTGRESQL),
    ),
    _Bench(
        "kinematics",
        "Measure the kinematics of linkages. Errors and times of path methods, branches, descents, extreme scenes.",
        "hcsearch bench kinematics --quick",
        (_REPEATS,),
    ),
    _Bench(
        "mobility",
        "Measure the stage mobility. Its time, which foldings are locked, and what frees them.",
        "hcsearch bench mobility --quick",
        (_REPEATS,),
    ),
    _Bench(
        "iftomm",
        "Measure the dynamics on published problems. Errors, energies and times for A01 to A05 of IFToMM, beside other "
        "programs.\n"
        "\n"
        "MuJoCo, Pinocchio and Exudyn come with an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench iftomm --quick --json iftomm.json",
        (_REPEATS,),
    ),
    _Bench(
        "dynamics",
        "Measure deployments. Errors and times beside other programs, whole deployments, and quick checks.\n"
        "\n"
        "MuJoCo, Pinocchio and Exudyn come with an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench dynamics --quick --output dynamics",
        (_REPEATS,),
    ),
    _Bench(
        "collision",
        "Measure distances of panels. Compares random, degenerate, stacked and moving pairs with coal.\n"
        "\n"
        "coal comes with Pinocchio, in an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench collision --quick --json collision.json",
        (_REPEATS,),
    ),
    _Bench(
        "stability",
        "Measure the dynamics of extreme scenes. Each is accurate, less accurate within a bound, or refused.\n"
        "\n"
        "Stiffness, damping, thickness, masses, panels, starts, tolerances and restitution vary over many decades.\n"
        "Branches and verdicts are also computed with the linear algebra of other processors.",
        "hcsearch bench stability --quick --json stability.json",
    ),
    _Bench(
        "planning",
        "Measure the stage motion. Foldings settled against work, margin and thickness, and searches beside OMPL.\n"
        "\n"
        "OMPL comes with an extra: pip install 'hcsearch[bench]'.",
        "hcsearch bench planning --quick",
    ),
    _Bench(
        "experiment",
        "Repeat the experiment of the thesis. The 4x4 array with equal, tuned and catalogue springs and gravity.",
        "hcsearch bench experiment --quick",
    ),
    _Bench(
        "identification",
        "Measure errors of identified springs and damping. Measurements are simulated, with known laws and noise.",
        "hcsearch bench identification --quick --json identification.json",
    ),
    _Bench(
        "tables",
        "Count designs on all arrays of n cells and on single arrays. For docs/measurements/tables.md.",
        "hcsearch bench tables --output docs/measurements",
        (_limit("600, quick: 10", "a search"),),
    ),
    _Bench(
        "deployability",
        "Count foldings that springs open, and what helps the others. For docs/measurements/tables.md.",
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
    bench.command(own.name, help=own.text, epilog=examples(own.example))(command)


for _one in _BENCHES:
    _add(_one)
