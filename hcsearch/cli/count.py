"""`hcsearch count`: exact counts, without storing circuits."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.vocabulary import Keep
from hcsearch.cli.options import examples_epilog, several_sizes_option, target_options, worker_options
from hcsearch.cli.progress import SHARE, ProgressMeter
from hcsearch.designs.grid.sequences import known_sequences

if TYPE_CHECKING:
    from hcsearch.api.counting import CircuitCount, CountTable
    from hcsearch.search.enumeration.growth import Growth

_FORMATS = ("text", "csv", "json")


def _sequences_epilog() -> str:
    """Return the sequences of the OEIS that the command computes, one per line."""
    lines = (
        f"  {s.number}  {s.grid + (f' --array {s.array}' if s.array else ''):24}{s.counts:9} {s.term:14} {s.lattice}"
        for s in known_sequences()
    )
    return (
        "\n\nA circuit on N cells is a self-avoiding polygon of N steps (SAP) on the graph of cells, a circuit of an "
        "array a Hamiltonian cycle: hexagons are the vertices of the triangular lattice, triangles those of the "
        "honeycomb."
        "\n\n\b\nSequences of the OEIS (--grid, counts, term, lattice):\n" + "\n".join(lines)
    )


@click.command(
    epilog=examples_epilog(
        "hcsearch count --grid square --array 12x12",
        "hcsearch count --grid hex --n 20 --keep untwisted",
        "hcsearch count --grid hex --n 6-16 --format csv",
    )
    + _sequences_epilog()
)
@partial(target_options, sizes_option=several_sizes_option)
@worker_options
@click.option(
    "--format", "style", type=click.Choice(_FORMATS), default="text", show_default=True, help="How counts are printed."
)
def count(
    grid: str,
    n: int | list[int] | None,
    array_spec: str | None,
    keep: Keep,
    jobs: int | None,
    scheduler: str | None,
    style: str,
) -> None:
    """Count circuits, or designs that fold, exactly.

    The command prints the number of all circuits and their number up to symmetry; with --keep it counts only those that
    fold. Circuits of one array are counted by the states of a frontier, without listing them; designs that fold, over
    all arrays of N cells, by joining half-chains; all others by listing them.

    For several N it prints a row for each, with the ratio to the count before and the growth constant mu, from a fit of
    C mu^n n^g to the circuits up to there; beside designs that fold, all circuits are counted where that takes seconds.
    """
    from hcsearch.api import counting

    is_single_array = array_spec is not None and keep == "all"
    with ProgressMeter("edge" if is_single_array else SHARE if isinstance(n, list) else "batch") as meter:
        options: dict[str, Any] = {"grid": grid, "n": n, "array": array_spec, "keep": keep}
        counted: CircuitCount | CountTable = counting.count(
            **options,
            jobs=jobs,
            scheduler=scheduler,
            progress=meter,
            announce=lambda sentence: click.echo(sentence, err=True),
        )
    if style != "text":
        _print_records(counted.records(), style)
    elif isinstance(counted, counting.CountTable):
        _print_table(counted)
    else:
        _print_count(counted)


def _print_records(records: list[dict[str, object]], style: str) -> None:
    from hcsearch.store import Rows, format_rows

    names = tuple(records[0])
    rows = Rows(names, (None,) * len(names), iter([[tuple(record.values()) for record in records]]))
    for text in format_rows(rows, style):
        click.echo(text, nl=False)


def _print_count(counted: CircuitCount) -> None:
    from hcsearch.designs.folding import no_folding_reason
    from hcsearch.search.enumeration import ArraySearch

    search, keep = counted.search, counted.keep
    if isinstance(search, ArraySearch):
        click.echo(f"array              {search.array.notation}")
        click.echo(f"cells              {search.array.n}")
        click.echo(f"array symmetry     {search.group_order}")
    else:
        click.echo(f"panels             {search.n}")
    circuits = "circuits" if isinstance(search, ArraySearch) else "fixed circuits"
    if keep != "all":
        click.echo(f"kept               {keep}")
    click.echo(f"{circuits:<19}{counted.circuits}")
    click.echo(f"{'up to symmetry':<19}{counted.classes}")
    if keep != "all" and search.n % 2:
        click.echo(f"nothing folds: {no_folding_reason(search.n)}", err=True)


def _print_table(counted: CountTable) -> None:
    from tabulate import tabulate

    from hcsearch.system.terminal import short_number

    hidden = ("_error", "exponent", "_oeis", "biased_mu")  # the lines below have them
    records = []
    for row, record in zip(counted.rows, counted.records(), strict=True):
        mu = None if row.growth is None else _with_error(row.growth.mu, row.growth.mu_error)
        records.append({name: value for name, value in (record | {"mu": mu}).items() if not name.endswith(hidden)})

    def cell(value: object) -> str:
        return "-" if value is None else short_number(value, 6) if isinstance(value, float) else str(value)

    cells = [[cell(value) for value in record.values()] for record in records]
    click.echo(tabulate(cells, headers=list(records[0]), disable_numparse=True, colalign=["right"] * len(records[0])))
    click.echo()
    click.echo(f"{'growth constant':<19}{_growth_text(counted.growth)}")
    if counted.keep == "all":
        click.echo(f"{'exponent -5/2':<19}{_growth_text(counted.biased_growth)}")
    for label, number in (("all circuits", counted.circuits_oeis), ("their classes", counted.classes_oeis)):
        if number is not None:
            click.echo(f"{label:<19}OEIS {number}")


def _growth_text(growth: Growth | None) -> str:
    if growth is None:
        return "not determined: it takes more N, most where counts rise and fall"
    exponent = f", exponent {_with_error(growth.exponent, growth.exponent_error)}" if growth.exponent_error else ""
    return f"mu = {_with_error(growth.mu, growth.mu_error)}{exponent}"


def _with_error(value: float, error: float) -> str:
    """Return a value with its error in units of the last digits, such as 4.161(70)."""
    places = max(0, 1 - math.floor(math.log10(error))) if error > 0 else 6
    return f"{value:.{places}f}({round(error * 10**places)})"
