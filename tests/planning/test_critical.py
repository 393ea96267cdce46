"""Critical margins: against those of trials with other margins, and against what the search itself says at each."""

from dataclasses import replace
from itertools import pairwise

import pytest

from hcsearch.motion.collision.panel_prisms import deepest_margin
from hcsearch.motion.planning.critical import (
    MARGIN_GRID_RATIO,
    CriticalMargin,
    critical_margin,
    critical_margin_grid,
)
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.planning.schedule import BISECTION_TREES
from hcsearch.motion.searching import Budget
from tests.planned import joined

TRIALS = {
    "hex:0232435051:3": (1.3, 1.0),
    "hex:0233350401:3": (1.0, 0.7),
    "hex:0233435001:3": (0.35, 0.25),
    "hex:023242354000:3": (0.18, 0.13),
}
"""Hinged, 50 x 6 mm: least margin (mm) with a path, and greatest below it without one, of trials by hand.

Source: searches of two trees at ten margins, 120 to 200 rounds, 2 to 3 seeds, 2026-11. For square:012123230301:2, :3
and :5 they came to 1.0 and 0.7: there junctions as further roots open all three with 0.01 mm.
"""
OTHERS = {
    "hex:023133355501:3": (None, 2.5),
    "hex:0232335050:2": (None, 2.5),
    "square:012123230301:2": (0.01, None),
    "hex:0234550132:4": (0.01, None),
}


@pytest.mark.parametrize("name", TRIALS)
def test_critical_margins_are_those_of_trials(name):
    found, (path, none) = critical_margin(joined(name, "hinged")), TRIALS[name]
    assert 1e3 * found.least_met <= MARGIN_GRID_RATIO * path
    assert 1e3 * found.greatest_unmet >= none / MARGIN_GRID_RATIO
    assert found.least_met == pytest.approx(MARGIN_GRID_RATIO * found.greatest_unmet)
    assert found.least_proved is None or found.least_proved >= found.least_met


@pytest.mark.parametrize("name", OTHERS)
def test_some_need_no_play_to_speak_of_and_others_are_not_opened_by_any(name):
    found, (path, none) = critical_margin(joined(name, "hinged")), OTHERS[name]
    assert found.least_met == (None if path is None else pytest.approx(1e-3 * path))
    assert found.greatest_unmet == (None if none is None else pytest.approx(1e-3 * none, rel=MARGIN_GRID_RATIO - 1))
    assert found.least_proved is None or found.least_met <= found.least_proved <= MARGIN_GRID_RATIO**3 * found.least_met
    assert (found.least_proved is None) == (path is None)


def test_what_is_said_of_margins_is_what_the_search_comes_to():
    linkage, looking = joined("hex:0232435051:3", "hinged"), replace(BISECTION_TREES, rounds=100, seeds=(0, 1), roots=2)
    found = critical_margin(linkage, looking)
    assert found == critical_margin(linkage, looking)
    assert found.trees == looking
    assert found.greatest_unmet < found.least_met <= found.least_proved

    def paths(margin):
        planner = Planner(linkage, margin)
        plans = [planner.plan(Budget(100, seed=seed), roots=2).states for seed in range(2)]
        return [states for states in plans if states is not None]

    assert not paths(found.greatest_unmet)
    assert paths(found.least_met)
    margins = critical_margin_grid(linkage)
    assert found.least_proved in margins
    assert Prover(linkage).prove(found.states, margins).margin == found.least_proved


def test_margins_leave_something_of_a_panel():
    linkage = joined("hex:0234435011:3", "hinged")
    margins = critical_margin_grid(linkage)
    assert margins[0] == pytest.approx(1e-5)
    assert all(two == pytest.approx(MARGIN_GRID_RATIO * one) for one, two in pairwise(margins))
    assert deepest_margin(linkage) / MARGIN_GRID_RATIO**2 < margins[-1] < deepest_margin(linkage)


def test_a_lesser_margin_is_one_that_is_proved_then_one_that_is_met():
    looking = BISECTION_TREES
    proved, worse = CriticalMargin(1e-4, 1e-4, None, looking, 1), CriticalMargin(2e-4, 1e-5, None, looking, 1)
    met, none = CriticalMargin(None, 1e-5, None, looking, 1), CriticalMargin(None, None, 1e-3, looking, 1)
    ordered = [proved, worse, met, none]
    for one, two in pairwise(ordered):
        assert one.less_than(two)
        assert not two.less_than(one)


def test_the_path_of_the_least_margin_is_a_proved_one():
    linkage = joined("square:012123230301:2", "hinged")
    found = critical_margin(linkage)
    assert Prover(linkage).prove(found.states, [found.least_proved]).margin == found.least_proved
