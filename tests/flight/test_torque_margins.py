"""Torque margins of single states: duals, random rates, closed forms, symmetries and scales."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.flight.torque_margin import (
    allowed_senses,
    closed_rates,
    power_ratios,
    torque_margins,
    torque_margins_failed,
)
from tests.flight.random_margins import best_random_ratio, closed_basis, dual, primal, random_closed_states
from tests.linkages import linkage_named

CLOSE = 1e-8


def margins_of(jacobians, torques, friction, senses=None):
    rates = closed_rates(jacobians)
    return torque_margins(rates, torques, friction, np.zeros(torques.shape, np.int8) if senses is None else senses)


@st.composite
def states(draw, nullity=None):
    """A random state: a Jacobian (often with whole entries, so that it is degenerate), torques, friction and senses."""
    n = draw(st.integers(2, 9))
    free = nullity if nullity is not None else draw(st.integers(1, n))
    assume(free <= n)
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    whole = draw(st.booleans())
    jacobian = rng.integers(-2, 3, (n - free, n)).astype(float) if whole else rng.normal(size=(n - free, n))
    torques = rng.integers(-1, 3, n).astype(float) if whole else rng.normal(size=n)
    friction = rng.integers(draw(st.integers(0, 1)), 3, n).astype(float) if whole else rng.uniform(0.1, 1.0, n)
    senses = rng.choice([-1, 0, 0, 1], n).astype(np.int8) if draw(st.booleans()) else np.zeros(n, np.int8)
    return jacobian, torques, friction, senses


@given(states())
def test_rates_and_wrench_certify_each_other_and_agree_with_both_linear_programs(state):
    jacobian, torques, friction, senses = state
    found = margins_of(jacobian[None], torques[None], friction, senses[None])
    margin, bound = found.margins[0], found.bounds[0]
    rates, moments = found.rates[0], torques + jacobian.T @ found.wrenches[0]
    for expected in (primal(*state), dual(*state)):
        assert margin == expected or margin == pytest.approx(expected, rel=CLOSE, abs=CLOSE)
        assert bound == expected or bound == pytest.approx(expected, rel=CLOSE, abs=CLOSE)
    assert margin <= bound
    assert np.abs(jacobian @ rates).max(initial=0.0) < CLOSE * max(1.0, np.abs(rates).max())
    assert (senses * rates >= -CLOSE * np.abs(rates).max()).all()
    if math.isfinite(bound):
        limit = bound * friction + CLOSE
        assert (moments <= np.where(senses < 0, np.inf, limit)).all()
        assert (-moments <= np.where(senses > 0, np.inf, limit)).all()


@pytest.mark.parametrize("degenerate", [False, True])
def test_many_freedoms_agree_with_the_linear_program(degenerate):
    """30 hinges in one loop, as in arrays of 30 squares."""
    rng = np.random.default_rng(11)
    for _ in range(10):
        jacobian = rng.integers(-1, 2, (6, 30)).astype(float) if degenerate else rng.normal(size=(6, 30))
        torques, friction = np.ones(30), np.ones(30) if degenerate else rng.uniform(0.1, 1.0, 30)
        senses = rng.choice([-1, 0, 1], 30).astype(np.int8)
        found = margins_of(jacobian[None], torques[None], friction, senses[None])
        expected = primal(jacobian, torques, friction, senses)
        assert found.margins[0] == pytest.approx(expected, rel=CLOSE, abs=CLOSE)
        assert found.bounds[0] == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


@given(states(nullity=1))
def test_one_freedom_is_a_ratio(state):
    jacobian, torques, friction, _ = state
    basis = closed_basis(jacobian)
    assume(basis.shape[1] == 1 and (friction > 0.0).all())
    ratio = abs(torques @ basis[:, 0]) / (friction @ np.abs(basis[:, 0]))
    assert margins_of(jacobian[None], torques[None], friction).margins[0] == pytest.approx(ratio, rel=CLOSE, abs=CLOSE)


def test_two_freedoms_agree_with_a_dense_search():
    rng = np.random.default_rng(3)
    for _ in range(20):
        jacobian, torques, friction = rng.normal(size=(5, 7)), rng.normal(size=7), rng.uniform(0.1, 1.0, 7)
        turns = np.linspace(0.0, 2.0 * np.pi, 20_000)
        rates = np.c_[np.cos(turns), np.sin(turns)] @ closed_basis(jacobian).T
        best = ((rates @ torques) / (np.abs(rates) @ friction)).max()
        margin = margins_of(jacobian[None], torques[None], friction).margins[0]
        assert best <= margin * (1.0 + CLOSE)
        assert best > margin * (1.0 - 1e-3)


@pytest.mark.parametrize("name", ["hex:023434050022:5", "square:012233230011:4", "ten-triangles"])
def test_no_random_rates_are_better(name):
    """200 closed states in all, 10,000 closed rates each."""
    linkage = linkage_named(name)
    rng = np.random.default_rng(7)
    angles = random_closed_states(linkage, 67, seed=5)
    torques, friction = 0.1 * angles + rng.uniform(0.0, 0.1, angles.shape), rng.uniform(0.01, 0.05, linkage.n_hinges)
    jacobians = np.array([linkage.closure(state)[1] for state in angles])
    senses = allowed_senses(angles)
    found = margins_of(jacobians, torques, friction, senses)
    for k, margin in enumerate(found.margins):
        ratio = best_random_ratio(jacobians[k], torques[k], friction, senses[k], 10_000, rng)
        assert 0.0 < ratio <= margin * (1.0 + CLOSE)
        if found.nullities[k] <= 2:
            assert ratio > 0.9 * margin
    assert np.allclose(found.margins, found.bounds, rtol=CLOSE)


@pytest.mark.parametrize("name", ["unit-ii", "unit-iii", "array-6r", "modules-i-four-b", "module-iii-4-1"])
@pytest.mark.parametrize("arriving", [False, True])
def test_linkages_of_several_loops_agree_with_both_linear_programs_at_their_ends(name, arriving):
    linkage, rng = linkage_named(name), np.random.default_rng(0)
    angles = linkage.flat if arriving else linkage.folded
    jacobian, senses = linkage.closure(angles)[1], allowed_senses(angles, arriving=arriving)
    torques, friction = rng.uniform(0.1, 0.5, linkage.n_hinges), rng.uniform(0.01, 0.02, linkage.n_hinges)
    found = margins_of(jacobian[None], torques[None], friction, senses[None])
    for margin in (found.margins[0], found.bounds[0]):
        assert margin == pytest.approx(primal(jacobian, torques, friction, senses), rel=CLOSE)
        assert margin == pytest.approx(dual(jacobian, torques, friction, senses), rel=CLOSE)
    assert found.margins[0] > 1.0


@given(states(), st.floats(0.01, 100.0))
def test_margins_scale_with_torques_and_against_friction(state, factor):
    jacobian, torques, friction, senses = state
    one = margins_of(jacobian[None], torques[None], friction, senses[None]).margins[0]
    assume(math.isfinite(one))
    more = margins_of(jacobian[None], factor * torques[None], friction, senses[None]).margins[0]
    less = margins_of(jacobian[None], torques[None], factor * friction, senses[None]).margins[0]
    assert more == pytest.approx(factor * one, rel=CLOSE, abs=CLOSE)
    assert less == pytest.approx(one / factor, rel=CLOSE, abs=CLOSE)


@given(states(), st.randoms(use_true_random=False))
def test_margins_do_not_depend_on_numbering_senses_and_bases(state, random):
    jacobian, torques, friction, senses = state
    n = len(torques)
    order = random.sample(range(n), n)
    signs = np.array([random.choice([-1, 1]) for _ in range(n)])
    mixed = np.linalg.qr(np.random.default_rng(1).normal(size=(len(jacobian), len(jacobian))))[0] @ jacobian
    one = margins_of(jacobian[None], torques[None], friction, senses[None]).margins[0]
    other = margins_of(
        (mixed * signs)[None][:, :, order],
        (torques * signs)[None][:, order],
        friction[order],
        (senses * signs).astype(np.int8)[None][:, order],
    ).margins[0]
    assert other == one or other == pytest.approx(one, rel=CLOSE, abs=CLOSE)


@given(states())
def test_the_worst_failed_spring_is_the_worst_of_all(state):
    jacobian, torques, friction, senses = state
    rates = closed_rates(jacobian[None])
    whole = torque_margins(rates, torques[None], friction, senses[None])
    found = torque_margins_failed(rates, torques[None], friction, senses[None], whole)
    margins, hinges = found.margins, found.hinges
    assert found.known.all()
    assert margins[0] <= found.bounds[0]
    working = torques * (1.0 - np.eye(len(torques)))
    each = {int(k): primal(jacobian, working[k], friction, senses) for k in np.flatnonzero(torques)}
    if not each:
        assert (margins[0], hinges[0]) == (0.0, -1)
        return
    assert margins[0] == min(each.values()) or margins[0] == pytest.approx(min(each.values()), rel=CLOSE, abs=CLOSE)
    assert each[int(hinges[0])] == pytest.approx(min(each.values()), rel=CLOSE, abs=CLOSE)


@given(states())
def test_a_failed_spring_leaves_less_where_every_spring_helps(state):
    jacobian, torques, friction, _ = state
    senses = np.ones(len(torques), np.int8)  # hinges open only
    torques = np.abs(torques)
    rates = closed_rates(jacobian[None])
    whole = torque_margins(rates, torques[None], friction, senses[None])
    margins = torque_margins_failed(rates, torques[None], friction, senses[None], whole).margins
    assert margins[0] <= whole.bounds[0] * (1.0 + CLOSE) + CLOSE


def test_without_friction_any_power_is_unbounded():
    jacobian, nothing = np.array([[[1.0, -1.0]]]), np.zeros(2)
    assert margins_of(jacobian, np.array([[1.0, 0.0]]), nothing).margins[0] == np.inf
    assert margins_of(jacobian, np.array([[1.0, -1.0]]), nothing).margins[0] == 0.0
    assert margins_of(jacobian, np.array([[1.0, 0.0]]), np.array([0.0, 0.5])).margins[0] == pytest.approx(2.0)


def test_an_open_chain_is_as_good_as_its_best_hinge():
    found = margins_of(np.zeros((1, 0, 3)), np.array([[1.0, -6.0, 2.0]]), np.array([1.0, 2.0, 0.5]))
    assert found.margins[0] == pytest.approx(4.0)
    assert found.bounds[0] == pytest.approx(found.margins[0], rel=1e-12)
    assert found.hinges[0] == 2


def test_stops_allow_hinges_to_leave_them_or_to_arrive():
    angles = np.array([0.0, math.pi, 1.0])
    assert allowed_senses(angles).tolist() == [-1, 1, 0]
    assert allowed_senses(angles, arriving=True).tolist() == [1, -1, 0]


def test_ratios_are_signed():
    torques, rates = np.array([[1.0, 1.0]] * 3), np.array([[1.0, 1.0], [-2.0, 1.0], [0.0, 0.0]])
    assert power_ratios(torques, np.ones(2), rates).tolist() == pytest.approx([1.0, -1.0 / 3.0, 0.0])


@pytest.mark.parametrize(
    ("torques", "friction"),
    [
        (np.ones((1, 3)), np.ones(2)),
        (np.ones((2, 2)), np.ones(2)),
        (np.ones((1, 2)), np.array([1.0, -0.1])),
        (np.array([[np.nan, 1.0]]), np.ones(2)),
        (np.ones((1, 2)), np.array([np.inf, 1.0])),
    ],
)
def test_wrong_torques_and_friction_are_refused(torques, friction):
    with pytest.raises(HcsearchError, match="give"):
        margins_of(np.ones((1, 1, 2)), torques, friction, np.zeros((1, 2), np.int8))
