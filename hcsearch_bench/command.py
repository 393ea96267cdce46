"""`hcsearch bench`: all benches as commands, none of which is loaded for the help of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import FiniteNumber, examples_epilog
from hcsearch.system.outputs import check_folder, check_output

if TYPE_CHECKING:
    from hcsearch_bench.run.bench import Bench, BenchReport


class _Benches(click.Group):
    """The group of all benches, which are read where one of them is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        from hcsearch_bench.benches import BENCHES

        return sorted(BENCHES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        from hcsearch_bench.benches import BENCHES

        return command_of(BENCHES[cmd_name]) if cmd_name in BENCHES else None


@click.group(cls=_Benches, epilog=examples_epilog("hcsearch bench enumeration --quick"))
def bench() -> None:
    """Measure speed, memory and accuracy.

    Each command writes tables and plots, with the machine and the versions, and compares with other programs.
    """


def command_of(own: Bench[Any]) -> click.Command:
    """The command of a bench."""

    def run(output: Path, json_file: Path | None, **options: Any) -> None:
        _finish(own.run(say=_say, **options), output, json_file)

    return click.Command(
        own.name, callback=run, params=_options(own), help=own.summary, epilog=examples_epilog(own.example)
    )


def _options(own: Bench[Any]) -> list[click.Parameter]:
    """`--output`, `--quick` and `--json`, which every bench has, and those of a bench's own."""
    output = click.Option(
        ["--output"],
        type=Path,
        callback=_checked(check_folder),
        default=Path(f"reports/bench-{own.name}"),
        show_default=True,
        metavar="DIR",
        help="The folder for tables (CSV, Markdown), plots and machine.json.",
    )
    quick = click.Option(["--quick"], is_flag=True, help="Measure small sizes once each, in some seconds.")
    json_file = click.Option(
        ["--json", "json_file"],
        type=Path,
        callback=_checked(check_output),
        metavar="FILE",
        help="Also write all tables to one file.",
    )
    options: list[click.Parameter] = [output, quick, json_file]
    if own.repeats:
        how = "The number of runs, of which medians are taken."
        options.append(click.Option(["--repeats"], type=click.IntRange(min=1), default=3, show_default=True, help=how))
    if (limit := own.limit) is not None:
        greatest = f"The greatest time for {limit.what}, s.  [default: {limit.usual:g}, quick: {limit.quick:g}]"
        options.append(click.Option(["--limit"], type=FiniteNumber(min=0, min_open=True), help=greatest))
    if own.server:
        postgresql = click.Option(
            ["--postgresql"],
            envvar="HCSEARCH_BENCH_POSTGRESQL",
            show_envvar=True,
            metavar="URL",
            help="A server on which databases may be made and dropped.",
        )
        options.append(postgresql)
    return options


def _checked(check: Callable[[Path], None]) -> Callable[[click.Context, click.Parameter, Path | None], Path | None]:
    """Refuse an output that could not be written before anything is measured."""

    def callback(_context: click.Context, _parameter: click.Parameter, path: Path | None) -> Path | None:
        if path is not None:
            check(path)
        return path

    return callback


def _say(step: str) -> None:
    click.echo(step, err=True)


def _finish(report: BenchReport[Any], output: Path, json_file: Path | None) -> None:
    """Print a report's tables, and save it."""
    from hcsearch_bench.run.table import save_json, text

    click.echo(f"{report.machine}\n")
    for table in report.tables:
        click.echo(text(table))
    report.save(output)
    if json_file is not None:
        save_json(report.tables, report.machine, json_file)
    click.echo(f"saved in {output}")
