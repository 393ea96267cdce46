"""Arrays of certificates in whole numbers, exact poses, and enclosures of angles: for a second checker.

Written from docs/explanation/certificates.md, with no code of the checkers of the project. Points are (X, Y, Z) of the
lattice and stand for (sqrt(root) X, Y, Z) units; in these coordinates a rotation about a level line is rational if the
tangent of half its angle is a rational multiple of |line| / sqrt(root). Reals are whole multiples of 2**-64, rounded
outward.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import isqrt
from typing import Any

ONE = 1 << 64
"""The number 1 in fixed point."""
FINE_BITS = 100
FINE = 1 << FINE_BITS
"""The length 1, the size of the array, in fixed point."""
MAX_NUMBER_LENGTH, MAX_COORDINATE, MAX_HINGES = 40, 10**6, 200

Vector = tuple[int, int, int]
Matrix = tuple[Vector, Vector, Vector]


class RefusedError(Exception):
    """A claim is not proved, or not of the documented form."""


def need(condition: object, reason: str) -> None:
    """Refuse the claim unless a condition holds."""
    if not condition:
        raise RefusedError(reason)


def whole(value: object) -> int:
    """A whole number of a claim, neither a truth nor a fraction."""
    need(type(value) is int and abs(value) < MAX_COORDINATE, "a number is not whole")
    assert isinstance(value, int)
    return value


def listed(value: object) -> list[Any]:
    """A list of a claim."""
    need(isinstance(value, list), "something is no list")
    assert isinstance(value, list)
    return value


def real(value: object) -> Fraction:
    """The exact value of a finite number of a claim."""
    need(type(value) in (int, float) and abs(value) < MAX_COORDINATE, "a number is not finite")  # type: ignore[arg-type]
    return Fraction(value)  # type: ignore[arg-type]


def length(text: object) -> Fraction:
    """A length that is written as a decimal or as a quotient, in at most 40 characters, not below 0."""
    need(isinstance(text, str) and len(text) <= MAX_NUMBER_LENGTH, "a length is no short text")
    assert isinstance(text, str)
    need(re.fullmatch(r"[0-9]+(/[0-9]+|(\.[0-9]*)?(e[+-]?[0-9]{1,2})?)", text), "a length is no decimal")
    need("/" not in text or int(text.partition("/")[2]), "a length is divided by 0")
    return Fraction(text)


def down(value: Fraction, scale: int = ONE) -> int:
    """A number in fixed point, not above its value."""
    return value.numerator * scale // value.denominator


def up(value: Fraction, scale: int = ONE) -> int:
    """A number in fixed point, not below its value."""
    return -(-value.numerator * scale // value.denominator)


def root_up(value: int) -> int:
    """The square root of a whole number, rounded up."""
    return isqrt(value) + 1


def _arc_sum(x: Fraction, scale: int) -> tuple[int, int]:
    """Bounds of atan(x), 0 <= x <= 1, by Euler's series, whose terms are positive and shrink by half at least."""
    square = x * x / (1 + x * x)
    low, high = down(square, scale), up(square, scale)
    small, great = down(x / (1 + x * x), scale), up(x / (1 + x * x), scale)
    least, most, n = small, great, 0
    while great > 1:
        n += 1
        small = small * low * 2 * n // ((2 * n + 1) * scale)
        great = -(-great * high * 2 * n // ((2 * n + 1) * scale))
        least, most = least + small, most + great
    return least, most + 2  # the terms left out sum to no more than the last one


def _pi() -> tuple[int, int]:
    """Bounds of pi in fixed point, by Machin's formula."""
    fine = ONE << 16
    (a, b), (c, d) = _arc_sum(Fraction(1, 5), fine), _arc_sum(Fraction(1, 239), fine)
    return (16 * a - 4 * d) >> 16, -((4 * c - 16 * b) >> 16)


PI_LOW, PI_HIGH = _pi()


def arc(square: Fraction) -> tuple[int, int]:
    """Bounds of atan of the square root of a number."""
    if square > 1:
        low, high = arc(1 / square)
        return PI_LOW // 2 - high, (PI_HIGH + 1) // 2 - low
    fine = ONE << 16
    under = isqrt(down(square, fine * fine))
    (low, _), (_, high) = (_arc_sum(Fraction(x, fine), fine) for x in (under, min(under + 1, fine)))
    return low >> 16, -(-high >> 16)


@dataclass(frozen=True)
class Hinge:
    """A hinge of an array in the flat state: it carries the second panel, as seen from the first one.

    point, way : of its line; a positive angle turns about `way` by the right hand, and closes the hinge's face.
    square : of the length of `way`, in the metric of the lattice.
    """

    first: int
    second: int
    point: Vector
    way: Vector
    square: int
    closes: bool


class Pose:
    """A rigid motion, exactly: X goes to (turn X + shift) / divisor, in whole numbers."""

    def __init__(self, turn: Matrix, shift: Vector, divisor: int) -> None:
        self.turn, self.shift, self.divisor = turn, shift, divisor

    def then(self, other: Pose) -> Pose:
        """The motion that moves by another one first, and by this one after it."""
        turn = tuple(tuple(sum(row[k] * other.turn[k][j] for k in range(3)) for j in range(3)) for row in self.turn)
        moved = (dot(row, other.shift) for row in self.turn)
        shift = tuple(a + b * other.divisor for a, b in zip(moved, self.shift, strict=True))
        return Pose(turn, shift, self.divisor * other.divisor)  # type: ignore[arg-type]

    def vector(self, v: Vector, scale: int) -> Vector:
        """A moved vector in fixed point."""
        x, y, z = (dot(row, v) * scale // self.divisor for row in self.turn)
        return x, y, z

    def point(self, p: Vector, scale: int) -> Vector:
        """A moved point in fixed point."""
        moved = zip(self.turn, self.shift, strict=True)
        x, y, z = ((dot(row, p) + s) * scale // self.divisor for row, s in moved)
        return x, y, z


STILL = Pose(((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, 0, 0), 1)


def dot(a: Vector, b: Vector) -> int:
    """The sum of the products of entries."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class Array:
    """The panels and hinges of a claim, and its loops of hinges."""

    def __init__(self, data: Any) -> None:
        need(isinstance(data, dict), "there is no array")
        self.root, self.thickness, self.unit = whole(data["root"]), whole(data["thickness"]), length(data["unit"])
        need(min(self.root, self.thickness) > 0 < self.unit, "the array has no size")
        self.facets = [self._facet(facet) for facet in listed(data["facets"])]
        owners = sorted((whole(k), panel) for panel, own in enumerate(listed(data["panels"])) for k in listed(own))
        need([k for k, _ in owners] == list(range(len(self.facets))), "a facet is not in one panel")
        self.panel_of = [panel for _, panel in owners]
        self.hinges = [self._hinge(hinge) for hinge in listed(data["hinges"])]
        need(len(self.hinges) <= MAX_HINGES, "there are too many hinges")
        self.size = max(self.thickness, *(abs(x) for facet in self.facets for corner in facet for x in corner))
        self.panels = range(len(data["panels"]))
        need(all(data["panels"]), "a panel has no facets")
        ways = self.ways(0)
        need(set(ways) == set(self.panels), "the panels are not joined to one piece")
        inner = {k for way in ways.values() for k, _ in way}
        self.loops = [self._loop(ways, k) for k in range(len(self.hinges)) if k not in inner]

    def _facet(self, corners: Any) -> list[tuple[int, int]]:
        """The corners of a facet, which is convex and runs counterclockwise around once."""
        ring = []
        for corner in listed(corners):
            need(len(listed(corner)) == 2, "a corner has no two coordinates")
            ring.append((whole(corner[0]), whole(corner[1])))
        need(len(ring) > 2, "a facet has no three corners")
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
            sides = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in ring]
            need((ax, ay) != (bx, by) and min(sides) >= 0 < max(sides), "a facet is not convex")
        need(len(set(ring)) == len(ring), "a facet runs around more than once")
        return ring

    def _hinge(self, data: Any) -> Hinge:
        """A hinge, by the one side that its two facets share."""
        need(isinstance(data, dict), "a hinge is none")
        one, two = (whole(k) for k in listed(data["facets"]))
        need(min(one, two) >= 0 and max(one, two) < len(self.facets), "a hinge joins no facets")
        rings = [list(zip(ring, ring[1:] + ring[:1], strict=True)) for ring in (self.facets[one], self.facets[two])]
        shared = [(p, q) for p, q in rings[0] if (q, p) in rings[1]]
        need(len(shared) == 1, "two facets of a hinge do not share one side")
        need(self.panel_of[one] != self.panel_of[two], "a hinge joins a panel to itself")
        need(data["face"] in ("top", "bottom") and type(data["closes"]) is bool, "a hinge has no face")
        ((px, py), (qx, qy)), sign = shared[0], 1 if data["face"] == "top" else -1
        x, y = sign * (px - qx), sign * (py - qy)
        square = self.root * x * x + y * y
        height = self.thickness if data["face"] == "top" else 0
        return Hinge(self.panel_of[one], self.panel_of[two], (px, py, height), (x, y, 0), square, data["closes"])

    def ways(self, start: int, without: frozenset[int] = frozenset()) -> dict[int, list[tuple[int, int]]]:
        """Ways from a panel to all that can be reached, the shortest first, as hinges and senses."""
        ways: dict[int, list[tuple[int, int]]] = {start: []}
        waiting = [start]
        for here in waiting:
            for k, hinge in enumerate(self.hinges):
                for a, b, sense in ((hinge.first, hinge.second, 1), (hinge.second, hinge.first, -1)):
                    if a == here and b not in ways and k not in without:
                        ways[b] = [*ways[here], (k, sense)]
                        waiting.append(b)
        return ways

    def _loop(self, ways: dict[int, list[tuple[int, int]]], k: int) -> list[tuple[int, int]]:
        """The loop that a hinge closes: from a panel along it and back."""
        out, back = ways[self.hinges[k].first], ways[self.hinges[k].second]
        while out and back and out[0] == back[0]:
            out, back = out[1:], back[1:]
        return [*out, (k, 1), *((h, -sense) for h, sense in reversed(back))]

    def is_closed(self, packed: bool) -> bool:
        """Whether the loops are exactly closed where the hinges that close are folded flat, or where none is."""
        for loop in self.loops:
            pose = STILL
            for k, _ in loop:
                if packed and self.hinges[k].closes:
                    pose = pose.then(half_turn(self.hinges[k].point, self.hinges[k].way, self.root))
            still = all(
                x == (pose.divisor if i == j else 0) for i, row in enumerate(pose.turn) for j, x in enumerate(row)
            )
            if not still or any(pose.shift):
                return False
        return True

    def turn(self, k: int, sense: int, half: Fraction) -> Pose:
        """The motion beyond hinge k by the angle 2 atan(half |way| / sqrt(root)), forward or backward."""
        return _turn(self.hinges[k].point, self.hinges[k].way, self.root, sense * half)

    def angle(self, k: int, half: Fraction) -> tuple[int, int]:
        """Bounds of the angle of `turn`, half >= 0."""
        return _angle(half, self.hinges[k].square, self.root)


@cache
def _angle(half: Fraction, square: int, root: int) -> tuple[int, int]:
    low, high = arc(half * half * square / root)
    return 2 * low, 2 * high


@cache
def half_turn(point: Vector, way: Vector, root: int) -> Pose:
    """The rotation about a level line by pi."""
    x, y, _ = way
    square = root * x * x + y * y
    turn = (
        (square - 2 * y * y, 2 * x * y, 0),
        (2 * root * x * y, square - 2 * root * x * x, 0),
        (0, 0, -square),
    )
    px, py, pz = (square * p - dot(row, point) for p, row in zip(point, turn, strict=True))
    return Pose(turn, (px, py, pz), square)


@cache
def _turn(point: Vector, way: Vector, root: int, half: Fraction) -> Pose:
    """A rotation about a level line, by Rodrigues's formula in the metric of the lattice."""
    a, q = half.numerator, half.denominator
    x, y, _ = way
    s, c = 2 * a * q, 2 * a * a
    divisor = root * q * q + a * a * (root * x * x + y * y)
    turn = (
        (divisor - c * y * y, c * x * y, s * y),
        (c * root * x * y, divisor - c * root * x * x, -s * root * x),
        (-s * root * y, s * root * x, divisor - c * (y * y + root * x * x)),
    )
    px, py, pz = (divisor * p - dot(row, point) for p, row in zip(point, turn, strict=True))
    return Pose(turn, (px, py, pz), divisor)
