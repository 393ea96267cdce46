"""How many designs there are on all arrays of n cells: a row a grid and n, with the laws it must obey."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import divisible
from hcsearch.designs.grid import Grid, grid_named
from hcsearch.search.enumeration import PolygonSearch, Search, search_all
from hcsearch.search.pipeline import Funnel, Plan, WorkerPool, count_designs, run_dry
from hcsearch.system.work_steps import Progress
from hcsearch_bench.run.bench import Say

T = TypeVar("T")

# first n, last n with the whole funnel, last n of all
SIZES = {
    "triangle": (6, 44, 50),
    "square": (4, 28, 34),
    "rectangle": (4, 26, 30),
    "hex": (3, 20, 24),
    "rhombus": (3, 26, 32),
    "kite": (3, 26, 32),
    "right45": (4, 42, 50),
    "right30": (4, 42, 50),
    "obtuse": (3, 48, 56),
}
QUICK = {
    "triangle": (6, 18, 20),
    "square": (4, 12, 14),
    "rectangle": (4, 10, 10),
    "hex": (3, 11, 12),
    "rhombus": (3, 9, 10),
    "kite": (3, 9, 10),
    "right45": (4, 14, 16),
    "right30": (4, 14, 16),
    "obtuse": (11, 14, 15),
}


@dataclass(frozen=True)
class FunnelRow:
    """All designs of n cells; None where it was not computed.

    fixed : circuits up to translation; free : up to congruence, as are all numbers that follow.
    arrays : those with a circuit; untwisted_arrays : those with an untwisted design.
    divisible, share : how many circuits have a number m of directions that divides the alternating sum T of their
    turns, as only those that fold do, and their share; not defined for odd n.
    """

    grid: str
    n: int
    fixed: int | None
    free: int | None
    arrays: int | None
    divisible: int | None
    share: float | None
    two_stack: int | None
    untwisted: int | None
    untwisted_arrays: int | None


class LateError(Exception):
    """A cell of a table takes longer than its limit."""


class Patience:
    """Does each kind of task as long as it stays within a limit of seconds, and never again once it has not."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self._beaten: set[str] = set()

    def run(self, task: str, work: Callable[[Progress], T]) -> T | None:
        """The result of some work, which reports its progress; None when it is late, or was before."""
        if task in self._beaten:
            return None
        begin = time.perf_counter()

        def check(*_: object) -> None:
            if time.perf_counter() - begin > self.limit:
                raise LateError

        try:
            return work(check)
        except LateError:
            self._beaten.add(task)
            return None


def measure_funnels(sizes: Mapping[str, tuple[int, int, int]], *, limit: float, say: Say) -> list[FunnelRow]:
    """One row a grid and n, in this process; HcsearchError when a law is broken.

    limit : seconds for each of a row's searches; one that takes longer is not tried on larger n.
    """
    return [row for name, (first, full, last) in sizes.items() for row in _grid(name, first, full, last, limit, say)]


def _grid(name: str, first: int, full: int, last: int, limit: float, say: Say) -> Iterator[FunnelRow]:
    patience = Patience(limit)
    grid = grid_named(name)
    for n in range(first, last + 1, 2 if grid.has_two_colours else 1):
        say(f"{name} n={n}: {'funnel' if n <= full else 'two-stack and untwisted designs'}")
        row = _funnel(grid, n, patience) if n <= full else None
        yield row or _counted(grid, n, patience)


def _funnel(grid: Grid, n: int, patience: Patience) -> FunnelRow | None:
    """All columns; None when that takes too long."""
    funnel = patience.run("all", partial(_run, PolygonSearch(grid, n), "all"))
    if funnel is None:
        return None
    row = FunnelRow(
        *(grid.name, n, funnel.fixed_circuits, funnel.circuits),
        *(funnel.arrays, None, None, funnel.two_stack, funnel.untwisted, None),
    )
    divide = None if n % 2 else patience.run("divisible", partial(_divisible, PolygonSearch(grid, n)))
    if divide is not None:
        row = replace(row, divisible=divide, share=divide / funnel.circuits if funnel.circuits else None)
    kept = patience.run("untwisted arrays", partial(_run, search_all(grid, n, "untwisted"), "untwisted"))
    if kept is not None:
        row = replace(row, untwisted_arrays=kept.arrays)
        _check(row, {f"untwisted designs are {kept.untwisted} when searched alone": kept.untwisted == row.untwisted})
    check_laws(row)
    return row


def _divisible(search: PolygonSearch, progress: Progress) -> int:
    """List all circuits once more, for those whose T is divisible."""
    number = 0
    for done, batch in enumerate(search.batches()):
        number += int(divisible(batch).sum())
        progress(done, 0, "")
    return number


def _counted(grid: Grid, n: int, patience: Patience) -> FunnelRow:
    """Only the numbers of designs that fold."""
    two_stack, untwisted = (
        patience.run(f"count {keep}", partial(_count, search_all(grid, n, keep), keep))
        for keep in ("two-stack", "untwisted")
    )
    row = FunnelRow(grid.name, n, None, None, None, None, None, two_stack, untwisted, None)
    check_laws(row)
    return row


def check_laws(row: FunnelRow) -> None:
    """HcsearchError, with the row and the law, when the row breaks a law (docs/explanation/theory.md, 4, 12 and 14)."""
    narrowing = [row.fixed, row.free, row.divisible, row.two_stack, row.untwisted]
    left = [number for number in narrowing if number is not None]
    _check(
        row,
        {
            "fixed >= free >= divisible >= two-stack >= untwisted": left == sorted(left, reverse=True),
            "free >= arrays >= arrays of untwisted designs": (row.untwisted_arrays or 0)
            <= (row.arrays or 0)
            <= (row.free or 0),
            "nothing folds when n is odd": row.n % 2 == 0 or not (row.two_stack or row.untwisted),
            "T is divisible everywhere but on hexagons": row.grid == "hex" or row.divisible in {None, row.free},
            "no untwisted design on triangles when 4 divides n": row.grid != "triangle"
            or row.n % 4 != 0
            or not row.untwisted,
        },
    )


def _check(row: FunnelRow, laws: Mapping[str, bool]) -> None:
    for law, holds in laws.items():
        if not holds:
            raise HcsearchError(f"{row} breaks a law: {law}; report this")


def _run(search: Search, keep: str, progress: Progress) -> Funnel:
    """The funnel of a search through the stages until `twist`."""
    return run_dry(Plan(search, "twist", keep), progress).funnel


def _count(search: Search, keep: str, progress: Progress) -> int:
    """The number of designs to keep, without listing them."""
    return count_designs(search, keep, WorkerPool(), progress).classes
