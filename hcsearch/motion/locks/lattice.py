"""Exact screws of hinges, in whole numbers, at the ends of the motion of linkages on a tiling.

Flat and folded, every hinge lies along an edge of the tiling at a whole multiple of the thickness
(docs/explanation/theory.md, 25). On tilings with right angles and half right angles points are rational. On those with
angles of 30 degrees one coordinate is a multiple of sqrt(3): with x = sqrt(q) X, y = Y, z = Z all points are rational,
and so are screws, their brackets and heights at contacts, but for one positive factor each. So signs are computed with
whole numbers, without arithmetic in Q(sqrt 3). Factors of screws differ between hinges, which scales their turns.
The first edge of panels, their width and thickness are the decimal numbers of 12 digits nearest to those given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.designs.grid import GRIDS, Grid, LatticePoint
from hcsearch.designs.grid.tessellation import square_of
from hcsearch.shape.linkage import Linkage, Walk, at_stops
from hcsearch.shape.mesh import Facet

ExactArray = NDArray[np.object_]
"""Arrays of Python integers, which do not overflow."""

LatticeLine = tuple[int, int, int, int, int]
"""A point of a hinge's line in the flat state, (X, Y, Z), and its direction (X, Y)."""

EXACT_LENGTH_DIGITS = 12
"""Decimal digits to which lengths are taken as exact."""
LATTICE_TOLERANCE = 1e-7
"""Points within this share of the steps from the lattice are on it; rounding is 1e-14."""


@dataclass(frozen=True, eq=False)
class LatticeFrame(ByValue):
    """Whole coordinates (X, Y, Z) of a lattice: the point origin + unit (sqrt(q) X e_x + Y e_y + Z e_z), in metres.

    q : 1 on tilings with right angles and their halves, 3 on those with angles of 30 degrees. steps : lengths of the
    lattice's steps in X, Y and Z, the last one a thickness. axes : e_x and e_y in the pattern's drawing, as columns.
    """

    q: int
    steps: tuple[int, int, int]
    unit: float
    origin: Reals
    axes: Reals

    def points(self, points: Reals) -> ExactArray | None:
        """Whole coordinates X, Y of points (k, 2) of the plane, in metres; None if some are off the lattice."""
        steps = self.unit * np.array([math.sqrt(self.q) * self.steps[0], self.steps[1]])
        return self._on_lattice((points - self.origin) @ self.axes / steps, np.array(self.steps[:2], object))

    def directions(self, directions: Reals) -> ExactArray | None:
        """Whole directions along unit vectors of the plane, shape (k, 2); None if some are no lattice directions.

        Their squared lengths are 1, or 2 between the axes, where q is 1, and 4 or 12 where it is 3.
        """
        scaled = directions @ self.axes / np.array([math.sqrt(self.q), 1.0])
        short, long = (1.0, 2.0) if self.q == 1 else (4.0, 12.0)
        fits = np.abs(math.sqrt(short) * scaled - np.rint(math.sqrt(short) * scaled)).max(axis=1) < LATTICE_TOLERANCE
        return self._on_lattice(np.sqrt(np.where(fits, short, long))[:, None] * scaled, np.array([1, 1], object))

    def square(self, x: int, y: int) -> int:
        """The squared length of a whole vector of the plane."""
        return self.q * x * x + y * y

    def _on_lattice(self, counts: Reals, steps: ExactArray) -> ExactArray | None:
        """Whole coordinates from counts of steps in X and Y, whose sum is even where q is 3; else None.

        Half turns map the lattice to itself only with even sums.
        """
        multiples = _rounded(counts, steps)
        if multiples is None or (self.q == 3 and (np.rint(counts).sum(axis=1) % 2).any()):
            return None
        return multiples

    def brackets(self, wrench: Sequence[int]) -> ExactArray:
        """The matrix S, (6, 6), with y . [A, B] = A' S B for whole screws A, B of level lines, up to a positive factor.

        In true coordinates the cross product of vectors (sqrt(q) X, Y, Z) is sqrt(q) times the vector with coordinates
        (X/q, Y, Z) of the cross product of (X, Y, Z); moments are such vectors already.
        """
        q = self.q
        *_, c, d, e, f = wrench
        return np.array(
            [
                [0, q * c, 0, 0, q * f, -q * e],
                [-q * c, 0, 0, -f, 0, q * d],
                [0, 0, 0, 0, 0, 0],
                [0, f, 0, 0, 0, 0],
                [-q * f, 0, 0, 0, 0, 0],
                [q * e, -q * d, 0, 0, 0, 0],
            ],
            object,
        )


