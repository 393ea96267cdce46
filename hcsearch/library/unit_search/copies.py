"""Copies of an element on one plane, pairs and rings of them: isometries that overlap panels and merge hinges.

A copy is carried by an isometry of the plane and may have its faces exchanged. A reflection that exchanges them is
the element turned over; one that does not, and an exchange alone, make its mirror image in space (the inversion of
thesis 6.1). Points are complex numbers, lengths divided by the size of a facet.

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
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import WholeNumbers
from hcsearch.library.assemblies.overlays import facets_clash
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.mesh import Facet
from hcsearch.shape.pattern import Crease, Pattern

ComplexArray = NDArray[np.complex128]

SAME_POINT_DISTANCE_SHARE = 1e-6
"""Points nearer than this share of a facet's size are the same."""
SLIT_CODE = 99
"""Code of two facets without a crease; the codes of hinges change sign with the face, that of a rigid crease is 0."""

_STEP, _SHIFT = 1e-4, 0.3771
_TURN = 1e-3


class CopyPlacement(NamedTuple):
    """Where a copy lies: an isometry of the plane; exchange : -1 where top and bottom faces are exchanged, else 1."""

    plane: Isometry
    exchange: int

    def __matmul__(self, first: CopyPlacement) -> CopyPlacement:
        """The motion that comes of `first`, then this one."""
        return CopyPlacement(self.plane @ first.plane, self.exchange * first.exchange)

    @property
    def inverse(self) -> CopyPlacement:
        """The motion that takes this one back."""
        return CopyPlacement(self.plane.inverse, self.exchange)

    @property
    def inverts(self) -> bool:
        """Whether the copy is the element's mirror image in space: no rigid motion takes the element there."""
        return self.plane.reflects == (self.exchange > 0)

    @property
    def key(self) -> int:
        """A number that distinguishes motions, whatever the rounding of where they come from."""
        around = round(math.tau / _TURN)
        angle = math.floor(self.plane.angle / _TURN + _SHIFT) % around
        x, y = (math.floor(v / _STEP + _SHIFT) + (1 << 21) for v in (self.plane.shift.real, self.plane.shift.imag))
        return ((((x << 22) | y) << 13) | angle) << 2 | self.plane.reflects << 1 | (self.exchange < 0)

    def of(self, pattern: Pattern, unit: float) -> Pattern:
        """The pattern moved so; `unit` is the length (m) that shifts are counted in."""
        turned = pattern.inverted() if self.inverts else pattern
        return turned.placed(self.plane._replace(shift=unit * self.plane.shift))


IDENTITY_PLACEMENT = CopyPlacement(Isometry(False, 1.0 + 0.0j, 0.0j), 1)


@dataclass(frozen=True)
class CopyOverlap:
    """Where two copies lie on each other.

    facets, hinges : number that they share. crossed : number of creases of one that lie in a slit of the other.
    agrees : whether no facets overlap in part and no creases differ.
    """

    facets: int
    hinges: int
    crossed: int
    agrees: bool


