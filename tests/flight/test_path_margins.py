"""Torque margins along paths: at regular states, at singular ends, and with a spring failed."""

import math

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.scenes.laws import law_named, linear_law
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.path_margins import best_rates_along, margins_along, path_rates
from hcsearch.springs.flight.torque_margin import power_ratios
from tests.flight.paths import NAMES, rates_of, springs_of
from tests.flight.random_margins import dual, primal

CLOSE = 1e-8


@pytest.mark.parametrize("name", NAMES)
def test_regular_states_have_the_margins_of_both_linear_programs(name):
    path, (_, torques, friction) = rates_of(name), springs_of(name)
    found = margins_along(path, torques, friction)
    regular = np.flatnonzero(~path.singular)
    assert len(regular) > 10
    for k in regular[::5]:
        state = path.rates.jacobians[k], torques[k], friction, path.senses[k]
        assert found.margins[k] == pytest.approx(primal(*state), rel=CLOSE)
        assert found.bounds[k] == pytest.approx(dual(*state), rel=CLOSE)
        failed = [primal(state[0], torques[k] * working, *state[2:]) for working in 1.0 - np.eye(len(friction))]
        assert found.failed[k] == pytest.approx(min(failed), rel=CLOSE)
        assert failed[found.failed_hinges[k]] == pytest.approx(min(failed), rel=CLOSE)
        losses = friction * np.abs(found.rates[k])
        assert losses[found.hinges[k]] == losses.max()


@pytest.mark.parametrize("name", NAMES)
def test_margins_are_between_the_ratio_along_the_path_and_the_bound(name):
    path, (_, torques, friction) = rates_of(name), springs_of(name)
    found = margins_along(path, torques, friction)
    assert (found.along <= found.margins * (1.0 + CLOSE)).all()
    assert (found.margins <= found.bounds * (1.0 + CLOSE)).all()
    assert (found.failed <= found.failed_bounds * (1.0 + CLOSE)).all()
    assert (found.along > 0.0).sum() > 0.9 * len(found.along)
    working = 1.0 - np.eye(len(friction))
    guided = np.min([power_ratios(torques * own, friction, path.tangents) for own in working], axis=0)
    assert np.allclose(found.along_failed, guided, rtol=CLOSE, atol=CLOSE)
    assert (found.along_failed <= found.failed + CLOSE).all()
    assert np.allclose(power_ratios(torques, friction, found.rates), found.margins, rtol=CLOSE)
    assert np.allclose(
        best_rates_along(path, torques, friction, np.ones((1, len(friction))))[0, ~path.singular],
        found.rates[~path.singular],
    )


@pytest.mark.parametrize("name", NAMES)
def test_motions_at_singular_ends_are_those_of_the_linkage(name):
    """States a little along the rates of an end close with a change of second order."""
    path, (_, torques, friction) = rates_of(name), springs_of(name)
    found = margins_along(path, torques, friction)
    assert set(path.ends) == {0, len(path.angles) - 1}
    for state, sense in ((0, -1.0), (len(path.angles) - 1, 1.0)):  # what opens at the start has folded at the end
        rates = found.rates[state] / np.abs(found.rates[state]).max()
        assert found.margins[state] > 0.0
        moved = []
        for step in (0.02, 0.01):
            guess = path.angles[state] + sense * step * rates
            closed = close_linkage(path.linkage, guess)
            assert closed.closed
            moved.append(np.abs(closed.angles - guess).max())
        assert moved[1] < 0.35 * moved[0] < 0.35 * 0.01


@pytest.mark.parametrize("name", NAMES)
def test_no_motion_at_an_end_exceeds_the_bound_and_few_exceed_the_margin(name):
    """Motions nearest to 100 random rates, found by Newton's method."""
    path, (_, torques, friction) = rates_of(name), springs_of(name)
    found, rng = margins_along(path, torques, friction), np.random.default_rng(5)
    seen = 0
    for state, end in path.ends.items():
        guesses = path.senses[state] * rng.uniform(0.0, 1.0, (100, len(friction)))
        motions = [own for guess in guesses if (own := end._motion_near(guess, regular=True)) is not None]
        if not motions:  # some hinge rests in every motion
            continue
        seen += len(motions)
        ratios = power_ratios(np.tile(torques[state], (len(motions), 1)), friction, np.array(motions))
        assert ratios.max() <= found.bounds[state] * (1.0 + CLOSE)
        assert (ratios > found.margins[state] * (1.0 + CLOSE)).mean() < 0.05
    assert seen > 50


def test_linear_springs_without_preload_have_no_margin_at_the_flat_state():
    path, (_, torques, friction) = rates_of(NAMES[0]), springs_of(NAMES[0], preload=0.0)
    found = margins_along(path, torques, friction)
    assert (found.margins[-1], found.bounds[-1], found.failed_hinges[-1]) == (0.0, 0.0, -1)
    assert (found.least_state, found.least_failed_state) == (len(path.angles) - 1,) * 2


def test_equal_preloads_over_equal_friction_are_the_margin_at_the_flat_state():
    path = rates_of(NAMES[0])
    torques, friction = np.full(path.angles.shape, 0.06), np.full(path.angles.shape[1], 0.01)
    found = margins_along(path, torques, friction)
    assert found.margins[-1] == pytest.approx(6.0, rel=1e-12)
    assert found.bounds[-1] == pytest.approx(6.0, rel=1e-12)


@pytest.mark.parametrize("shape", [(1, 10), (3, 4), (10,)])
def test_paths_of_other_shapes_are_refused(shape):
    linkage = rates_of(NAMES[0]).linkage
    with pytest.raises(HcsearchError, match="give two states or more"):
        path_rates(linkage, np.zeros(shape))


def test_a_state_that_is_there_twice_is_refused():
    path = rates_of(NAMES[0])
    with pytest.raises(HcsearchError, match="leave it out"):
        path_rates(path.linkage, path.angles[[0, 1, 1, 2]])


def test_torques_of_laws_are_their_moments():
    laws = [
        law_named("free"),
        linear_law(0.1, 0.02),
        law_named("table:0@0,0.1@1.5,0.3@3.1"),
        law_named("quadratic:1,2"),
    ]
    angles = np.linspace(math.pi, -0.01, 50)[:, None] * np.ones(4)
    expected = [[law.straight.moment(angle) for law, angle in zip(laws, state, strict=True)] for state in angles]
    assert np.allclose(law_torques(laws, angles), expected, rtol=1e-14)


def test_a_tape_stays_bent_until_it_snaps_back():
    tape = law_named("tape:0.2@0.05,0.03@0.01")
    angles = np.array([3.0, 0.04, tape.snap_down * 1.01, tape.snap_down * 0.99, 0.04, 0.06])
    branches = [tape.bent, tape.bent, tape.bent, tape.straight, tape.straight, tape.bent]
    expected = [branch.moment(angle) for branch, angle in zip(branches, angles, strict=True)]
    assert law_torques([tape], angles[:, None])[:, 0] == pytest.approx(expected)
