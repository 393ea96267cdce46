"""Budgets: the first efforts are those of always, and a search that goes on comes to what one at once comes to."""

from itertools import islice, pairwise

import numpy as np
import pytest

from hcsearch.errors import HcsearchError
from hcsearch.folding import Folding
from hcsearch.planning.motions import motion_of
from hcsearch.planning.schedule import (
    FIRST,
    MOST_BOXES,
    Bisection,
    Floods,
    Moves,
    Trees,
    efforts,
    planned_efforts,
)
from hcsearch.scenes import default_panel

GIVEN_UP = "square:012222300301:2"
"""Undecided with the budget that is given by default, and proved at 0.1 mm with more."""


def test_the_first_efforts_are_those_of_a_search_without_a_budget():
    tight = Trees(widest=False, loose=False, rounds=40, seeds=(0,))
    assert planned_efforts(FIRST) == [
        (tight, Moves(loose=False), Moves(loose=True)),
        (Trees(widest=True, loose=True, rounds=60, seeds=(1, 2, 3)),),
    ]


def test_efforts_that_go_on_have_seeds_of_their_own_and_more_boxes():
    some = list(islice(efforts(), 12))
    trees = [step for effort in some for step in effort if isinstance(step, Trees)]
    for one, two in pairwise(trees):
        assert max(one.seeds) < min(two.seeds)
    assert {one.roots > 0 for one in trees[2:]} == {True, False}
    assert {one.loose for one in trees[2:]} == {True, False}
    assert min(one.rounds for one in trees[2:]) > max(one.rounds for one in trees[:2])
    for panels in (False, True):
        floods = [step for effort in some for step in effort if isinstance(step, Floods) and step.panels == panels]
        boxes = [step.boxes for step in floods]
        assert len(boxes) == len(some) - 2
        assert boxes == sorted(boxes)
        assert boxes[-1] == MOST_BOXES
    assert sum(isinstance(step, Bisection) for effort in some for step in effort) == 1


@pytest.mark.parametrize("done", [0, 1, 2, 5])
def test_a_budget_goes_on_after_what_was_done(done):
    assert planned_efforts(5, done) == planned_efforts(5)[done:]
    assert planned_efforts(2, 5) == []
    with pytest.raises(HcsearchError, match="a budget of -1 efforts"):
        planned_efforts(-1)


def test_what_is_given_up_is_taken_up_again():
    folding, panel = Folding.from_notation(GIVEN_UP), default_panel("square")
    short = motion_of(folding, panel, ("hinged",))
    assert (short.states, short.margin, short.efforts) == (None, None, FIRST)
    on = motion_of(folding, panel, ("hinged",), budget=6, done=short.efforts)
    assert on.margin is not None
    assert FIRST < on.efforts <= 6
    once = motion_of(folding, panel, ("hinged",), budget=6)
    assert (once.efforts, once.margin) == (on.efforts, on.margin)
    assert np.array_equal(once.states, on.states)
    stopped = motion_of(folding, panel, ("hinged",), budget=on.efforts - 1, done=FIRST)
    assert (stopped.margin, stopped.efforts) == (None, on.efforts - 1)
