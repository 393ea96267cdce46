"""Hypothesis strategies: circuits in any position, order and direction; connected arrays."""

from collections.abc import Iterator
from functools import cache

from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, Array, Grid
from hcsearch.designs.grid.tilings import LatticeIsometry
from hcsearch.search.enumeration import PolygonSearch

SIZES = {
    "triangle": (6, 10, 12, 14, 18, 22),
    "square": (4, 8, 10, 12, 14),
    "rectangle": (4, 8, 10, 12, 14),
    "hex": (3, 5, 6, 7, 9, 10),
    "rhombus": (3, 6, 7, 8, 11, 12),
    "kite": (3, 4, 7, 8, 9, 10, 12),
    "right45": (4, 8, 10, 12, 14, 16, 18),
    "right30": (4, 6, 8, 12, 14, 16),
    "obtuse": (3, 12, 13, 14, 15, 16, 22),
}


@cache
def words(grid: str, n: int) -> list[tuple[int, ...]]:
    return [tuple(word) for batch in PolygonSearch(GRIDS[grid], n).batches() for word in batch.words.tolist()]


@st.composite
def circuits(draw: st.DrawFn, grids: tuple[str, ...] = tuple(GRIDS), even: bool = False) -> Circuit:
    """A canonical circuit."""
    grid = draw(st.sampled_from(grids))
    n = draw(st.sampled_from([n for n in SIZES[grid] if not even or n % 2 == 0]))
    return Circuit(GRIDS[grid], draw(st.sampled_from(words(grid, n))))


def rewritten(circuit: Circuit, isometry: LatticeIsometry, start: int, backwards: bool) -> Circuit:
    """The same circuit, moved by an isometry of its grid, from another panel, perhaps in the other direction."""
    word = [isometry.steps[step] for step in circuit.word]
    word = word[start:] + word[:start]
    if backwards:
        word = [circuit.grid.backwards[step] for step in reversed(word)]
    return Circuit(circuit.grid, tuple(word))


def writings(circuit: Circuit) -> Iterator[Circuit]:
    """A circuit mirrored and turned in every way, each forwards and backwards, from another panel."""
    for number, isometry in enumerate(circuit.grid.point_group):
        for backwards in (False, True):
            yield rewritten(circuit, isometry, 1 + number % (circuit.n - 1), backwards)


@st.composite
def congruences(draw: st.DrawFn, circuit: Circuit) -> Circuit:
    """The circuit moved by a symmetry of its grid, begun elsewhere, perhaps walked backwards."""
    isometry = draw(st.sampled_from(circuit.grid.point_group))
    backwards = draw(st.booleans())
    return rewritten(circuit, isometry, draw(st.integers(0, circuit.n - 1)), backwards)


@st.composite
def arrays(draw: st.DrawFn, grids: tuple[str, ...] = tuple(GRIDS), max_cells: int = 14) -> Array:
    """A connected array grown cell by cell."""
    grid: Grid = GRIDS[draw(st.sampled_from(grids))]
    points = [grid.point((0, 0, draw(st.integers(0, grid.kinds - 1))))]
    for _ in range(draw(st.integers(0, max_cells - 1))):
        free = sorted({to for p in points for _, to in grid.neighbours(p)} - set(points))
        points.append(draw(st.sampled_from(free)))
    return Array.from_cells(grid, map(grid.cell, points))
