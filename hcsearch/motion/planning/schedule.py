"""The schedule of the search for a folding's motion: a sequence of efforts, which a budget cuts off.

A search with a greater budget continues after the efforts already made, so that an undecided folding can be searched
further without repeating them. The result of an effort does not depend on when the efforts before it were made.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice
from typing import ClassVar

from hcsearch.basics.errors import HcsearchError


@dataclass(frozen=True)
class MovesStep:
    """Simple moves in every way. loose : whether the margin is the greatest; else the least that is stated."""

    words: ClassVar[str] = "trying simple moves"
    loose: bool


@dataclass(frozen=True)
class FloodStep:
    """Proofs that loops and stops lock the folding.

    boxes : number of boxes for each way of joining flat pairs. panels : whether the proof also uses panels that do not
    pass through each other, at the greatest margin.
    """

    words: ClassVar[str] = "searching for a proof of a lock"
    boxes: int
    panels: bool = False


@dataclass(frozen=True)
class TreeStep:
    """Searches by trees of states.

    widest : whether only the widest way of joining flat pairs is searched, which allows all motions of the others; else
    every way. loose : whether the margin is the greatest; else the least that is stated. rounds, seeds : rounds and
    seeds of each search. roots : number of junctions as further roots of trees.
    """

    words: ClassVar[str] = "searching for a path"
    widest: bool
    loose: bool
    rounds: int
    seeds: tuple[int, ...]
    roots: int = 0


@dataclass(frozen=True)
class BisectionStep:
    """Search for the critical margin."""

    words: ClassVar[str] = "searching for the least play"


EffortStep = MovesStep | FloodStep | TreeStep | BisectionStep

TIGHT_SEARCH_ROUNDS, LOOSE_SEARCH_ROUNDS, LONG_SEARCH_ROUNDS = 40, 60, 300
"""Rounds of the first, second and later searches."""
SEARCH_ROOT_COUNT = 6
"""Number of junctions in one search."""
DEFAULT_EFFORT_BUDGET = 2
"""The default budget."""
SEARCH_SEED_COUNT = 3
"""Number of seeds in an effort."""
BISECTION_TREES = TreeStep(
    widest=True, loose=False, rounds=LONG_SEARCH_ROUNDS, seeds=tuple(range(SEARCH_SEED_COUNT)), roots=SEARCH_ROOT_COUNT
)
"""The search with each margin of a bisection."""
FIRST_FLOOD_BOXES, FLOOD_BOX_GROWTH = 100_000, 6
"""Boxes of the first floods, and the growth factor of boxes from one effort to the next."""


def all_efforts() -> Iterator[tuple[EffortStep, ...]]:
    """Yield all efforts in order, each as its steps, without end.

    A proof that a folding is locked ends the search, as a proved path does. A proof that uses panels holds up to
    a margin, so that the first comes after the critical margin, which gives a sufficient play. Trees come before
    simple moves, whose paths lead through singular states, where drives cannot control them. From the third effort on
    floods take ever more boxes, and trees have new seeds: with junctions as further roots, then without, and
    every third time with the least margin, by which paths are better.
    """
    trees = TreeStep(widest=False, loose=False, rounds=TIGHT_SEARCH_ROUNDS, seeds=(0,))
    yield trees, MovesStep(loose=False), MovesStep(loose=True)
    yield (TreeStep(widest=True, loose=True, rounds=LOOSE_SEARCH_ROUNDS, seeds=(1, 2, 3)),)
    for k in count():
        boxes = FIRST_FLOOD_BOXES * FLOOD_BOX_GROWTH**k
        loose, roots = ((True, SEARCH_ROOT_COUNT), (True, 0), (False, SEARCH_ROOT_COUNT))[k % 3]
        first = 100 * (k + 1)  # other seeds than in the first two efforts, which add tens where a proof fails
        seeds = tuple(range(first, first + SEARCH_SEED_COUNT))
        trees = TreeStep(widest=True, loose=loose, rounds=LONG_SEARCH_ROUNDS, seeds=seeds, roots=roots)
        free, blocked = FloodStep(boxes), FloodStep(boxes, panels=True)
        yield (free, trees, BisectionStep(), blocked) if k == 0 else (free, blocked, trees)


def planned_efforts(budget: int, done: int = 0) -> list[tuple[EffortStep, ...]]:
    """Return the efforts of a budget, without the first `done` ones."""
    if budget < 0 or done < 0:
        raise HcsearchError(f"a budget of {budget} efforts after {done} is none: give 0 or more of each")
    return list(islice(all_efforts(), done, budget))
