"""A second checker of paths, in whole numbers: it shares no code with that of the project.

Numbers are polynomials in fixed point with a radius of each coefficient, of |u| <= 1 along a piece. Closed states are
c(u) + G(u) y, with a G that two pieces share where they meet, so that they have the closed state there in common. NumPy
only guesses G and the scaling of equations, which may be any, and directions that separate panels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise
from math import isqrt
from typing import Any

import numpy as np

from tests.certificates.exact_arrays import (
    ONE,
    PI_HIGH,
    PI_LOW,
    STILL,
    Array,
    RefusedError,
    down,
    length,
    listed,
    need,
    real,
)

ORDERS = 8
"""Coefficients of a polynomial; the radius of the last one also holds all that is of higher order."""
MOST_BEYOND_STOPS = Fraction(1, 1000)
MAX_HALVINGS, MAX_TUBE_HALVINGS = 12, 6

Numbers = list[int]


class Poly:
    """A polynomial in u with a radius of each coefficient."""

    __slots__ = ("mid", "rad")

    def __init__(self, mid: Numbers, rad: Numbers) -> None:
        self.mid, self.rad = mid, rad

    def __add__(self, other: Poly) -> Poly:
        return Poly(
            [a + b for a, b in zip(self.mid, other.mid, strict=True)],
            [a + b for a, b in zip(self.rad, other.rad, strict=True)],
        )

    def __sub__(self, other: Poly) -> Poly:
        return Poly(
            [a - b for a, b in zip(self.mid, other.mid, strict=True)],
            [a + b for a, b in zip(self.rad, other.rad, strict=True)],
        )

    def __mul__(self, other: Poly) -> Poly:
        mid, rad = [0] * ORDERS, [0] * ORDERS
        sizes = [abs(b) + r for b, r in zip(other.mid, other.rad, strict=True)]
        for i, (a, r) in enumerate(zip(self.mid, self.rad, strict=True)):
            if not (a or r):
                continue
            size = abs(a) + r
            for j in range(ORDERS - i):
                mid[i + j] += a * other.mid[j]
                rad[i + j] += size * other.rad[j] + r * abs(other.mid[j])
            if i:
                rad[-1] += size * sum(sizes[ORDERS - i :])
        return Poly([x >> 64 for x in mid], [(x >> 64) + 2 if x or y else 0 for x, y in zip(rad, mid, strict=True)])

    def times(self, number: int, doubt: int = 1) -> Poly:
        """The product with a number in fixed point that is known to so many units."""
        size = abs(number)
        rad = [(r * size + abs(a) * doubt >> 64) + 2 if a or r else 0 for a, r in zip(self.mid, self.rad, strict=True)]
        return Poly([a * number >> 64 for a in self.mid], rad)

    def bound(self) -> int:
        """The greatest size."""
        return sum(map(abs, self.mid)) + sum(self.rad)

    def range(self) -> tuple[int, int]:
        """Bounds of all values."""
        far = sum(map(abs, self.mid[1:])) + sum(self.rad)
        return self.mid[0] - far, self.mid[0] + far

    def over(self, order: int) -> Poly:
        """The quotient by a power of u, of what is 0 to that order at u = 0."""
        return Poly([*self.mid[order:], *[0] * order], [*self.rad[order:], *[0] * order])

    def at(self, u: float) -> float:
        """The value of the middle somewhere, about."""
        return sum(a / ONE * u**k for k, a in enumerate(self.mid))

    def shrunk(self, middle: Fraction, half: Fraction) -> Poly:
        """The polynomial in v, u = middle + half v; exact in the middle but for rounding."""
        mid, rad = [0] * ORDERS, [0] * ORDERS
        m, h = int(middle * 2**20), int(half * 2**20)
        for k in range(ORDERS):
            for j in range(k + 1):
                factor = math.comb(k, j) * m ** (k - j) * h**j
                mid[j] += self.mid[k] * factor >> 20 * k
                rad[j] += (self.rad[k] * abs(factor) >> 20 * k) + 2
        return Poly(mid, rad)


def constant(value: int, doubt: int = 0) -> Poly:
    """A number that is known to so many units."""
    return Poly([value, *[0] * (ORDERS - 1)], [doubt, *[0] * (ORDERS - 1)])


ZERO, UNIT = constant(0), constant(ONE)
Spatial = tuple[Poly, Poly, Poly]


@cache
def sine_and_cosine(angle: int) -> tuple[int, int]:
    """The sine and the cosine of an angle in fixed point, to 4 units."""
    fine, term, k, sums = angle << 16, 1 << 80, 0, [0, 0]
    while term:
        sums[k % 2] += term if k % 4 < 2 else -term
        k += 1
        term = term * fine // (k << 80)
    return sums[1] >> 16, sums[0] >> 16


def turned(base: int | None, step: Poly) -> tuple[Poly, Poly]:
    """Sine and cosine of a base angle, None for pi, plus a step that is small."""
    small_sine, small_cosine, power, k = step, UNIT, step, 1
    while power.bound() > 200:
        k += 1
        power = power * step
        power = Poly(
            [x // k for x in power.mid],
            [r // k + 1 if r or x else 0 for x, r in zip(power.mid, power.rad, strict=True)],
        )
        small_sine, small_cosine = (
            (small_sine, small_cosine - power if k % 4 == 2 else small_cosine + power)
            if k % 2 == 0
            else (small_sine - power if k % 4 == 3 else small_sine + power, small_cosine)
        )
        need(k < 60, "a piece turns too far")
    rest = Poly([0] * ORDERS, [400, *[0] * (ORDERS - 1)] if step.rad[0] else [0] * (ORDERS - 1) + [400])
    small_sine, small_cosine = small_sine + rest, small_cosine + rest  # terms left out are less than the last one
    if base is None:
        return ZERO - small_sine, ZERO - small_cosine
    if base == 0:
        return small_sine, small_cosine
    s, c = sine_and_cosine(base)
    return small_sine.times(c, 4) + small_cosine.times(s, 4), small_cosine.times(c, 4) - small_sine.times(s, 4)


class Lines:
    """The hinges of an array in lengths over its size: a point, and a level direction of length 1, in fixed point."""

    def __init__(self, array: Array) -> None:
        self.array, root = array, isqrt(array.root * ONE * ONE)
        self.root = root
        size = array.size
        self.points, self.ways = [], []
        for hinge in array.hinges:
            x, y, z = hinge.point
            self.points.append((x * root // size, y * ONE // size, z * ONE // size))
            wide = isqrt(hinge.square * ONE * ONE)
            self.ways.append((hinge.way[0] * root * ONE // wide // 1 if wide else 0, hinge.way[1] * ONE * ONE // wide))

    def walked(self, steps: Any, angles: Sequence[tuple[Poly, Poly]]) -> tuple[list[Spatial], Spatial, list[Any]]:
        """Columns of the rotation and the shift of a walk along hinges, and the axis and the place of each hinge."""
        columns: list[Spatial] = [(UNIT, ZERO, ZERO), (ZERO, UNIT, ZERO), (ZERO, ZERO, UNIT)]
        shift: Spatial = (ZERO, ZERO, ZERO)
        screws = []
        for k, sense in steps:
            sine, cosine = angles[k]
            screw, columns, shift = self._step(columns, shift, k, (sine if sense > 0 else ZERO - sine, cosine))
            screws.append((k, screw[0] if sense > 0 else negative(screw[0]), screw[1]))
        return columns, shift, screws

    def _step(
        self, columns: list[Spatial], shift: Spatial, k: int, turn: tuple[Poly, Poly]
    ) -> tuple[tuple[Spatial, Spatial], list[Spatial], Spatial]:
        """The axis and the place of a hinge on a walk, and the columns of the rotation and the shift behind it."""
        (a, b), point, (sine, cosine) = self.ways[k], self.points[k], turn
        along = spatial(lambda i: columns[0][i].times(a, 8) + columns[1][i].times(b, 8))
        across = spatial(lambda i: columns[1][i].times(a, 8) - columns[0][i].times(b, 8))
        before = spatial(lambda i: moved(columns, point, i))
        new = spatial(lambda i: cosine * across[i] + sine * columns[2][i])
        turned_columns = [
            spatial(lambda i: along[i].times(a, 8) - new[i].times(b, 8)),
            spatial(lambda i: along[i].times(b, 8) + new[i].times(a, 8)),
            spatial(lambda i: cosine * columns[2][i] - sine * across[i]),
        ]
        place = spatial(lambda i: before[i] + shift[i])
        return (along, place), turned_columns, spatial(lambda i: place[i] - moved(turned_columns, point, i))


def spatial(entry: Callable[[int], Poly]) -> Spatial:
    """A vector by its entries."""
    return entry(0), entry(1), entry(2)


def negative(vector: Spatial) -> Spatial:
    """The opposite vector."""
    return spatial(lambda i: ZERO - vector[i])


def moved(columns: Sequence[Spatial], point: Sequence[int], i: int) -> Poly:
    """An entry of a rotated vector, which is known to 8 units."""
    return columns[0][i].times(point[0], 8) + columns[1][i].times(point[1], 8) + columns[2][i].times(point[2], 8)


def cross(a: Spatial, b: Spatial) -> Spatial:
    """The cross product."""
    return spatial(lambda i: a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])


class Row:
    """An equation of a loop: a twist along a fixed direction, by its loop and its six factors in fixed point.

    kind : the number of a coordinate, or `turn`, `level` or `up` of a loop whose hinges turn about parallel lines.
    scale : the entry of a screw is a rational number, over the length of its line for coordinates, times this.
    """

    def __init__(self, loop: int, kind: int | str, scale: int, factors: Sequence[int]) -> None:
        self.loop, self.kind, self.scale, self.factors = loop, kind, scale, factors

    def of(self, twist: Sequence[Poly]) -> Poly:
        """The entry of a twist."""
        total = ZERO
        for factor, part in zip(self.factors, twist, strict=True):
            if factor:
                total = total + (part if factor == ONE else part.times(factor, 8))
        return total


class Stretch:
    """The equations of closed loops that decide for some moving hinges, and their rank at flat-folded states."""

    def __init__(self, lines: Lines, closed: Sequence[bool], moving: Sequence[int]) -> None:
        self.lines, self.array, self.moving = lines, lines.array, moving
        self.rows, self.exact = [], self._lines_at(closed)
        for number, own in enumerate(self.exact):
            turning = [(u, p) for k, u, p in own if k in moving]
            if not turning:
                continue
            (x, y, _), place = turning[0]
            if any(u[0] * y != u[1] * x for u, _ in turning):
                for k in range(6):
                    scale = lines.root if k in (0, 4, 5) else ONE
                    self.rows.append(Row(number, k, scale, [ONE if i == k else 0 for i in range(6)]))
                continue
            wide = isqrt((self.array.root * x * x + y * y) * ONE * ONE // 1)
            a, b = x * lines.root * ONE // wide, y * ONE * ONE // wide
            self.rows.append(Row(number, "turn", ONE, [a, b, 0, 0, 0, 0]))
            same = all(p[2] == place[2] and (p[0] - place[0]) * y == (p[1] - place[1]) * x for _, p in turning)
            if not same:
                self.rows.append(Row(number, "level", ONE, [0, 0, 0, -b, a, 0]))
                self.rows.append(Row(number, "up", lines.root * (wide // ONE) * ONE // wide, [0, 0, 0, 0, 0, ONE]))
        mixed = len({isinstance(row.kind, int) for row in self.rows}) > 1
        need(not mixed, "loops with parallel lines beside others are not decided")

    def _lines_at(self, closed: Sequence[bool]) -> list[list[Any]]:
        """The exact lines of loops where some hinges are folded flat: hinge, direction and point of the lattice."""
        from tests.certificates.exact_arrays import half_turn

        found = []
        for loop in self.array.loops:
            pose, own = STILL, []
            for k, sense in loop:
                hinge = self.array.hinges[k]
                way = [
                    sense * Fraction(sum(a * b for a, b in zip(row, hinge.way, strict=True)), pose.divisor)
                    for row in pose.turn
                ]
                moved_rows = zip(pose.turn, pose.shift, strict=True)
                place = [
                    Fraction(sum(a * b for a, b in zip(row, hinge.point, strict=True)) + s, pose.divisor)
                    for row, s in moved_rows
                ]
                own.append((k, way, place))
                if closed[k]:
                    pose = pose.then(half_turn(hinge.point, hinge.way, self.array.root))
            turn = [Fraction(x, pose.divisor) for row in pose.turn for x in row]
            need(turn == [1, 0, 0, 0, 1, 0, 0, 0, 1] and not any(pose.shift), "a loop is open at a flat-folded state")
            found.append(own)
        return found

    def wrenches(self, closed: Sequence[bool]) -> list[list[Poly]]:
        """Combinations of the rows that no moving hinge works against at a flat-folded state, exactly, as factors."""
        lines_at = self._lines_at(closed)
        table = []
        for row in self.rows:
            entries = [Fraction(0)] * len(self.moving)
            first = next(u for k, u, _ in lines_at[row.loop] if k in self.moving)
            most = isqrt(int(self.array.root * first[0] ** 2 + first[1] ** 2))
            for k, (x, y, _), p in lines_at[row.loop]:
                if k not in self.moving:
                    continue
                px, py, pz = (Fraction(own) / self.array.size for own in p)
                sense = 1 if self.array.root * x * first[0] + y * first[1] > 0 else -1
                up = sense * (px * first[1] - py * first[0]) / most
                of_kind = {"turn": Fraction(sense), "level": sense * pz, "up": up}
                twist = [x, y, Fraction(0), -pz * y, pz * x, px * y - py * x]
                entries[self.moving.index(k)] += twist[row.kind] if isinstance(row.kind, int) else of_kind[row.kind]
            table.append(entries)
        count = len(self.rows)
        full_table = [own + [Fraction(i == j) for j in range(count)] for i, own in enumerate(table)]
        for column in range(len(self.moving)):
            pivot = next((own for own in full_table if own[column]), None)
            if pivot is None:
                continue
            full_table = [
                [a - own[column] / pivot[column] * b for a, b in zip(own, pivot, strict=True)]
                for own in full_table
                if own is not pivot
            ]
        nulls = []
        for own in full_table:
            factors = own[len(self.moving) :]
            most = max(map(abs, factors))
            nulls.append(
                [constant(down(x / most * ONE / row.scale), 8) for x, row in zip(factors, self.rows, strict=True)]
            )
        return nulls

    def twists(self, angles: Sequence[tuple[Poly, Poly]]) -> tuple[list[Poly], list[list[Poly]], Poly]:
        """The equations, their derivatives by moving hinges, and a bound of T - 1 by its coefficients."""
        values, slopes, off = [], [[ZERO] * len(self.moving) for _ in self.rows], ZERO
        for number, loop in enumerate(self.array.loops):
            rows = [(i, row) for i, row in enumerate(self.rows) if row.loop == number]
            if not rows:
                continue
            columns, shift, screws = self.lines.walked(loop, angles)
            skew = [columns[(i + 1) % 3][(i + 2) % 3] - columns[(i + 2) % 3][(i + 1) % 3] for i in range(3)]
            twist = [*(halved(part) for part in skew), *shift]
            values += [row.of(twist) for _, row in rows]
            wide, far = [0] * ORDERS, [0] * ORDERS
            for i, column in enumerate(columns):
                parts = [part - UNIT if i == j else part for j, part in enumerate(column)]
                own = [sum(abs(part.mid[k]) + part.rad[k] for part in parts) for k in range(ORDERS)]
                wide = [max(x, y) for x, y in zip(wide, own, strict=True)]
            for part in shift:
                far = [x + abs(a) + r for x, a, r in zip(far, part.mid, part.rad, strict=True)]
            # the derivative is the screw times T: of the skew part it differs by a column of T - 1 at the most, of the
            # shift by the shift; a row along a direction that is no axis adds two parts
            doubts = [Poly([0] * ORDERS, own) for own in (wide, far)]
            off = off + doubts[0] + doubts[0] + doubts[0] + doubts[1]
            for k, axis, place in screws:
                if k in self.moving:
                    column, screw = self.moving.index(k), [*axis, *cross(place, axis)]
                    for i, row in rows:
                        doubt = doubts[any(row.factors[3:])]
                        slopes[i][column] = (
                            slopes[i][column] + row.of(screw) + doubt + (ZERO if isinstance(row.kind, int) else doubt)
                        )
        return values, slopes, off


def halved(part: Poly) -> Poly:
    """Half of a polynomial."""
    return Poly(
        [x >> 1 for x in part.mid], [r + 2 >> 1 if r or x else 0 for x, r in zip(part.mid, part.rad, strict=True)]
    )


def fixed(matrix: Any) -> list[Numbers]:
    """A matrix of guesses as fixed-point numbers, which are then exact."""
    need(
        np.isfinite(matrix).all() and np.abs(matrix).max(initial=0.0) < 2**40,
        "equations of closure depend on each other",
    )
    return [[int(x * 2**64) for x in row] for row in matrix.tolist()]


def combined(factors: Sequence[int], parts: Sequence[Poly]) -> Poly:
    """A sum of polynomials times exact numbers."""
    total = ZERO
    for factor, part in zip(factors, parts, strict=True):
        if factor:
            total = total + part.times(factor, 0)
    return total


class Piece:
    """A piece of a course: base angles and steps of all hinges in u, -1 <= u <= 1, or from a singular state, 0 <= u."""

    def __init__(self, bases: list[Any], steps: list[Poly]) -> None:
        self.bases, self.steps = bases, steps

    def angles(self, doubts: Sequence[Poly] | None = None) -> list[tuple[Poly, Poly]]:
        """Sines and cosines of all hinges, each in doubt by so much."""
        own = self.steps if doubts is None else [a + b for a, b in zip(self.steps, doubts, strict=True)]
        return [turned(base, step) for base, step in zip(self.bases, own, strict=True)]

    def part(self, middle: Fraction, doubts: Sequence[Poly]) -> tuple[Piece, list[Poly]]:
        """The half of the piece about a middle, as a piece of its own, and doubts of its angles."""
        bases, steps = list(self.bases), []
        for k, step in enumerate(self.steps):
            own = step.shrunk(middle, Fraction(1, 2)) if any(step.mid) or any(step.rad) else ZERO
            if bases[k] is not None and own.mid[0]:
                bases[k] += own.mid[0]
                own.mid[0] = 0
            steps.append(own)
        return Piece(bases, steps), [constant(0, sum(doubt.rad)) for doubt in doubts]


def tube(stretch: Stretch, piece: Piece, gains: Sequence[list[Numbers]], nulls: Sequence[Any] = ()) -> list[Poly]:
    """Doubts of the angles of closed states about a piece: c + G(u) y, |y| <= w, G between two gains; else refused.

    nulls : wrenches of a singular state at u = 0, from which the piece departs; then closed states are c + u G y.
    """
    count, order, moving = len(stretch.rows), int(bool(nulls)), stretch.moving
    if not count:  # in no loop
        return [ZERO] * len(piece.bases)
    kept = list(range(count))
    for null in nulls:  # equations along wrenches take the place of as many others
        kept.remove(max(kept, key=lambda i: abs(null[i].mid[0])))

    def divided(parts: Sequence[Poly], along: int) -> list[Poly]:
        if not nulls:
            return list(parts)
        sums = []
        for null in nulls:
            total = ZERO
            for factor, part in zip(null, parts, strict=True):
                total = total + factor * part
            sums.append(total.over(along + 1))
        return [parts[i].over(along) for i in kept] + sums

    def states(w: Sequence[int]) -> list[Poly]:
        doubts = [ZERO] * len(piece.bases)
        for column, k in enumerate(moving):
            far = sum((max(abs(own[column][j]) for own in gains) * w[j] >> 64) + 1 for j in range(count))
            doubts[k] = Poly([0] * ORDERS, [far if i == order else 0 for i in range(ORDERS)])
        return doubts

    values, slopes, _ = stretch.twists(piece.angles())
    start = divided(values, order)
    middle = 0.5 if nulls else 0.0
    jacobian = np.array(
        [
            [part.at(middle) for part in own]
            for own in zip(*(divided(c, 0) for c in zip(*slopes, strict=True)), strict=True)
        ]
    )
    mean = np.mean([np.array(own, float) / ONE for own in gains], 0)
    need(abs(np.linalg.det(jacobian @ mean)) > 1e-30, "equations of closure depend on each other")
    scaling = fixed(np.linalg.inv(jacobian @ mean))
    first = [combined(own, start).bound() for own in scaling]
    w = [3 * x + max(first) // 8 + (ONE >> 48) for x in first]
    for _ in range(4):
        doubts = states(w)
        _, slopes, off = stretch.twists(piece.angles(doubts))
        if off.bound() > 2 * ONE // 3:
            break
        by_hinge = [divided(column, 0) for column in zip(*slopes, strict=True)]
        need_more = []
        for i, own in enumerate(scaling):
            parts = [combined(own, column) for column in by_hinge]
            total = first[i]
            for j in range(count):
                ends = [combined([gain[column][j] for column in range(len(moving))], parts) for gain in gains]
                if len(ends) == 2:  # (1 - u)/2 G0 + (1 + u)/2 G1
                    total_part = halved(ends[0] + ends[1])
                    lean = halved(ends[1] - ends[0])
                    shifted = Poly([0, *lean.mid[:-1]], [0, *lean.rad[:-1]])
                    shifted.rad[-1] += abs(lean.mid[-1]) + lean.rad[-1]
                    product = total_part + shifted
                else:
                    product = ends[0]
                if i == j:
                    product = product - UNIT
                total += (product.bound() * w[j] >> 64) + 1
            need_more.append(total)
        if all(a < b for a, b in zip(need_more, w, strict=True)):
            return doubts
        w = [max(2 * a, b) for a, b in zip(need_more, w, strict=True)]
    need(False, "closed states are not proved to lie beside a path, and to be joined")
    raise AssertionError


def gain_at(stretch: Stretch, piece: Piece, u: float, near: list[Numbers] | None = None) -> list[Numbers]:
    """Directions across which equations change at a place of a piece, in the order and senses of those near by."""
    _, slopes, _ = stretch.twists(piece.angles())
    if not slopes:
        return []
    own = np.linalg.svd(np.array([[part.at(u) for part in row] for row in slopes]), full_matrices=False)[2]
    if near is not None:
        likeness, order = own @ (np.array(near, float) / ONE), [0] * len(own)
        rest = np.abs(likeness)
        for _ in order:
            row, column = np.unravel_index(rest.argmax(), rest.shape)
            order[column], rest[row], rest[:, column] = int(row), -1.0, -1.0
        own = own[order] * np.where(likeness[order, range(len(own))] < 0, -1.0, 1.0)[:, None]
    return fixed(own.T)


def led_by_cubics(lines: Lines, data: Any, closed: list[bool]) -> Iterator[tuple[Piece, list[Poly]]]:
    """Prove a stretch along cubics; yield its pieces and the doubts of closed states; change `closed` to its end."""
    n = len(closed)
    times = [real(x) for x in listed(data["times"])]
    angles, rates = ([[real(x) for x in listed(row)] for row in listed(data[key])] for key in ("angles", "rates"))
    need(
        len(times) == len(angles) == len(rates) > 2 and all(len(row) == n for row in (*angles, *rates)),
        "a stretch has no states",
    )
    need(all(a < b for a, b in pairwise(times)), "times do not rise")
    ended = [row > 1 for row in angles[-1]]
    for row, stops in ((angles[0], closed), (angles[-1], ended)):
        need(
            all(x == (Fraction(math.pi) if at else 0) for x, at in zip(row, stops, strict=True)),
            "a stretch ends at no stop",
        )
    moving = [k for k in range(n) if any(row[k] != angles[0][k] for row in angles) or any(row[k] for row in rates)]
    stretch = Stretch(lines, closed, moving)
    true_pi = Fraction(PI_LOW, ONE)
    angles = [[true_pi if x == Fraction(math.pi) else x for x in row] for row in angles]
    ends = [stretch.wrenches(closed), Stretch(lines, ended, moving).wrenches(ended)]
    last = len(times) - 2
    gain: list[Numbers] | None = None
    for number in range(last + 1):
        a, b, step = angles[number], angles[number + 1], times[number + 1] - times[number]
        cubics = []
        for k in range(n):
            rise, c, d = b[k] - a[k], step * rates[number][k], step * rates[number + 1][k]
            cubics.append((a[k], c, 3 * rise - 2 * c - d, c + d - 2 * rise))
        if number in (0, last) and ends[number > 0]:
            if number:
                cubics = [(p + q + r + s, -q - 2 * r - 3 * s, r + 3 * s, -s) for p, q, r, s in cubics]
            piece = departing(cubics, moving, closed if not number else ended)
            if gain is None:
                gain = gain_at(stretch, piece, 1.0)
            yield piece.part(Fraction(1, 2), tube(stretch, piece, [gain], ends[number > 0]))
            continue
        piece = between(cubics, moving, closed)
        gain = yield from tubes(stretch, piece, gain_at(stretch, piece, -1.0) if gain is None else gain)
    closed[:] = ended


def tubes(
    stretch: Stretch, piece: Piece, before: list[Numbers], depth: int = 0
) -> Generator[tuple[Piece, list[Poly]], None, list[Numbers]]:
    """Yield a piece and the doubts of its closed states, or its halves and theirs; return the directions at its end.

    Directions turn fast where a path passes a singular state nearby: those at an end continue those of the last half.
    """
    after = gain_at(stretch, piece, 1.0, before)
    try:
        doubts = tube(stretch, piece, [before, after])
    except RefusedError:
        if depth == MAX_TUBE_HALVINGS:
            raise
    else:
        yield piece, doubts
        return after
    still = [ZERO] * len(piece.bases)
    for side in (Fraction(-1, 2), Fraction(1, 2)):
        before = yield from tubes(stretch, piece.part(side, still)[0], before, depth + 1)
    return before


def departing(cubics: Sequence[Any], moving: Sequence[int], state: Sequence[bool]) -> Piece:
    """A piece from a flat-folded state, at u = 0."""
    bases = [None if at else 0 for at in state]
    steps = []
    for k, (_, q, r, s) in enumerate(cubics):
        own = [0, *(down(x) for x in (q, r, s)), *[0] * (ORDERS - 4)]
        steps.append(Poly(own, [0, 2, 2, 2, *[0] * (ORDERS - 4)]) if k in moving else ZERO)
    return Piece(bases, steps)


def between(cubics: Sequence[Any], moving: Sequence[int], state: Sequence[bool]) -> Piece:
    """A piece between two states, at u = -1 and u = 1."""
    bases: list[Any] = []
    steps = []
    for k, (p, q, r, s) in enumerate(cubics):
        if k not in moving:
            bases.append(None if state[k] else 0)
            steps.append(ZERO)
            continue
        own = [p + q / 2 + r / 4 + s / 8, q / 2 + r / 2 + 3 * s / 8, r / 4 + 3 * s / 8, s / 8]
        whole_parts = [down(x) for x in own]
        bases.append(whole_parts[0])
        steps.append(Poly([0, *whole_parts[1:], *[0] * (ORDERS - 4)], [8, 8, 8, 8, *[0] * (ORDERS - 4)]))
    return Piece(bases, steps)


def led_by_equal_turns(lines: Lines, data: Any, closed: list[bool]) -> Iterator[tuple[Piece, list[Poly]]]:
    """Prove a stretch of equal turns; yield its pieces; change `closed` to its end.

    Every loop is closed for all angles if its pose is 1 as a polynomial in the half-angle's tangent t: it is of degree
    2 in t for each hinge over (1 + t^2) for each, so that it is 1 if it is 1 at more values of t than 2 for each hinge.
    """
    n, array = len(closed), lines.array
    hinges = listed(data["hinges"])
    need(
        all(type(k) is int and 0 <= k < n for k in hinges) and len(set(hinges)) == len(hinges) > 0,
        "equal turns of no hinge",
    )
    from tests.certificates.exact_arrays import half_turn

    squares = {array.hinges[k].square for k in hinges}
    for loop in array.loops:
        own = sum(k in hinges for k, _ in loop)
        common = isqrt(min(squares))
        for value in range(1, 2 * own + 2):
            pose = STILL
            for k, sense in loop:
                hinge = array.hinges[k]
                if closed[k]:
                    pose = pose.then(half_turn(hinge.point, hinge.way, array.root))
                if k in hinges:
                    # one tangent for all hinges needs directions of rational ratio
                    ratio = isqrt(hinge.square * min(squares))
                    need(ratio * ratio == hinge.square * min(squares), "equal turns of hinges of other directions")
                    half = Fraction(value, common) * Fraction(min(squares), ratio)
                    pose = pose.then(array.turn(k, sense * (-1 if closed[k] else 1), half))
            still = all(
                x == (pose.divisor if i == j else 0) for i, row in enumerate(pose.turn) for j, x in enumerate(row)
            )
            need(still and not any(pose.shift), "hinges that turn by one angle open a loop")
    count = 16
    for part in range(count):
        bases: list[Any] = []
        steps = []
        for k in range(n):
            if k not in hinges:
                bases.append(None if closed[k] else 0)
                steps.append(ZERO)
                continue
            share = Fraction(2 * part + 1, 2 * count)
            middle = down((1 - share if closed[k] else share) * Fraction(PI_LOW, ONE))
            lean = down(Fraction(PI_LOW, ONE) / (2 * count)) * (-1 if closed[k] else 1)
            bases.append(middle)
            steps.append(Poly([0, lean, *[0] * (ORDERS - 2)], [8, 8, *[0] * (ORDERS - 2)]))
        yield Piece(bases, steps), [ZERO] * n
    for k in hinges:
        closed[k] = not closed[k]


class Prisms:
    """Facets less a margin, as prisms in lengths over the size of the array, and pairs that may overlap."""

    def __init__(self, lines: Lines, margin: Fraction) -> None:
        array = lines.array
        self.lines, self.array, self.margin = lines, array, margin
        height = array.thickness
        need(0 < 2 * margin < height, "the margin leaves nothing of a panel")
        self.ways = array.ways(0)
        self.corners: list[list[tuple[int, int, int]]] = []
        metric = math.sqrt(array.root)
        for ring in array.facets:
            points = np.array(ring, float) * [metric, 1.0]
            along = np.roll(points, -1, 0) - points
            normals = np.stack([along[:, 1], -along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
            own = []
            for k, point in enumerate(points):  # a little less is cut off than the margin: prisms are larger
                a, b = normals[k - 1], normals[k]
                inner = point - float(margin) * (1 - 1e-9) * (a + b) / (1.0 + a @ b) if 1.0 + a @ b > 1e-9 else point
                own.append(inner)
            flat = [tuple(int(x / array.size * 2**64) for x in point) for point in own]
            levels = [
                down(margin * (1 - Fraction(1, 10**9)) / array.size),
                down((height - margin * (1 - Fraction(1, 10**9))) / array.size),
            ]
            self.corners.append([(x, y, z) for z in levels for x, y in flat])
        self.beside = {}
        for k, hinge in enumerate(array.hinges):
            px, py, _ = hinge.point
            x, y, _ = hinge.way
            top = 1 if hinge.point[2] else -1
            for one, two in combinations(range(len(array.facets)), 2):
                for f, g in ((one, two), (two, one)):
                    if (array.panel_of[f], array.panel_of[g]) == (hinge.first, hinge.second):
                        side = [[top * (x * (b - py) - y * (a - px)) for a, b in array.facets[own]] for own in (f, g)]
                        if max(side[0]) <= 0 <= min(side[1]):
                            self.beside[one, two] = k
        self.pairs = [
            pair
            for pair in combinations(range(len(array.facets)), 2)
            if array.panel_of[pair[0]] != array.panel_of[pair[1]]
        ]

    def check(self, piece: Piece, doubts: Sequence[Poly], pairs: Sequence[tuple[int, int]], depth: int = 0) -> None:
        """Refuse a piece in which hinges pass their stops or prisms may overlap; halve it where it is not decided."""
        stops = down(MOST_BEYOND_STOPS)
        give = self.margin / self.array.size / 8
        within, left = True, []
        beyond = []
        for base, step, doubt in zip(piece.bases, piece.steps, doubts, strict=True):
            low, high = (step + doubt).range()
            base_low, base_high = (PI_LOW, PI_HIGH) if base is None else (base, base)
            beyond.append(max(-(base_low + low), base_high + high - PI_LOW))
            within &= beyond[-1] <= stops
        angles = piece.angles(doubts)
        poses = {panel: self.lines.walked(way, angles)[:2] for panel, way in self.ways.items()}
        for pair in pairs:
            k = self.beside.get(pair)
            if k is not None and beyond[k] <= down(give):
                continue
            if not self.apart(poses, pair):
                left.append(pair)
        if within and not left:
            return
        need(depth < MAX_HALVINGS, "panels are not proved to keep apart, or hinges within their stops")
        for middle in (Fraction(-1, 2), Fraction(1, 2)):
            self.check(*piece.part(middle, doubts), left, depth + 1)

    def apart(self, poses: dict[int, Any], pair: tuple[int, int]) -> bool:
        """Whether a direction fixed to one of two prisms separates them in a whole piece."""
        panels = [self.array.panel_of[facet] for facet in pair]
        values = []
        for panel in panels:
            columns, shift = poses[panel]
            values.append(
                (
                    np.array([[part.mid[0] / ONE for part in own] for own in columns]).T,
                    np.array([part.mid[0] / ONE for part in shift]),
                )
            )
        mine, yours = (np.array(self.corners[facet], float) / ONE for facet in pair)
        placed = [corners @ turn.T + shift for corners, (turn, shift) in zip((mine, yours), values, strict=True)]
        tried = []
        for own, (turn, _) in zip((mine, yours), values, strict=True):
            half = len(own) // 2
            along = np.roll(own[:half], -1, 0) - own[:half]
            normals = np.cross(along, [0.0, 0.0, 1.0])
            tried += [turn @ [0.0, 0.0, 1.0], *(normals @ turn.T)]
        edges = []
        for own, (turn, _) in zip((mine, yours), values, strict=True):
            rim = own[: len(own) // 2]
            edges.append(np.vstack([np.roll(rim, -1, 0) - rim, [0.0, 0.0, 1.0]]) @ turn.T)
        tried += [np.cross(a, b) for a in edges[0] for b in edges[1]]
        best = []
        for way in tried:
            size = np.linalg.norm(way)
            if size < 1e-9:
                continue
            heights = [own @ (way / size) for own in placed]
            best.append((heights[1].min() - heights[0].max(), way / size))
            best.append((heights[0].min() - heights[1].max(), -way / size))
        best.sort(key=lambda own: -own[0])
        for gap, way in best[:2]:
            if gap <= 0:
                return False
            for a, b, sign in ((0, 1, 1), (1, 0, -1)):
                if self.separated(poses, pair[a], pair[b], sign * values[a][0].T @ way):
                    return True
        return False

    def separated(self, poses: dict[int, Any], one: int, two: int, way: Any) -> bool:
        """Whether the second prism lies beyond the first one along a direction that is fixed to the first."""
        normal = [int(x * 2**64) for x in way]
        most = max(sum(a * b >> 64 for a, b in zip(normal, corner, strict=True)) + 3 for corner in self.corners[one])
        columns, shift = poses[self.array.panel_of[one]]
        turn, place = poses[self.array.panel_of[two]]
        there = spatial(lambda i: moved_exactly(columns, normal, i))

        def along(vector: Spatial) -> Poly:
            return there[0] * vector[0] + there[1] * vector[1] + there[2] * vector[2]

        offset = along(spatial(lambda i: place[i] - shift[i]))
        parts = [along(turn[k]) for k in range(3)]
        for corner in self.corners[two]:
            height = offset
            for factor, part in zip(corner, parts, strict=True):
                height = height + part.times(factor, 8)
            if height.range()[0] <= most:
                return False
        return True


def moved_exactly(columns: Sequence[Spatial], vector: Sequence[int], i: int) -> Poly:
    """An entry of a rotated vector of exact entries."""
    return columns[0][i].times(vector[0], 0) + columns[1][i].times(vector[1], 0) + columns[2][i].times(vector[2], 0)


def check_path(claim: Any, array: Array, share: int = 1) -> int:
    """Check a claim of a path; return the number of its pieces. share : every such piece is checked for gaps."""
    lines, closed = Lines(array), [hinge.closes for hinge in array.hinges]
    need(any(closed), "nothing folds: packed is flat")
    prisms = Prisms(lines, length(claim["margin"]) / array.unit)
    kinds, count = {"equal": led_by_equal_turns, "cubics": led_by_cubics}, 0
    need(array.is_closed(packed=True), "the packed state is not closed")
    for stretch in listed(claim["stretches"]):
        for piece, doubts in kinds[stretch["kind"]](lines, stretch, closed):
            if count % share == 0:
                prisms.check(piece, doubts, prisms.pairs)
            count += 1
    need(count and not any(closed), "the path does not end flat")
    return count
