"""Enumeration of the circuits of n panels that fold, one per congruence class, joined from half-chains."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.errors import SizeError
from hcsearch.designs.grid import Grid
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits import chains, joining
from hcsearch.search.enumeration.frontier_counts import connective_constant
from hcsearch.search.enumeration.plane import LatticePlane, canonical_batch
from hcsearch.search.enumeration.polygon_search import check_length

HalfChainLists = tuple[chains.HalfChains, chains.HalfChains, NDArray[np.int64]]

_SHARD_PAIRS = 250_000  # about 10,000 circuits
_COUNTED_PAIRS = 100_000_000  # less than a second
_MAX_COUNTED = 2_000
_MAX_SHARDS = 200_000
_MAX_LISTED = 2e12  # pairs; about 1e11 circuits
_CODE_BITS = 63
_MAX_CHAINS = 2e10


@dataclass(frozen=True)
class FoldedSearch:
    """All circuits of n panels that fold into two stacks, or only the untwisted ones, split into shards.

    The two flat creases of a folding cut the circuit into two half-chains, each of which leads from one flat crease to
    the other. Half-chains are listed by key (last place, exit) and joined with those of the matching key; a pair is
    kept where its cells are disjoint. For untwisted circuits only opposite sums of turns are joined. Of keys that are
    images of each other, one suffices. A shard is a range of keys, or part of one key. Memory holds the half-chains of
    one key at a time.

    Empty for odd n. Raises SizeError below 3 panels and where the half-chains are too many to list.
    """

    grid: Grid
    n: int
    untwisted: bool

    def __post_init__(self) -> None:
        check_length(self.n)
        longest = int(math.log(_MAX_CHAINS) / math.log(connective_constant(self.grid)))
        max_panels = 2 * min(longest + 1, _CODE_BITS // self._letter_bits)
        if self.n % 2 == 0 and self.n > max_panels:
            raise SizeError(
                f"--n {self.n} has too many half-chains on this grid: use --n {self._longest_listed} or "
                f"less to list designs, or count them with `hcsearch count --keep {self.lists}` up to --n {max_panels}"
            )

    @property
    def target(self) -> str:
        """Notation of the searched array: empty, as the search covers all arrays."""
        return ""

    @property
    def lists(self) -> str:
        """Which circuits are listed, as a value of `--keep`."""
        return "untwisted" if self.untwisted else "two-stack"

    @property
    def group_order(self) -> int:
        """Order of the grid's point group: fixed circuits that differ by more than a translation are distinct."""
        return len(self.grid.point_group)

    @property
    def expected(self) -> None:
        """None: the share of pairs that become circuits depends on the grid."""
        return

    @cached_property
    def prefixes(self) -> list[str]:
        """Names of the shards, in order: `first-last` for whole keys, `key:part/parts` for part of one."""
        if self.n_pairs > _MAX_LISTED:
            raise SizeError(
                f"--n {self.n} is too large to list: about {0.05 * self.n_pairs:.0e} circuits; use --n "
                f"{self._longest_listed} or less, or `hcsearch count --keep {self.lists}`"
            )
        return self.shards(max(_SHARD_PAIRS, int(self.n_pairs / _MAX_SHARDS)))

    @property
    def _longest_listed(self) -> int:
        """The greatest n that can be listed, extrapolated from the pairs of small n by the growth of circuits."""
        n, pairs = 4, 0.0
        while pairs < 1e-3 * _MAX_LISTED:
            n += 2
            pairs = replace(self, n=n).n_pairs
        return n + 2 * int(math.log(_MAX_LISTED / pairs) / math.log(connective_constant(self.grid)) / 2)

    @property
    def counting_shards(self) -> list[str]:
        """Names of larger shards for `count`, the largest first, so that workers finish at nearly the same time."""
        size = max(_COUNTED_PAIRS, int(self.n_pairs / _MAX_COUNTED))
        return sorted(self.shards(size), key=lambda shard: -self.pairs[list(_range(shard))].sum())

    def shards(self, size: int) -> list[str]:
        """Cut the keys into shards of about `size` pairs."""
        names: list[str] = []
        first, joined = 0, 0
        for key, pairs in enumerate(self.pairs.tolist()):
            if joined and joined + pairs > size:
                names.append(f"{first}-{key - 1}")
                joined = 0
            if pairs > size:
                parts = -(-pairs // size)
                names += [f"{key}:{part}/{parts}" for part in range(parts)]
                continue
            if not joined:
                first = key
            joined += pairs
        return [*names, f"{first}-{len(self.pairs) - 1}"] if joined else names

    def circuits(self, prefix: str, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield the canonical circuits of one shard lazily, in batches of at most `batch_size`."""
        return self._listed(self._join(prefix), batch_size)

    def batches(self, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield all canonical circuits lazily, in batches of at most `batch_size`."""
        return self._listed(_Join(self, range(len(self.keys))), batch_size)

    def count(self, shard: str) -> tuple[int, int]:
        """Count the classes and the fixed circuits of a shard, without listing them."""
        if len(self.grid.first_directions) > 1:  # circuits that differ by a quarter turn are compared by words
            classes = fixed = 0
            for batch in self.circuits(shard):
                classes += len(batch)
                fixed += int((self.group_order // batch.symmetry).sum())
            return classes, fixed
        return self._join(shard).count()

    @property
    def pairs(self) -> NDArray[np.int64]:
        """Number of pairs of half-chains for each key, to which the cost of the search is proportional."""
        pairs: NDArray[np.int64] = self.keys[:, 2] * self.keys[:, 3]
        return pairs

    @property
    def n_pairs(self) -> float:
        """Number of pairs of half-chains of all keys."""
        return float(self.pairs.sum(dtype=float))

    def _join(self, shard: str) -> _Join:
        part, _, parts = (shard.partition(":")[2] or "0/1").partition("/")
        return _Join(self, _range(shard), int(part), int(parts))

    def _listed(self, join: _Join, batch_size: int) -> Iterator[CircuitBatch]:
        while len(words := join.more(batch_size)):
            yield canonical_batch(self.grid, words)

    @property
    def _letter_bits(self) -> int:
        return (len(self.grid.turns) - 1).bit_length()

    @cached_property
    def _places(self) -> LatticePlane:
        return LatticePlane.around_home(self.grid.tiling, self.n - 1)

    @cached_property
    def plane(self) -> chains.Plane:
        """The lattice around home, as kernels traverse it."""
        places, h = self._places, self.n // 2 - 1
        return chains.Plane(
            moves=places.moves,
            turns=np.array(self.grid.turns),
            bits=self._letter_bits,
            distance=places.distance,
            reach=np.flatnonzero(places.distance <= h),
            home=places.home,
            h=h,
            turned=self.grid.is_triangle and h % 2 == 1,
        )

    def half_chains(self, key: int) -> HalfChainLists:
        """Return the half-chains of a key and of the matching key; the last result is cached."""
        if self._cache.get("key") != key:
            self._cache.update(key=key, lists=chains.list_chains(self.plane, self.keys[key]))
        lists: HalfChainLists = self._cache["lists"]
        return lists

    @cached_property
    def _cache(self) -> dict[str, Any]:
        return {}

    @cached_property
    def keys(self) -> NDArray[np.int64]:
        """Keys that are the least of their images, shape (n_keys, 5), as input of `joining.join_chains`."""
        if self.n % 2:
            return np.empty((0, 5), np.int64)
        sizes = np.zeros((len(self._places.distance), self.grid.directions), np.int64)
        chains.count_chains(self.plane, sizes)
        keys = []
        for end, face in np.argwhere(sizes).tolist():
            images = self._images(end, face)
            mate = images[1]
            if min(images) == images[0] and sizes[mate]:
                stabiliser = sum(1 << root for root, image in enumerate(images) if image == images[0])
                keys.append((end, face, sizes[end, face], sizes[mate], stabiliser))
        return np.array(keys, np.int64).reshape(-1, 5)

    def _images(self, end: int, face: int) -> list[tuple[int, int]]:
        """Return the keys of a folding's eight roots (`kernels.circuits.chains`), given that of the first."""
        places, m = self._places, self.grid.directions
        turns = {g.offset: g for g in places.grid.point_group if g.sign == 1}
        mirror = next(g for g in places.grid.point_group if (g.sign, g.offset) == (-1, 0))
        x, y = places.point(end)
        back = places.place(turns[-face % m]((-x, -y))), -face % m
        images = []
        for key in ((end, face), back):
            across = 2 * places.home + int(places.moves[0] - places.moves[key[1]]) - key[0]
            images += [key, (across, key[1])]
        return images + [(places.place(mirror(places.point(place))), -d % m) for place, d in images]


def _range(shard: str) -> range:
    """Return the range of keys of a shard."""
    first, _, last = shard.partition(":")[0].partition("-")
    return range(int(first), int(last or first) + 1)


class _Join:
    """A resumable join of the half-chains of several keys."""

    def __init__(self, search: FoldedSearch, keys: range, part: int = 0, parts: int = 1) -> None:
        self.search, self.keys, self.part, self.parts = search, iter(keys), part, parts
        self.state = np.zeros(2, np.int64)
        self.key = next(self.keys, None)

    def more(self, size: int) -> NDArray[np.int8]:
        """Return the next words, at most `size`; fewer only at the end."""
        words = np.empty((size, self.search.n), np.int8)
        written = 0
        while self.key is not None and written < size:
            written += self._run(self.key, words[written:], np.zeros(2, np.int64))
        return words[:written].copy()

    def count(self) -> tuple[int, int]:
        """Count the classes and the fixed circuits of all keys."""
        totals = np.zeros(2, np.int64)
        while self.key is not None:
            self._run(self.key, np.empty((0, self.search.n), np.int8), totals)
        return int(totals[0]), int(totals[1])

    def _run(self, key: int, words: NDArray[np.int8], totals: NDArray[np.int64]) -> int:
        search = self.search
        lists = search.half_chains(key)
        order = search.group_order
        written = joining.join_chains(
            search.plane,
            search.keys[key],
            lists,
            search.untwisted,
            self.part,
            self.parts,
            order,
            self.state,
            words,
            totals,
        )
        if self.state[0] == len(lists[0].codes):
            self.key = next(self.keys, None)
            self.state[:] = 0
        return written
