"""Options that several commands share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
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


class PanelNumbers(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """A number of panels, or several: a range such as 6-16, or a list such as 6,8,10-14; a list of them for several."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | list[int]:
        """Parse the numbers; click.BadParameter for another text, or for a range that is empty or too long."""
        ranges = []
        for part in str(value).split(","):
            match = re.fullmatch(r"\s*(-?[0-9]{1,6})\s*(?:-\s*([0-9]{1,6})\s*)?", part)
            if match is None:
                self.fail(f"{value!r} is no number of panels: write 12, a range 6-16 or a list 6,8,10.", param, ctx)
            first, last = int(match[1]), int(match[2] or match[1])
            if last < first:
                self.fail(f"the range {part.strip()} is empty: write the smaller number first.", param, ctx)
            ranges.append(range(first, last + 1))
        if sum(map(len, ranges)) > _MOST_NUMBERS:
            self.fail(f"{value!r} has more than {_MOST_NUMBERS} numbers: ask for fewer.", param, ctx)
        return ranges[0][0] if str(value).strip().lstrip("-").isdigit() else [*chain.from_iterable(ranges)]


_MOST_NUMBERS = 1000  # none above 120 is searched: the others are refused by name


def one_size_option(command: Command) -> Command:
    """Add `--n` for one number of cells."""
    return click.option("--n", type=int, metavar="N", help="Search all arrays of N cells.")(command)


def several_sizes_option(command: Command) -> Command:
    """Add `--n` for one number of cells, or several."""
    return click.option(
        "--n",
        type=PanelNumbers(),
        metavar="N|RANGE",
        help="Count on all arrays of N cells, for one N, a range (6-16) or a list (6,8,10).",
    )(command)


def target_options(command: Command, sizes_option: Callable[[Command], Command] = one_size_option) -> Command:
    """Add `--grid` with `--n`, as an option of its own adds it, or `--array`, and `--keep`."""
    for option in (
        click.option(
            "--keep",
            type=click.Choice(KEEPS),
            default="all",
            show_default=True,
            help="Which designs are kept: all, those that fold into two stacks, or those that fold without twist.",
        ),
        click.option(
            "--array",
            "array_spec",
            metavar="SPEC",
            help="Search one array: 6x5, 3-4-3, p5x4, t5, h3, s1, @FILE or a drawing, 'XXX / X.X'.",
        ),
        sizes_option,
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