def lattice_frame_of(linkage: Linkage) -> LatticeFrame | None:
    """The lattice of a pattern's first facet, if that is a panel of one of the grids; else None."""
    return _frame_of(linkage.pattern.facets[0], linkage.pattern.thickness)


@lru_cache(maxsize=256)
def _frame_of(facet: Facet, thickness: float) -> LatticeFrame | None:
    for grid in (grid for grid in GRIDS.values() if grid.edges_per_cell == len(facet)):
        mirrored = tuple((y, x) for x, y in (*grid.polygon[1::-1], *grid.polygon[:1:-1]))
        for first in range(len(facet)):
            for polygon in (grid.polygon, mirrored):
                frame = _frame(grid, polygon, np.roll(facet, -first, axis=0), thickness)
                if frame is not None:
                    return frame
    return None


def _frame(grid: Grid, polygon: Sequence[LatticePoint], facet: Reals, thickness: float) -> LatticeFrame | None:
    """The lattice of a facet that is similar to a polygon, or to its stretched image, corner by corner; else None."""
    q, (along, across) = 3 if grid.axes == 6 else 1, facet[1:3] - facet[:2]
    length, width = math.hypot(*along), math.hypot(*(across if grid.stretched else along))
    axes = np.array([[along[1], along[0]], [-along[0], along[1]]]) / length  # Y along the first edge
    first, square = _between(*polygon[:2]), square_of(_between(*polygon[:2]), grid.axes)
    corners = np.array([_parts(_between(polygon[0], corner), first, grid.axes) for corner in polygon])
    scale = np.array([math.sqrt(q) * width, length]) / (2 * square)
    if np.abs(corners * scale - (facet - facet[0]) @ axes).max() > LATTICE_TOLERANCE * length:
        return None
    cells = [grid.lattice_corners((0, 0, kind)) for kind in range(grid.kinds)]
    parts = [_parts(_between(cell[0], corner), first, grid.axes) for cell in cells for corner in cell]
    exact = [
        _decimal(size) * Fraction(math.gcd(*counts), 2 * square)
        for size, counts in zip((width, length), zip(*parts, strict=True), strict=True)
    ] + [_decimal(thickness)]
    denominator = math.lcm(*(size.denominator for size in exact))
    x, y, z = (int(size * denominator) for size in exact)
    return LatticeFrame(q, (x, y, z), 1.0 / denominator, facet[0], axes)


def _between(p: LatticePoint, q: LatticePoint) -> LatticePoint:
    return (q[0] - p[0], q[1] - p[1])


def _parts(vector: LatticePoint, first: LatticePoint, axes: int) -> tuple[int, int]:
    """The parts of a vector across and along an edge, X to its right and Y, in edges over twice its squared length."""
    (x, y), (a, b) = vector, first
    right = (x * b - y * a) * (1 if axes == 6 else 2)
    return right, square_of((x + a, y + b), axes) - square_of(vector, axes) - square_of(first, axes)


def _decimal(length: float) -> Fraction:
    return Fraction(f"{length:.{EXACT_LENGTH_DIGITS}g}")


def _rounded(values: Reals, steps: ExactArray) -> ExactArray | None:
    """Multiples of steps whose factors are whole but for rounding, made exact; None if some are not whole."""
    whole = np.rint(values)
    if not np.isfinite(values).all() or np.abs(values - whole).max(initial=0.0) > LATTICE_TOLERANCE:
        return None
    multiples: ExactArray = whole.astype(np.int64).astype(object) * steps
    return multiples


