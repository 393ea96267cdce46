"""Budgets: the first efforts are those of always, and a search that goes on comes to what one at once comes to."""

from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.motion.locks.enclosures import Enclosure
from hcsearch.motion.planning import motion_search
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_motion, reason_of
from hcsearch.motion.planning.planner import TreeGrowth
from hcsearch.motion.planning.schedule import (
    DEFAULT_EFFORT_BUDGET,
    BisectionStep,
    FloodStep,
    MovesStep,
    TreeStep,
    all_efforts,
    planned_efforts,
)
from hcsearch.search.stages.motion import _batch

GROWN = TreeGrowth((1, 1), (2, 2), 3, (0.0, 0.0), 0.15, False)
GIVEN_UP = "square:012222300301:2"
"""Undecided with the budget that is given by default, and proved at 0.1 mm with more."""


def test_the_first_efforts_are_those_of_a_search_without_a_budget():
    tight = TreeStep(widest=False, loose=False, rounds=40, seeds=(0,))
    assert planned_efforts(DEFAULT_EFFORT_BUDGET) == [
        (tight, MovesStep(loose=False), MovesStep(loose=True)),
        (TreeStep(widest=True, loose=True, rounds=60, seeds=(1, 2, 3)),),
    ]


def test_efforts_that_go_on_have_seeds_of_their_own_and_more_boxes():
    some = list(islice(all_efforts(), 12))
    trees = [step for effort in some for step in effort if isinstance(step, TreeStep)]
    for one, two in pairwise(trees):
        assert max(one.seeds) < min(two.seeds)
    assert {one.roots > 0 for one in trees[2:]} == {True, False}
    assert {one.loose for one in trees[2:]} == {True, False}
    assert min(one.rounds for one in trees[2:]) > max(one.rounds for one in trees[:2])
    for panels in (False, True):
        floods = [step for effort in some for step in effort if isinstance(step, FloodStep) and step.panels == panels]
        boxes = [step.boxes for step in floods]
        assert len(boxes) == len(some) - 2
        assert all(two == 6 * one for one, two in pairwise(boxes))
    assert sum(isinstance(step, BisectionStep) for effort in some for step in effort) == 1


@pytest.mark.parametrize("done", [0, 1, 2, 5])
def test_a_budget_goes_on_after_what_was_done(done):
    assert planned_efforts(5, done) == planned_efforts(5)[done:]
    assert planned_efforts(2, 5) == []
    with pytest.raises(HcsearchError, match="a budget of -1 efforts"):
        planned_efforts(-1)


def test_what_is_given_up_is_taken_up_again():
    folding, panel = Folding.from_notation(GIVEN_UP), default_panel("square")
    short = plan_motion(folding, panel, ("hinged",))
    assert (short.states, short.margin, short.efforts) == (None, None, DEFAULT_EFFORT_BUDGET)
    on = plan_motion(folding, panel, ("hinged",), budget=6, done=short.efforts)
    assert on.margin is not None
    assert DEFAULT_EFFORT_BUDGET < on.efforts <= 6
    once = plan_motion(folding, panel, ("hinged",), budget=6)
    assert (once.efforts, once.margin) == (on.efforts, on.margin)
    assert np.array_equal(once.states, on.states)
    stopped = plan_motion(folding, panel, ("hinged",), budget=on.efforts - 1, done=DEFAULT_EFFORT_BUDGET)
    assert (stopped.margin, stopped.efforts) == (None, on.efforts - 1)


@pytest.mark.parametrize("ways", [("rigid", "hinged"), ("rigid",)])
def test_panels_lock_what_closed_states_join(monkeypatch, ways):
    """Of its own search only the floods with panels."""
    monkeypatch.setattr(motion_search, "planned_efforts", lambda *_: [(FloodStep(10_000, panels=True),)])
    folding = Folding.from_notation("hex:0233435001:3")
    motion = plan_motion(folding, default_panel("hex"), ways)
    assert motion.locked
    assert [way for way, _ in motion.locks] == list(ways)
    assert motion.lock == motion.locks[-1]
    assert motion.lock[1].margin == pytest.approx(1e-4)
    reason = reason_of(motion)
    assert reason.startswith("locked by collision at margins up to 0.1 mm, as panels, loops and stops")
    assert reason.endswith(f"with {ways[-1]} flat pairs from the packed state, by 16 cubes of fold angles")
    (own,) = _batch([motion], [None]).evidence
    assert (own.lock.margin, own.lock.decides) == (motion.lock[1].margin, True)


def test_several_locks_hold_at_the_least_margin_of_all():
    locks = (("rigid", Enclosure("flat", 1, 8, 9, False, 1e-4)), ("merged", Enclosure("packed", 2, 8, 9, False)))
    motion = PlannedMotion(None, None, None, (), locks=locks, locked=True)
    assert motion.lock == ("merged", replace(locks[1][1], margin=1e-4))
    assert replace(motion, locked=False).lock == locks[1]
    hinged = replace(motion, locks=(locks[0], ("hinged", locks[1][1])))
    assert hinged.lock == hinged.locks[1]
    assert replace(motion, locks=()).lock is None
    left = replace(motion, locked=False, locks=locks[:1], growths=(("hinged", GROWN),))
    assert "there is none with rigid flat pairs at margins up to 0.1 mm" in reason_of(left)
