"""Copies of an element in one plane, in pairs and rings of four, that share panels and merge hinges.

A copy is placed by an isometry of the plane, optionally with top and bottom faces exchanged. A reflection with exchange
turns the element over; a reflection without exchange, or an exchange alone, gives its mirror image in space (the
inversion of thesis 6.1). Points are complex numbers, in units of a facet's size.

By the thesis's rule (5.2) four copies A, B, C, D are arranged such that A and B, B and C, C and D, D and A merge
hinges, and mountains and valleys agree wherever copies overlap. Arrangements are equivalent where their unions are
congruent, possibly turned over or inverted.
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
"""Tolerance for equal points, in units of a facet's size."""
SLIT_CODE = 99
"""Code of two facets without a crease. Codes of hinges have opposite signs on opposite faces; a rigid crease has 0."""

_STEP, _SHIFT = 1e-4, 0.3771
_TURN = 1e-3


class CopyPlacement(NamedTuple):
    """The placement of a copy: an isometry of the plane, and face_sign : -1 where faces are exchanged, else 1."""

    isometry: Isometry
    face_sign: int

    def __matmul__(self, first: CopyPlacement) -> CopyPlacement:
        """The composition of placements: `first`, then this one."""
        return CopyPlacement(self.isometry @ first.isometry, self.face_sign * first.face_sign)

    @property
    def inverse(self) -> CopyPlacement:
        """The inverse placement."""
        return CopyPlacement(self.isometry.inverse, self.face_sign)

    @property
    def inverts(self) -> bool:
        """Whether the copy is the element's mirror image in space, which no rigid motion reaches."""
        return self.isometry.reflects == (self.face_sign > 0)

    @property
    def key(self) -> int:
        """A number that identifies a placement up to rounding."""
        around = round(math.tau / _TURN)
        angle = math.floor(self.isometry.angle / _TURN + _SHIFT) % around
        x, y = (
            math.floor(v / _STEP + _SHIFT) + (1 << 21) for v in (self.isometry.shift.real, self.isometry.shift.imag)
        )
        return ((((x << 22) | y) << 13) | angle) << 2 | self.isometry.reflects << 1 | (self.face_sign < 0)

    def of(self, pattern: Pattern, unit: float) -> Pattern:
        """Return a pattern in this placement; unit : length unit of shifts, m."""
        oriented = pattern.inverted() if self.inverts else pattern
        return oriented.placed(self.isometry._replace(shift=unit * self.isometry.shift))


IDENTITY_PLACEMENT = CopyPlacement(Isometry(False, 1.0 + 0.0j, 0.0j), 1)


@dataclass(frozen=True)
class CopyOverlap:
    """The overlap of two copies.

    facets, hinges : numbers of shared facets and hinges. creases_in_slits : number of creases of one copy in slits of
    the other.
    agrees : whether no facets overlap partially and no creases differ.
    """

    facets: int
    hinges: int
    creases_in_slits: int
    agrees: bool


