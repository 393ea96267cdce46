"""All designs of single arrays, counted: full rectangles, and hexagons in rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import divisible, fold
from hcsearch.designs.grid import GRIDS, Array, parse_array
from hcsearch.designs.twisting import twist_batch
from hcsearch.search.enumeration import ArraySearch, count_array
from hcsearch.system.work_steps import Progress
from hcsearch_bench.run.bench import Say
from hcsearch_bench.tables.funnels import Patience

# beside all sides of 2 or more with up to 56 cells: those that docs/explanation/theory.md is about
LARGE_RECTANGLES = ("12x5", "10x6", "20x3", "16x4", "8x8", "9x8", "16x5")


@dataclass(frozen=True)
class RectangleRow:
    """Full rectangle of squares: circuits of the array, and classes of them up to its symmetries.

    unfolded : classes without a folding.
    """

    array: str
    n: int
    circuits: int | None = None
    classes: int | None = None
    two_stack: int | None = None
    untwisted: int | None = None
    unfolded: int | None = None


@dataclass(frozen=True)
class HexagonRow:
    """Hexagons in rows: circuits of the array, and classes of them up to its symmetries.

    divisible : classes with 6 | T, as only those that fold have; None where n is odd.
    least_twist : of all foldings, in full twists; None where nothing folds.
    """

    array: str
    n: int
    symmetry: int
    circuits: int
    classes: int
    divisible: int | None
    two_stack: int
    untwisted: int
    least_twist: int | None


@dataclass(frozen=True)
class _Designs:
    circuits: int
    classes: int
    divisible: int | None
    two_stack: int
    untwisted: int
    least_twist: int | None


def measure_rectangles(cells: int, more: Iterable[str], *, limit: float, say: Say) -> list[RectangleRow]:
    """One row a rectangle with an even number of cells and sides of 2 or more, up to `cells`, and those named more.

    limit : seconds for an array; one that takes longer has no numbers, and what is larger is not tried.
    """
    small = [(a, b) for b in range(2, cells) for a in range(b, cells // b + 1) if a * b % 2 == 0]
    named = [(int(a), int(b)) for a, b in (spec.split("x") for spec in more)]
    patience = Patience(limit)
    rows = []
    for a, b in sorted({*small, *named}, key=lambda sides: (sides[0] * sides[1], sides)):
        spec = f"{a}x{b}"
        say(f"square {spec}")
        numbers = patience.run("rectangle", partial(_designs, parse_array(GRIDS["square"], spec)))
        if numbers is not None and numbers.untwisted != numbers.two_stack:
            raise HcsearchError(
                f"square {spec}: {numbers}, but all foldings of a full rectangle are untwisted; report this"
            )
        rows.append(
            RectangleRow(spec, a * b)
            if numbers is None
            else RectangleRow(
                *(spec, a * b, numbers.circuits, numbers.classes),
                *(numbers.two_stack, numbers.untwisted, numbers.classes - numbers.two_stack),
            )
        )
    return rows


def measure_hexagon_rows(cells: int, *, say: Say) -> list[HexagonRow]:
    """One row an array of two to five rows of hexagons that has a circuit, of at most `cells`, by number of cells."""
    seen: set[Array] = set()
    rows = []
    for lengths in row_lengths(cells):
        array = parse_array(GRIDS["hex"], "-".join(map(str, lengths)))
        if array.canonical() in seen:
            continue
        seen.add(array.canonical())
        numbers = _designs(array, lambda *_: None)
        if numbers.circuits:
            rows.append(HexagonRow("-".join(map(str, lengths)), array.n, array.symmetry, **vars(numbers)))
    say(f"{len(rows)} arrays of hexagons in rows")
    return rows


def row_lengths(cells: int) -> list[tuple[int, ...]]:
    """Lengths of two to five rows, each by at most one different from the next, with `cells` cells or fewer."""
    lists: list[tuple[int, ...]] = []
    longest: list[tuple[int, ...]] = [(length,) for length in range(1, cells)]
    for _ in range(4):
        longest = [
            (*rows, length)
            for rows in longest
            for length in range(max(1, rows[-1] - 1), rows[-1] + 2)
            if sum(rows) + length <= cells
        ]
        lists += longest
    return sorted(lists, key=lambda rows: (sum(rows), len(rows), rows))


def _designs(array: Array, progress: Progress) -> _Designs:
    """List, fold and twist all circuits of an array; the classes must hold as many as are counted without listing."""
    search = ArraySearch(array)
    classes = copies = divide = two_stack = untwisted = 0
    least: int | None = None
    for batch in search.batches():
        foldings = fold(batch)
        twists = twist_batch(batch, foldings)
        classes += len(batch)
        divide += 0 if array.n % 2 else int(divisible(batch).sum())
        copies += int((search.group_order // batch.symmetry).sum())
        two_stack += len(np.unique(foldings.row))
        untwisted += len(np.unique(foldings.row[twists == 0]))
        if len(twists):
            least = int(twists.min()) if least is None else min(least, int(twists.min()))
        progress(copies, search.n_circuits, "")
    counted = count_array(array)
    if (copies, classes) != (counted.circuits, counted.classes):
        raise HcsearchError(
            f"{array}: {copies} circuits in {classes} classes are listed, but {counted.circuits} in "
            f"{counted.classes} counted; report this"
        )
    return _Designs(copies, classes, None if array.n % 2 else divide, two_stack, untwisted, least)
