"""Linear programs over a box cut by a subspace, against their vertices one by one and against SciPy."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from hcsearch.kernels.linkage.boxed_programs import farthest_in_box, greatest_in_box


def orthonormal(matrix):
    """Rows that span those of a matrix."""
    if not matrix.size:
        return np.zeros((0, matrix.shape[1]))
    _, values, rows = np.linalg.svd(matrix, full_matrices=False)
    return np.ascontiguousarray(rows[values > 1e-9])


def vertices(rows):
    """All vertices of the set |y| <= 1, R y = 0: r coordinates follow from the others, which are at their bounds."""
    r, n = rows.shape
    for free in itertools.combinations(range(n), r):
        fixed = [j for j in range(n) if j not in free]
        if r and np.linalg.matrix_rank(rows[:, free], tol=1e-9) < r:
            continue
        for signs in itertools.product([-1.0, 1.0], repeat=n - r):
            point = np.zeros(n)
            point[fixed] = signs
            if r:
                point[list(free)] = np.linalg.solve(rows[:, free], -rows[:, fixed] @ np.array(signs))
            if np.abs(point).max() <= 1.0 + 1e-9:
                yield point


def solved(rows, goals):
    values, multipliers = np.empty(len(goals)), np.empty((len(goals), len(rows)))
    points = np.empty(goals.shape)
    greatest_in_box(rows, goals, values, multipliers, points)
    return values, multipliers, points


@st.composite
def programs(draw, most=5):
    """Rows and goals of small whole numbers, which have many ties, or of random numbers, which have none."""
    n = draw(st.integers(1, most))
    r = draw(st.integers(0, n - 1))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    if draw(st.booleans()):
        matrix, goals = rng.integers(-1, 2, (r, n)).astype(float), rng.integers(-2, 3, (4, n)).astype(float)
    else:
        matrix, goals = rng.normal(size=(r, n)), rng.normal(size=(4, n))
    return orthonormal(matrix), goals


@given(programs())
def test_the_greatest_value_is_that_of_the_best_vertex(program):
    rows, goals = program
    corners = np.array(list(vertices(rows)))
    assert solved(rows, goals)[0] == pytest.approx((goals @ corners.T).max(axis=1), abs=1e-8)


@given(programs())
def test_the_farthest_image_is_that_of_a_vertex(program):
    rows, goals = program
    images = goals.reshape(2, 2, -1)
    corners = np.array(list(vertices(rows)))
    distances = np.empty(2)
    farthest_in_box(rows, images, distances)
    naive = np.linalg.norm(images @ corners.T, axis=1).max(axis=1)
    assert distances == pytest.approx(naive, abs=1e-8)


@given(programs(most=60))
def test_value_point_and_multipliers_certify_each_other_and_agree_with_scipy(program):
    rows, goals = program
    values, multipliers, points = solved(rows, goals)
    assert np.abs(points).max() <= 1.0 + 1e-8
    assert np.abs(rows @ points.T).max(initial=0.0) < 1e-8
    assert np.abs(goals - multipliers @ rows).sum(axis=1) == pytest.approx(values, abs=1e-9)
    assert (goals * points).sum(axis=1) == pytest.approx(values, abs=1e-7)
    equations = {"A_eq": rows, "b_eq": np.zeros(len(rows))} if len(rows) else {}
    best = linprog(-goals[0], bounds=(-1, 1), **equations)
    assert values[0] == pytest.approx(-best.fun, abs=1e-7)
