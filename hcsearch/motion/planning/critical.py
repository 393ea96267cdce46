"""The critical margin of a linkage: the least play that opens it, and the greatest for which no path was found.

Panels shrunk by more have all motions of panels shrunk by less, so the least margin with a path is found by bisection,
on a grid of margins that is the same for all linkages up to their scale. At this margin a path is proved. Below it
there is only a search that found no path (docs/explanation/motion.md), with its cost. With more play there is more to
search, so that a path may be found with less play, and none with the greatest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.motion.collision.panel_prisms import MIN_PANEL_MARGIN, check_margin, scale_of
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.planning.schedule import BISECTION_TREES, TreeStep
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.linkage import Linkage

MARGIN_GRID_RATIO = 1.3
"""Ratio of a margin to the one before it."""
MAX_TRIED_MARGIN_SHARE = 0.97
"""Greatest tried margin, as a share of the margin that leaves nothing of a panel."""
MARGIN_LIST_PARTS = 4
"""A first path is searched for at the ends of this many parts of the list of margins, the greatest margin first."""


@dataclass(frozen=True, eq=False)
class CriticalMargin(ByValue):
    """The play that opens a linkage.

    least_proved : m, the least margin of the grid with a proved path, None without one. least_met : m, the least margin
    with a path that was found, proved or not. greatest_unmet : m, the greatest margin below `least_met` for which the
    search found no path, or of all where it found none; None where it found one at the least margin. trees : the trees
    of each search. searches : number of searches, each with one margin. states : the states, (k, n_hinges), of the path
    that is proved at the least margin, as it was found.
    """

    least_proved: float | None
    least_met: float | None
    greatest_unmet: float | None
    trees: TreeStep
    searches: int
    states: Reals | None = None

    def less_than(self, other: CriticalMargin) -> bool:
        """Whether this linkage opens with less play than another: by proved margins, then by margins of paths met."""
        return (_last(self.least_proved), _last(self.least_met)) < (_last(other.least_proved), _last(other.least_met))


def critical_margin_grid(linkage: Linkage) -> tuple[float, ...]:
    """Margins to try (m), in ascending order: 0.01 mm for edges of 50 mm, then a factor of `MARGIN_GRID_RATIO` each."""
    greatest, margins = MAX_TRIED_MARGIN_SHARE * check_margin(linkage, MIN_PANEL_MARGIN * scale_of(linkage)), []
    margin = MIN_PANEL_MARGIN * scale_of(linkage)
    while margin < greatest:
        margins.append(margin)
        margin *= MARGIN_GRID_RATIO
    return tuple(margins)


def critical_margin(linkage: Linkage, trees: TreeStep = BISECTION_TREES) -> CriticalMargin:
    """Find the least play that opens a linkage, and the greatest below it for which no path was found.

    The widest way of joining flat pairs, which allows all motions of the others, needs the least play:
    `motion_search._widest`.
    """
    return _Bisection(linkage, trees).run()


class _Bisection(SteppedSearch[CriticalMargin]):
    """Bisection over the list of margins; efforts are searches, each with one margin.

    met, proved : index of the least margin with a path that is found, or proved; the list's length where it is unknown.
    failed : indices of margins for which the search found no path. next : index of the margin of the next search.
    """

    efforts = 0

    def __init__(self, linkage: Linkage, trees: TreeStep) -> None:
        self.linkage, self.trees, self.prover = linkage, trees, Prover(linkage)
        self.margins = critical_margin_grid(linkage)
        self.met = self.proved = len(self.margins)
        self.states: Reals | None = None
        self.failed: list[int] = []
        self._places = self._order()
        self.next = next(self._places, None)

    @property
    def unmet(self) -> int:
        """The greatest index below `met` at which no path was found, -1 without one."""
        return max((place for place in self.failed if place < self.met), default=-1)

    def _order(self) -> Iterator[int]:
        """Yield places: down to the least margin at which a path is met; then to the least at which one is proved."""
        top = len(self.margins) - 1
        for place in sorted({top * k // MARGIN_LIST_PARTS for k in range(MARGIN_LIST_PARTS + 1)}, reverse=True):
            yield place
            if self.met <= top:
                break
        else:
            return
        while self.met - self.unmet > 1:
            yield (self.unmet + self.met) // 2
        low = self.met
        while self.proved - low > 1:  # a proof may fail at more play than a proved path has: that costs a place or two
            middle = (low + self.proved) // 2
            yield middle
            low = middle if self.proved > middle else low

    @property
    def done(self) -> bool:
        """Whether both margins are found."""
        return self.next is None

    @property
    def result(self) -> CriticalMargin:
        """The margins that are known."""
        top = len(self.margins) - 1
        lowest = self.unmet if self.met <= top else top
        proved, met, unmet = map(self._margin, (self.proved, self.met, lowest))
        return CriticalMargin(proved, met, unmet, self.trees, self.efforts, self.states)

    def _margin(self, place: int) -> float | None:
        return self.margins[place] if 0 <= place < len(self.margins) else None

    def step(self, budget: Budget) -> None:
        """Search with a margin until a path is proved. A path may be clear with less play, too."""
        place = self.next
        assert place is not None
        self.efforts += 1
        planner, met = Planner(self.linkage, self.margins[place]), False
        for seed in self.trees.seeds:
            states = planner.plan(Budget(self.trees.rounds, seed=seed), roots=self.trees.roots).states
            if states is None:
                continue
            met, self.met = True, min(self.met, place)
            # a path that is not quite clear at its margin may be clear at the next one
            margin = self.prover.prove(states, self.margins[self.unmet + 1 : place + 2]).margin
            if margin is not None:
                if self.margins.index(margin) < self.proved:
                    self.proved, self.states = self.margins.index(margin), states
                self.met = min(self.met, self.proved)
                break
        if not met:
            self.failed.append(place)
        self.next = next(self._places, None)


def _last(margin: float | None) -> float:
    """A margin as a key by which unknown ones come last."""
    return math.inf if margin is None else margin
