"""Growth constants fitted to counts."""

import pytest

from hcsearch.search.enumeration.growth import POLYGON_EXPONENT, fit_growth
from tests import golden

# published polygons of a lattice, and its connective constant
LATTICES = {
    "triangular": (golden.values("A036418"), 4.150797),
    "square": (golden.values("A002931", step=2), 2.638159),
    "honeycomb": (golden.values("A006774", step=2), 1.847759),
    "kagome": ({n: 3 * term // (2 * n) for n, term in golden.values("A005397").items()}, 2.560577),
}

REACH = {"square": 38}  # beyond which the program lists no circuits


@pytest.mark.parametrize("exponent", [-2.5, -0.5, 1.0])
def test_the_fit_finds_the_growth_of_counts_that_grow_so(exponent):
    counts = {n: round(10**12 * 1.7**n * n**exponent) for n in (6, 9, 10, 15, 20, 26, 31, 40)}
    growth = fit_growth(counts)
    assert growth.mu == pytest.approx(1.7, abs=1e-9)
    assert growth.exponent == pytest.approx(exponent, abs=1e-8)
    assert growth.mu_error < 1e-8
    assert fit_growth(counts, exponent).mu == pytest.approx(1.7, abs=1e-9)
    assert fit_growth(counts, exponent).exponent_error == 0


@pytest.mark.parametrize("exponent", [None, POLYGON_EXPONENT])
@pytest.mark.parametrize("lattice", LATTICES)
def test_errors_cover_the_published_constants_of_four_lattices(lattice, exponent):
    counts, mu = LATTICES[lattice]
    n_fits = 0
    for last in range(10, min(max(counts), REACH.get(lattice, 120)) + 1):
        growth = fit_growth({n: count for n, count in counts.items() if 3 <= n <= last}, exponent)
        if growth is not None:
            n_fits += 1
            assert abs(growth.mu - mu) <= growth.mu_error
            assert abs(growth.exponent - POLYGON_EXPONENT) <= max(2 * growth.exponent_error, 1e-12)
    assert n_fits >= 2


def test_errors_fall_as_counts_are_added():
    counts, _ = LATTICES["triangular"]
    errors = [fit_growth({n: counts[n] for n in range(3, last)}).mu_error for last in (13, 18, 23, 28)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.03


@pytest.mark.parametrize("counts", [{}, {n: 2**n for n in range(3, 8)}, {n: 2**n * (n % 2) for n in range(3, 13)}])
def test_few_counts_have_no_growth(counts):
    assert fit_growth(counts) is None


def test_counts_that_jump_have_no_growth():
    assert fit_growth({n: 2**n * (1000 if n % 3 else 1) for n in range(6, 16)}) is None


def test_counts_beyond_floats_are_fitted():
    growth = fit_growth({n: 3**n for n in range(600, 1000, 20)})
    assert growth.mu == pytest.approx(3)
