"""Exact ranks of whole hinge lines, at sizes where products of determinants would leave 63 bits."""

from fractions import Fraction

import numpy as np
import pytest

from hcsearch.kernels.linkage.hinge_lines import whole_rank


def rank(rows):
    """Rank by Gauss elimination over the rationals."""
    left = [[Fraction(int(entry)) for entry in row] for row in rows]
    count = 0
    for column in range(5):
        pivot = next((row for row in left if row[column]), None)
        if pivot is None:
            continue
        count += 1
        left.remove(pivot)
        left = [[a - row[column] / pivot[column] * b for a, b in zip(row, pivot, strict=True)] for row in left]
    return count


@pytest.mark.parametrize("n", [10, 1000, 60_000])
def test_ranks_of_lines_are_those_over_the_rationals(n):
    random = np.random.default_rng(n)
    seen = set()
    for _ in range(100):
        k = int(random.integers(2, 9))
        dx, dy = random.integers(-3, 4, (2, k))
        z = random.integers(0, n // 2 if random.random() < 0.7 else 1, k)
        moment = random.integers(-6 * n, 6 * n, k)
        if random.random() < 0.5:  # all lines belong to one linear complex
            a, b, c, d = random.integers(-2, 3, 4)
            moment = -a * z * dy + b * z * dx + c * n * dx + d * n * dy
        rows = np.stack([dx, dy, -z * dy, z * dx, moment], axis=1)
        seen.add(rank(rows))
        assert whole_rank(rows) == rank(rows)
    assert {2, 3, 4, 5} <= seen


def test_a_determinant_that_a_prime_divides_is_not_zero():
    for prime in (2147483647, 2147483629):
        assert whole_rank(np.diag([1, 1, 1, 1, prime])) == 5
