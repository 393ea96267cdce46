"""Options that several commands share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import KEEPS
from hcsearch.designs.grid import GRIDS
from hcsearch.system.machine import default_database

Command = Callable[..., Any]


class FiniteNumber(click.FloatRange):
    """A finite number within optional bounds; the types of click accept `nan`."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Parse a number; click.BadParameter if it is none, not finite or out of bounds."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{number} is not a finite number.", param, ctx)
        return number

    def _describe_range(self) -> str:
        """Return the bounds for the help text; click would show None for missing ones."""
        return "" if self.min is None and self.max is None else super()._describe_range()

    def __repr__(self) -> str:
        return f"Number({self._describe_range()})"


def examples_epilog(*commands: str) -> str:
    """Return the examples that end a command's help, one per line."""
    return "\b\nExample: " + "\n         ".join(commands)  # click keeps the lines that follow the character \b


def database_option(command: Command) -> Command:
    """Add `--db`, by default HCSEARCH_DB, else hcsearch.sqlite in the current folder."""
    return click.option(
        "--db",
        metavar="PATH|URL",
        default=default_database,
        help="The database: a file, or the URL of an SQLite or PostgreSQL database.  [default: $HCSEARCH_DB, else "
        "hcsearch.sqlite]",
    )(command)


def query_argument(command: Command) -> Command:
    """Add the argument `condition` for a query: one or, unquoted in a shell, several words."""
    return click.argument("condition", nargs=-1, metavar="[QUERY]", callback=joined_words)(command)


def joined_words(_ctx: click.Context, _param: click.Parameter, words: tuple[str, ...]) -> str:
    """Join the words of an argument."""
    return " ".join(words)


def json_option(command: Command) -> Command:
    """Add `--json` for the results as JSON instead of lines for people."""
    return click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")(command)


def target_options(command: Command) -> Command:
    """Add `--grid` with `--n` or `--array`, and `--keep`."""
    for option in (
        click.option(
            "--keep",
            type=click.Choice(KEEPS),
            default="all",
            show_default=True,
            help="Which designs are kept: all, those that fold into two stacks, or those that fold without twist.",
        ),
        click.option(
            "--array", "array_spec", metavar="SPEC", help="Search one array: 6x5, 3-4-3, p5x4, t5, h3, s1 or @FILE."
        ),
        click.option("--n", type=int, metavar="N", help="Search all arrays of N cells."),
        click.option(
            "--grid", type=click.Choice(tuple(GRIDS)), required=True, help="The tiling whose cells are the panels."
        ),
    ):
        command = option(command)
    return command


def worker_options(command: Command) -> Command:
    """Add `--jobs` and `--scheduler` for the workers."""
    for option in (
        click.option(
            "--scheduler", metavar="ADDRESS", help="Use the Dask cluster at this address, such as tcp://HOST:8786."
        ),
        click.option(
            "--jobs",
            type=click.IntRange(min=1),
            metavar="K",
            help="Number of processes, at most four per core.  [default: one per core]",
        ),
    ):
        command = option(command)
    return command


def named_numbers(
    texts: Sequence[str], twice: Callable[[str], HcsearchError]
) -> Iterator[tuple[str, str, float | None]]:
    """Yield text, name and number of each text NAME=NUMBER; the number is None if it cannot be parsed.

    twice : returns the error for a repeated name.
    """
    names = set()
    for text in texts:
        name, _, value = text.partition("=")
        if name in names:
            raise twice(name)
        names.add(name)
        number: float | None = None
        with suppress(ValueError):
            number = float(value)
        yield text, name, number
