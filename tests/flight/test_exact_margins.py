"""Margins at the ends in fractions lie between those of floating point, and are proved."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.springs.flight.exact_margins import _proved_margin, exact_end_margin
from hcsearch.springs.flight.torque_margin import allowed_senses, closed_rates, torque_margins
from tests.linkages import linkage_named

NAMES = ("hex:0234550132:4", "square:012233230011:4", "rectangle:0122333011:1", "triangle:012343454505012321:3")


def by_floats(linkage, angles, torques, friction, arriving):
    senses = allowed_senses(angles, arriving=arriving)[None]
    return torque_margins(closed_rates(linkage.closure(angles)[1][None]), torques[None], friction, senses)


@given(st.sampled_from(NAMES), st.integers(0, 1000), st.booleans())
def test_exact_margins_lie_between_those_of_floating_point(name, seed, arriving):
    linkage, rng = linkage_named(name), np.random.default_rng(seed)
    angles = linkage.flat if arriving else linkage.folded
    torques, friction = rng.uniform(0.01, 0.5, linkage.n_hinges), rng.uniform(0.005, 0.02, linkage.n_hinges)
    exact = exact_end_margin(linkage, angles, torques, friction, arriving=arriving)
    found = by_floats(linkage, angles, torques, friction, arriving)
    assert exact is not None
    assert found.margins[0] <= exact <= found.bounds[0]
    assert float(exact) == pytest.approx(found.bounds[0], rel=1e-9)


def test_whole_torques_have_a_margin_that_is_a_simple_fraction():
    linkage = linkage_named("hex:0234550132:4")
    exact = exact_end_margin(
        linkage, linkage.flat, np.full(linkage.n_hinges, 3.0), np.full(linkage.n_hinges, 2.0), arriving=True
    )
    assert exact == Fraction(3, 2)


def test_without_torques_the_margin_is_0():
    linkage = linkage_named("hex:0234550132:4")
    nothing = np.zeros(linkage.n_hinges)
    assert exact_end_margin(linkage, linkage.flat, nothing, nothing + 0.01, arriving=True) == 0


def test_off_the_ends_and_without_friction_nothing_is_exact():
    linkage = linkage_named("hex:0234550132:4")
    some = np.ones(linkage.n_hinges)
    assert exact_end_margin(linkage, 0.5 * linkage.folded, some, some) is None
    assert exact_end_margin(linkage, linkage.folded, some, 0.0 * some) is None


def test_only_the_right_hinges_prove_a_margin():
    """Three parallel hinges with x0 = x1 + 2 x2: the margin is that of x = (2, 0, 1)."""
    columns = [[1], [-1], [-2]]
    powers, losses = [Fraction(1), Fraction(1), Fraction(5)], [Fraction(1)] * 3
    assert _proved_margin(columns, powers, losses, [0, 2], []) == Fraction(7, 3)
    assert _proved_margin(columns, powers, losses, [0, 1], []) is None  # x = (1, 1, 0) has the ratio 1
    assert _proved_margin(columns, powers, losses, [1, 2], []) is None  # they would have to turn against each other
    assert _proved_margin(columns, powers, losses, [0, 1, 2], []) is None  # several x vanish elsewhere
