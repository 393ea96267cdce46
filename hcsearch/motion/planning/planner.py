"""Search for paths from packed to flat: trees of closed states that grow from several roots until they meet.

The first two roots are packed and flat, the others flat-folded states whose components motions may have to pass. Two
trees at a time grow towards each other. Trees that met are one part (union-find); a pair takes its turn only if one of
its trees is in the part of packed or flat, and the other in another part.

Panels may slide along each other and hinges along their stops, without friction. Springs play no role: a drive can
reach every state of it. A search without a path does not prove that there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.kernels.planning.path_smoothing import relax_path, shorten_path, thin_path
from hcsearch.kernels.planning.space import Space, SpaceWork, StateStack, new_space_work, new_state_stack
from hcsearch.kernels.planning.tree_search import (
    STATE_CELL_WIDTH,
    TREES_FULL,
    TREES_MET,
    Meeting,
    StateTree,
    fan_out,
    new_tree,
    search_trees,
)
from hcsearch.motion.collision.panel_prisms import check_margin
from hcsearch.motion.planning.problems import space_of
from hcsearch.motion.planning.simple_moves import clear_junctions
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.linkage import Linkage

TREE_STATE_CAPACITY = 12000
"""Capacity of a tree (states)."""
PAIR_CALL_ROUNDS, FOREST_CALL_ROUNDS = 50, 10
"""Rounds in one call of the kernel, for which an interrupt waits: with two trees alone, and with two among several."""
ROOT_START_COUNT, MAX_ROOT_TRIES = 30, 400
"""Number of states near a root from which its tree grows, and of tries to reach them."""
MAX_BRIDGE_STATES = 4000
"""Greatest number of states between two trees."""


@dataclass(frozen=True, eq=False)
class TreeConnection(ByValue):
    """The place where two trees met: their numbers, a state of each, and closed states from the first to the second."""

    trees: tuple[int, int]
    nodes: tuple[int, int]
    bridge: Reals

    def turned(self) -> TreeConnection:
        """Return the same connection seen from the second tree."""
        return TreeConnection(self.trees[::-1], self.nodes[::-1], self.bridge[::-1])


class Forest:
    """Trees from roots, shape (k, m); the first two roots are the packed and the flat state."""

    def __init__(self, space: Space, roots: Reals, stack: StateStack, work: SpaceWork) -> None:
        self.space, self.stack, self.work = space, stack, work
        self.trees: list[StateTree] = [new_tree(TREE_STATE_CAPACITY, root) for root in roots]
        self.parts = list(range(len(roots)))
        self.joints: list[TreeConnection] = []
        self.meeting = Meeting(
            np.zeros(2, np.int64), np.zeros((MAX_BRIDGE_STATES, roots.shape[1])), np.zeros(1, np.int64)
        )
        self.turns = 0
        self.full_pairs: set[tuple[int, int]] = set()

    def fan_out(self, seed: int) -> tuple[int, ...]:
        """Add states near each root and drop further roots without any; return their number for each remaining root."""
        starts = [
            int(fan_out(self.space, tree, ROOT_START_COUNT, MAX_ROOT_TRIES, 2 * seed + i, self.stack, self.work))
            for i, tree in enumerate(self.trees)
        ]
        remaining = [i for i, own in enumerate(starts) if own or i < 2]
        self.trees, self.parts = [self.trees[i] for i in remaining], list(range(len(remaining)))
        return tuple(starts[i] for i in remaining)

    @property
    def is_joined(self) -> bool:
        """Whether packed and flat are in one part."""
        return self.parts[0] == self.parts[1]

    @property
    def is_full(self) -> bool:
        """Whether the trees that could take a turn have no room to grow."""
        return not self.is_joined and not self._pairs()

    @property
    def rounds_per_turn(self) -> int:
        """Number of rounds of one turn."""
        return PAIR_CALL_ROUNDS if len(self.trees) == 2 else FOREST_CALL_ROUNDS

    def grow(self, rounds: int, seed: int) -> None:
        """Take one turn: two trees grow for some rounds, or until they meet."""
        pairs = self._pairs()
        pair = pairs[self.turns % len(pairs)]
        self.turns += 1
        trees = self.trees[pair[0]], self.trees[pair[1]]
        state = int(search_trees(self.space, *trees, rounds, seed, self.stack, self.work, self.meeting))
        if state == TREES_MET:
            one, two = self.meeting.nodes.tolist()
            self.joints.append(
                TreeConnection(pair, (one, two), self.meeting.bridge[: int(self.meeting.bridge_size[0])].copy())
            )
            merged, absorbed = sorted(self.parts[i] for i in pair)
            self.parts = [merged if part == absorbed else part for part in self.parts]
        elif state == TREES_FULL:
            self.full_pairs.add(pair)

    def _pairs(self) -> list[tuple[int, int]]:
        """The pairs of trees that may take a turn."""
        ends = {self.parts[0], self.parts[1]}
        return [
            (i, j)
            for i, j in combinations(range(len(self.trees)), 2)
            if self.parts[i] != self.parts[j]
            and {self.parts[i], self.parts[j]} & ends
            and (i, j) not in self.full_pairs
        ]

    def sizes(self) -> tuple[int, int]:
        """Return the numbers of states in the part of packed and in the part of flat."""
        one, two = (sum(int(tree.size[0]) for tree in self._part(end)) for end in (0, 1))
        return one, two

    def clouds(self) -> tuple[Reals, Reals]:
        """Return the states joined to packed, and those joined to flat, shape (k, m) each."""
        one, two = (np.concatenate([tree.angles[: int(tree.size[0])] for tree in self._part(end)]) for end in (0, 1))
        return one, two

    def _part(self, end: int) -> list[StateTree]:
        return [tree for tree, part in zip(self.trees, self.parts, strict=True) if part == self.parts[end]]

    def path(self) -> Reals:
        """Return the states of a path from packed to flat, after these have met."""
        tree, node, lines = 0, 0, []
        for joint in self._route():
            lines += [_between(self.trees[tree], node, joint.nodes[0]), joint.bridge]
            tree, node = joint.trees[1], joint.nodes[1]
        return np.concatenate([*lines, _between(self.trees[tree], node, 0)])

    def _route(self) -> list[TreeConnection]:
        """The connections on the route from the first tree to the second: trees that met form a tree themselves."""
        routes: dict[int, list[TreeConnection]] = {0: []}
        while 1 not in routes:
            for joint in (*self.joints, *(joint.turned() for joint in self.joints)):
                here, there = joint.trees
                if here in routes and there not in routes:
                    routes[there] = [*routes[here], joint]
        return routes[1]


def _between(tree: StateTree, one: int, two: int) -> Reals:
    """The states of a tree from one to another, inclusive."""
    out, back = _branch(tree, one), _branch(tree, two)
    while len(out) > 1 and len(back) > 1 and out[-2] == back[-2]:
        out.pop(), back.pop()
    states: Reals = tree.angles[[*out, *back[-2::-1]]]
    return states


def _branch(tree: StateTree, node: int) -> list[int]:
    """The numbers of the states from a node to the root."""
    nodes: list[int] = []
    while node >= 0:
        nodes.append(node)
        node = int(tree.parents[node])
    return nodes


def forest_roots(ends: Sequence[Reals], junctions: Reals, count: int, seed: int) -> Reals:
    """Return the roots of a forest, shape (k, m): both ends and so many junctions, which rotate with the seed."""
    root_count = min(count, len(junctions))
    numbers = [(seed * root_count + k) % len(junctions) for k in range(root_count)]
    return np.array([*ends, *junctions[numbers]])


PLANNER_STACK_DEPTH = 15
"""Number of states in the kernels' stack."""
PATH_SHORTCUT_TRIES, PATH_RELAXATION_SWEEPS = 60, 8
"""Number of shortcuts that are tried, and of sweeps in which states of a path are moved between their neighbours."""
THINNED_STATE_DISTANCE = 0.03
"""Distance (rad) up to which neighbouring states are left out, where panels still keep apart."""
WISHED_GAP_SHARE = 0.2
"""Gap of shrunk panels up to which contact pushes a path away, over the margin."""
CLOSED_OFF_STATE_SHARE = 0.02
"""A tree is closed off where the second half of the rounds adds less than this share of its states."""