@dataclass(frozen=True, eq=False)
class WholeEnd(ByValue):
    """An end of the motion in whole numbers.

    directions : whole directions of the hinges in the flat state, shape (n_hinges, 2).
    columns : screws (U, M) of the hinges in the sense in which they leave their stops, for each loop, shape
        (n_hinges, n_rows); where a hinge is in no loop, zeros. order : hinges of each loop, as it is walked.
    """

    frame: LatticeFrame
    directions: ExactArray
    columns: ExactArray
    order: tuple[tuple[int, ...], ...]
    size: float

    @property
    def rank(self) -> int:
        """Number of independent screws."""
        return len(reduced_rows(self.columns)) if self.columns.size else 0  # an open chain has no rows

    def wrench(self, wrench: Reals) -> ExactArray:
        """Convert a wrench on the rows of `Linkage.closure`, shape (n_rows,), to one on whole screws.

        Powers are the same but for rounding and a positive factor: the entries are fractions, the values of doubles.
        """
        frame = self.frame
        basis = np.eye(3)
        basis[:2, :2] = frame.axes * np.array([math.sqrt(frame.q), 1.0])
        moments = math.sqrt(frame.q) * np.linalg.inv(basis).T * frame.unit / self.size
        x, y = frame.origin / self.size
        shift = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]]) @ basis
        parts = wrench.reshape(-1, 2, 3)
        entries = np.stack([parts[:, 0] @ basis + parts[:, 1] @ shift, parts[:, 1] @ moments], axis=1)
        return np.array([Fraction(value) for value in entries.ravel().tolist()], object)

    def contacts(self, rows: Reals) -> ExactArray | None:
        """Conditions on turns, shape (k, n_hinges), as `end_locks.contact_rows` has them, in whole numbers.

        They are heights of lattice points over lines of the lattice; None if some are not.
        """
        frame = self.frame
        steps = [math.gcd(*u) for u in (abs(self.directions) * np.array([frame.steps[1], frame.steps[0]], object))]
        heights = frame.unit * math.sqrt(frame.q) / self.lengths / self.size
        return _rounded(rows / (heights * np.array(steps, float)), np.array(steps, object))

    def force(self, forces: Reals) -> ExactArray:
        """Forces at contacts as fractions, on the scale of `wrench`."""
        scaled = forces * self.frame.unit * math.sqrt(self.frame.q) / self.size
        return np.array([Fraction(value) for value in scaled.tolist()], object)

    @property
    def lengths(self) -> Reals:
        """The lengths of the hinges' whole directions, by which their whole screws exceed unit screws."""
        return np.sqrt([float(self.frame.square(*u)) for u in self.directions.tolist()])

    def bends(self, wrench: ExactArray) -> ExactArray:
        """The symmetric form of y . b on velocities: entries y . [A_i, A_j], shape (n_hinges, n_hinges).

        Twice y . b(x) is the form's value at x, up to a positive factor.
        """
        form: ExactArray = np.zeros((len(self.columns), len(self.columns)), object)
        for loop, hinges in enumerate(self.order):
            rows = slice(6 * loop, 6 * loop + 6)
            screws = self.columns[list(hinges), rows]
            upper = np.triu(screws @ self.frame.brackets(wrench[rows].tolist()) @ screws.T, 1)
            form[np.ix_(hinges, hinges)] += upper + upper.T
        return form


