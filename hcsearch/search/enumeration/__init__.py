"""Enumeration of Hamiltonian circuits up to symmetry: over all arrays of n cells, or on one array."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any, ClassVar, Protocol

from hcsearch.basics.errors import HcsearchError, SizeError, expect_kind
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import Array, Grid, grid_of
from hcsearch.designs.records import CircuitBatch
from hcsearch.search.enumeration.array_circuits import ArraySearch
from hcsearch.search.enumeration.folded import FoldedSearch
from hcsearch.search.enumeration.frontier_counts import ArrayCount, count_array
from hcsearch.search.enumeration.polygon_search import PolygonSearch

__all__ = [
    "ArrayCount",
    "ArraySearch",
    "FoldedSearch",
    "PolygonSearch",
    "Search",
    "count_array",
    "enumerate_circuits",
    "search_all",
]

_FEW = 100_000


class Search(Protocol):
    """Interface of `PolygonSearch`, `FoldedSearch` and `ArraySearch`: an enumeration in shards named by prefixes."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __hash__(self) -> int:
        """Equal searches have equal hashes."""

    @property
    def grid(self) -> Grid:
        """The grid of the circuits."""

    @property
    def n(self) -> int:
        """Number of panels of each circuit."""

    @property
    def lists(self) -> str:
        """Which circuits are listed, as a value of `--keep`: `all`, `two-stack` or `untwisted`."""

    @property
    def target(self) -> str:
        """Canonical notation of the searched array; '' for all arrays."""

    @property
    def group_order(self) -> int:
        """Order of the group that defines congruence; a class holds group_order / symmetry circuits."""

    @property
    def expected(self) -> float | None:
        """Estimated number of listed circuits; None where only a probe of some shards can give it."""

    @property
    def prefixes(self) -> list[str]:
        """Keys of the shards, which together contain every class of circuits once."""

    def circuits(self, prefix: str, batch_size: int = ...) -> Iterator[CircuitBatch]:
        """Yield batches of the canonical circuits of one shard, lazily."""

    def batches(self, batch_size: int = ...) -> Iterator[CircuitBatch]:
        """Yield batches of all canonical circuits, lazily."""


def search_all(grid: Grid, n: int, keep: str = "all") -> Search:
    """Return the search over all arrays of n cells for a value of `--keep`: all, two-stack or untwisted.

    Circuits that fold are joined from half-chains, unless all circuits are few enough to be listed at once, which
    counts them, too.
    """
    if keep == "all":
        return PolygonSearch(grid, n)
    folded = FoldedSearch(grid, n, untwisted=keep == "untwisted")
    everything = PolygonSearch(grid, n)
    return everything if everything.expected < _FEW else folded


def enumerate_circuits(
    grid: str | Grid | None = None,
    *,
    n: int | None = None,
    array: Array | None = None,
    limit: int | None = None,
    batch_size: int = 4096,
) -> Iterator[Circuit]:
    """Yield one circuit of every congruence class: on all arrays of n cells of a grid, or on one array.

    Circuits of an array run through its own cells; circuits of all arrays are canonical and lie near the origin.

    Parameters
    ----------
    grid, n
        The grid, or its name, and the number of cells, for all arrays.
    array
        The array, in place of both.
    limit
        The greatest number of circuits.
    batch_size
        The number of circuits that are held in memory.

    Returns
    -------
    iterator of Circuit
        One circuit of each class.

    Raises
    ------
    SizeError
        For n below 3 or too large, and for an array that is too wide.

    Examples
    --------
    >>> from hcsearch import enumerate_circuits, parse_array
    >>> wall = parse_array("hex", "3-4-3")
    >>> [circuit.array == wall for circuit in enumerate_circuits(array=wall, limit=2)]
    [True, True]

    The iterator is lazy and holds `batch_size` circuits in memory, whatever n is; `limit` is the most it yields.
    `PolygonSearch(grid, n).batches()` and `ArraySearch(array).batches()` give whole batches as NumPy arrays.
    """
    for name, number in (("limit", limit), ("batch_size", batch_size)):
        if number is not None:
            expect_kind(name, number, int, "a whole number")
    if batch_size < 1 or (limit is not None and limit < 0):
        raise SizeError(f"batch_size {batch_size} and limit {limit}: use at least 1 and 0")
    search: Search
    if array is not None and grid is None and n is None:
        search = ArraySearch(array)
    elif array is None and grid is not None and n is not None:
        search = PolygonSearch(grid_of(grid), n)
    else:
        raise HcsearchError("give a grid and n, as enumerate_circuits('hex', n=6), or one array, as array=...")
    circuits = (
        Circuit(search.grid, tuple(word)) for batch in search.batches(batch_size) for word in batch.words.tolist()
    )
    return islice(circuits if array is None else (circuit.on(array) for circuit in circuits), limit)