@dataclass(frozen=True)
class CopySheet:
    """The facets and creases of an element, normalised for the comparison of copies.

    unit : unit of length, m. lattice : whether the facets are cells of a regular tiling, so that copies that share an
        edge never overlap partially.
    """

    pattern: Pattern
    lattice: bool

    @cached_property
    def unit(self) -> float:
        """Side of a square of a facet's mean area, in metres."""
        return math.sqrt(self.pattern.area / len(self.pattern.facets))

    @cached_property
    def corners(self) -> list[ComplexArray]:
        """The corners of the facets, as complex numbers."""
        return [np.array([complex(x, y) / self.unit for x, y in facet], complex) for facet in self.pattern.facets]

    @cached_property
    def centres(self) -> ComplexArray:
        """The centres of the facets, shape (n_facets,)."""
        return np.array([points.mean() for points in self.corners])

    @cached_property
    def codes(self) -> WholeNumbers:
        """The codes of the creases between facets, shape (n_facets, n_facets)."""
        codes = np.full((len(self.centres),) * 2, SLIT_CODE)
        for (i, j), crease in self.pattern.creases.items():
            codes[i, j] = codes[j, i] = crease_code_of(crease)
        return codes

    @cached_property
    def creases(self) -> list[tuple[complex, complex, int]]:
        """Both ends of each crease, and its code, as tuples."""
        ends = ((self.pattern.segment(pair), crease_code_of(crease)) for pair, crease in self.pattern.creases.items())
        return [(complex(*a) / self.unit, complex(*b) / self.unit, code) for (a, b), code in ends]

    def overlap(self, motion: CopyPlacement) -> CopyOverlap:
        """Compute the overlap of a copy with the element."""
        centres = motion.isometry(self.centres)
        same = np.abs(self.centres[:, None] - centres) < SAME_POINT_DISTANCE_SHARE
        fixed, moved = np.nonzero(same)
        fixed_codes, moved_codes = self.codes[np.ix_(fixed, fixed)], self.codes[np.ix_(moved, moved)]
        moved_codes = np.where(moved_codes == SLIT_CODE, SLIT_CODE, motion.face_sign * moved_codes)
        both_creased = (fixed_codes != SLIT_CODE) & (moved_codes != SLIT_CODE)
        hinges = int(np.count_nonzero(both_creased & (fixed_codes == moved_codes) & (fixed_codes != 0))) // 2
        creases_in_slits = int(np.count_nonzero((fixed_codes != SLIT_CODE) != (moved_codes != SLIT_CODE))) // 2
        agrees = bool((fixed_codes == moved_codes)[both_creased].all()) and (self.lattice or not self._clash(motion))
        return CopyOverlap(len(fixed), hinges, creases_in_slits, agrees)

    def _clash(self, motion: CopyPlacement) -> bool:
        """Whether facets of a copy partially overlap facets of the element."""
        moved = [motion.isometry(points) for points in self.corners]
        return facets_clash(_facets(self.corners), _facets(moved), SAME_POINT_DISTANCE_SHARE)

    def placements(self) -> Iterator[CopyPlacement]:
        """Yield all placements that lay a hinge of a copy onto one of the element, each once, symmetries included."""
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
    """Return the code of a crease: 0 if rigid, 1 for a hinge, 2 for one that stays flat; negative on the bottom."""
    if crease.face is None:
        return 0
    return (1 if crease.closes else 2) * (1 if crease.face == "top" else -1)


def _facets(corners: Sequence[ComplexArray]) -> list[Facet]:
    return [tuple(zip(points.real.tolist(), points.imag.tolist(), strict=True)) for points in corners]


UnionKey = tuple[tuple[int, ...], ...]
PlacedMark = tuple[complex, int]
"""A facet or a crease of a union: its centre and a code; facets have the code `_FACET`."""

_FACET = 50
_PLACE_STEP, _PLACE_SHIFT = 1e-5, 0.3771


