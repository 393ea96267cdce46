"""The closure of a loop as a power series: its terms against contour integrals of matrix exponentials."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from hcsearch.kernels.planning.series import SERIES_ORDER_COUNT, write_series


def hat(twist):
    x, y, z = twist[:3]
    return np.block([[np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), twist[3:, None]], [np.zeros((1, 4))]])


def twist(matrix):
    r = matrix[:3, :3]
    return np.r_[0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]), matrix[:3, 3]]


def lines(rng, m):
    """Screws of random lines near each other."""
    turns = rng.normal(size=(3, m))
    turns /= np.linalg.norm(turns, axis=0)
    return np.concatenate([turns, np.cross(rng.normal(size=(m, 3)), turns.T).T])


@settings(max_examples=12)
@given(st.integers(1, 7), st.integers(1, 3), st.integers(0, 2**32))
def test_terms_are_those_of_the_product_of_exponentials(m, k, seed):
    rng = np.random.default_rng(seed)
    screws, order = lines(rng, m + 1), rng.permutation(m + 1)[:m]
    course, columns = rng.normal(size=(m + 1, 4)), rng.normal(size=(m + 1, k))
    terms, slopes = np.zeros((SERIES_ORDER_COUNT, 6)), np.zeros((SERIES_ORDER_COUNT, 6, k))
    write_series(screws, order, course, columns, terms, slopes)

    def closure(s, beside=0.0):
        angles = course[:, 1] * s + course[:, 2] * s**2 + course[:, 3] * s**3 + beside
        product = np.eye(4, dtype=complex)
        for h in order:
            product = product @ expm(angles[h] * hat(screws[:, h]))
        return twist(product)

    count, r, h = 64, 0.4, 1e-5
    around = r * np.exp(2j * np.pi * np.arange(count) / count)
    values = np.array([closure(s) for s in around])
    orders = np.fft.fft(values, axis=0)[:SERIES_ORDER_COUNT] / count / r ** np.arange(SERIES_ORDER_COUNT)[:, None]
    assert (np.abs(terms - orders.real) <= 1e-9 * (1 + np.abs(terms))).all()
    for j in range(k):
        rise = np.array([closure(s, h * columns[:, j]) - closure(s, -h * columns[:, j]) for s in around]) / (2 * h)
        orders = np.fft.fft(rise, axis=0)[:SERIES_ORDER_COUNT] / count / r ** np.arange(SERIES_ORDER_COUNT)[:, None]
        assert (np.abs(slopes[:, :, j] - orders.real) <= 1e-5 * (1 + np.abs(orders).max())).all()
