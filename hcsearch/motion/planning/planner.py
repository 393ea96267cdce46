"""Paths from the packed to the flat state of a linkage: trees of closed states that grow until these are joined.

Panels may slide along each other and hinges along their stops, without friction. A tree knows no springs: what it
reaches, a drive can reach. Where it finds no path that is no proof that there is none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.equality import ByValue
from hcsearch.kernels.planning.smoothing import relax_path, shorten_path, thin_path
from hcsearch.kernels.planning.space import Space, SpaceWork, StateStack, new_space_work, new_state_stack
from hcsearch.kernels.planning.trees import STATE_CELL_WIDTH
from hcsearch.motion.collision.margins import check_margin
from hcsearch.motion.planning.forests import Forest, forest_roots
from hcsearch.motion.planning.junctions import clear_junctions
from hcsearch.motion.planning.problems import space_of
from hcsearch.shape.linkage import Linkage

PLANNER_STACK_DEPTH = 15
"""States that the kernels work with."""
PATH_SHORTCUT_TRIES, PATH_RELAXATION_SWEEPS = 60, 8
"""Shortcuts that are tried, and how often states of a path are moved between their neighbours."""
THINNED_STATE_DISTANCE = 0.03
"""States nearer to each other than this (rad) are left out, where panels keep apart without."""
WISHED_GAP_SHARE = 0.2
"""Gap of shrunk panels up to which contact pushes a path away, over the margin."""
CLOSED_OFF_STATE_SHARE = 0.02
"""A tree is closed off where the second half of the rounds brings less than this share of its states."""


@dataclass(frozen=True)
class TreeGrowth:
    """What the trees came to.

    starts : states near the packed and near the flat state from which they grew; without any, the search came to no
    state beyond that end. sizes : states of both trees, with those of trees that met them. rounds : how often one grew.
    late : the share of the states of each that the second half of the rounds brought: a tree that is closed off brings
    none. resolution : rad, width of cells by which states count as alike. full : whether a tree had no more room.
    roots : flat-folded states from which further trees grew.
    """

    starts: tuple[int, int]
    sizes: tuple[int, int]
    rounds: int
    late: tuple[float, float]
    resolution: float
    full: bool
    roots: int = 0

    @property
    def closed_off(self) -> tuple[bool, bool]:
        """Whether the tree from the packed and that from the flat state stopped growing, to the resolution tried."""
        return self.late[0] < CLOSED_OFF_STATE_SHARE, self.late[1] < CLOSED_OFF_STATE_SHARE


@dataclass(frozen=True, eq=False)
class PathPlan(ByValue):
    """What one search came to.

    states : of a path, (k, n_hinges), from packed to flat, or None. growth : what the trees came to. clouds : closed
    states that were reached from packed, and those that were from flat, (k, n_hinges) each; where there is a path, all
    of them both times.
    """

    states: Reals | None
    growth: TreeGrowth
    clouds: tuple[Reals, Reals]


class Planner:
    """Searches for paths of one linkage with panels shrunk by a margin (m) on every face.

    collide : whether panels must keep apart; else they pass through each other, and only loops and stops count. What is
    not joined then is joined with no margin, which is evidence of a lock that contacts have no part in.
    """

    def __init__(self, linkage: Linkage, margin: float, *, collide: bool = True) -> None:
        check_margin(linkage, margin)
        self.linkage, self.margin = linkage, margin
        self.space: Space = space_of(linkage, margin, collide=collide)
        self.stack: StateStack = new_state_stack(self.space, PLANNER_STACK_DEPTH)
        self.work: SpaceWork = new_space_work(self.space)

    @cached_property
    def junctions(self) -> Reals:
        """Flat-folded states beside the ends at which panels keep apart, (k, n_hinges)."""
        return clear_junctions(self.linkage, self.space, self.stack)

    def plan(self, rounds: int, seed: int = 0, *, roots: int = 0) -> PathPlan:
        """Search for a path for some rounds; the same for the same seed.

        roots : of how many junctions trees grow, too, at most; each seed takes others. Rounds are those of all trees.
        """
        ends = self.space.folded, self.linkage.flat
        if not self.linkage.n_hinges:
            growth = TreeGrowth((0, 0), (1, 1), 0, (0.0, 0.0), STATE_CELL_WIDTH, False)
            return PathPlan(None, growth, (ends[0][None], ends[1][None]))
        further = forest_roots(ends, self.junctions, roots, seed) if roots else np.array(ends)
        # the search of a gap begins where the last one ended: anew, so that no plan hangs on the one before
        self.stack.corners[:], self.stack.ways[:] = -1, 0.0
        forest = Forest(self.space, further, self.stack, self.work)
        starts = forest.fan_out(seed)
        half, done = (0, 0), 0
        while done < rounds and all(starts) and not forest.met and not forest.full:
            own = min(forest.slice, (rounds // 2 if done < rounds // 2 else rounds) - done)
            forest.grow(own, _slice_seed(seed, done))
            done += own
            if done <= rounds // 2:
                half = forest.sizes()
        sizes = forest.sizes()
        late = (1.0 - half[0] / sizes[0], 1.0 - half[1] / sizes[1])
        growth = TreeGrowth((starts[0], starts[1]), sizes, done, late, STATE_CELL_WIDTH, forest.full, len(starts) - 2)
        return PathPlan(self._path(forest.path(), seed) if forest.met else None, growth, forest.clouds())

    def _path(self, states: Reals, seed: int) -> Reals:
        """A path, shortened and relaxed."""
        path = np.zeros((2 * len(states) + 1000, states.shape[1]))
        path[: len(states)] = states
        between = np.zeros((1000, states.shape[1]))
        count = shorten_path(self.space, path, len(states), PATH_SHORTCUT_TRIES, seed, self.stack, self.work, between)
        count = thin_path(self.space, path, count, THINNED_STATE_DISTANCE, self.stack)
        wished = WISHED_GAP_SHARE * self.margin
        relax_path(self.space, path, count, PATH_RELAXATION_SWEEPS, wished, self.stack, self.work)
        return path[:count].copy()


def _slice_seed(seed: int, done: int) -> int:
    """A seed for each call of the kernel."""
    return (1_000_003 * seed + done) % 2**32
