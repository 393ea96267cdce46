"""Coarse and fine floods of cubes from an end of the motion, which enclose all states that can be reached from it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.enclosure import flooding
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.flooding import (
    COUNT_BOXES,
    COUNT_HEAD,
    COUNT_TAIL,
    COUNT_TESTED_FACES,
    Flood,
    new_flood,
    spread_flood,
)
from hcsearch.kernels.enclosure.refutation import Refutation
from hcsearch.motion.locks.boxes import MAX_BOX_ANGLE
from hcsearch.motion.searching import UNBOUNDED, Budget, SteppedSearch

FLOOD_GRID_ANGLES = (0.15, 0.4, 0.8, 1.2), (0.075, 0.15, 0.275, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4)
"""Grid angles of cubes from either stop (rad), of coarse and of fine floods: narrow cubes hold hinges that hardly leave
a stop."""
MISSED_CUBES_RATIO = 3.0
"""Greatest ratio of a flood's cubes to the cubes that a walk visits, if the flood holds only reachable parts."""
WAITING_FACE_COST_RATIO = 3.0
"""Approximate cost of a waiting face over the cost of a tested one, in boxes."""
SETTLED_FLOOD_BOXES = 300_000
"""Number of boxes after which the estimate should grow no more; until then it often does, even if the flood ends."""
FLOOD_CUBE_CAPACITY = 200_000
"""Maximum number of cubes of a flood."""
BOXES_PER_KERNEL_CALL = 10_000
"""Boxes in one call of the kernel: an interrupt waits no longer than these take, some tenths of a second."""


@dataclass(eq=False)
class CubeFlood(SteppedSearch[bool]):
    """A flood from an end (side 0 packed, 1 flat), coarse or fine (level), which is allocated at its first turn.

    Its efforts are boxes; its result is whether it has ended without the other end.
    new_tables : factory of the tables of its search. cubes_expected : estimate of its final number of cubes, or None.
    state : the state of the kernel.
    progress_at_doubling : numbers of boxes, cubes and tested cubes when the boxes had last doubled.
    """

    rings: HingeRings
    side: int
    level: int
    start: Reals
    goal: Reals
    new_tables: Callable[[], Refutation]
    flood: Flood | None = None
    search: Refutation | None = None
    cubes_expected: float | None = None
    state: int = flooding.FLOOD_GOING
    progress_at_doubling: tuple[int, int, int] = (0, 0, 0)

    @property
    def efforts(self) -> int:
        """Number of boxes tested so far."""
        return self._count(COUNT_BOXES)

    @property
    def cubes(self) -> int:
        """Number of cubes flooded so far."""
        return self._count(COUNT_TAIL)

    @property
    def faces(self) -> int:
        """Number of faces tested so far."""
        return self._count(COUNT_TESTED_FACES)

    def _count(self, entry: int) -> int:
        return 0 if self.flood is None else int(self.flood.counts[entry])

    @property
    def done(self) -> bool:
        """Whether the flood has ended."""
        return self.state != flooding.FLOOD_GOING

    @property
    def result(self) -> bool:
        """Whether the flood has ended without the other end."""
        return self.state == flooding.FLOOD_ENCLOSED

    def run(self, budget: Budget = UNBOUNDED) -> bool:
        """Advance the flood by one turn."""
        if self.efforts >= 2 * self.progress_at_doubling[0]:
            self.progress_at_doubling = self._progress
        return super().run(budget)

    def step(self, budget: Budget) -> None:
        """Make one call of the kernel."""
        if self.flood is None or self.search is None:
            self.flood = new_flood(self.start, self.goal, flood_grid(self.level), FLOOD_CUBE_CAPACITY)
            self.search = self.new_tables()
            if (self.flood.cubes[0] == self.flood.goal).all():  # both ends lie in one cube
                self.state = flooding.FLOOD_REACHED
                return
        pause = int(min(self.efforts + BOXES_PER_KERNEL_CALL, budget.efforts))
        self.state = int(spread_flood(self.rings, self.flood, pause, self.search))

    @property
    def boxes_expected(self) -> float:
        """Estimate of the total number of boxes at the end of the flood.

        It assumes the expected number of cubes. A walk misses some; where the flood has many more already, cubes have
        let it into other parts of the closed states, and it will take many more than these. Where the estimate grew
        since the last doubling of boxes, it is extrapolated with the same growth for each remaining doubling.
        """
        if self.flood is None or self.cubes_expected is None:
            return math.inf
        estimate, earlier_estimate = self._expected_at(*self._progress), self._expected_at(*self.progress_at_doubling)
        if not self.efforts > self.progress_at_doubling[0] > SETTLED_FLOOD_BOXES:
            return estimate
        doublings = math.log(max(estimate / self.efforts, 1.0)) / math.log(self.efforts / self.progress_at_doubling[0])
        return estimate * math.pow(max(estimate / earlier_estimate, 1.0), doublings)

    @property
    def _progress(self) -> tuple[int, int, int]:
        """Numbers of boxes tested, cubes flooded, and cubes whose faces were all tested."""
        return self.efforts, self.cubes, self._count(COUNT_HEAD)

    def _expected_at(self, boxes: int, cubes: int, tested: int) -> float:
        """Estimate of the total number of boxes from the progress at some time and the current estimate of cubes."""
        assert self.cubes_expected is not None
        final_cubes = max(self.cubes_expected, cubes, cubes**2 / (MISSED_CUBES_RATIO * self.cubes_expected))
        return WAITING_FACE_COST_RATIO * boxes * final_cubes / max(tested, 0.5)

    @property
    def bounds(self) -> tuple[Reals, Reals]:
        """Lowest and highest angles of the cubes."""
        assert self.flood is not None
        cubes, grid = self.flood.cubes[: self.cubes].astype(np.int64), self.flood.grid
        return grid[cubes], grid[cubes + 1]


def floods_from(rings: HingeRings, ends: tuple[Reals, Reals], new_tables: Callable[[], Refutation]) -> list[CubeFlood]:
    """Coarse and fine floods from the packed and the flat end, not yet started."""
    levels = range(len(FLOOD_GRID_ANGLES))
    return [
        CubeFlood(rings, side, level, ends[side], ends[1 - side], new_tables) for side in (0, 1) for level in levels
    ]


def flood_grid(level: int) -> Reals:
    """Grid angles of the cubes of a flood, from 0 to `MAX_BOX_ANGLE`."""
    cuts = np.array(FLOOD_GRID_ANGLES[level])
    return np.concatenate([[0.0], cuts, math.pi - cuts[::-1], [MAX_BOX_ANGLE]])


def expected_cube_counts(states: Reals) -> list[float]:
    """Estimate the number of cubes of each grid that hold reachable states, from the states of a walk, (m, n).

    The estimator uses the numbers of cubes visited once and twice. Source: A. Chao, Scand. J. Statist. 11 (1984) 265.
    """
    expected = []
    for level in range(len(FLOOD_GRID_ANGLES)):
        cubes = np.searchsorted(flood_grid(level), states, side="right")
        visits = np.unique(cubes, axis=0, return_counts=True)[1]
        once, twice = ((visits == k).sum() for k in (1, 2))
        expected.append(len(visits) + once * (once - 1) / (2.0 * (twice + 1)))
    return expected
