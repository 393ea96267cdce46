"""Trees of closed states from several roots, and where they met: a path runs where packed and flat are joined.

The first two roots are packed and flat, the others flat-folded states through whose parts motions may have to pass. Two
trees at a time grow towards each other. Trees that met are one part; a pair takes its turn only if one of its trees is
in the part of packed or flat, and the other in another part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.equality import ByValue
from hcsearch.kernels.planning.search import TREES_FULL, TREES_MET, Meeting, fan_out, search_trees
from hcsearch.kernels.planning.space import Space, SpaceWork, StateStack
from hcsearch.kernels.planning.trees import StateTree, new_tree

TREE_STATE_CAPACITY = 12000
"""States that a tree holds."""
PAIR_CALL_ROUNDS, FOREST_CALL_ROUNDS = 50, 10
"""Rounds in one call of the kernel, for which an interrupt waits: of two trees alone, and of two among several."""
ROOT_START_COUNT, MAX_ROOT_TRIES = 30, 400
"""States near a root from which its tree grows, and how many are tried."""
MAX_BRIDGE_STATES = 4000
"""States between two trees, at most."""


@dataclass(frozen=True, eq=False)
class TreeConnection(ByValue):
    """Where two trees met: their numbers, a state of each, and closed states from the first of these to the second."""

    trees: tuple[int, int]
    nodes: tuple[int, int]
    bridge: Reals

    def turned(self) -> TreeConnection:
        """The same from the second tree."""
        return TreeConnection(self.trees[::-1], self.nodes[::-1], self.bridge[::-1])


class Forest:
    """Trees from some roots, shape (k, m), of which the first two are the packed and the flat state."""

    def __init__(self, space: Space, roots: Reals, stack: StateStack, work: SpaceWork) -> None:
        self.space, self.stack, self.work = space, stack, work
        self.trees: list[StateTree] = [new_tree(TREE_STATE_CAPACITY, root) for root in roots]
        self.parts = list(range(len(roots)))
        self.joints: list[TreeConnection] = []
        self.meeting = Meeting(
            np.zeros(2, np.int64), np.zeros((MAX_BRIDGE_STATES, roots.shape[1])), np.zeros(1, np.int64)
        )
        self.turns = 0
        self.done: set[tuple[int, int]] = set()

    def fan_out(self, seed: int) -> tuple[int, ...]:
        """Add states near each root, and leave further roots without any out; how many, for each root that is left."""
        starts = [
            int(fan_out(self.space, tree, ROOT_START_COUNT, MAX_ROOT_TRIES, 2 * seed + i, self.stack, self.work))
            for i, tree in enumerate(self.trees)
        ]
        left = [i for i, own in enumerate(starts) if own or i < 2]
        self.trees, self.parts = [self.trees[i] for i in left], list(range(len(left)))
        return tuple(starts[i] for i in left)

    @property
    def met(self) -> bool:
        """Whether packed and flat are in one part."""
        return self.parts[0] == self.parts[1]

    @property
    def full(self) -> bool:
        """Whether trees that could take a turn have no room to grow."""
        return not self.met and not self._pairs()

    @property
    def slice(self) -> int:
        """Rounds of one turn."""
        return PAIR_CALL_ROUNDS if len(self.trees) == 2 else FOREST_CALL_ROUNDS

    def grow(self, rounds: int, seed: int) -> None:
        """One turn: two trees grow for some rounds, or until they meet."""
        pairs = self._pairs()
        pair = pairs[self.turns % len(pairs)]
        self.turns += 1
        trees = self.trees[pair[0]], self.trees[pair[1]]
        state = int(search_trees(self.space, *trees, rounds, seed, self.stack, self.work, self.meeting))
        if state == TREES_MET:
            one, two = self.meeting.nodes.tolist()
            self.joints.append(
                TreeConnection(pair, (one, two), self.meeting.bridge[: int(self.meeting.filled[0])].copy())
            )
            kept, gone = sorted(self.parts[i] for i in pair)
            self.parts = [kept if part == gone else part for part in self.parts]
        elif state == TREES_FULL:
            self.done.add(pair)

    def _pairs(self) -> list[tuple[int, int]]:
        """Pairs of trees that may take a turn."""
        ends = {self.parts[0], self.parts[1]}
        return [
            (i, j)
            for i, j in combinations(range(len(self.trees)), 2)
            if self.parts[i] != self.parts[j] and {self.parts[i], self.parts[j]} & ends and (i, j) not in self.done
        ]

    def sizes(self) -> tuple[int, int]:
        """States of the trees in the part of packed, and in that of flat."""
        one, two = (sum(int(tree.size[0]) for tree in self._part(end)) for end in (0, 1))
        return one, two

    def clouds(self) -> tuple[Reals, Reals]:
        """The states that are joined to packed, and those that are joined to flat, shape (k, m) each."""
        one, two = (np.concatenate([tree.angles[: int(tree.size[0])] for tree in self._part(end)]) for end in (0, 1))
        return one, two

    def _part(self, end: int) -> list[StateTree]:
        return [tree for tree, part in zip(self.trees, self.parts, strict=True) if part == self.parts[end]]

    def path(self) -> Reals:
        """The states of a path from packed to flat, where these have met."""
        tree, node, lines = 0, 0, []
        for joint in self._route():
            lines += [_between(self.trees[tree], node, joint.nodes[0]), joint.bridge]
            tree, node = joint.trees[1], joint.nodes[1]
        return np.concatenate([*lines, _between(self.trees[tree], node, 0)])

    def _route(self) -> list[TreeConnection]:
        """The joints on the way from the first tree to the second: those that met form a tree themselves."""
        routes: dict[int, list[TreeConnection]] = {0: []}
        while 1 not in routes:
            for joint in (*self.joints, *(joint.turned() for joint in self.joints)):
                here, there = joint.trees
                if here in routes and there not in routes:
                    routes[there] = [*routes[here], joint]
        return routes[1]


def _between(tree: StateTree, one: int, two: int) -> Reals:
    """The states of a tree from one to another, both included."""
    out, back = _branch(tree, one), _branch(tree, two)
    while len(out) > 1 and len(back) > 1 and out[-2] == back[-2]:
        out.pop(), back.pop()
    states: Reals = tree.angles[[*out, *back[-2::-1]]]
    return states


def _branch(tree: StateTree, node: int) -> list[int]:
    """The numbers of the states from one to the root."""
    nodes: list[int] = []
    while node >= 0:
        nodes.append(node)
        node = int(tree.parents[node])
    return nodes


def forest_roots(ends: Sequence[Reals], junctions: Reals, count: int, seed: int) -> Reals:
    """The roots of a forest: both ends and so many junctions, shape (k, m); with other seeds others, all in turn."""
    most = min(count, len(junctions))
    own = [(seed * most + k) % len(junctions) for k in range(most)]
    return np.array([*ends, *junctions[own]])
