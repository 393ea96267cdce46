"""Copies of an element on one plane: their isometries, and whether two copies agree where they overlap.

A copy is carried by an isometry of the plane and may have its faces exchanged. A reflection that exchanges them is
the element turned over; one that does not, and an exchange alone, make its mirror image in space (the inversion of
thesis 6.1). Points are complex numbers, lengths divided by the size of a facet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import WholeNumbers
from hcsearch.library.assemblies.clashes import clash
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.mesh import Facet
from hcsearch.shape.pattern import Crease, Pattern

Complex = NDArray[np.complex128]

NEAR = 1e-6
"""Points nearer than this share of a facet's size are the same."""
SLIT = 99
"""Code of two facets without a crease; the codes of hinges change sign with the face, that of a rigid crease is 0."""

_STEP, _SHIFT = 1e-4, 0.3771
_TURN = 1e-3


class Placement(NamedTuple):
    """Where a copy lies: an isometry of the plane; exchange : -1 where top and bottom faces are exchanged, else 1."""

    plane: Isometry
    exchange: int

    def __matmul__(self, first: Placement) -> Placement:
        """The motion that comes of `first`, then this one."""
        return Placement(self.plane @ first.plane, self.exchange * first.exchange)

    @property
    def inverse(self) -> Placement:
        """The motion that takes this one back."""
        return Placement(self.plane.inverse, self.exchange)

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


STILL = Placement(Isometry(False, 1.0 + 0.0j, 0.0j), 1)


@dataclass(frozen=True)
class Overlap:
    """Where two copies lie on each other.

    facets, hinges : number that they share. crossed : number of creases of one that lie in a slit of the other.
    agrees : whether no facets overlap in part and no creases differ.
    """

    facets: int
    hinges: int
    crossed: int
    agrees: bool


@dataclass(frozen=True)
class Sheet:
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
    def corners(self) -> list[Complex]:
        """Corners of the facets."""
        return [np.array([complex(x, y) / self.unit for x, y in facet], complex) for facet in self.pattern.facets]

    @cached_property
    def centres(self) -> Complex:
        """Middles of the facets, shape (n_facets,)."""
        return np.array([points.mean() for points in self.corners])

    @cached_property
    def codes(self) -> WholeNumbers:
        """Codes of the creases between facets, shape (n_facets, n_facets)."""
        codes = np.full((len(self.centres),) * 2, SLIT)
        for (i, j), crease in self.pattern.creases.items():
            codes[i, j] = codes[j, i] = code_of(crease)
        return codes

    @cached_property
    def creases(self) -> list[tuple[complex, complex, int]]:
        """Both ends of each crease, and its code."""
        ends = ((self.pattern.segment(pair), code_of(crease)) for pair, crease in self.pattern.creases.items())
        return [(complex(*a) / self.unit, complex(*b) / self.unit, code) for (a, b), code in ends]

    def overlap(self, motion: Placement) -> Overlap:
        """How a copy lies on the element itself."""
        centres = motion.plane(self.centres)
        same = np.abs(self.centres[:, None] - centres) < NEAR
        still, moved = np.nonzero(same)
        own, other = self.codes[np.ix_(still, still)], self.codes[np.ix_(moved, moved)]
        other = np.where(other == SLIT, SLIT, motion.exchange * other)
        both = (own != SLIT) & (other != SLIT)
        hinges = int(np.count_nonzero(both & (own == other) & (own != 0))) // 2
        crossed = int(np.count_nonzero((own != SLIT) != (other != SLIT))) // 2
        agrees = bool((own == other)[both].all()) and (self.lattice or not self._clash(motion))
        return Overlap(len(still), hinges, crossed, agrees)

    def _clash(self, motion: Placement) -> bool:
        """Whether facets overlap in part."""
        moved = [motion.plane(points) for points in self.corners]
        return clash(_facets(self.corners), _facets(moved), NEAR)

    def placements(self) -> Iterator[Placement]:
        """All motions that lay a hinge of a copy onto a hinge of the element, each once; the element's own too."""
        known = set()
        hinges = [crease for crease in self.creases if crease[2]]
        for a, b, code in hinges:
            for c, d, other in hinges:
                if abs(code) != abs(other) or abs(abs(b - a) - abs(d - c)) > NEAR:
                    continue
                exchange = 1 if code == other else -1
                for reflects, ends in product((False, True), ((a, b), (b, a))):
                    motion = Placement(Isometry.carrying((c, d), ends, reflects=reflects), exchange)
                    if motion.key not in known:
                        known.add(motion.key)
                        yield motion


def code_of(crease: Crease) -> int:
    """0 for a rigid crease, else 1 or 2 (for hinges that stay flat), negative on the bottom face."""
    if crease.face is None:
        return 0
    return (1 if crease.closes else 2) * (1 if crease.face == "top" else -1)


def _facets(corners: Sequence[Complex]) -> list[Facet]:
    return [tuple(zip(points.real.tolist(), points.imag.tolist(), strict=True)) for points in corners]
