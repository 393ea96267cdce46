"""Lower bounds of margins between the states of a path, against closed states in between."""

import math

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.linkage.courses import COURSE_TERM_COUNT
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.scenes.laws import law_named, linear_law
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight import certified_margins
from hcsearch.springs.flight.certified_margins import certified_margin, steepest_slopes, wander_of
from hcsearch.springs.flight.torque_margin import (
    allowed_senses,
    closed_rates,
    torque_margins,
    torque_margins_failed,
)
from hcsearch.springs.flight.travel import states_at
from tests.flight.paths import NAMES, springs_of
from tests.planned import along, planned


def bounded(name, laws, friction, enough=(math.inf, math.inf)):
    sample = planned(name)
    wander = wander_of(sample.linkage, sample.proof.slack)
    assert wander == pytest.approx(sample.wander)
    return certified_margin(
        sample.linkage,
        sample.proof.motion,
        wander,
        lambda angles: law_torques(laws, angles),
        steepest_slopes(laws),
        friction,
        enough,
    )


def margins_at(linkage, states, laws, friction):
    """The least margins at some states, with all springs and with the worst one failed."""
    rates = closed_rates(np.array([linkage.closure(state)[1] for state in states]))
    program = rates, law_torques(laws, states), friction, allowed_senses(states)
    whole = torque_margins(*program)
    return whole.margins.min(), torque_margins_failed(*program, whole).margins.min()


@pytest.mark.parametrize("name", NAMES)
def test_no_closed_state_between_the_gaps_has_less(name):
    """Closed states at 2,000 times of the proved motion, nearer to it than the wander."""
    sample, (laws, _, friction) = planned(name), springs_of(name)
    found = bounded(name, laws, friction)
    times = np.random.default_rng(1).uniform(*sample.proof.motion.times[[0, -1]], 2000)
    for start, end in found.gaps:
        times = times[(times < start) | (times > end)]
    assert len(times) > 1900
    assert found.certified > 0.99
    states = np.array([close_linkage(sample.linkage, state).angles for state in along(sample, times)])
    dense, failed = margins_at(sample.linkage, states, laws, friction)
    assert found.bound <= dense
    assert found.bound >= 0.9 * min(found.least, dense)
    assert found.least <= dense * 1.05
    assert found.failed <= failed
    assert found.failed >= 0.9 * min(found.least_failed, failed)
    assert found.failed <= found.bound


@pytest.mark.parametrize("name", NAMES)
def test_weakest_states_have_the_least_margins(name):
    sample, (laws, _, friction) = planned(name), springs_of(name)
    found = bounded(name, laws, friction)
    for time, least, which in ((found.weakest, found.least, 0), (found.weakest_failed, found.least_failed, 1)):
        state = states_at(sample.proof.motion, np.array([time]))
        assert np.allclose(state, along(sample, np.array([time])), atol=1e-12)
        assert margins_at(sample.linkage, state, laws, friction)[which] == pytest.approx(least, rel=1e-6)


def test_enough_leaves_bounds_that_are_good_enough():
    laws, _, friction = springs_of(NAMES[0])
    whole, enough = bounded(NAMES[0], laws, friction), (1.0, 0.5)
    found = bounded(NAMES[0], laws, friction, enough)
    assert found.intervals < whole.intervals
    assert (found.bound, found.failed) >= enough
    assert found.bound <= whole.least
    assert found.failed <= whole.least_failed


def test_boxes_hold_the_polynomials():
    polynomials = np.random.default_rng(4).normal(size=(5, 3, COURSE_TERM_COUNT))
    intervals = certified_margins._Intervals(
        np.array([0, 3, 4]), np.array([0.0, 0.25, 0.5]), np.array([1.0, 0.5, 0.75])
    )
    boxes = certified_margins._boxes_of(polynomials, intervals, 0.1)
    u, powers = np.linspace(-1.0, 1.0, 50), np.arange(COURSE_TERM_COUNT)
    for k, (step, start, end) in enumerate(zip(intervals.steps, intervals.starts, intervals.ends, strict=True)):
        shares = 0.5 * (start + end) + 0.5 * (end - start) * u
        values = polynomials[step] @ shares ** powers[:, None]
        left = np.abs(values - boxes.middles[k][:, None] - np.outer(boxes.drifts[k], u)).max(axis=1)
        assert (left <= boxes.rests[k] - 0.1 + 1e-12).all()
        assert boxes.middles[k] == pytest.approx(polynomials[step] @ (0.5 * (start + end)) ** powers)


def test_without_preload_bounds_fall_to_0_towards_the_flat_end():
    laws, _, friction = springs_of(NAMES[0], preload=0.0)
    found = bounded(NAMES[0], laws, friction)
    assert found.least < 1e-4
    assert 0.0 < found.bound < 1e-2
    assert found.gaps[-1][1] == planned(NAMES[0]).proof.motion.times[-1]


def test_slopes_are_the_steepest():
    laws = [
        law_named(text) for text in ("free", "linear:0.1+0.5", "quadratic:0.1,0.2", "table:0@0,0.1@1.5,0.9@2,1@3.1")
    ]
    angles = np.linspace(-0.01, math.pi + 0.01, 20_001)
    for law, slope in zip(laws, steepest_slopes(laws), strict=True):
        steepest = np.abs(np.diff([law.straight.moment(angle) for angle in angles]) / np.diff(angles)).max()
        assert steepest <= slope * (1.0 + 1e-9)
        assert slope <= steepest * 1.001 + 1e-12


def test_laws_that_snap_are_refused():
    with pytest.raises(HcsearchError, match="without a snap"):
        steepest_slopes([linear_law(0.1), law_named("tape:0.2@0.05,0.03@0.01")])
