"""Cones of one-sided velocities, against plain searches and SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog, nnls

from hcsearch.kernels.linkage.cones import MAX_EXTREME_RAYS, cone_rays, find_locking_wrench, nonnegative_least_squares
from tests import naive


@st.composite
def columns(draw, most=8, height=5):
    """Small whole columns, so that many are dependent."""
    n = draw(st.integers(2, most))
    rows = draw(st.lists(st.lists(st.integers(-2, 2), min_size=height, max_size=height), min_size=n, max_size=n))
    return np.array(rows, np.int64)


@given(columns(), st.lists(st.integers(-3, 3), min_size=5, max_size=5))
def test_nonnegative_least_squares_agree_with_scipy(rows, target):
    lengths = np.linalg.norm(rows, axis=1)
    unit = rows[lengths > 0] / lengths[lengths > 0, None]
    if not len(unit):
        return
    x, left = np.empty(len(unit)), np.empty(5)
    nonnegative_least_squares(unit, np.array(target, float), x, left)
    assert x.min() >= 0.0
    assert left == pytest.approx(target - unit.T @ x, abs=1e-9)
    assert np.linalg.norm(left) == pytest.approx(nnls(unit.T, np.array(target, float))[1], abs=1e-8)


@given(columns())
def test_a_wrench_loads_all_hinges_exactly_where_nothing_can_move(rows):
    wrench = np.empty(5, np.int64)
    held = find_locking_wrench(rows, wrench)
    if held:
        assert (rows @ wrench > 0).all()
    moves = linprog(np.zeros(len(rows)), A_eq=np.r_[rows.T, np.ones((1, len(rows)))], b_eq=[0] * 5 + [1])
    assert held == (moves.status == 2)


@given(columns(most=7))
def test_rays_of_a_cone_are_those_of_all_sets_of_hinges(rows):
    lengths = np.linalg.norm(rows, axis=1)
    unit = rows[lengths > 0] / lengths[lengths > 0, None]
    if not len(unit):
        return
    rays = np.empty((MAX_EXTREME_RAYS, len(unit)))
    count = cone_rays(unit, rays)
    expected = naive.cone_corners(unit)
    assert count == len(expected)
    for ray in rays[:count]:
        assert min(np.abs(ray - other).max() for other in map(np.array, expected)) < 1e-8


def test_a_cone_with_too_many_rays_is_given_up():
    rows = np.zeros((40, 5))
    rows[:20, 0], rows[20:, 0] = 1.0, -1.0
    assert cone_rays(rows, np.empty((300, 40))) == -1
    assert cone_rays(rows, np.empty((500, 40))) == 400