@dataclass(frozen=True)
class TreeGrowth:
    """The growth of the trees in one search.

    starts : states near the packed and near the flat state from which they grew; 0 where the search reached no
    state beyond that end. sizes : numbers of states of both trees, with all trees that met them. rounds : rounds of
    growth in all. late : the share of each tree's states that the second half of the rounds added: 0 for a tree that is
    closed off.
    resolution : rad, width of cells in which states count as alike. full : whether a tree had no more room.
    roots : number of flat-folded states from which further trees grew.
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
        """Whether the tree from packed and the tree from flat stopped growing, at this resolution."""
        return self.late[0] < CLOSED_OFF_STATE_SHARE, self.late[1] < CLOSED_OFF_STATE_SHARE


@dataclass(frozen=True, eq=False)
class PathPlan(ByValue):
    """The result of one search.

    states : the states of a path from packed to flat, (k, n_hinges), or None. growth : the growth of the trees.
    clouds : closed states reached from packed, and closed states reached from flat, (k, n_hinges) each; where there is
    a path, both hold all of them.
    """

    states: Reals | None
    growth: TreeGrowth
    clouds: tuple[Reals, Reals]


class _TreeSearch(SteppedSearch[TreeGrowth]):
    """Trees of a forest that take turns; efforts are rounds."""

    efforts = 0

    def __init__(self, forest: Forest, seed: int) -> None:
        self.forest, self.seed = forest, seed
        self.starts, self.half = forest.fan_out(seed), (0, 0)

    @property
    def done(self) -> bool:
        """Whether packed and flat are joined, or no tree can grow."""
        return not all(self.starts) or self.forest.is_joined or self.forest.is_full

    def step(self, budget: Budget) -> None:
        """Take one turn, which passes neither the middle nor the end of the budget."""
        rounds = int(budget.efforts)
        left = (rounds // 2 if self.efforts < rounds // 2 else rounds) - self.efforts
        turn = min(self.forest.rounds_per_turn, left)
        self.forest.grow(turn, _slice_seed(self.seed, self.efforts))
        self.efforts += turn
        if self.efforts <= rounds // 2:
            self.half = self.forest.sizes()

    @property
    def result(self) -> TreeGrowth:
        """The growth of the trees."""
        sizes = self.forest.sizes()
        late = (1.0 - self.half[0] / sizes[0], 1.0 - self.half[1] / sizes[1])
        starts, roots = (self.starts[0], self.starts[1]), len(self.starts) - 2
        return TreeGrowth(starts, sizes, self.efforts, late, STATE_CELL_WIDTH, self.forest.is_full, roots)


class Planner:
    """Searches for paths of one linkage with panels shrunk by a margin (m) on every face.

    collide : whether panels must keep apart; else they pass through each other, and only loops and stops count. States
    that are not joined then are not joined with any margin, which is evidence of a lock that does not depend on
    contacts.
    """

    def __init__(self, linkage: Linkage, margin: float, *, collide: bool = True) -> None:
        check_margin(linkage, margin)
        self.linkage, self.margin = linkage, margin
        self.space: Space = space_of(linkage, margin, collide=collide)
        self.stack: StateStack = new_state_stack(self.space, PLANNER_STACK_DEPTH)
        self.work: SpaceWork = new_space_work(self.space)

    @cached_property
    def junctions(self) -> Reals:
        """Flat-folded states other than the ends at which panels keep apart, (k, n_hinges)."""
        return clear_junctions(self.linkage, self.space, self.stack)

    def plan(self, budget: Budget, *, roots: int = 0) -> PathPlan:
        """Search for a path; the result depends only on the arguments.

        budget : its efforts are the rounds of all trees. roots : greatest number of junctions as further roots; each
        seed takes others.
        """
        ends = self.space.folded, self.linkage.flat
        if not self.linkage.n_hinges:
            growth = TreeGrowth((0, 0), (1, 1), 0, (0.0, 0.0), STATE_CELL_WIDTH, False)
            return PathPlan(None, growth, (ends[0][None], ends[1][None]))
        root_states = forest_roots(ends, self.junctions, roots, budget.seed) if roots else np.array(ends)
        # the search of a gap begins where the last one ended: reset, so that no plan depends on the one before
        self.stack.corners[:], self.stack.gap_directions[:] = -1, 0.0
        growing = _TreeSearch(Forest(self.space, root_states, self.stack, self.work), budget.seed)
        growth, forest = growing.run(budget), growing.forest
        return PathPlan(self._path(forest.path(), budget.seed) if forest.is_joined else None, growth, forest.clouds())

    def _path(self, states: Reals, seed: int) -> Reals:
        """Shorten and relax a path."""
        path = np.zeros((2 * len(states) + 1000, states.shape[1]))
        path[: len(states)] = states
        between = np.zeros((1000, states.shape[1]))
        count = shorten_path(self.space, path, len(states), PATH_SHORTCUT_TRIES, seed, self.stack, self.work, between)
        count = thin_path(self.space, path, count, THINNED_STATE_DISTANCE, self.stack)
        wished = WISHED_GAP_SHARE * self.margin
        relax_path(self.space, path, count, PATH_RELAXATION_SWEEPS, wished, self.stack, self.work)
        return path[:count].copy()


def _slice_seed(seed: int, rounds_done: int) -> int:
    """The seed of one call of the kernel."""
    return (1_000_003 * seed + rounds_done) % 2**32
