"""Trees of hinges: how each panel of a pattern hangs on another, and the ways along hinges that follow."""

from __future__ import annotations

from collections import deque
from collections.abc import Container
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import WholeNumbers
from hcsearch.shape.pattern import Pattern


class HingeTree(NamedTuple):
    """A breadth-first tree, and one for each further part of a pattern that has several.

    order : of panels. roots : (n_panels,), where the tree of each begins. parents, hinges, signs : (n_panels,), the
        panel before each, the hinge between them, and 1 where it is the hinge's second panel, else -1; -1, -1 and 0 for
        a root.
    """

    order: WholeNumbers
    roots: WholeNumbers
    parents: WholeNumbers
    hinges: WholeNumbers
    signs: WholeNumbers

    def way(self, panel: int) -> list[tuple[int, int]]:
        """Hinges from the root of a panel to it, with their signs."""
        steps = []
        while self.parents[panel] >= 0:
            steps.append((int(self.hinges[panel]), int(self.signs[panel])))
            panel = int(self.parents[panel])
        return steps[::-1]


def hinge_tree(pattern: Pattern, base: int, without: Container[int] = ()) -> HingeTree:
    """The tree from a base panel: ways from there are the shortest that there are, across no hinge of `without`."""
    n = len(pattern.panels)
    joined: list[list[tuple[int, int, int]]] = [[] for _ in range(n)]
    for k, hinge in enumerate(pattern.hinges):
        if k in without:
            continue
        joined[hinge.first].append((hinge.second, k, 1))
        joined[hinge.second].append((hinge.first, k, -1))
    parents, hinges, signs = np.full(n, -2), np.full(n, -1), np.zeros(n, np.int64)
    roots = np.zeros(n, np.int64)
    order: list[int] = []
    for root in (base, *range(n)):  # a pattern in several parts has a tree for each
        if parents[root] != -2:
            continue
        parents[root] = -1
        waiting = deque([root])
        while waiting:
            panel = waiting.popleft()
            order.append(panel)
            roots[panel] = root
            for to, hinge, sign in joined[panel]:
                if parents[to] == -2:
                    parents[to], hinges[to], signs[to] = panel, hinge, sign
                    waiting.append(to)
    return HingeTree(np.array(order), roots, parents, hinges, signs)