@dataclass(frozen=True)
class CopySheet:
    """The facets and creases of an element, as copies of it are compared.

    unit : length (m) that everything is divided by. lattice : whether the facets are cells of a regular tiling, so that
        copies that share an edge never overlap in part.
    """

    pattern: Pattern
    lattice: bool

    @cached_property
    def unit(self) -> float:
        """Side of a square of a facet's mean area, in metres."""
        return math.sqrt(self.pattern.area / len(self.pattern.facets))

    @cached_property
    def corners(self) -> list[ComplexArray]:
        """Corners of the facets."""
        return [np.array([complex(x, y) / self.unit for x, y in facet], complex) for facet in self.pattern.facets]

    @cached_property
    def centres(self) -> ComplexArray:
        """Middles of the facets, shape (n_facets,)."""
        return np.array([points.mean() for points in self.corners])

    @cached_property
    def codes(self) -> WholeNumbers:
        """Codes of the creases between facets, shape (n_facets, n_facets)."""
        codes = np.full((len(self.centres),) * 2, SLIT_CODE)
        for (i, j), crease in self.pattern.creases.items():
            codes[i, j] = codes[j, i] = crease_code_of(crease)
        return codes

    @cached_property
    def creases(self) -> list[tuple[complex, complex, int]]:
        """Both ends of each crease, and its code."""
        ends = ((self.pattern.segment(pair), crease_code_of(crease)) for pair, crease in self.pattern.creases.items())
        return [(complex(*a) / self.unit, complex(*b) / self.unit, code) for (a, b), code in ends]

    def overlap(self, motion: CopyPlacement) -> CopyOverlap:
        """How a copy lies on the element itself."""
        centres = motion.plane(self.centres)
        same = np.abs(self.centres[:, None] - centres) < SAME_POINT_DISTANCE_SHARE
        still, moved = np.nonzero(same)
        own, other = self.codes[np.ix_(still, still)], self.codes[np.ix_(moved, moved)]
        other = np.where(other == SLIT_CODE, SLIT_CODE, motion.exchange * other)
        both = (own != SLIT_CODE) & (other != SLIT_CODE)
        hinges = int(np.count_nonzero(both & (own == other) & (own != 0))) // 2
        crossed = int(np.count_nonzero((own != SLIT_CODE) != (other != SLIT_CODE))) // 2
        agrees = bool((own == other)[both].all()) and (self.lattice or not self._clash(motion))
        return CopyOverlap(len(still), hinges, crossed, agrees)

    def _clash(self, motion: CopyPlacement) -> bool:
        """Whether facets overlap in part."""
        moved = [motion.plane(points) for points in self.corners]
        return facets_clash(_facets(self.corners), _facets(moved), SAME_POINT_DISTANCE_SHARE)

    def placements(self) -> Iterator[CopyPlacement]:
        """All motions that lay a hinge of a copy onto a hinge of the element, each once; the element's own too."""
        known = set()
        hinges = [crease for crease in self.creases if crease[2]]
        for a, b, code in hinges:
            for c, d, other in hinges:
                if abs(code) != abs(other) or abs(abs(b - a) - abs(d - c)) > SAME_POINT_DISTANCE_SHARE:
                    continue
                exchange = 1 if code == other else -1
                for reflects, ends in product((False, True), ((a, b), (b, a))):
                    motion = CopyPlacement(Isometry.carrying((c, d), ends, reflects=reflects), exchange)
                    if motion.key not in known:
                        known.add(motion.key)
                        yield motion


def crease_code_of(crease: Crease) -> int:
    """0 for a rigid crease, else 1 or 2 (for hinges that stay flat), negative on the bottom face."""
    if crease.face is None:
        return 0
    return (1 if crease.closes else 2) * (1 if crease.face == "top" else -1)


def _facets(corners: Sequence[ComplexArray]) -> list[Facet]:
    return [tuple(zip(points.real.tolist(), points.imag.tolist(), strict=True)) for points in corners]


UnionKey = tuple[tuple[int, ...], ...]
PlacedMark = tuple[complex, int]
"""A facet or a crease of a union: its middle and a code; facets have the code `_FACET`."""

_FACET = 50
_PLACE_STEP, _PLACE_SHIFT = 1e-5, 0.3771


