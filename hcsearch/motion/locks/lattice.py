"""Exact screws of hinges, in whole numbers, at the ends of the motion of linkages on a tiling.

Flat and folded, every hinge lies along an edge of the tiling at a whole multiple of the thickness
(docs/explanation/theory.md, 25). On squares and rectangles points are rational. On triangles and hexagons one
coordinate is a multiple of sqrt(3): with x = sqrt(q) X, y = Y, z = Z all points are rational, and so are screws, their
brackets and heights at contacts, but for one positive factor each. So signs are computed with whole numbers, without
arithmetic in Q(sqrt 3). Side, width and thickness of panels are the decimal numbers of 12 digits nearest to those
given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage, Walk

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

    q : 1 on squares and rectangles, 3 on triangles and hexagons. steps : lengths of the lattice's steps in X, Y and Z,
    the last one a thickness. axes : e_x and e_y in the pattern's drawing, as columns. length : of whole directions.
    """

    q: int
    length: int
    steps: tuple[int, int, int]
    unit: float
    origin: Reals
    axes: Reals

    def points(self, points: Reals) -> ExactArray | None:
        """Whole coordinates X, Y of points (k, 2) of the plane, in metres; None if some are off the lattice."""
        steps = self.unit * np.array([math.sqrt(self.q) * self.steps[0], self.steps[1]])
        return self._on_lattice((points - self.origin) @ self.axes / steps, np.array(self.steps[:2], object))

    def directions(self, directions: Reals) -> ExactArray | None:
        """Whole directions along unit vectors of the plane, shape (k, 2); None if some are no lattice directions."""
        scaled = self.length * directions @ self.axes / np.array([math.sqrt(self.q), 1.0])
        return self._on_lattice(scaled, np.array([1, 1], object))

    def _on_lattice(self, counts: Reals, steps: ExactArray) -> ExactArray | None:
        """Whole coordinates from counts of steps in X and Y, whose sum is even on triangles and hexagons; else None.

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
    """The lattice of a pattern's first facet, if that is a rectangle or a regular triangle or hexagon; else None."""
    facet = np.array(linkage.pattern.facets[0])
    sides = np.roll(facet, -1, axis=0) - facet
    lengths = np.hypot(*sides.T)
    turns = np.einsum("ij,ij->i", sides, np.roll(sides, -1, axis=0)) / lengths / np.roll(lengths, -1)
    corners = {3: -0.5, 4: 0.0, 6: 0.5}  # cosines of the angles between sides
    even = np.abs(lengths - lengths[0]).max() < LATTICE_TOLERANCE * lengths[0]
    if len(facet) not in corners or not (even or len(facet) == 4):
        return None
    if np.abs(turns - corners[len(facet)]).max() > LATTICE_TOLERANCE:
        return None
    across = sides[0] / lengths[0]
    axes = np.array([[across[1], across[0]], [-across[0], across[1]]])  # Y along the first side
    side_steps = (lengths[1], lengths[0]) if len(facet) == 4 else (0.5 * lengths[0], 0.5 * lengths[0])
    exact = [_decimal(length) for length in (*side_steps, linkage.pattern.thickness)]
    denominator = math.lcm(*(length.denominator for length in exact))
    steps = (int(exact[0] * denominator), int(exact[1] * denominator), int(exact[2] * denominator))
    q, length = (1, 1) if len(facet) == 4 else (3, 2)
    return LatticeFrame(q, length, steps, 1.0 / denominator, facet[0], axes)


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

    columns : screws (U, M) of the hinges in the sense in which they leave their stops, for each loop, shape
        (n_hinges, n_rows); where a hinge is in no loop, zeros. order : hinges of each loop, as it is walked.
    """

    frame: LatticeFrame
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
        steps = [math.gcd(*u) for u in (abs(self._directions) * np.array([frame.steps[1], frame.steps[0]], object))]
        height = frame.unit * math.sqrt(frame.q) / frame.length / self.size
        return _rounded(rows / (height * np.array(steps, float)), np.array(steps, object))

    def force(self, forces: Reals) -> ExactArray:
        """Forces at contacts as fractions, on the scale of `wrench`."""
        scaled = forces * self.frame.unit * math.sqrt(self.frame.q) / self.size
        return np.array([Fraction(value) for value in scaled.tolist()], object)

    @property
    def _directions(self) -> ExactArray:
        """The direction of each hinge in the first loop that holds it, shape (n_hinges, 2); 1 where none does."""
        directions: ExactArray = np.zeros((len(self.columns), 2), object)
        for row in range(0, self.columns.shape[1], 6):
            unknown = ~directions.any(axis=1).astype(bool)
            directions[unknown] = self.columns[unknown, row : row + 2]
        directions[~directions.any(axis=1).astype(bool)] = 1  # in no loop: any row is 0 there
        return directions

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
    if frame is None or not (closed | (angles == 0.0)).all():
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
    return WholeEnd(frame, columns, order, linkage.pattern.size)


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
    q, double = frame.q, 4 // frame.length**2
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
            h, i, j, k = q * double * ux * ux - 2, double * ux * uy, q * double * ux * uy, double * uy * uy - 2
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
    """A multiple of a row plus one of a pivot's row that is 0 in the pivot's column, in lowest terms."""
    if not row[column]:
        return row
    cleared = [a * pivot[column] - b * row[column] for a, b in zip(row, pivot, strict=True)]
    divisor = math.gcd(*cleared) or 1
    return [value // divisor for value in cleared]
