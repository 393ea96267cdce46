"""Leaving an end of the motion: the equations, the series and its rest, and closed states beside the first step."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.kernels.planning.series import SERIES_ORDER_COUNT, write_series
from hcsearch.motion.planning.ends import DEPARTURE_RESIDUAL, MIN_DEPARTURE_TURN_RATIO, EndClosure, _rest
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover
from hcsearch.motion.planning.problems import group_of_all, loops_of
from hcsearch.shape.linkage import Linkage
from tests.linkages import linkage_named
from tests.naive import around_the_loop
from tests.planned import SAMPLES, planned


def ends(name):
    linkage = planned(name).linkage
    group = group_of_all(loops_of(linkage))
    return [(linkage, EndClosure(linkage, angles, group)) for angles in (linkage.folded.astype(float), linkage.flat)]


def departures(name):
    """How the path of a sample leaves both ends: the end, its cubic, and what is proved of it."""
    sample = planned(name)
    prover = Prover(sample.linkage)
    for end, line in zip(prover.whole.ends, (sample.states, sample.states[::-1]), strict=True):
        state, (slope, after), _, departure = prover.whole._left(end, line, prover.limit(CERTIFIED_MARGINS[-1]))
        rise = state - line[0]
        course = np.stack([line[0], slope, 3 * rise - 2 * slope - after, slope + after - 2 * rise], axis=1)
        yield sample.linkage, end, course, departure


def opened(linkage, angles):
    """Twists of T - 1, about the middles of an end's loops."""
    twists = []
    for loop in linkage.loops:
        twists.append(around_the_loop(linkage.directions, linkage.points / linkage.pattern.size, loop, angles))
    return twists


def middles(linkage, end):
    """The point and the unit of length of each loop, from its screws there."""
    _, jacobian = linkage.closure(end.angles)
    centres = []
    for number, loop in enumerate(linkage.loops):
        own = jacobian[6 * number : 6 * number + 6, [h for h, _ in loop]]
        middle, moments = np.zeros(3), own[3:].T
        for _ in range(6):
            shift = np.cross(own[:3].T, moments).mean(axis=0)
            middle, moments = middle + shift, moments - np.cross(shift, own[:3].T)
        centres.append((middle, math.sqrt((moments**2).sum(axis=1).mean())))
    return centres


def closure(linkage, end, angles):
    rows = []
    for t, (middle, unit) in zip(opened(linkage, angles), middles(linkage, end), strict=True):
        r, shift = t[:3, :3], (t[:3, 3] + t[:3, :3] @ middle - middle) / unit
        rows.append(np.r_[0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]), shift])
    return np.concatenate(rows)


@pytest.mark.parametrize("name", SAMPLES)
def test_the_equations_are_the_first_two_terms_of_closure(name):
    rng = np.random.default_rng(1)
    for linkage, end in ends(name):
        assert end.exact
        assert end.provable
        direction = rng.normal(size=linkage.n_hinges)
        left, derivative = end.equations(direction)
        course = np.zeros((linkage.n_hinges, 4))
        course[:, 1] = direction
        terms, slopes = np.zeros((SERIES_ORDER_COUNT, 6)), np.zeros((SERIES_ORDER_COUNT, 6, linkage.n_hinges))
        write_series(end.jacobian, end.orders[0], course, np.eye(linkage.n_hinges), terms, slopes)
        np.testing.assert_allclose(left, np.r_[end.across @ terms[1], end.along @ terms[2]], atol=1e-13)
        np.testing.assert_allclose(derivative, np.r_[end.across @ slopes[0], end.along @ slopes[1]], atol=1e-13)
        assert np.abs(end.along @ end.jacobian).max() < 1e-14  # what makes the equations regular at the end
        h = 1e-3
        second = (
            closure(linkage, end, end.angles + h * direction) + closure(linkage, end, end.angles - h * direction)
        ) / 2
        np.testing.assert_allclose(second / h**2, terms[2], atol=1e-4)


@pytest.mark.parametrize("name", SAMPLES)
def test_directions_leave_the_end_within_the_stops(name):
    sample = planned(name)
    for (_, end), line in zip(ends(name), (sample.states, sample.states[::-1]), strict=True):
        direction = end.direction(line[1] - line[0])
        left, _ = end.equations(direction)
        assert np.abs(left).max() < 10 * DEPARTURE_RESIDUAL
        assert np.abs(direction).max() == 1
        turns = direction * np.where(end.angles > 1, -1, 1)
        assert turns.min() >= 0
        assert turns.min() == 0 or turns.min() >= MIN_DEPARTURE_TURN_RATIO / 2


