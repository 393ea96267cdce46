"""The arithmetic of the checkers of certificates, against fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.motion.certificates import balls
from hcsearch.motion.certificates.polynomials import TERMS, Poly, sines

SCALES = st.integers(-8, 8)


def in_fractions(matrix):
    """A matrix of doubles as an array of fractions."""
    return np.vectorize(Fraction, otypes=[object])(matrix)


def length(matrix):
    """The Frobenius norm of an array of fractions, not below the spectral one, from above."""
    return float(sum(x * x for x in matrix.flat)) ** 0.5 * (1 + 1e-12)


def exact_sine(x):
    """Sine and 1 - cosine of a fraction, to 1e-40, by the series of the exponential function."""
    term, parts = Fraction(1), [Fraction(0), Fraction(0)]
    for k in range(1, 60):
        term = term * x / k
        parts[k % 2 == 0] += (-1) ** ((k - 1) // 2) * term
    return parts


@settings(max_examples=40)
@given(st.floats(-4.0, 4.0))
def test_sines_hold_the_exact_values(x):
    values, errors = balls.sines(np.array([x]))
    for value, error, exact in zip(values[:, 0], errors[:, 0], exact_sine(Fraction(x)), strict=True):
        assert abs(Fraction(float(value)) - exact) <= Fraction(float(error))
        assert error < 3e-14


def test_sines_of_angles_beyond_the_series_are_not_bounded():
    assert np.isinf(balls.sines(np.array([4.5, np.nan, -1e9]))[1]).all()


@settings(max_examples=40)
@given(st.integers(0, 10**6), SCALES, SCALES)
def test_products_and_sums_of_balls_hold_those_of_what_they_hold(seed, one, two):
    rng = np.random.default_rng(seed)
    mids = rng.normal(size=(2, 3, 3)) * 10.0 ** np.array([one, two])[:, None, None]
    away = rng.normal(size=(2, 3, 3)) * 10.0 ** (np.array([one, two])[:, None, None] - rng.integers(3, 20))
    held = [in_fractions(mid) + in_fractions(part) for mid, part in zip(mids, away, strict=True)]
    own = [
        balls.Ball(mid, length(in_fractions(part)), length(exact))
        for mid, part, exact in zip(mids, away, held, strict=True)
    ]
    share = rng.normal()
    for ball, exact in (
        (own[0] @ own[1], held[0].dot(held[1])),
        (own[0] + own[1], held[0] + held[1]),
        (own[0] - own[1], held[0] - held[1]),
        (own[0] * np.array(share), held[0] * Fraction(share)),
    ):
        rest = exact - in_fractions(ball.mid)
        assert np.linalg.norm(rest.astype(float), 2) <= ball.rad
        assert np.linalg.norm(exact.astype(float), 2) <= ball.size


@pytest.mark.parametrize("root", [1, 3])
def test_places_and_directions_hold_the_exact_ones(root):
    rng = np.random.default_rng(root)
    points = rng.integers(-9999, 9999, (200, 3))
    places, ways = balls.lattice(points, root), balls.directions(balls.lattice(points, root))
    exact = points * np.sqrt([float(root), 1.0, 1.0])
    for ball, vectors in ((places, exact), (ways, exact / np.linalg.norm(exact, axis=1, keepdims=True))):
        away = np.linalg.norm(vectors - ball.mid[..., 0], axis=1)
        assert (away <= ball.rad).all()
        assert (ball.rad <= 3e-15 * ball.size).all()
        assert (np.linalg.norm(vectors, axis=1) <= ball.size * (1 + 1e-15)).all()


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(-6, 0))
def test_polynomials_of_sines_hold_the_exact_values(seed, scale):
    rng = np.random.default_rng(seed)
    cubic = rng.uniform(-1, 1, (1, 1, 4)) * [np.pi, *[10.0**scale] * 3]
    sin, low, rad = sines(cubic, np.zeros((1, 1)), 0)
    x = rng.uniform(-1, 1)
    angle = sum(Fraction(float(c)) * Fraction(x) ** k for k, c in enumerate(cubic[0, 0]))
    for coefficients, exact in zip((sin, low), exact_sine(angle), strict=True):
        value = sum(Fraction(float(c)) * Fraction(x) ** k for k, c in enumerate(coefficients[0, 0]))
        assert abs(value - exact) <= Fraction(float(rad.sum()))


@settings(max_examples=40)
@given(st.integers(0, 10**6))
def test_products_of_polynomials_hold_the_exact_ones(seed):
    rng = np.random.default_rng(seed)
    mids = rng.normal(size=(2, TERMS, 3, 3)) * 0.5 ** np.arange(TERMS)[:, None, None]
    product = Poly(mids[0], np.zeros(TERMS)) @ Poly(mids[1], np.zeros(TERMS))
    x = Fraction(rng.uniform(-1, 1))

    def at(polynomial):
        return sum(in_fractions(part) * x**k for k, part in enumerate(polynomial))

    rest = at(mids[0]).dot(at(mids[1])) - at(product.mid)
    assert np.linalg.norm(rest.astype(float), 2) <= product.rad.sum()
