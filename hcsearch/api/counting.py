"""Count circuits without storing them: of one size, or of several, with their growth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Keep
from hcsearch.designs.grid import Array, Grid
from hcsearch.designs.grid.sequences import polygon_sequence
from hcsearch.search.enumeration import ArraySearch, Search, count_array
from hcsearch.search.enumeration.frontier_counts import expected_circuits
from hcsearch.search.enumeration.growth import POLYGON_EXPONENT, Growth, fit_growth
from hcsearch.search.pipeline import DesignCount, WorkerPool, count_designs, counting_seconds, duration_text
from hcsearch.system.work_steps import Announcement, Progress, part_of_progress, parts_of_work

if TYPE_CHECKING:
    import pandas as pd

_LISTED_BESIDE = 1e7
"""Greatest number of classes that are listed beside those that fold, which takes seconds."""


@dataclass(frozen=True)
class CircuitCount:
    """The number of circuits that a search keeps, in total and up to symmetry.

    search : the counted search. circuits, classes : number of circuits, and of classes up to symmetry.
    """

    search: Search
    keep: Keep
    circuits: int
    classes: int

    def records(self) -> list[dict[str, Any]]:
        """Return the counts as one row of values by column."""
        array = {"array": self.search.target} if self.search.target else {}
        kept = {} if self.keep == "all" else {"keep": self.keep}
        return [array | {"n": self.search.n} | kept | {"circuits": self.circuits, "classes": self.classes}]


@dataclass(frozen=True)
class CountRow:
    """The counts for one n in a `CountTable`.

    circuits, classes : number of all circuits, and of their classes up to symmetry; None where only designs that fold
    were counted, as all are too many to list in seconds. kept_circuits, kept_classes : those that `keep` selects.
    ratio : kept_circuits over those of the row before that has any. growth : fitted to the kept_circuits up to this
    row, and biased_growth with the exponent -5/2 of all circuits. These are None where there are no circuits, in the
    first row that has any, and where the counts do not determine them.
    """

    n: int
    circuits: int | None
    classes: int | None
    kept_circuits: int
    kept_classes: int
    ratio: float | None
    growth: Growth | None
    biased_growth: Growth | None

    def record(self, keep: Keep) -> dict[str, Any]:
        """Return the row as values by column; circuits that fold have columns named by `keep`."""
        kept = {}
        if keep != "all":
            name = keep.replace("-", "_")
            kept = {f"{name}_circuits": self.kept_circuits, name: self.kept_classes}
        growth, biased = self.growth, self.biased_growth
        return {
            "n": self.n,
            "circuits": self.circuits,
            "classes": self.classes,
            **kept,
            "ratio": self.ratio,
            "mu": growth and growth.mu,
            "mu_error": growth and growth.mu_error,
            "exponent": growth and growth.exponent,
            "exponent_error": growth and growth.exponent_error,
            **({} if kept else {"biased_mu": biased and biased.mu, "biased_mu_error": biased and biased.mu_error}),
        }


@dataclass(frozen=True)
class CountTable:
    """The numbers of circuits of all arrays of n cells, for several n.

    grid : its name. rows : one for each n, in ascending order. circuits_oeis, classes_oeis : the numbers of the
    sequences of all circuits, and of their classes, in the On-Line Encyclopedia of Integer Sequences, or None.
    """

    grid: str
    keep: Keep
    rows: tuple[CountRow, ...]

    @property
    def circuits_oeis(self) -> str | None:
        """Number of the sequence of all circuits."""
        return polygon_sequence(self.grid, "circuits")

    @property
    def classes_oeis(self) -> str | None:
        """Number of the sequence of classes."""
        return polygon_sequence(self.grid, "classes")

    @property
    def growth(self) -> Growth | None:
        """Growth of the kept circuits by all rows."""
        return next((row.growth for row in reversed(self.rows) if row.kept_circuits), None)

    @property
    def biased_growth(self) -> Growth | None:
        """Growth of all circuits by all rows, with the exponent -5/2; None where `keep` selects some."""
        return next((row.biased_growth for row in reversed(self.rows) if row.kept_circuits), None)

    def records(self) -> list[dict[str, Any]]:
        """Return each row as values by column, with the numbers of the sequences."""
        oeis = {"circuits_oeis": self.circuits_oeis, "classes_oeis": self.classes_oeis}
        return [row.record(self.keep) | oeis for row in self.rows]

    def table(self) -> pd.DataFrame:
        """Return the rows as a pandas table; counts are integers of any size."""
        import pandas as pd  # noqa: PLC0415 - only for tables

        records = self.records()
        names = list(records[0])
        kinds = {name: "Float64" for name in names if name == "ratio" or "mu" in name or "exponent" in name}
        kinds |= {"n": "int64", "circuits_oeis": "string", "classes_oeis": "string"}
        return pd.DataFrame(records, columns=names, dtype=object).astype(kinds)


@overload
def count(
    *,
    grid: str | Grid | None = ...,
    n: int | None = ...,
    array: str | Array | None = ...,
    keep: Keep = ...,
    jobs: int | None = ...,
    scheduler: str | None = ...,
    progress: Progress | None = ...,
    announce: Announcement | None = ...,
) -> CircuitCount: ...
@overload
def count(
    *,
    grid: str | Grid | None = ...,
    n: Sequence[int],
    array: None = ...,
    keep: Keep = ...,
    jobs: int | None = ...,
    scheduler: str | None = ...,
    progress: Progress | None = ...,
    announce: Announcement | None = ...,
) -> CountTable: ...
def count(
    *,
    grid: str | Grid | None = None,
    n: int | Sequence[int] | None = None,
    array: str | Array | None = None,
    keep: Keep = "all",
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    announce: Announcement | None = None,
) -> CircuitCount | CountTable:
    """Count the circuits of all arrays of n cells, or of one array, as `hcsearch count` does.

    Parameters
    ----------
    n
        The number of cells, or several numbers, such as `range(6, 17)`.
    grid, array, keep, jobs, scheduler, progress, announce
        As in `enumerate_into`.

    Returns
    -------
    CircuitCount or CountTable
        A `CountTable`, with ratios and the growth constant, for several numbers of cells.

    Examples
    --------
    >>> from hcsearch import count
    >>> counted = count(grid="square", array="6x6")
    >>> counted.circuits, counted.classes
    (1072, 149)
    >>> [(row.n, row.circuits, row.classes) for row in count(grid="hex", n=[6, 8, 10]).rows]
    [(6, 15, 4), (8, 123, 16), (10, 1212, 120)]
    """
    check_kinds(count, locals())
    if not isinstance(n, Sequence):
        search = chosen_search(grid, n, array, keep)
        return _counted(search, keep, chosen_workers(jobs, scheduler), progress, announce)
    if array is not None:
        raise HcsearchError("give either --n N (every array of N cells) or --array SPEC (one array)")
    searches = _searches(grid, n, keep)
    pairs = _pairs(searches, keep, chosen_workers(jobs, scheduler), progress, announce)
    return CountTable(searches[0].grid.name, keep, tuple(_rows(list(pairs), keep)))


def _counted(
    search: Search, keep: Keep, crew: WorkerPool, progress: Progress | None, announce: Announcement | None
) -> CircuitCount:
    """Count the circuits of one search."""
    is_single_array = isinstance(search, ArraySearch) and keep == "all"
    if crew.scheduler is not None and is_single_array:
        raise HcsearchError("circuits of one array are counted in this process: leave out --scheduler")
    crew.check_cluster()
    seconds = None if keep == "all" else counting_seconds(search)
    if seconds is not None and announce is not None:
        announce(f"about {duration_text(seconds)} of core time to count")
    if is_single_array:
        assert isinstance(search, ArraySearch)
        totals = count_array(search.array, progress)
        counted = DesignCount(totals.classes, totals.circuits)
    else:
        counted = count_designs(search, keep, crew, progress)
    return CircuitCount(search, keep, counted.circuits, counted.classes)


def _searches(grid: str | Grid | None, sizes: Sequence[int], keep: Keep) -> list[Search]:
    """Return the searches of several n, in order; sizes out of reach are refused before anything is counted."""
    ordered = sorted(set(sizes))
    if not ordered:
        raise HcsearchError("there is no n to count: give at least one, such as range(6, 17)")
    searches = [chosen_search(grid, n, None, keep) for n in ordered]
    for search in reversed(searches):  # the largest is refused first
        if search.lists == "all":
            _ = search.prefixes  # SizeError when there are too many circuits to list
    if len(sizes) > len(ordered):
        twice = next(n for n in ordered if list(sizes).count(n) > 1)
        raise HcsearchError(f"n = {twice} is given twice: give each number once")
    return searches


def _pairs(
    searches: Sequence[Search], keep: Keep, crew: WorkerPool, progress: Progress | None, announce: Announcement | None
) -> Iterator[tuple[CircuitCount | None, CircuitCount]]:
    """Yield the counts of all circuits, where that takes seconds, and of those kept."""
    parts = parts_of_work(expected_circuits(search.grid, search.n) for search in searches)
    for search, (begin, end) in zip(searches, parts, strict=True):
        name = f"n = {search.n}"
        show = None if progress is None else part_of_progress(progress, begin, end, name=name, unit="batch")
        chosen = _counted(search, keep, crew, show, announce)
        everything: CircuitCount | None = chosen
        if keep != "all":
            alone = chosen_search(search.grid, search.n, None, "all")
            few = alone.expected is not None and alone.expected < _LISTED_BESIDE
            rest = None if progress is None else part_of_progress(progress, end, end, name=name, unit="batch")
            everything = _counted(alone, "all", crew, rest, announce) if few else None
        yield everything, chosen


def _rows(pairs: Sequence[tuple[CircuitCount | None, CircuitCount]], keep: Keep) -> Iterator[CountRow]:
    """Yield the rows of a table from the counts of all circuits, and of those kept, with ratios and growth."""
    positive: dict[int, int] = {}
    for everything, kept in pairs:
        before = next(reversed(positive.values()), None)
        if kept.circuits:
            positive[kept.search.n] = kept.circuits
        yield CountRow(
            n=kept.search.n,
            circuits=None if everything is None else everything.circuits,
            classes=None if everything is None else everything.classes,
            kept_circuits=kept.circuits,
            kept_classes=kept.classes,
            ratio=kept.circuits / before if before and kept.circuits else None,
            growth=fit_growth(positive) if kept.circuits else None,
            biased_growth=fit_growth(positive, POLYGON_EXPONENT) if kept.circuits and keep == "all" else None,
        )
