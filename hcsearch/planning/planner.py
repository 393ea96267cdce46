"""Paths from the packed to the flat state of a linkage: two trees of closed states that grow until they meet.

Panels may slide along each other and hinges along their stops, without friction. A tree knows no springs: what it
reaches, a drive can reach. Where it finds no path that is no proof that there is none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.collision.margins import check_margin
from hcsearch.equality import ByValue
from hcsearch.kernels.planning.search import FULL, MET, Meeting, fan_out, search
from hcsearch.kernels.planning.smoothing import relax, shorten, thin
from hcsearch.kernels.planning.space import Space, SpaceWork, Stack, new_stack, new_work
from hcsearch.kernels.planning.trees import CELL, StateTree, new_tree
from hcsearch.linkage import Linkage
from hcsearch.planning.problems import space_of
from hcsearch.typing import Reals

CAPACITY = 12000
"""States that a tree holds."""
SLICE = 50
"""Rounds in one call of the kernel: an interrupt waits no longer than these."""
STARTS, TRIES = 30, 400
"""States near an end from which its tree grows, and how many are tried."""
DEPTH = 15
"""States that the kernels work with."""
SHORTCUTS, SWEEPS = 60, 8
"""Shortcuts that are tried, and how often states of a path are moved between their neighbours."""
THIN = 0.03
"""States nearer to each other than this (rad) are left out, where panels keep apart without."""
WISHED = 0.2
"""Gap of shrunk panels up to which contact pushes a path away, over the margin."""
CLOSED_OFF = 0.02
"""A tree is closed off where the second half of the rounds brings less than this share of its states."""


@dataclass(frozen=True)
class Growth:
    """What the trees came to.

    starts : states near the packed and near the flat state from which they grew; without any, the search came to no
    state beyond that end. sizes : states of both trees. rounds : how often one grew. late : the share of the states of
    each that the second half of the rounds brought: a tree that is closed off brings none. resolution : rad, width of
    cells by which states count as alike. full : whether a tree had no more room.
    """

    starts: tuple[int, int]
    sizes: tuple[int, int]
    rounds: int
    late: tuple[float, float]
    resolution: float
    full: bool

    @property
    def closed_off(self) -> tuple[bool, bool]:
        """Whether the tree from the packed and that from the flat state stopped growing, to the resolution tried."""
        return self.late[0] < CLOSED_OFF, self.late[1] < CLOSED_OFF


@dataclass(frozen=True, eq=False)
class PathPlan(ByValue):
    """What one search came to: states of a path, (k, n_hinges), from packed to flat, or None; and the trees."""

    states: Reals | None
    growth: Growth


class Planner:
    """Searches for paths of one linkage with panels shrunk by a margin (m) on every face."""

    def __init__(self, linkage: Linkage, margin: float) -> None:
        check_margin(linkage, margin)
        self.linkage, self.margin = linkage, margin
        self.space: Space = space_of(linkage, margin)
        self.stack: Stack = new_stack(self.space, DEPTH)
        self.work: SpaceWork = new_work(self.space)

    def plan(self, rounds: int, seed: int = 0) -> PathPlan:
        """Search for a path for some rounds; the same for the same seed."""
        m = self.linkage.n_hinges
        if not m:
            return PathPlan(None, Growth((0, 0), (1, 1), 0, (0.0, 0.0), CELL, False))
        # the search of a gap begins where the last one ended: anew, so that no plan hangs on the one before
        self.stack.corners[:], self.stack.ways[:] = -1, 0.0
        flat = np.zeros(m)
        trees = new_tree(CAPACITY, self.space.folded), new_tree(CAPACITY, flat)
        starts = (
            int(fan_out(self.space, trees[0], STARTS, TRIES, 2 * seed, self.stack, self.work)),
            int(fan_out(self.space, trees[1], STARTS, TRIES, 2 * seed + 1, self.stack, self.work)),
        )
        if not all(starts):
            return PathPlan(None, self._growth(starts, trees, 0, (0, 0), False))
        meeting = Meeting(np.zeros(2, np.int64), np.zeros((4000, m)), np.zeros(1, np.int64))
        half, done, state = (0, 0), 0, -1
        while done < rounds:
            own = min(SLICE, (rounds // 2 if done < rounds // 2 else rounds) - done)
            state = int(search(self.space, *trees, own, _slice_seed(seed, done), self.stack, self.work, meeting))
            done += own
            if state in (MET, FULL):
                break
            if done <= rounds // 2:
                half = int(trees[0].size[0]), int(trees[1].size[0])
        growth = self._growth(starts, trees, done, half, state == FULL)
        return PathPlan(self._path(trees, meeting, seed) if state == MET else None, growth)

    def _growth(
        self,
        starts: tuple[int, int],
        trees: tuple[StateTree, StateTree],
        rounds: int,
        half: tuple[int, int],
        full: bool,
    ) -> Growth:
        sizes = int(trees[0].size[0]), int(trees[1].size[0])
        late = (1.0 - half[0] / sizes[0], 1.0 - half[1] / sizes[1])
        return Growth(starts, sizes, rounds, late, CELL, full)

    def _path(self, trees: tuple[StateTree, StateTree], meeting: Meeting, seed: int) -> Reals:
        """The path through both trees, shortened and relaxed."""
        bridge = meeting.bridge[: int(meeting.filled[0])]
        states = np.concatenate(
            [_branch(trees[0], meeting.nodes[0])[::-1], bridge, _branch(trees[1], meeting.nodes[1])]
        )
        path = np.zeros((2 * len(states) + 1000, states.shape[1]))
        path[: len(states)] = states
        between = np.zeros((1000, states.shape[1]))
        count = shorten(self.space, path, len(states), SHORTCUTS, seed, self.stack, self.work, between)
        count = thin(self.space, path, count, THIN, self.stack)
        wished = WISHED * self.margin
        relax(self.space, path, count, SWEEPS, wished, self.stack, self.work)
        return path[:count].copy()


def _branch(tree: StateTree, node: int) -> Reals:
    """The states from a node to the root."""
    states = []
    while node >= 0:
        states.append(tree.angles[node].copy())
        node = int(tree.parents[node])
    return np.array(states)


def _slice_seed(seed: int, done: int) -> int:
    """A seed for each call of the kernel."""
    return (1_000_003 * seed + done) % 2**32
