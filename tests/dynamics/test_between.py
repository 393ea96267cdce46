"""Closed states between those of a motion: where they are put, and that they belong to it."""

import numpy as np
import pytest

from hcsearch.kernels.multibody.events import INTERPOLATED_STATE_RESIDUAL, largest_opening
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.dynamics.time_integration import closed_between
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]


def deployed(name, tolerance, formulation="constrained"):
    return simulate_deployment(linkage_named(name), DEFAULT, formulation, tolerance=tolerance, certified=False)


def own_opening(system, states, cubic=False):
    tree = system.mechanism.tree
    return largest_opening(tree, states, cubic, work_for(tree))


@pytest.mark.parametrize("name", ["hex:0234550132:4", "hex:022344440011:1", "hex:0233340501:3"])
def test_closed_states_come_between_where_loops_open(name):
    deployment = deployed(name, 1e-4)
    system, motion, linkage = deployment.compiled.system, deployment.motion, deployment.compiled.linkage
    before = own_opening(system, (motion.times, motion.q, motion.v, motion.a))
    (times, q, v, a), gaps = closed_between(system, motion)
    after = gaps.max()
    assert before > INTERPOLATED_STATE_RESIDUAL
    assert after == own_opening(system, (times, q, v, a))
    assert after < max(1.1 * INTERPOLATED_STATE_RESIDUAL, 0.1 * before)
    assert len(times) > len(motion.times)
    assert (np.diff(times) >= 0.0).all()
    # the states there were are all there, in their order
    rows = {row.tobytes(): k for k, row in enumerate(np.column_stack([times, q, v, a]))}
    old = [rows[row.tobytes()] for row in np.column_stack([motion.times, motion.q, motion.v, motion.a])]
    assert old == sorted(old)
    # the others are closed, near the motion, and move along its loops
    new = np.setdiff1d(np.arange(len(times)), old)
    exact = deployed(name, 1e-9).motion
    early = new[times[new] < 0.5 * min([event.time for event in motion.events], default=times[-1])]
    for k in new:
        angles, rates = deployment.compiled.of_hinges(q[k : k + 1], v[k : k + 1])
        residual, jacobian = linkage.closure(angles[0])
        assert np.abs(residual).max() < 1e-11
        assert np.abs(jacobian @ rates[0]).max() < 1e-9 * max(1.0, np.abs(rates).max())
    assert np.abs(q[early] - exact.at(times[early])).max(initial=0.0) < 1e-3


def test_motions_whose_loops_stay_closed_stay_as_they_are():
    deployment = deployed("hex:0234550132:4", 1e-9)
    (times, q, v, a), gaps = closed_between(deployment.compiled.system, deployment.motion)
    assert gaps.max() < INTERPOLATED_STATE_RESIDUAL
    for table, own in zip((times, q, v, a), ("times", "q", "v", "a"), strict=True):
        assert table.tobytes() == getattr(deployment.motion, own).tobytes()


@pytest.mark.parametrize("method", ["implicit", "dormand-prince-8"])
def test_motions_without_inertia_have_closed_rates_and_states_between(method):
    """By cubics: the implicit method once gave them rates of hundreds of rad/s, and long steps opened the loops."""
    linkage = linkage_named("hex:0234550132:4")
    deployment = simulate_deployment(linkage, DEFAULT, "quasistatic", method=method)
    exact = simulate_deployment(linkage, DEFAULT, "quasistatic", tolerance=1e-10, certified=False).motion
    (times, q, v, _), gaps = closed_between(deployment.compiled.system, deployment.motion)
    moving = times < 0.9 * times[-1]
    assert len(times) > len(deployment.motion.times)
    assert gaps.max() < 2.0 * INTERPOLATED_STATE_RESIDUAL
    assert np.abs(q[moving] - exact.at(times[moving])).max() < 1e-3
    for k in np.flatnonzero(moving):
        angles, rates = deployment.compiled.of_hinges(q[k : k + 1], v[k : k + 1])
        assert np.abs(linkage.closure(angles[0])[1] @ rates[0]).max() < 1e-6 * np.abs(rates).max()
    assert deployment.clearance.kind == "clear"


def test_springs_across_the_loops_close_them_as_they_do():
    deployment = deployed("hex:0234550132:4", 1e-3, "compliant")
    motion, system = deployment.motion, deployment.compiled.system
    (times, *_), gaps = closed_between(system, motion)
    assert times.tobytes() == motion.times.tobytes()
    assert gaps.max() > INTERPOLATED_STATE_RESIDUAL
    # what a step opens is computed with its neighbours, and never less than it is
    own = [
        own_opening(system, tuple(t[k : k + 2] for t in (motion.times, motion.q, motion.v, motion.a))) for k in range(5)
    ]
    assert len(gaps) == len(times) - 1
    assert 0.0 < max(own) <= gaps[0] < gaps.max()