@dataclass
class CopyRings:
    """The arrangements of two or four copies of one element.

    strict : whether to exclude creases of one copy in slits of another.
    """

    sheet: CopySheet
    strict: bool = True
    _known: dict[int, CopyOverlap] = field(default_factory=dict)

    @cached_property
    def symmetries(self) -> list[CopyPlacement]:
        """The symmetries of the element: placements that map it onto itself."""
        n = len(self.sheet.centres)
        placements = (motion for motion in self.sheet.placements() if self._whole(motion, n))
        return [IDENTITY_PLACEMENT, *(motion for motion in placements if motion.key != IDENTITY_PLACEMENT.key)]

    def _whole(self, motion: CopyPlacement, n: int) -> bool:
        overlap = self.sheet.overlap(motion)
        return overlap.agrees and overlap.facets == n and not overlap.creases_in_slits

    @cached_property
    def placements(self) -> list[CopyPlacement]:
        """The placements of a second copy that merge hinges, one of each class under the element's symmetries."""
        distinct: dict[int, CopyPlacement] = {}
        for motion in self.sheet.placements():
            key = self.key(motion)
            if key not in distinct and self._joins(motion):
                distinct[key] = motion
        return list(distinct.values())

    def key(self, motion: CopyPlacement) -> int:
        """Return the number of a copy, equal for placements that differ by a symmetry of the element."""
        return min((motion @ symmetry).key for symmetry in self.symmetries)

    def simplest_placement(self, motion: CopyPlacement) -> CopyPlacement:
        """Return the simplest equivalent placement: not inverted, and not turned over, where possible."""
        return min(
            (motion @ symmetry for symmetry in self.symmetries),
            key=lambda same: (same.inverts, same.isometry.reflects, same.key),
        )

    def overlap(self, motion: CopyPlacement) -> CopyOverlap:
        """Return the overlap of a copy with the element, from a cache."""
        key = motion.key
        if key not in self._known:
            self._known[key] = self.sheet.overlap(motion)
        return self._known[key]

    def fits(self, motion: CopyPlacement) -> bool:
        """Whether a copy is compatible with the element, overlapping or not."""
        overlap = self.overlap(motion)
        return overlap.agrees and not (self.strict and overlap.creases_in_slits)

    def _joins(self, motion: CopyPlacement) -> bool:
        overlap = self.overlap(motion)
        return self.fits(motion) and overlap.hinges > 0 and overlap.facets < len(self.sheet.centres)

    def pairs(self) -> Iterator[tuple[CopyPlacement, ...]]:
        """Yield arrangements of two copies, the first at the identity."""
        for motion in self.placements:
            yield IDENTITY_PLACEMENT, motion

    def rings(self) -> Iterator[tuple[CopyPlacement, ...]]:
        """Yield arrangements of four copies A, B, C, D, A at the identity; exchanges of B and D are listed once."""
        across: dict[int, tuple[CopyPlacement, list[int]]] = {}
        for b, first in enumerate(self.placements):
            for second in self.placements:
                motion = first @ second
                across.setdefault(self.key(motion), (motion, []))[1].append(b)
        identity_key = self.key(IDENTITY_PLACEMENT)
        compatible: dict[tuple[int, int], bool] = {}
        for key, (motion, middle_copies) in across.items():
            if key == identity_key or len(middle_copies) < 2 or not self.fits(motion):
                continue
            for b, d in combinations(middle_copies, 2):
                if (b, d) not in compatible:
                    compatible[b, d] = self.fits(self.placements[b].inverse @ self.placements[d])
                if compatible[b, d]:
                    yield IDENTITY_PLACEMENT, self.placements[b], motion, self.placements[d]

    def marks(self, copies: Iterable[CopyPlacement]) -> list[PlacedMark]:
        """Return the marks (facets and creases) of a union, each once."""
        distinct: dict[tuple[int, int, int], PlacedMark] = {}
        for motion in copies:
            for place, code in self._own_marks:
                image = motion.isometry(place)
                image_code = code if code == _FACET else motion.face_sign * code
                distinct[_rounded(image, image_code)] = (image, image_code)
        return list(distinct.values())

    @cached_property
    def _own_marks(self) -> list[PlacedMark]:
        return marks_of_copies(self.sheet)


def marks_of_copies(sheet: CopySheet) -> list[PlacedMark]:
    """Return the marks (facets and creases) of a pattern."""
    creases = [((a + b) / 2, code) for a, b, code in sheet.creases]
    return [(complex(centre), _FACET) for centre in sheet.centres] + creases


def least_kutzbach(marks: Sequence[PlacedMark]) -> int:
    """Return a lower bound of a union's Kutzbach count, since several creases may be one hinge."""
    counts: dict[int, int] = defaultdict(int)
    for _, code in marks:
        counts[code] += 1
    facets, rigid = counts[_FACET], counts[0]
    return 6 * (facets - rigid - 1) - 5 * (len(marks) - facets - rigid)


def congruence_key(marks: Sequence[PlacedMark]) -> UnionKey:
    """Return a canonical form of a union's marks, equal exactly for congruent unions, inverted ones included."""
    places = np.array([place for place, _ in marks])
    codes = np.array([code for _, code in marks])
    facets = codes == _FACET
    places = places - places[facets].mean()
    radii = np.abs(places[facets])
    far = places[facets][radii > radii.max() - 10 * _PLACE_STEP]
    best: bytes | None = None
    rows = np.empty((0, 3), np.int64)
    for reflects in (False, True):
        reflected = places.conj() if reflects else places
        for turn in far.conj() if reflects else far:
            rotated = reflected * (abs(turn) / turn)
            xy = [np.floor(part / _PLACE_STEP + _PLACE_SHIFT).astype(np.int64) for part in (rotated.real, rotated.imag)]
            for exchange in (1, -1):
                table = np.column_stack([*xy, np.where(facets, codes, exchange * codes)])
                table = table[np.lexsort(table.T)]
                text = table.tobytes()
                if best is None or text < best:
                    best, rows = text, table
    return tuple((x, y, code) for x, y, code in rows.tolist())


def _rounded(place: complex, code: int) -> tuple[int, int, int]:
    x, y = (math.floor(part / _PLACE_STEP + _PLACE_SHIFT) for part in (place.real, place.imag))
    return x, y, code
