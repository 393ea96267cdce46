"""Parts of the closed states: states belong to the one to which small steps lead."""

import numpy as np
import pytest

from hcsearch.kernels.enclosure.refutation import new_refutation, reaches_closed_state
from hcsearch.kernels.enclosure.wandering import MAX_GOAL_STEP, approach_goal
from hcsearch.motion.locks.boxes import whole_box
from hcsearch.motion.locks.regions import ARRIVED_DISTANCE, StateParts
from hcsearch.motion.searching import Budget
from tests.locks.test_regions import held, open_by_states
from tests.planned import joined, region_of, walks_of

LOCKED = "hex:0233435001:2"
"""Its ends are proved to be in two parts (test_regions)."""


def apart(one, other):
    """How far states are from another, root of the sum of squares."""
    return np.sqrt(((one - other) ** 2).sum(axis=-1))


def test_steps_lead_to_states_of_the_same_part_and_not_to_others():
    linkage = joined(LOCKED, "hinged")
    rings, walks = walks_of(linkage, 2_000)
    work, led = new_refutation(rings), 0
    for number in range(0, 2_000, 400):
        start, goal = walks[0][number], walks[0][number + 100]
        states, steps = approach_goal(rings, start, goal, 3000, number, work)
        assert 0 < steps <= 3000
        assert np.array_equal(states[0], start)
        assert open_by_states(linkage, states).max() < 1e-6
        assert (np.diff(apart(states, goal)) < 0.0).all()
        assert np.abs(np.diff(states, axis=0)).max(initial=0.0) <= 1.5 * MAX_GOAL_STEP
        led += apart(states[-1], goal) < ARRIVED_DISTANCE
        other = walks[1][np.argmin(apart(walks[1], start))]
        assert apart(approach_goal(rings, start, other, 3000, number, work)[0][-1], other) > ARRIVED_DISTANCE
    assert led > 2


def test_states_are_added_to_the_part_to_which_steps_lead():
    rings, walks = walks_of(joined(LOCKED, "hinged"), 20_000)
    parts = StateParts(rings, walks[0][:2_000], walks[1][:2_000], 1, new_refutation(rings))
    known = [len(part) for part in parts.states]
    for number in range(3_000, 20_000, 4_000):
        for side in (0, 1):
            assert parts.add_state(walks[side][number], whole_box(rings.hinge_count)) == side
    assert len(parts.states) == 2
    assert all(len(part) > before for part, before in zip(parts.states, known, strict=True))
    assert parts.steps > 8 * 2_000


@pytest.mark.parametrize("name", ["hex:0233545012:2", "hex:0233534001:3"])
def test_a_state_is_not_of_the_part_of_its_nearest_state_if_no_steps_lead_there(name):
    linkage = joined(name, "hinged")
    region = region_of(linkage, 0, 5_000)
    assert region.run(Budget(100_000))
    rings, walks = walks_of(linkage, 5_000)
    own, others = walks[0][::500], walks[1][::500]
    rng, box, work, misled = np.random.default_rng(1), whole_box(rings.hinge_count), new_refutation(rings), []
    while len(misled) < 5:
        state = rng.uniform(0.0, np.pi, rings.hinge_count)
        if reaches_closed_state(rings, *box, state, work) and apart(own, state).min() < apart(others, state).min():
            misled += [] if held(region, state[None])[0] else [state]
    # they are outside what is proved to hold all that the packed end leads to
    for state in misled:
        assert StateParts(rings, own, others, 1, work).add_state(state, box) != 0


def test_a_state_to_which_no_steps_lead_is_a_part_by_itself():
    rings, walks = walks_of(joined(LOCKED, "hinged"), 2_000)
    packed, flat = walks
    parts = StateParts(rings, packed[:1_000], packed[1_000:1_100], 1, new_refutation(rings))
    assert parts.add_state(flat[0], whole_box(rings.hinge_count)) == 2
    assert np.array_equal(parts.states[2][0], flat[0])
