"""A piece of a motion: its bounds hold at every state that is tried, and closed states lie where they are said to."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.kernels.planning.pieces import (
    CHEBYSHEV_NODE_COUNT,
    LEBESGUE_CONSTANT,
    LOOP_POSE_ROUNDING,
    MAX_CONTRACTION_FACTOR,
    _opening,
    _scale,
    _screws,
    _shift,
    new_piece_tables,
    prove_piece,
)
from hcsearch.motion.planning.problems import group_of_all, loops_of
from tests.planned import SAMPLES, cubic, joined, planned


def hat(twist):
    (x, y, z), v = twist[:3], twist[3:]
    return np.block([[np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), v[:, None]], [np.zeros((1, 4))]])


def rotation(axis, angle):
    cross = hat(np.r_[axis, 0 * axis])[:3, :3]
    return np.eye(3) + np.sin(angle) * cross + 2 * np.sin(angle / 2) ** 2 * cross @ cross


def around(linkage, loop, angles, dtype=float):
    """T of a loop in units of the pattern's size, in a precision."""
    directions, points = linkage.directions.astype(dtype), linkage.points.astype(dtype) / dtype(linkage.pattern.size)
    product = np.eye(4, dtype=dtype)
    for hinge, sign in loop:
        matrix = np.eye(4, dtype=dtype)
        matrix[:3, :3] = rotation(directions[hinge], sign * angles[hinge].astype(dtype))
        matrix[:3, 3] = points[hinge] - matrix[:3, :3] @ points[hinge]
        product = product @ matrix
    return product


def about(matrix, middle, length):
    """A motion about a point, in another unit of length."""
    moved = matrix.copy()
    moved[:3, 3] = (matrix[:3, 3] + matrix[:3, :3] @ middle - middle) / length
    return moved


def twist(matrix):
    r = matrix[:3, :3]
    return np.r_[0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]), matrix[:3, 3]]


def opened(linkage, tables, angles, dtype=float):
    """F, the twists of T - 1 of all loops about their middles."""
    twists = [
        twist(about(around(linkage, loop, angles, dtype), tables.middles[k], tables.lengths[k]))
        for k, loop in enumerate(linkage.loops)
    ]
    return np.concatenate(twists)


def screws(linkage, tables, angles):
    """J at some angles, about the middles."""
    _, screws = linkage.closure(angles)
    for k in range(len(linkage.loops)):
        own = screws[6 * k : 6 * k + 6]
        own[3:] = (own[3:] - np.cross(tables.middles[k], own[:3].T).T) / tables.lengths[k]
    return screws


def derivative(linkage, tables, angles):
    """DF, by central differences."""
    h = 1e-5
    columns = [
        (opened(linkage, tables, angles + h * e) - opened(linkage, tables, angles - h * e)) / (2 * h)
        for e in np.eye(linkage.n_hinges)
    ]
    return np.stack(columns, axis=1)


pieces = st.tuples(
    st.sampled_from(sorted(SAMPLES)), st.floats(0.1, 0.9), st.floats(0.0, 1.0), st.integers(0, 6), st.integers(0, 2**32)
)


def piece_of(drawn):
    """A sample, a piece of its motion as (course, shares), and a generator."""
    name, place, low, halvings, seed = drawn
    sample = planned(name)
    course = cubic(sample, int(place * (len(sample.proof.motion.times) - 1)))
    long = 0.5**halvings
    return sample, course, (low * (1 - long), low * (1 - long) + long), np.random.default_rng(seed)


def proved(sample, course, shares, before=None):
    loops = loops_of(sample.linkage)
    tables = new_piece_tables(loops, group_of_all(loops))
    before = np.zeros(sample.linkage.n_hinges) if before is None else before
    factor, wander = prove_piece(loops, group_of_all(loops), course, shares, before, math.inf, tables)
    return factor, wander, tables


def at(course, share):
    return course @ share ** np.arange(4)


