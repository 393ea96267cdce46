"""Paths of simple moves, and the groups in which their loops close: against naive products of matrices."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.planning.closed_states import close_state, new_closing
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover
from hcsearch.motion.planning.problems import group_of, group_of_all, loops_of, turns_equally
from hcsearch.motion.planning.simple_moves import simple_path
from tests.naive import around_the_loop
from tests.planned import Planned, along, joined, open_by

SINGULAR = [
    *(f"square:012222230000:{crease}" for crease in (0, 2, 3, 5)),
    *(f"square:01222300:{crease}" for crease in range(4)),
    *(
        f"square:{rest}"
        for rest in ("0112223300:0", "0112223300:3", "0122323001:3", "011122233300:2", "011122233300:5")
    ),
    *(f"rectangle:01222300:{crease}" for crease in (2, 3)),
    "hex:0233335000:1",
]
"""Foldings whose loops close in fewer equations than six throughout a path, or that pass through such states."""


def simple(name, margin=CERTIFIED_MARGINS[-1]):
    linkage = joined(name, "rigid")
    states = simple_path(linkage, margin)
    return linkage, states


@pytest.mark.parametrize("name", SINGULAR)
def test_foldings_with_singular_paths_are_proved_by_simple_moves(name):
    linkage, states = simple(name)
    proof = Prover(linkage).prove(states, CERTIFIED_MARGINS)
    assert proof.margin in CERTIFIED_MARGINS
    assert proof.exact
    assert proof.slack < 1e-8
    sample = Planned(linkage, states, proof)
    moments = along(sample, np.linspace(0, proof.motion.times[-1], 2000))
    assert open_by(linkage, moments).max() < 2 * proof.slack + 1e-9
    assert moments.min() >= -proof.stop_excess
    assert moments.max() <= math.pi + proof.stop_excess
    assert (moments[0] == linkage.folded).all()
    assert (moments[-1] == 0).all()


def test_such_a_folding_has_a_proved_motion_at_once():
    folding = Folding.from_notation("square:01222300:0")
    motion = plan_motion(folding, default_panel("square"), ("rigid", "hinged"))
    assert motion.way == "rigid"
    assert motion.margin == CERTIFIED_MARGINS[0]


def flat_folded(name):
    """The flat-folded states of a path of simple moves."""
    linkage, states = simple(name)
    stops = np.where(states > 1.0, math.pi, 0.0)
    return linkage, stops[np.abs(states - stops).max(axis=1) < 1e-9]


@pytest.mark.parametrize("name", SINGULAR[::3])
def test_equal_turns_close_loops_where_they_are_said_to_and_nowhere_else(name):
    linkage, states = flat_folded(name)
    rng = np.random.default_rng(5)
    found = 0
    for state in states:
        end = whole_end(linkage, state)
        some = [c for k in (2, 3, 4) for c in combinations(range(linkage.n_hinges), k)]
        moving = np.array([np.isin(np.arange(linkage.n_hinges), c) for c in some])
        turns = moving * np.where(state > 1.0, -1.0, 1.0) * rng.uniform(0.1, 3.0, (3, len(some), 1))
        closed = open_by(linkage, state + turns).max(axis=0) < 1e-12
        assert [turns_equally(end, own) for own in moving] == closed.tolist()
        found += closed.sum()
    assert found


@pytest.mark.parametrize("name", SINGULAR[::3])
def test_loops_of_some_hinges_stay_in_their_group_whatever_these_turn_by(name):
    linkage, states = flat_folded(name)
    loops, rng = loops_of(linkage), np.random.default_rng(7)
    lines = linkage.directions, linkage.points / linkage.pattern.size
    dimensions = set()
    for one, two in pairwise(states):
        moving = one != two
        end = whole_end(linkage, one)
        group = group_of(linkage, loops, end, moving, linkage.closure(one)[1])
        assert (group.moving == moving).all()
        np.testing.assert_allclose(group.rows @ group.rows.T, np.eye(len(group.rows)), atol=1e-14)
        angles = one + moving * rng.uniform(-1, 1, linkage.n_hinges)
        matrix = around_the_loop(*lines, linkage.loops[0], angles)
        twist = np.r_[
            0.5 * (matrix[2, 1] - matrix[1, 2]),
            0.5 * (matrix[0, 2] - matrix[2, 0]),
            0.5 * (matrix[1, 0] - matrix[0, 1]),
            matrix[:3, 3],
        ]
        dimensions.add(len(group.rows))
        if len(group.rows) == 3:  # a plane motion: all of its twist is seen by three equations
            assert np.linalg.norm(twist) == pytest.approx(np.linalg.norm(group.rows @ twist), abs=1e-13)
        # rank in the group is rank at all
        _, jacobian = linkage.closure(one)
        jacobian[:, ~moving] = 0.0
        assert np.linalg.matrix_rank(group.rows @ jacobian, 1e-9) == np.linalg.matrix_rank(jacobian, 1e-9)
    assert dimensions <= {1, 3}


def test_hinges_in_two_directions_close_in_the_group_of_all_motions():
    linkage = joined("square:012222230000:0", "rigid")
    state = linkage.folded.astype(float)
    moving = np.ones(linkage.n_hinges, bool)
    loops = loops_of(linkage)
    group = group_of(linkage, loops, whole_end(linkage, state), moving, linkage.closure(state)[1])
    assert group.rows.shape == group_of_all(loops).rows.shape == (6, 6)


def test_hinges_that_are_held_do_not_turn_where_loops_are_closed():
    linkage, states = flat_folded("hex:0233335000:1")
    moving = states[0] != states[1]
    work = new_closing(loops_of(linkage))
    work.fixed[:] = ~moving
    state = states[0] + moving * np.where(states[0] > 1.0, -0.4, 0.4)
    state[np.flatnonzero(moving)[0]] += 1e-3
    assert close_state(loops_of(linkage), state, 1e-13, 0.0, 40, work)
    assert (state[~moving] == states[0][~moving]).all()


def test_a_folding_without_simple_moves_has_no_such_path():
    linkage = joined("hex:0234435011:3", "hinged")
    assert simple_path(linkage, CERTIFIED_MARGINS[0]) is None
