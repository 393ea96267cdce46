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
from hcsearch.designs.grid import Grid, LatticeIsometry
from hcsearch.designs.grid.turning import edge_classes, step_tables
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits import chains, joining
from hcsearch.search.enumeration.polygon_search import LatticePlane, canonical_batch, check_length

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
    the other. Half-chains are listed by key (last place, exit) and joined with the half-chains of the matching key; a
    pair is kept where its cells are disjoint. For untwisted circuits only opposite sums of turns are joined. Of keys
    that are images of each other, one suffices. A shard is a range of keys, or part of one key. Memory holds the
    half-chains of one key at a time.

    Empty for odd n. Raises SizeError below 3 panels and where the half-chains are too many to list.
    """

    grid: Grid
    n: int
    untwisted: bool

    def __post_init__(self) -> None:
        check_length(self.n)
        longest = int(math.log(_MAX_CHAINS) / math.log(self.grid.connective_constant))
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
        return n + 2 * int(math.log(_MAX_LISTED / pairs) / math.log(self.grid.connective_constant) / 2)

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
        if self.grid.step_classes > 1:  # circuits that differ by a quarter turn are compared by words
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
        return (self.grid.edges_per_cell - 2).bit_length()

    @cached_property
    def _places(self) -> LatticePlane:
        return LatticePlane.around_home(self.grid.tiling, self._h + 2)

    @property
    def _h(self) -> int:
        """Number of steps of a half-chain."""
        return self.n // 2 - 1

    @cached_property
    def planes(self) -> tuple[chains.Plane, ...]:
        """The lattice around home, as kernels traverse it, with a first crease of each class of edges."""
        places = self._places
        return tuple(
            chains.Plane(
                steps=step_tables(self.grid),
                moves=places.moves,
                bits=self._letter_bits,
                kinds=places.kinds,
                distance=places.distance,
                reach=np.flatnonzero(places.distance <= self._h),
                home=places.home,
                crease=crease,
                classes=edge_classes(self.grid).classes,
                reflected=edge_classes(self.grid).reflected,
                mirror=self._mirror_places(crease),
                mirror_steps=np.array(self._mirror(crease).steps),
                h=self._h,
            )
            for crease in edge_classes(self.grid).firsts
        )

    def _mirror(self, crease: int) -> LatticeIsometry:
        """The reflection that takes a cell to its neighbour across a crease, but for a translation."""
        tiling = self.grid.tiling
        back = tiling.backwards[crease]
        return next(isometry for isometry in tiling.point_group if isometry.sign < 0 and isometry.steps[crease] == back)

    def _mirror_places(self, crease: int) -> NDArray[np.int64]:
        """The image of each place near home in the crease between home and the cell across it; 0 for the others."""
        places, mirror = self._places, self._mirror(crease)
        (x, y), (dx, dy) = places.point(places.home), self.grid.tiling.steps[crease]
        shift_x, shift_y = mirror((x, y))
        shift = (x + dx - shift_x, y + dy - shift_y)
        images = np.zeros(len(places.distance), np.int64)
        for place in np.flatnonzero(places.distance <= self._h + 1).tolist():
            image = mirror(places.point(place))
            images[place] = places.place((image[0] + shift[0], image[1] + shift[1]))
        return images

    def half_chains(self, key: int) -> HalfChainLists:
        """Return the half-chains of a key and of the matching key; the last result is cached."""
        if self._cache.get("key") != key:
            plane = self.planes[self.keys[key, 5]]
            self._cache.update(key=key, lists=chains.list_chains(plane, self.keys[key]))
        lists: HalfChainLists = self._cache["lists"]
        return lists

    @cached_property
    def _cache(self) -> dict[str, Any]:
        return {}

    @cached_property
    def keys(self) -> NDArray[np.int64]:
        """Keys that are the least of their images, shape (n_keys, 6), as input of `joining.join_chains`.

        The last number is the class of the flat creases.
        """
        keys = []
        for edge_class, plane in enumerate(self.planes if self.n % 2 == 0 else ()):
            sizes = np.zeros((len(plane.distance), len(plane.moves)), np.int64)
            chains.count_chains(plane, sizes)
            listed = [(*self._places.point(end)[::-1], face, end) for end, face in np.argwhere(sizes).tolist()]
            order = {(end, face): k for k, (*_, face, end) in enumerate(sorted(listed))}
            for (end, face), place in order.items():
                images = self._images(edge_class, end, face)
                mate = images[1]
                if min(order.get(image, len(order)) for image in images) == place and sizes[mate]:
                    stabiliser = sum(1 << root for root, image in enumerate(images) if image == images[0])
                    keys.append((end, face, sizes[end, face], sizes[mate], stabiliser, edge_class))
        return np.array(keys, np.int64).reshape(-1, 6)

    def _images(self, edge_class: int, end: int, face: int) -> list[tuple[int, int]]:
        """Return the keys of a folding's roots (`kernels.circuits.joining`), given the key of the first."""
        places, plane, tiling = self._places, self.planes[edge_class], self.grid.tiling
        carried = next(
            isometry
            for isometry in tiling.point_group
            if isometry.sign == (-1) ** self._h and isometry.steps[face] == plane.crease
        )
        (x, y), (end_x, end_y) = places.point(places.home), places.point(end)
        dx, dy = carried((x - end_x, y - end_y))
        images = []
        for place, step in ((end, face), (places.place((x + dx, y + dy)), carried.steps[plane.crease])):
            across = int(plane.mirror[place + plane.moves[step]])
            images += [(place, step), (across, int(plane.mirror_steps[tiling.backwards[step]]))]
        if not edge_classes(self.grid).bisected[edge_class]:
            return images
        bisector = next(
            isometry
            for isometry in tiling.point_group
            if isometry.sign < 0 and isometry.steps[plane.crease] == plane.crease
        )
        for place, step in images[:4]:
            to_x, to_y = places.point(place)
            dx, dy = bisector((to_x - x, to_y - y))
            images.append((places.place((x + dx, y + dy)), bisector.steps[step]))
        return images


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
        edge_class, edges = int(search.keys[key, 5]), edge_classes(search.grid)
        written = joining.join_chains(
            search.planes[edge_class],
            search.keys[key],
            lists,
            8 if edges.bisected[edge_class] else 4,
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
