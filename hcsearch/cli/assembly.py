"""`hcsearch assembly`: the named assemblies of the thesis and their computed properties."""

from __future__ import annotations

import json
from typing import Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.options import FiniteNumber, examples_epilog
from hcsearch.system.outputs import check_output, write_output


@click.command(
    epilog=examples_epilog(
        "hcsearch assembly list",
        "hcsearch assembly unit-ii --alpha 70 --base 30 --thickness 10 --picture unit-ii.svg",
        "hcsearch assembly array-6r 3x2 --json",
    )
)
@click.argument("name", metavar="NAME|list")
@click.argument("size", required=False)
@click.option("--alpha", type=FiniteNumber(), metavar="DEGREES", help="The base angle of isosceles triangles, degrees.")
@click.option("--base", type=FiniteNumber(), metavar="MM", help="The base of isosceles triangles, mm.")
@click.option("--thickness", type=FiniteNumber(), metavar="MM", help="The thickness of all panels, mm.")
@click.option("--side", type=FiniteNumber(), metavar="MM", help="The side of squares, or the length of rectangles, mm.")
@click.option("--width", type=FiniteNumber(), metavar="MM", help="The width of rectangles, mm.")
@click.option(
    "--json", "as_json", is_flag=True, help="Print the results as JSON; undecided values are null, with the reason."
)
@click.option("--picture", metavar="FILE", help="Also draw the flat pattern into a file .svg.")
def assembly(
    name: str, size: str | None, alpha: float | None, as_json: bool, picture: str | None, **lengths: float | None
) -> None:
    """Print the properties of an assembly of the thesis.

    `hcsearch assembly list` prints the names of all assemblies with their default sizes. SIZE is the number of columns
    and rows of assemblies that can have any size, such as 3x2.
    """
    from hcsearch.api import describing

    given_lengths = {name: length for name, length in lengths.items() if length is not None}
    if name == "list":
        if size is not None or alpha is not None or given_lengths or picture:
            raise HcsearchError("the list has no parameters: give them with the name of an assembly")
        _print_list(describing.list_assemblies(), as_json)
        return
    parameters = given_lengths | {"alpha": alpha, "size": size}
    if picture is not None:
        check_output(picture)
        write_output(picture, describing.draw_assembly(name, parameters))
    facts = describing.describe(name, **parameters)
    if as_json:
        click.echo(json.dumps(facts, indent=2, allow_nan=False))
        return
    from hcsearch.library.assemblies.description import fact_lines

    for line in fact_lines(facts):
        click.echo(line)


def _print_list(rows: list[dict[str, Any]], as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(rows, indent=2))
        return
    from hcsearch.library.assemblies.description import fact_text

    table = [(row["name"], row["title"], row["source"], fact_text(row["parameters"])) for row in rows]
    widths = [max(len(str(row[k])) for row in table) for k in range(3)]
    for row in table:
        padded = "  ".join(str(text).ljust(width) for text, width in zip(row, widths, strict=False))
        click.echo(f"{padded}  {row[3]}")
