"""The untwisted foldings of a search: all of them, or a part evenly over the list."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from hcsearch.designs.folding import fold
from hcsearch.designs.grid import grid_named, parse_array
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.designs.twisting import twist_batch
from hcsearch.search.enumeration import ArraySearch, PolygonSearch, Search

Batches = Iterable[tuple[CircuitBatch, FoldingBatch]]


def search_of(grid: str, cells: str) -> Search:
    """The search for the circuits of all arrays of n cells, or of one array such as `6x5`."""
    if cells.isdigit():
        return PolygonSearch(grid_named(grid), int(cells))
    return ArraySearch(parse_array(grid_named(grid), cells))


def untwisted(search: Search, every: int = 1) -> Iterator[tuple[CircuitBatch, FoldingBatch]]:
    """Every so many-th untwisted folding, in the batches of circuits of a search."""
    seen = 0
    for circuits in search.batches():
        foldings = fold(circuits)
        plain = np.flatnonzero(twist_batch(circuits, foldings) == 0)
        kept = plain[-seen % every :: every]
        seen += len(plain)
        yield circuits, FoldingBatch(foldings.row[kept], foldings.crease[kept])


def packed(batches: Batches) -> Iterator[tuple[CircuitBatch, FoldingBatch]]:
    """All foldings of some batches in one batch, with only their circuits; nothing where there are no foldings."""
    words, symmetry, creases = [], [], []
    grid = ""
    for circuits, foldings in batches:
        grid = circuits.grid
        words.append(circuits.words[foldings.row])
        symmetry.append(circuits.symmetry[foldings.row])
        creases.append(foldings.crease)
    if grid and any(map(len, words)):
        picked = CircuitBatch(grid, np.concatenate(words), np.concatenate(symmetry))
        # foldings of one circuit come one after the other
        news = np.r_[True, (picked.words[1:] != picked.words[:-1]).any(axis=1)]
        yield picked.take(news), FoldingBatch(np.cumsum(news) - 1, np.concatenate(creases))
