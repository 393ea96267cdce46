"""A cover of all directions by cells, less those in which some quadrics have no common point: where to begin a search.

The cells left out are proved to hold none, so that a search from every other cell misses none for want of a start, and
does not depend on the coordinates (Hansen and Walster 2004, Global Optimization Using Interval Analysis, chapter 11).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Flags, Reals, WholeNumbers
from hcsearch.basics.equality import ByValue

MIN_CELL_RADIUS = 0.05
"""Radius down to which cells are halved."""
MAX_HALVED_CELLS, MAX_COVER_CELLS = 4000, 1000
"""Halving ends above `MAX_HALVED_CELLS`; the cover is the last set of at most `MAX_COVER_CELLS` cells."""


@dataclass(frozen=True, eq=False)
class Cover(ByValue):
    """Unit vectors (n, m) of which one lies within `radius` of every common point (up to sign where both count)."""

    centres: Reals
    radius: float


@dataclass(frozen=True, eq=False)
class _Cells(ByValue):
    """Boxes on the faces of a cube about the origin: axis and sense of the face, middle and half widths there."""

    axis: WholeNumbers
    sense: Reals
    middle: Reals
    half: Reals

    def some(self, which: Flags) -> _Cells:
        return _Cells(self.axis[which], self.sense[which], self.middle[which], self.half[which])

    def halves(self) -> _Cells:
        """All cells cut in two across their longest side."""
        rows, side = np.arange(len(self.axis)), self.half.argmax(axis=1)
        half = self.half.copy()
        half[rows, side] *= 0.5
        shift = np.zeros_like(half)
        shift[rows, side] = half[rows, side]
        middle = np.concatenate([self.middle - shift, self.middle + shift])
        return _Cells(np.tile(self.axis, 2), np.tile(self.sense, 2), middle, np.tile(half, (2, 1)))

    def balls(self) -> tuple[Reals, Reals]:
        """Centres on the unit sphere, and radii of balls that hold what a cell covers of it."""
        n, m = len(self.axis), self.middle.shape[1] + 1
        rows = np.arange(n)
        corner = np.empty((n, m))
        corner[np.arange(m) != self.axis[:, None]] = self.middle.ravel()
        corner[rows, self.axis] = self.sense
        # points outside a sphere about the origin, projected onto it along their radii, come no further apart
        nearest = np.sqrt(1.0 + (np.maximum(np.abs(self.middle) - self.half, 0.0) ** 2).sum(axis=1))
        centres = corner / np.linalg.norm(corner, axis=1, keepdims=True)
        # reflected to axes that no linkage has: a centre on a plane of symmetry of the quadrics would be a bad start
        away = 1.0 + (np.arange(m) * 0.6180339887498949) % 1.0
        turned = centres - np.outer(centres @ away, 2.0 * away / (away @ away))
        return turned, np.minimum(np.linalg.norm(self.half, axis=1) / nearest, 2.0)


def cover_directions(forms: Reals, cone: Reals | None, *, both: bool, slack: float) -> Cover:
    """Cells that may hold unit vectors z with z' Q z = 0 for all forms Q (k, m, m) and, with a cone A, A z >= 0.

    both : whether z and -z are one. slack : what may be left of an equation.
    """
    m = forms.shape[1]
    senses = (1.0,) if both else (1.0, -1.0)
    axis, sense = np.tile(np.arange(m), len(senses)), np.repeat(senses, m)
    cells = _Cells(axis, sense, np.zeros((len(axis), m - 1)), np.ones((len(axis), m - 1)))
    kept = Cover(np.zeros((0, m)), 2.0)
    while True:
        centres, radii = cells.balls()
        left = _open(forms, cone, centres, radii, slack)
        cells, centres, radius = cells.some(left), centres[left], float(radii[left].max(initial=0.0))
        if len(centres) <= MAX_COVER_CELLS:
            kept = Cover(centres, radius)
        if radius <= MIN_CELL_RADIUS or len(centres) > MAX_HALVED_CELLS:
            return kept
        cells = cells.halves()


def _open(forms: Reals, cone: Reals | None, centres: Reals, radii: Reals, slack: float) -> Flags:
    """Which balls may hold a common point.

    Within r of a unit vector c a form is its value at c plus a linear term, up to (|F| + L) r^2, with L the norm of all
    forms together. That holds for each orthonormal combination of the forms, so also for those of least linear terms: a
    value that these cannot cancel proves that the ball holds no common point.
    """
    possible = np.ones(len(centres), bool)
    if cone is not None:
        possible &= (centres @ cone.T >= -np.linalg.norm(cone, axis=1) * radii[:, None] - slack).all(axis=1)
    at = np.flatnonzero(possible)
    if not len(forms) or not len(at):
        return possible
    products = np.einsum("kij,lij->kl", forms, forms)
    c, r = centres[at], radii[at, None]
    turned = np.einsum("kij,nj->nki", forms, c)
    values = np.einsum("nki,ni->nk", turned, c)
    slopes = 2.0 * (turned - values[:, :, None] * c[:, None, :])
    sums = np.linalg.eigh(np.einsum("nki,nli->nkl", slopes, slopes))[1]
    summed = np.abs(np.einsum("nkl,nk->nl", sums, values))
    linear = np.linalg.norm(np.einsum("nkl,nki->nli", sums, slopes), axis=2)
    curved = summed + np.sqrt(np.einsum("nkl,kj,njl->nl", sums, products, sums, optimize=True))
    possible[at] = (summed <= linear * r + curved * r * r + slack).all(axis=1)
    return possible
