"""Polynomials of the path checker: matrices that run along a piece of a path, with radii that hold every error.

This file needs NumPy and `balls.py` beside it. Proofs of the bounds: docs/explanation/certificates.md, 2.
"""

from typing import Any

import numpy as np

if __package__:
    from hcsearch.motion.certificates import balls
else:  # part of a program by itself, in one folder with it
    import balls  # type: ignore[import-not-found, no-redef]

Reals = np.ndarray[Any, np.dtype[np.float64]]
EPS, up = balls.EPS, balls.up
CHAIN = 40  # operations of bounds, at most: products of polynomials of norms take 30, in chains
TERMS = 9  # coefficients of a polynomial on -1 <= x <= 1; the last one also holds all higher orders
FIRST, ONE = np.eye(TERMS)[0], np.eye(TERMS)[0][:, None, None]  # the constant 1, of numbers and of matrices
ROUNDED = (3 * np.arange(TERMS) + 5) * EPS  # roundings of sums of 3, 6, 9, ... products of entries [2]


class Poly:
    """Polynomials of matrices, (..., TERMS, m, n), with radii of coefficients, (..., TERMS); turning : of rotations."""

    def __init__(self, mid: Reals, rad: Reals, turning: bool = False) -> None:
        self.mid, self.rad, self.turning = mid, rad, turning

    def norms(self) -> Reals:
        """Return the norms of the coefficients; the first coefficient of a rotation is a rotation."""
        size: Reals = up(np.sqrt((self.mid**2).sum((-2, -1))), CHAIN)
        if self.turning:
            size[..., 0] = up(1.0 + self.rad[..., 0], 1)
        return size

    def over(self, divisor: float) -> "Poly":
        """Return the polynomials over a number."""
        return Poly(self.mid / divisor, up(self.rad + EPS * self.norms(), CHAIN) / abs(divisor))

    def __add__(self, other: "Poly") -> "Poly":
        mid = self.mid + other.mid
        return Poly(mid, up(self.rad + other.rad + EPS * Poly(mid, self.rad).norms(), CHAIN))

    def __matmul__(self, other: "Poly") -> "Poly":
        mid, over, a, b = self.mid[..., :1, :, :] @ other.mid, 0.0, self.norms(), other.norms()
        for i in range(1, TERMS):
            mid[..., i:, :, :] += self.mid[..., i : i + 1, :, :] @ other.mid[..., : TERMS - i, :, :]
            over += a[..., i] * b[..., TERMS - i :].sum(-1)
        rad = folded(a, other.rad) + folded(self.rad, b + other.rad) + ROUNDED * folded(a, b)
        rad[..., -1] += over
        return Poly(mid, up(rad, CHAIN), self.turning and other.turning)


def folded(one: Reals, two: Reals) -> Reals:
    """Return the product of polynomials of norms; orders beyond the last one are added to the last."""
    product = one[..., :1] * two
    for i in range(1, TERMS):
        product[..., i:] += one[..., i : i + 1] * two[..., : TERMS - i]
        product[..., -1] += one[..., i] * two[..., TERMS - i :].sum(-1)
    bounds: Reals = up(product, CHAIN)
    return bounds


def sines(cubics: Reals, radii: Reals, order: int) -> tuple[Reals, Reals, Reals]:
    """Return sin and 1 - cos of cubics, (count, n, 4), and all radii; radii : (count, n), radii of one order."""
    mid = np.pad(cubics, ((0, 0), (0, 0), (0, TERMS - 4)))
    rad = 2 * EPS * (mid != 0.0)  # pi, at a stop, is no double
    rad[..., order] += radii
    step, one = Poly((mid * (1 - FIRST))[..., None, None], rad), Poly(ONE, 0 * FIRST)
    square, far, sine, less = step @ step, (np.abs(step.mid[..., 0, 0]) + rad).sum(-1), one, one
    for m, n in ((72, 90), (42, 56), (20, 30), (6, 12)):  # Taylor's series, as Horner sums it
        sine, less = (one + part.over(-k) for part, k in ((square @ sine, m), (square @ less, n)))
    sine, less = step @ sine, (square @ less).over(2.0)  # sin, and 1 - cos
    (s, low), errors = balls.sines(mid[..., :1])
    rads = sine.rad + less.rad + (errors.sum(0) + 4 * EPS) * (FIRST + sine.norms() + less.norms())
    rads[..., -1] += far**11 / 3e7 + far**12 / 4e8  # less than 11! and 12!
    sin, versed, c = sine.mid[..., 0, 0], less.mid[..., 0, 0], 1.0 - low
    return s * FIRST + c * sin - s * versed, low * FIRST + s * sin + c * versed, up(rads, CHAIN)


def shifted(cubics: Reals, m: float, h: float) -> Any:
    """Return cubics of x = m + h u as cubics of u."""
    powers = [1, 0, 0, 0], [m, h, 0, 0], [m * m, 2 * m * h, h * h, 0], [m**3, 3 * m * m * h, 3 * m * h * h, h**3]
    return cubics @ np.array(powers)