@pytest.mark.parametrize("name", SAMPLES)
def test_closed_states_lie_beside_the_first_step(name):
    for linkage, end, course, departure in departures(name):
        slope = np.abs(course[:, 1]).max()
        _, derivative = end.equations(course[:, 1] / slope)
        inverse = np.linalg.pinv(derivative)
        for part in (1.0, 0.5, 0.2, 0.05):
            share = part * departure.share
            s, y = slope * share, np.zeros(len(end.jacobian))
            state = course @ share ** np.arange(4)
            for _ in range(12):
                left = closure(linkage, end, state + s * inverse @ y)
                y -= np.r_[end.across @ left / s, end.along @ left / s**2]
            # so near to the singular end rounding of T, over s^2, is what can be seen
            blind = 1e-13 / s
            assert np.abs(closure(linkage, end, state + s * inverse @ y)).max() < 1e-13
            assert (np.abs(s * inverse @ y) <= departure.wanders + blind).all()


@pytest.mark.parametrize("name", sorted(SAMPLES)[:2])
def test_the_second_derivative_in_the_directions_of_the_ball_is_that_of_closure(name):
    for linkage, end, course, _ in departures(name):
        slope = np.abs(course[:, 1]).max()
        step = end._step(course / slope ** np.arange(4))
        _, derivative = end.equations(course[:, 1] / slope)
        inverse = np.linalg.pinv(derivative)
        k, h = inverse.shape[1], 1e-3
        bent = np.zeros((k, k, k))
        for i, one in enumerate(inverse.T):
            for j, two in enumerate(inverse.T):
                unit = h / max(np.abs(one).max(), np.abs(two).max())
                around = [
                    closure(linkage, end, end.angles + unit * (a * one + b * two))
                    for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))
                ]
                bent[:, i, j] = (around[0] - around[1] - around[2] + around[3]) / (4 * unit**2)
        for rows, size in ((end.across, step.bent_across), (end.along, step.bent_along)):
            assert np.linalg.norm(np.tensordot(rows, bent, 1)) == pytest.approx(size, rel=1e-2, abs=1e-2)


@given(st.floats(0, 30), st.floats(0, 300), st.floats(0, 3000), st.floats(1e-8, 0.3))
def test_the_rest_of_an_exponential_is_no_more_than_its_bound(b, c, d, s):
    order = 8
    assume(s * b + s * s * c + s**3 * d <= 20)
    terms = np.zeros(120)
    terms[0] = 1.0
    for n in range(1, len(terms)):  # n e_n = b e_(n-1) + 2 c e_(n-2) + 3 d e_(n-3)
        terms[n] = sum(k * x * terms[n - k] for k, x in ((1, b), (2, c), (3, d)) if k <= n) / n
    rest = (terms * s ** np.arange(len(terms)))[order:].sum()
    bound = _rest((b, c, d), s, order)
    assume(bound < math.inf)
    assert rest <= bound * (1 + 1e-9) + 1e-300  # what is less loses its digits


def test_the_bound_of_the_rest_is_near_it_for_steps_as_they_are():
    assert 1e-24 / math.factorial(8) < _rest((1.0, 0.0, 0.0), 1e-3, 8) < 3e-24 / math.factorial(8) * 8
    assert _rest((5.0, 3.0, 2.0), 1e-3, 8) < 1e-20


def test_an_end_off_the_lattice_is_known_but_for_rounding():
    linkage = linkage_named("element-8r")
    end = EndClosure(linkage, linkage.flat, group_of_all(loops_of(linkage)))
    assert not end.exact
    assert end.provable
    moved = linkage.flat.copy()
    moved[0] = 1e-6
    assert not EndClosure(linkage, moved, group_of_all(loops_of(linkage))).provable


def test_a_state_that_is_no_end_proves_nothing():
    sample = planned("hex:0234550132:4")
    linkage: Linkage = sample.linkage
    state = linkage.folded.copy()
    state[0] -= 1e-6
    end = EndClosure(linkage, state, group_of_all(loops_of(linkage)))
    assert not end.provable
    assert end.depart(np.zeros((linkage.n_hinges, 4)) + 1e-3) is None
