"""Pairs and rings of copies of one element: which can be laid so that panels overlap and hinges merge.

The thesis's rule (5.2): four copies A, B, C, D lie so that A and B, B and C, C and D, D and A merge hinges, and
mountains and valleys agree wherever copies overlap. Arrangements are the same where their unions are congruent, turned
over or inverted.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations

import numpy as np

from hcsearch.library.unit_search.copies import STILL, Overlap, Placement, Sheet

Key = tuple[tuple[int, ...], ...]
Mark = tuple[complex, int]
"""A facet or a crease of a union: its middle and a code; facets have the code `_FACET`."""

_FACET = 50
_STEP, _SHIFT = 1e-5, 0.3771


@dataclass
class Rings:
    """The ways to lay copies of one element together, two or four at a time.

    strict : whether no crease of one copy may lie in a slit of another.
    """

    sheet: Sheet
    strict: bool = True
    _known: dict[int, Overlap] = field(default_factory=dict)

    @cached_property
    def own(self) -> list[Placement]:
        """Motions that carry the element onto itself."""
        n = len(self.sheet.centres)
        symmetries = (motion for motion in self.sheet.placements() if self._whole(motion, n))
        return [STILL, *(motion for motion in symmetries if motion.key != STILL.key)]

    def _whole(self, motion: Placement, n: int) -> bool:
        overlap = self.sheet.overlap(motion)
        return overlap.agrees and overlap.facets == n and not overlap.crossed

    @cached_property
    def placements(self) -> list[Placement]:
        """Where a second copy can lie so that hinges merge, those that the element's symmetry makes equal once."""
        distinct: dict[int, Placement] = {}
        for motion in self.sheet.placements():
            key = self.key(motion)
            if key not in distinct and self._joins(motion):
                distinct[key] = motion
        return list(distinct.values())

    def key(self, motion: Placement) -> int:
        """The number of a copy: the same for motions that differ by a symmetry of the element."""
        return min((motion @ own).key for own in self.own)

    def plain(self, motion: Placement) -> Placement:
        """The same copy, inverted only where it must be, and turned over only where it must be."""
        return min((motion @ own for own in self.own), key=lambda same: (same.inverts, same.plane.reflects, same.key))

    def overlap(self, motion: Placement) -> Overlap:
        """How a copy lies on the element."""
        key = motion.key
        if key not in self._known:
            self._known[key] = self.sheet.overlap(motion)
        return self._known[key]

    def fits(self, motion: Placement) -> bool:
        """Whether a copy can lie there at all, overlapping or not."""
        overlap = self.overlap(motion)
        return overlap.agrees and not (self.strict and overlap.crossed)

    def _joins(self, motion: Placement) -> bool:
        overlap = self.overlap(motion)
        return self.fits(motion) and overlap.hinges > 0 and overlap.facets < len(self.sheet.centres)

    def pairs(self) -> Iterator[tuple[Placement, ...]]:
        """Two copies, the first where the element is."""
        for motion in self.placements:
            yield STILL, motion

    def rings(self) -> Iterator[tuple[Placement, ...]]:
        """Four copies A, B, C, D, the first where the element is; B and D may be exchanged."""
        across: dict[int, tuple[Placement, list[int]]] = {}
        for b, first in enumerate(self.placements):
            for second in self.placements:
                motion = first @ second
                across.setdefault(self.key(motion), (motion, []))[1].append(b)
        still = self.key(STILL)
        beside: dict[tuple[int, int], bool] = {}
        for key, (motion, between) in across.items():
            if key == still or len(between) < 2 or not self.fits(motion):
                continue
            for b, d in combinations(between, 2):
                if (b, d) not in beside:
                    beside[b, d] = self.fits(self.placements[b].inverse @ self.placements[d])
                if beside[b, d]:
                    yield STILL, self.placements[b], motion, self.placements[d]

    def marks(self, copies: Iterable[Placement]) -> list[Mark]:
        """Facets and creases of a union, each once."""
        distinct: dict[tuple[int, int, int], Mark] = {}
        for motion in copies:
            for place, code in self._own_marks:
                image = motion.plane(place)
                seen = code if code == _FACET else motion.exchange * code
                distinct[_rounded(image, seen)] = (image, seen)
        return list(distinct.values())

    @cached_property
    def _own_marks(self) -> list[Mark]:
        return marks_of(self.sheet)


def marks_of(sheet: Sheet) -> list[Mark]:
    """Facets and creases of a pattern."""
    creases = [((a + b) / 2, code) for a, b, code in sheet.creases]
    return [(complex(centre), _FACET) for centre in sheet.centres] + creases


def least_kutzbach(marks: Sequence[Mark]) -> int:
    """A lower bound of the union's Kutzbach count, and so of its degrees of freedom: creases may be one hinge."""
    counts: dict[int, int] = defaultdict(int)
    for _, code in marks:
        counts[code] += 1
    facets, rigid = counts[_FACET], counts[0]
    return 6 * (facets - rigid - 1) - 5 * (len(marks) - facets - rigid)


def congruence_key(marks: Sequence[Mark]) -> Key:
    """The same for congruent unions, also inverted ones, and for no others: their marks seen from a farthest facet."""
    places = np.array([place for place, _ in marks])
    codes = np.array([code for _, code in marks])
    facets = codes == _FACET
    places = places - places[facets].mean()
    radii = np.abs(places[facets])
    far = places[facets][radii > radii.max() - 10 * _STEP]
    best: bytes | None = None
    rows = np.empty((0, 3), np.int64)
    for reflects in (False, True):
        seen = places.conj() if reflects else places
        for turn in far.conj() if reflects else far:
            spun = seen * (abs(turn) / turn)
            xy = [np.floor(part / _STEP + _SHIFT).astype(np.int64) for part in (spun.real, spun.imag)]
            for exchange in (1, -1):
                table = np.column_stack([*xy, np.where(facets, codes, exchange * codes)])
                table = table[np.lexsort(table.T)]
                text = table.tobytes()
                if best is None or text < best:
                    best, rows = text, table
    return tuple((x, y, code) for x, y, code in rows.tolist())


def _rounded(place: complex, code: int) -> tuple[int, int, int]:
    return (math.floor(place.real / _STEP + _SHIFT), math.floor(place.imag / _STEP + _SHIFT), code)
