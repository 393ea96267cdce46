"""Switch states: hinges leave their stops together, and the path goes through the state at which they do."""

import math
from itertools import pairwise

import numpy as np

from hcsearch.kernels.planning.closed_states import largest_closure_residual, new_closing
from hcsearch.motion.planning import stretches
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover
from hcsearch.motion.planning.problems import loops_of
from hcsearch.motion.planning.stretches import switch_between
from tests.planned import planned

SWITCHED = "square:012123230301:1"


def stopped(state):
    return np.isin(state, (0.0, math.pi))


def switches_of(sample):
    """Steps of a path in which hinges leave or reach their stops, and the switch states of those that have one."""
    loops = loops_of(sample.linkage)
    states = Prover(sample.linkage).whole.closed_states(sample.states)
    for one, two in pairwise(states[1:-1]):
        yield one, two, switch_between(loops, one, two, new_closing(loops))


def test_a_switch_state_is_closed_and_has_the_stops_of_both_states():
    sample = planned(SWITCHED)
    loops, count = loops_of(sample.linkage), 0
    for one, two, switch in switches_of(sample):
        if (stopped(one) == stopped(two)).all():
            assert switch is None
        if switch is None:
            continue
        count += 1
        assert largest_closure_residual(loops, switch, new_closing(loops)) < 1e-13
        assert (stopped(switch) >= stopped(one) | stopped(two)).all()
        assert switch.min() >= 0
        assert switch.max() <= math.pi
        ways = np.linalg.norm(switch - one), np.linalg.norm(switch - two)
        assert min(ways) > 0
        assert max(ways) <= 2 * np.linalg.norm(two - one)
    assert count


def test_a_path_through_a_switch_state_is_proved_with_it_alone(monkeypatch):
    sample = planned(SWITCHED)
    assert sample.proof.margin == CERTIFIED_MARGINS[0]
    monkeypatch.setattr(stretches, "MAX_SWITCH_STATES", 0)
    assert Prover(sample.linkage).prove(sample.states, CERTIFIED_MARGINS).margin is None
