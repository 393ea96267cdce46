"""Planning: paths are what they should be, none is found where none can be, and a search can be stopped."""

import math
import signal
import time
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.kernels.collision.gaps import deepest_overlap
from hcsearch.motion.collision.panel_prisms import prisms_of
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.planning.motion_search import plan_motion, reason_of
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.planning.problems import kept_apart, space_of
from hcsearch.motion.searching import Budget
from tests.planned import SAMPLES, joined, open_by, planned
from tests.strategies import words

WAYS = ("rigid", "hinged", "merged")
LISTS = [("hex", 8), ("hex", 10), ("square", 8), ("square", 10), ("square", 12), ("rectangle", 8), ("triangle", 14)]


@pytest.mark.parametrize("name", SAMPLES)
def test_a_path_is_made_of_closed_states_with_panels_apart(name):
    sample = planned(name)
    linkage, states, margin = sample.linkage, sample.states, SAMPLES[name][1]
    assert (states[0] == linkage.folded).all()
    assert (states[-1] == 0).all()
    assert open_by(linkage, states).max() < 1e-8
    assert states.min() >= 0
    assert states.max() <= math.pi
    assert np.abs(np.diff(states, axis=0)).max() <= 0.15
    space = space_of(linkage, margin)
    assert deepest_overlap(linkage.chain, prisms_of(linkage, margin), space.pairs, states) == 0
    panels = space.prisms.panels[space.pairs]
    assert not {tuple(sorted(pair)) for pair in panels.tolist()} & kept_apart(linkage)


def test_the_same_seed_gives_the_same_path():
    linkage = joined("square:012233230011:4", "rigid")
    one, two = (Planner(linkage, 1e-5).plan(Budget(100, seed=seed)) for seed in (3, 3))
    assert (one.states == two.states).all()
    assert one.growth == two.growth
    again = Planner(linkage, 1e-5)
    again.plan(Budget(60, seed=8))
    # what was searched before leaves nothing behind
    assert (again.plan(Budget(100, seed=3)).states == one.states).all()


def test_the_same_folding_gives_the_same_motion():
    folding = foldings(Circuit.from_notation("hex:0234550132").canonical())[0]
    one, two = (plan_motion(folding, default_panel("hex"), WAYS) for _ in range(2))
    assert (one.way, one.margin) == (two.way, two.margin)
    assert (one.proof is None) == (two.proof is None)
    if one.proof is not None:
        assert (one.proof.motion.angles == two.proof.motion.angles).all()


def test_a_way_that_cannot_be_has_no_motion():
    folding = next(
        f for word in words("hex", 10) for f in foldings(Circuit(GRIDS["hex"], word)) if not f.can_join("merged")
    )
    motion = plan_motion(folding, default_panel("hex"), ("merged",))
    assert (motion.way, motion.states, motion.proof, motion.margin, motion.growths) == (None, None, None, None, ())
    assert motion.efforts == 0
    assert reason_of(motion) == "no path was searched for: the folding has no mirror pairs of panels to merge"


def test_a_margin_that_leaves_nothing_of_a_panel_is_refused():
    with pytest.raises(HcsearchError, match="a margin of"):
        Planner(joined("hex:02234400:1", "hinged"), 0.1)


def test_a_search_can_be_interrupted():
    planner = Planner(joined("hex:02234400:1", "rigid"), 1e-5)
    planner.plan(Budget(50))  # compiled
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    begin = time.process_time()
    try:
        with pytest.raises(KeyboardInterrupt):
            planner.plan(Budget(10**9))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert time.process_time() - begin < 5


def hopeless(folding):
    """The ways in which a folding has no path: all of a twisted one, and those in which an end is locked."""
    panel = default_panel(folding.circuit.grid.name)
    linkages = []
    for way in WAYS:
        if folding.can_join(way):
            linkage = folding.linkage(panel, flat_pairs=way)
            locked = any(lock_at(linkage, angles).order is not None for angles in (linkage.folded, linkage.flat))
            if twist(folding) or locked:
                linkages.append((way, linkage))
    return linkages


@cache
def planners():
    """Planners for all hopeless ways of the foldings of `LISTS`, with the least and the greatest margin."""
    listed = [folding for key in LISTS for word in words(*key) for folding in foldings(Circuit(GRIDS[key[0]], word))]
    return [
        ((folding.notation, way, margin), Planner(linkage, margin))
        for folding in listed
        for way, linkage in hopeless(folding)
        for margin in (1e-5, 1e-4)
    ]


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.integers(0, 10**6))
def test_twisted_and_locked_foldings_get_no_path(number, seed):
    what, planner = planners()[number % len(planners())]
    assert planner.plan(Budget(60, seed=seed)).states is None, (what, seed)


@pytest.mark.slow
def test_ten_thousand_tries_of_twisted_and_locked_foldings_get_no_path():
    """Of the paths that other foldings of these lists have after 60 rounds, two rounds give more than half."""
    rng, every = np.random.default_rng(11), planners()
    for _ in range(10_000):
        what, planner = every[rng.integers(len(every))]
        seed = int(rng.integers(10**6))
        assert planner.plan(Budget(2, seed=seed)).states is None, (what, seed)


def test_a_search_without_a_path_says_which_trees_stopped_growing():
    """The tree from the packed state of the first is closed off by its panels; both of the second go on growing."""
    linkage = joined("hex:022444551022:4", "rigid")
    growth = Planner(linkage, 1e-5).plan(Budget(40)).growth
    assert growth.closed_off == (True, False)
    assert growth.rounds == 40
    growth = Planner(joined("hex:022243445001:5", "hinged"), 1e-4).plan(Budget(60, seed=1)).growth
    assert growth.closed_off == (False, False)
    assert 0 < min(growth.late) <= max(growth.late) < 1