def whole_end(linkage: Linkage, angles: Reals) -> WholeEnd | None:
    """The end of the motion, in whole numbers, at a state where every hinge is at a stop.

    None where the linkage is on no tiling, a hinge is not at a stop, or the loops are not closed exactly.
    """
    frame = lattice_frame_of(linkage)
    closed = angles == math.pi
    if frame is None or not at_stops(angles).all():
        return None
    starts = frame.points(linkage.points[:, :2] - 0.5 * _spans(linkage))
    directions = frame.directions(linkage.directions[:, :2])
    if starts is None or directions is None:
        return None
    heights = [frame.steps[2] if hinge.face == "top" else 0 for hinge in linkage.pattern.hinges]
    lines = [
        (*point, height, *u) for point, height, u in zip(starts.tolist(), heights, directions.tolist(), strict=True)
    ]
    columns: ExactArray = np.zeros((linkage.n_hinges, linkage.n_rows), object)
    for loop, walk in enumerate(linkage.loops):
        screws = _walked(frame, lines, closed.tolist(), walk)
        if screws is None:
            return None
        columns[[hinge for hinge, _ in walk], 6 * loop : 6 * loop + 6] = screws
    order = tuple(tuple(hinge for hinge, _ in walk) for walk in linkage.loops)
    return WholeEnd(frame, directions, columns, order, linkage.pattern.size)


def _spans(linkage: Linkage) -> Reals:
    """Vectors from the start to the end of each hinge, shape (n_hinges, 2), in metres."""
    spans: Reals = np.array([np.subtract(hinge.end, hinge.start) for hinge in linkage.pattern.hinges]).reshape(-1, 2)
    return spans


def _walked(
    frame: LatticeFrame, lines: Sequence[LatticeLine], closed: Sequence[bool], walk: Walk
) -> list[list[int]] | None:
    """Screws of a loop's hinges in the sense in which they leave their stops, in the frame of its first panel.

    None where the loop is not closed. Panels are placed by half turns about level lines, which multiply directions
    (X, Y) by `turn` / 2, a matrix that is whole on all tilings, shift them, and reverse heights.
    """
    (a, b, c, d), (x, y, z), up = (2, 0, 0, 2), (0, 0, 0), 1
    screws = []
    for hinge, sign in walk:
        px, py, pz, ux, uy = lines[hinge]
        # the placed line; halved values are even, as half turns map the lattice to itself
        px, py, pz = (a * px + b * py) // 2 + x, (c * px + d * py) // 2 + y, up * pz + z
        ux, uy = sign * (a * ux + b * uy) // 2, sign * (c * ux + d * uy) // 2
        sense = -1 if closed[hinge] else 1
        moment = (-pz * uy, pz * ux, px * uy - py * ux)
        screws.append([sense * ux, sense * uy, 0, *(sense * value for value in moment)])
        if closed[hinge]:
            square = frame.square(ux, uy)
            h, i = 4 * frame.q * ux * ux // square - 2, 4 * ux * uy // square
            j, k = frame.q * i, 4 * uy * uy // square - 2
            a, b, c, d = (h * a + i * c) // 2, (h * b + i * d) // 2, (j * a + k * c) // 2, (j * b + k * d) // 2
            x, y, z = px + (h * (x - px) + i * (y - py)) // 2, py + (j * (x - px) + k * (y - py)) // 2, 2 * pz - z
            up = -up
    return screws if (a, b, c, d, x, y, z, up) == (2, 0, 0, 2, 0, 0, 0, 1) else None


def reduced_rows(rows: ExactArray) -> dict[int, list[int]]:
    """Reduce whole rows by Gauss's elimination: for each pivot column its row, which is 0 in other pivot columns."""
    pivots: dict[int, list[int]] = {}
    for whole_row in rows.tolist():
        row = whole_row
        for column, pivot in pivots.items():
            row = _cleared(row, pivot, column)
        column = max(range(len(row)), key=[abs(value) for value in row].__getitem__)
        if row[column]:
            pivots = {place: _cleared(pivot, row, column) for place, pivot in pivots.items()}
            pivots[column] = row
    return pivots


def _cleared(row: list[int], pivot: list[int], column: int) -> list[int]:
    """A multiple of a row plus a multiple of a pivot's row that is 0 in the pivot's column, in lowest terms."""
    if not row[column]:
        return row
    cleared = [a * pivot[column] - b * row[column] for a, b in zip(row, pivot, strict=True)]
    divisor = math.gcd(*cleared) or 1
    return [value // divisor for value in cleared]