@settings(max_examples=12)
@given(pieces)
def test_screws_and_the_scaling_are_what_they_are_said_to_be(drawn):
    sample, course, shares, _ = piece_of(drawn)
    _, _, tables = proved(sample, course, shares)
    middle = at(course, sum(shares) / 2)
    np.testing.assert_allclose(tables.jacobian, screws(sample.linkage, tables, middle), atol=1e-12)
    np.testing.assert_allclose(tables.scaling @ tables.jacobian, tables.basis, atol=1e-9)
    np.testing.assert_allclose(tables.basis @ tables.basis.T, np.eye(6), atol=1e-12)
    for column, most in zip(tables.jacobian.T, tables.norms[0], strict=True):
        bracket = np.block(
            [
                [hat(column)[:3, :3], np.zeros((3, 3))],
                [hat(np.r_[column[3:], column[:3]])[:3, :3], hat(column)[:3, :3]],
            ]
        )
        assert max(np.linalg.norm(hat(column), 2), np.linalg.norm(bracket, 2), np.linalg.norm(column)) <= most + 1e-12


@settings(max_examples=12)
@given(pieces)
def test_the_product_of_exponentials_at_a_state_closes_the_loop_elsewhere(drawn):
    from scipy.linalg import expm

    sample, course, shares, rng = piece_of(drawn)
    linkage = sample.linkage
    state, change = at(course, shares[0]), rng.normal(size=linkage.n_hinges)
    _, jacobian = linkage.closure(state)
    product = np.eye(4)
    for hinge, _ in linkage.loops[0]:
        product = product @ expm(change[hinge] * hat(jacobian[:6, hinge]))
    carried = product @ around(linkage, linkage.loops[0], state)
    np.testing.assert_allclose(carried, around(linkage, linkage.loops[0], state + change), atol=1e-12)


@settings(max_examples=12)
@given(pieces)
def test_the_factor_is_no_less_than_any_that_is_met_with(drawn):
    sample, course, shares, rng = piece_of(drawn)
    linkage = sample.linkage
    factor, _, tables = proved(sample, course, shares)
    if not math.isfinite(factor):
        return
    one = np.eye(6)
    for _ in range(5):
        place = at(course, rng.uniform(*shares))
        corner = place + tables.tube_radii * rng.choice([-1.0, 1.0], size=linkage.n_hinges)
        inside = place + tables.tube_radii * rng.uniform(-1, 1, linkage.n_hinges)
        for state in (corner, inside):
            shrunk = one - tables.scaling @ screws(linkage, tables, state) @ tables.basis.T
            assert np.linalg.norm(shrunk, 2) <= factor + 1e-9
        beside = at(course, rng.uniform(*shares)) + tables.wander_bounds * rng.uniform(-1, 1, linkage.n_hinges) / 2
        shrunk = one - tables.scaling @ derivative(linkage, tables, beside) @ tables.basis.T
        assert np.linalg.norm(shrunk, 2) <= factor + 1e-6


@settings(max_examples=12)
@given(pieces)
def test_the_derivative_of_the_map_on_the_course_is_that_of_naive_products(drawn):
    sample, course, shares, _ = piece_of(drawn)
    factor, _, tables = proved(sample, course, shares)
    if not math.isfinite(factor):
        return
    for node in range(CHEBYSHEV_NODE_COUNT):
        state = at(tables.centred_course, math.cos(math.pi * (node + 0.5) / CHEBYSHEV_NODE_COUNT))
        own = tables.scaling @ screws(sample.linkage, tables, state) @ tables.basis.T - np.eye(6)
        np.testing.assert_allclose(tables.contraction_matrices[node], own, atol=1e-9)
    dense = [
        np.linalg.norm(
            tables.scaling @ screws(sample.linkage, tables, at(tables.centred_course, x)) @ tables.basis.T - np.eye(6)
        )
        for x in np.linspace(-1, 1, 33)
    ]
    assert max(dense) <= factor + 1e-9


@settings(max_examples=12)
@given(pieces)
def test_a_newton_step_is_nowhere_longer_than_its_bound(drawn):
    sample, course, shares, _ = piece_of(drawn)
    loops = loops_of(sample.linkage)
    tables = new_piece_tables(loops, group_of_all(loops))
    _shift(course, sum(shares) / 2, (shares[1] - shares[0]) / 2, tables.centred_course)
    tables.angles[:] = tables.centred_course[:, 0]
    most = _screws(loops, group_of_all(loops), tables)
    strength = _scale(group_of_all(loops), tables)
    newton, off, _ = _opening(loops, group_of_all(loops), strength, most, tables)
    for x in np.linspace(-1, 1, 33):
        state = at(tables.centred_course, x)
        step = tables.scaling @ opened(sample.linkage, tables, state)
        assert np.linalg.norm(step) <= newton
        pose = about(around(sample.linkage, sample.linkage.loops[0], state), tables.middles[0], tables.lengths[0])
        assert np.linalg.norm(pose - np.eye(4)) <= off


