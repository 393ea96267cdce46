"""Arithmetic of the checkers: numbers, vectors and matrices that are known up to a radius, which holds every rounding.

Doubles follow IEEE 754, rounded to nearest, with subnormal numbers; sums may be taken in any order, and products
be fused with sums. Nothing is assumed of other functions: sines are computed here. This file needs NumPy alone.
Proofs of the bounds: docs/explanation/certificates.md, 1.
"""

from typing import Any

import numpy as np

Reals = np.ndarray[Any, np.dtype[np.float64]]
EPS, TINY = 2.0**-52, 2.0**-500  # twice the relative error of an operation; more than any underflow
TERMS, REST = 17, 2.0**-66  # terms of the series of sines, and their remainder at angles up to 4


def up(value: Any, steps: int) -> Any:
    """Return an upper bound of a positive value that was computed by so many operations with positive numbers."""
    return value * (1.0 + (steps + 2) * EPS) + TINY


def norms(vectors: Any) -> Any:
    """Return upper bounds of the lengths of vectors."""
    return up(np.sqrt((vectors**2).sum(-1)), vectors.shape[-1] + 2)


def sines(angles: Reals) -> tuple[Reals, Reals]:
    """Return sin and 1 - cos of angles from -4 to 4, (2, ...), and bounds of their errors, by Taylor's series."""
    square = angles * angles
    series, error = np.ones((2, *angles.shape)), np.zeros((2, *angles.shape))
    for term in range(TERMS, 0, -1):  # 1 - x^2/2.3 (1 - x^2/4.5 (1 - ...)), and 1 - x^2/3.4 (1 - x^2/5.6 (1 - ...))
        divisors = np.reshape([2 * term * (2 * term + 1), (2 * term + 1) * (2 * term + 2)], (2, *[1] * angles.ndim))
        part, error = square * series / divisors, square * error / divisors
        series = 1.0 - part
        error = up(error + 3 * EPS * np.abs(part) + EPS * np.abs(series), 9)
    factors = np.stack([angles, 0.5 * square])
    error = np.abs(factors) * error + 3 * EPS * np.abs(factors * series)
    held = np.where(np.abs(angles) <= 4.0, up(error, 6) + REST, np.inf)
    return factors * series, held


class Ball:
    """Matrices of at most 3 rows and columns, (..., m, n), each up to a radius in the spectral norm, (...).

    size : bounds of the norms of the exact matrices. The norm of a rotation is 1, so that radii of products add up.
    """

    def __init__(self, mid: Any, rad: Any, size: Any) -> None:
        self.mid, self.rad, self.size = mid, rad, size

    @property
    def bound(self) -> Any:
        """Bounds of the norms of the computed matrices."""
        return up(self.size + self.rad, 1)

    @property
    def length(self) -> Any:
        """Bounds of the lengths of vectors."""
        return up(norms(self.mid[..., 0]) + self.rad, 1)

    @property
    def transposed(self) -> "Ball":
        """The transposed matrices."""
        return Ball(np.swapaxes(self.mid, -1, -2), self.rad, self.size)

    def __getitem__(self, key: Any) -> "Ball":
        return Ball(self.mid[key], self.rad[key], self.size[key])

    def __neg__(self) -> "Ball":
        return Ball(-self.mid, self.rad, self.size)

    def __add__(self, other: "Ball") -> "Ball":
        rounded = 2 * EPS * (self.bound + other.bound)
        return Ball(self.mid + other.mid, up(self.rad + other.rad + rounded, 5), up(self.size + other.size, 1))

    def __sub__(self, other: "Ball") -> "Ball":
        return self + -other

    def __mul__(self, numbers: Any) -> "Ball":
        size = np.abs(numbers)
        rad = up(size * (self.rad + 2 * EPS * self.bound), 5)
        return Ball(self.mid * numbers[..., None, None], rad, up(size * self.size, 1))

    def __matmul__(self, other: "Ball") -> "Ball":
        rad = self.rad * other.bound + self.size * other.rad + 5 * EPS * self.bound * other.bound
        return Ball(self.mid @ other.mid, up(rad, 8), up(self.size * other.size, 1))


def stacked(balls: list[Ball], axis: int) -> Ball:
    """Return balls stacked along a new axis, which is neither rows nor columns."""
    return Ball(*(np.stack([getattr(ball, name) for ball in balls], axis) for name in ("mid", "rad", "size")))


def chosen(which: Any, one: Ball, other: Ball) -> Ball:
    """Return one ball where a condition holds, and another one elsewhere."""
    pairs = ((one.rad, other.rad), (one.size, other.size))
    return Ball(np.where(which[..., None, None], one.mid, other.mid), *(np.where(which, *pair) for pair in pairs))


def exact(vectors: Any) -> Ball:
    """Return vectors of doubles as columns, without a radius."""
    size = norms(vectors)
    return Ball(vectors[..., None], 0.0 * size, size)


def crossed(vectors: Ball) -> Ball:
    """Return the matrices of cross products with vectors; their norms are the lengths of the vectors."""
    x, y, z = np.moveaxis(vectors.mid[..., 0], -1, 0)
    matrices = np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], -1).reshape(*x.shape, 3, 3)
    return Ball(matrices, vectors.rad, vectors.size)


def rotations(ways: Ball, angles: Reals) -> Ball:
    """Return rotations, (..., n), about n axes of length 1 by angles, 1 + sin K + (1 - cos) K^2 (Rodrigues)."""
    cross = crossed(ways)
    square, values = cross @ cross, sines(angles)
    (sine, less), (sine_error, less_error) = values
    turned = cross * sine + square * less
    rad = up(turned.rad + cross.bound * sine_error + square.bound * less_error + 8 * EPS, 8)
    return Ball(turned.mid + np.eye(3), rad, np.ones_like(rad))


def lattice(points: Any, root: int) -> Ball:
    """Return vectors of whole numbers (X, Y, Z) below 10^7 as columns (sqrt(root) X, Y, Z)."""
    vectors = np.asarray(points, float) * np.sqrt([float(root), 1.0, 1.0])
    size = norms(vectors)
    return Ball(vectors[..., None], up(2 * EPS * size, 1), up(size, 4))


def directions(ways: Ball) -> Ball:
    """Return unit vectors along vectors that are not 0."""
    length = np.sqrt((ways.mid[..., 0] ** 2).sum(-1))
    rad = up(2.0 * ways.rad / length + 6 * EPS, 6)
    return Ball(ways.mid / length[..., None, None], rad, np.ones_like(rad))