@dataclass
class CopyRings:
    """The ways to lay copies of one element together, two or four at a time.

    strict : whether no crease of one copy may lie in a slit of another.
    """

    sheet: CopySheet
    strict: bool = True
    _known: dict[int, CopyOverlap] = field(default_factory=dict)

    @cached_property
    def own(self) -> list[CopyPlacement]:
        """Motions that carry the element onto itself."""
        n = len(self.sheet.centres)
        symmetries = (motion for motion in self.sheet.placements() if self._whole(motion, n))
        return [IDENTITY_PLACEMENT, *(motion for motion in symmetries if motion.key != IDENTITY_PLACEMENT.key)]

    def _whole(self, motion: CopyPlacement, n: int) -> bool:
        overlap = self.sheet.overlap(motion)
        return overlap.agrees and overlap.facets == n and not overlap.crossed

    @cached_property
    def placements(self) -> list[CopyPlacement]:
        """Where a second copy can lie so that hinges merge, those that the element's symmetry makes equal once."""
        distinct: dict[int, CopyPlacement] = {}
        for motion in self.sheet.placements():
            key = self.key(motion)
            if key not in distinct and self._joins(motion):
                distinct[key] = motion
        return list(distinct.values())

    def key(self, motion: CopyPlacement) -> int:
        """The number of a copy: the same for motions that differ by a symmetry of the element."""
        return min((motion @ own).key for own in self.own)

    def plain(self, motion: CopyPlacement) -> CopyPlacement:
        """The same copy, inverted only where it must be, and turned over only where it must be."""
        return min((motion @ own for own in self.own), key=lambda same: (same.inverts, same.plane.reflects, same.key))

    def overlap(self, motion: CopyPlacement) -> CopyOverlap:
        """How a copy lies on the element."""
        key = motion.key
        if key not in self._known:
            self._known[key] = self.sheet.overlap(motion)
        return self._known[key]

    def fits(self, motion: CopyPlacement) -> bool:
        """Whether a copy can lie there at all, overlapping or not."""
        overlap = self.overlap(motion)
        return overlap.agrees and not (self.strict and overlap.crossed)

    def _joins(self, motion: CopyPlacement) -> bool:
        overlap = self.overlap(motion)
        return self.fits(motion) and overlap.hinges > 0 and overlap.facets < len(self.sheet.centres)

    def pairs(self) -> Iterator[tuple[CopyPlacement, ...]]:
        """Two copies, the first where the element is."""
        for motion in self.placements:
            yield IDENTITY_PLACEMENT, motion

    def rings(self) -> Iterator[tuple[CopyPlacement, ...]]:
        """Four copies A, B, C, D, the first where the element is; B and D may be exchanged."""
        across: dict[int, tuple[CopyPlacement, list[int]]] = {}
        for b, first in enumerate(self.placements):
            for second in self.placements:
                motion = first @ second
                across.setdefault(self.key(motion), (motion, []))[1].append(b)
        still = self.key(IDENTITY_PLACEMENT)
        beside: dict[tuple[int, int], bool] = {}
        for key, (motion, between) in across.items():
            if key == still or len(between) < 2 or not self.fits(motion):
                continue
            for b, d in combinations(between, 2):
                if (b, d) not in beside:
                    beside[b, d] = self.fits(self.placements[b].inverse @ self.placements[d])
                if beside[b, d]:
                    yield IDENTITY_PLACEMENT, self.placements[b], motion, self.placements[d]

    def marks(self, copies: Iterable[CopyPlacement]) -> list[PlacedMark]:
        """Facets and creases of a union, each once."""
        distinct: dict[tuple[int, int, int], PlacedMark] = {}
        for motion in copies:
            for place, code in self._own_marks:
                image = motion.plane(place)
                seen = code if code == _FACET else motion.exchange * code
                distinct[_rounded(image, seen)] = (image, seen)
        return list(distinct.values())

    @cached_property
    def _own_marks(self) -> list[PlacedMark]:
        return marks_of_copies(self.sheet)


def marks_of_copies(sheet: CopySheet) -> list[PlacedMark]:
    """Facets and creases of a pattern."""
    creases = [((a + b) / 2, code) for a, b, code in sheet.creases]
    return [(complex(centre), _FACET) for centre in sheet.centres] + creases


def least_kutzbach(marks: Sequence[PlacedMark]) -> int:
    """A lower bound of the union's Kutzbach count, and so of its degrees of freedom: creases may be one hinge."""
    counts: dict[int, int] = defaultdict(int)
    for _, code in marks:
        counts[code] += 1
    facets, rigid = counts[_FACET], counts[0]
    return 6 * (facets - rigid - 1) - 5 * (len(marks) - facets - rigid)


def congruence_key(marks: Sequence[PlacedMark]) -> UnionKey:
    """The same for congruent unions, also inverted ones, and for no others: their marks seen from a farthest facet."""
    places = np.array([place for place, _ in marks])
    codes = np.array([code for _, code in marks])
    facets = codes == _FACET
    places = places - places[facets].mean()
    radii = np.abs(places[facets])
    far = places[facets][radii > radii.max() - 10 * _PLACE_STEP]
    best: bytes | None = None
    rows = np.empty((0, 3), np.int64)
    for reflects in (False, True):
        seen = places.conj() if reflects else places
        for turn in far.conj() if reflects else far:
            spun = seen * (abs(turn) / turn)
            xy = [np.floor(part / _PLACE_STEP + _PLACE_SHIFT).astype(np.int64) for part in (spun.real, spun.imag)]
            for exchange in (1, -1):
                table = np.column_stack([*xy, np.where(facets, codes, exchange * codes)])
                table = table[np.lexsort(table.T)]
                text = table.tobytes()
                if best is None or text < best:
                    best, rows = text, table
    return tuple((x, y, code) for x, y, code in rows.tolist())


def _rounded(place: complex, code: int) -> tuple[int, int, int]:
    return (
        math.floor(place.real / _PLACE_STEP + _PLACE_SHIFT),
        math.floor(place.imag / _PLACE_STEP + _PLACE_SHIFT),
        code,
    )
