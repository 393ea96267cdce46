"""`hcsearch bench`: measurements."""

from __future__ import annotations

from pathlib import Path

import click


@click.group(epilog="Example: hcsearch bench enumeration --quick")
def bench() -> None:
    """Measure and compare: tables and plots of speed and memory, with machine and versions."""


@bench.command(epilog="Example: hcsearch bench enumeration --output reports/bench-enumeration --json bench.json")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("reports/bench-enumeration"),
    show_default=True,
    metavar="DIR",
    help="Folder for tables (CSV, Markdown), plots and machine.json.",
)
@click.option("--quick", is_flag=True, help="Small sizes, one run each: some seconds.")
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True, help="Runs to take medians of.")
@click.option(
    "--limit", type=click.FloatRange(min=0, min_open=True), help="Seconds for a peer.  [default: 60, quick: 2]"
)
@click.option(
    "--json",
    "json_file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="All tables in one file.",
)
def enumeration(output: Path, quick: bool, repeats: int, limit: float | None, json_file: Path | None) -> None:
    """Circuits a second and memory against Graphillion, networkx and a plain backtracker, and cost as n grows.

    Every engine runs in a process of its own. Graphillion is an extra: pip install 'hcsearch[bench]'.
    """
    from hcsearch.bench.enumeration import measure, save_report  # noqa: PLC0415
    from hcsearch.bench.tables import save_json, text  # noqa: PLC0415

    report = measure(quick=quick, repeats=repeats, limit=limit, say=lambda step: click.echo(step, err=True))
    click.echo(f"{report.machine}\n")
    for table in report.tables:
        click.echo(text(table))
    save_report(report, output)
    if json_file is not None:
        save_json(report.tables, report.machine, json_file)
    click.echo(f"saved in {output}")