@settings(max_examples=12)
@given(pieces)
def test_a_closed_state_lies_beside_every_state_of_a_proved_piece(drawn):
    sample, course, shares, rng = piece_of(drawn)
    factor, wander, tables = proved(sample, course, shares)
    if factor > MAX_CONTRACTION_FACTOR:
        return
    for share in (*shares, rng.uniform(*shares)):
        state, y = at(course, share), np.zeros(6)
        for _ in range(25):
            y -= tables.scaling @ opened(sample.linkage, tables, state + tables.basis.T @ y)
        closed = state + tables.basis.T @ y
        # the map itself converges, as fast as its factor says, to within rounding
        assert np.abs(opened(sample.linkage, tables, closed)).max() < 1e-13
        assert (np.abs(closed - state) <= tables.wander_bounds).all()
        assert np.abs(closed - state).sum() <= wander


@settings(max_examples=10)
@given(pieces, st.floats(1e-9, 1e-4))
def test_closed_states_on_the_straight_way_between_two_lie_within_the_bow(drawn, size):
    sample, course, shares, rng = piece_of(drawn)
    before = size * rng.uniform(0, 1, sample.linkage.n_hinges)
    alone = proved(sample, course, shares)
    factor, wander, tables = proved(sample, course, shares, before)
    assert wander >= max(before.sum(), 0.999 * alone[1])
    if factor > MAX_CONTRACTION_FACTOR:
        return
    state, ends = at(course, shares[0]), []
    for off in (np.zeros(len(before)), before):
        x = state + off
        for _ in range(25):
            x = x - tables.basis.T @ (tables.scaling @ opened(sample.linkage, tables, x))
        ends.append(x)
    bow = ((tables.wander_bounds - alone[2].wander_bounds) / tables.column_norms).max()
    for share in (0.25, 0.5, 0.75):
        way = ends[0] + share * (ends[1] - ends[0])
        x = way
        for _ in range(25):
            x = x - tables.basis.T @ (tables.scaling @ opened(sample.linkage, tables, x))
        assert (np.abs(x - way) <= tables.column_norms * bow + 1e-13).all()


def test_interpolation_exceeds_values_by_no_more_than_its_constant():
    nodes = np.cos(np.pi * (np.arange(CHEBYSHEV_NODE_COUNT) + 0.5) / CHEBYSHEV_NODE_COUNT)
    x = np.linspace(-1, 1, 4001)[:, None]
    weights = [np.prod([(x[:, 0] - q) / (p - q) for q in nodes if q != p], axis=0) for p in nodes]
    assert np.abs(weights).sum(axis=0).max() <= LEBESGUE_CONSTANT


@pytest.mark.parametrize("name", SAMPLES)
def test_rounding_is_what_it_is_taken_for(name):
    sample, rng = planned(name), np.random.default_rng(0)
    linkage = sample.linkage
    loops = loops_of(linkage)
    tables = new_piece_tables(loops, group_of_all(loops))
    for _ in range(20):
        tables.angles[:] = rng.uniform(0, math.pi, linkage.n_hinges)
        most = _screws(loops, group_of_all(loops), tables)
        reach = np.linalg.norm(linkage.points, axis=1).max() / (linkage.pattern.size * tables.lengths.min())
        exact = opened(linkage, tables, tables.angles, np.longdouble)
        rough = opened(linkage, tables, tables.angles)
        assert np.linalg.norm((exact - rough).astype(float)) <= LOOP_POSE_ROUNDING * linkage.n_hinges * (
            1 + most + reach
        )


def test_redundant_closure_is_not_proved():
    linkage = joined("square:01222300:0", "rigid")  # six hinges, one freedom: closure is redundant all along
    loops = loops_of(linkage)
    tables = new_piece_tables(loops, group_of_all(loops))
    course = np.zeros((linkage.n_hinges, 4))
    course[:, 0] = linkage.folded
    bounds = prove_piece(loops, group_of_all(loops), course, (0.0, 1.0), np.zeros(linkage.n_hinges), math.inf, tables)
    assert bounds == (math.inf, math.inf)
