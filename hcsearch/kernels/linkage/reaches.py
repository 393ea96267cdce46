"""Ways between panels through a tree of hinges, and how far from each hinge's line a panel beyond it can come."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.algebra.vectors import at, cross, dot, minus
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import Chain
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.typing import Reals, Whole


class Pairs(NamedTuple):
    """Pairs of prisms, and the ways between their panels through the tree of the chain.

    prisms : (p, 2). lengths : (p,), hinges on the way. hinges : (p, m), from the first panel to the second.
    beyond, before : (p, m), greatest distance (m) from each hinge's line of points of the second prism, and of the
        first.
    """

    prisms: Whole
    lengths: Whole
    hinges: Whole
    beyond: Reals
    before: Reals


@compiled
def pairs_between(chain: Chain, prisms: Prisms, wanted: Whole) -> Pairs:
    """The ways between the panels of some pairs of prisms, shape (p, 2)."""
    count, most = len(wanted), len(chain.points)
    lengths, hinges = np.zeros(count, np.int64), np.zeros((count, most), np.int64)
    beyond, before = np.zeros((count, most)), np.zeros((count, most))
    depth = np.zeros(len(chain.order), np.int64)
    for panel in chain.order:
        if chain.parents[panel] >= 0:
            depth[panel] = depth[chain.parents[panel]] + 1
    back = np.empty(most, np.int64)
    for p in range(count):
        one, two = prisms.panels[wanted[p, 0]], prisms.panels[wanted[p, 1]]
        out = returned = 0
        while one != two:
            if depth[one] >= depth[two]:
                hinges[p, out] = chain.hinges[one]
                one = chain.parents[one]
                out += 1
            else:
                back[returned] = chain.hinges[two]
                two = chain.parents[two]
                returned += 1
        for k in range(returned):
            hinges[p, out + k] = back[returned - 1 - k]
        lengths[p] = out + returned
        _reach(chain, prisms, wanted[p, 1], hinges[p], lengths[p], 1, beyond[p])
        _reach(chain, prisms, wanted[p, 0], hinges[p], lengths[p], -1, before[p])
    most = lengths.max() if count else 0
    return Pairs(wanted, lengths, hinges[:, :most].copy(), beyond[:, :most].copy(), before[:, :most].copy())


@lean
def _reach(chain: Chain, prisms: Prisms, f: int, way: Whole, count: int, sense: int, reaches: Reals) -> None:
    """Greatest distance of the corners of a prism at one end of a way from the line of each hinge, however it folds.

    sense : 1 for the prism at the end, -1 for the one at the beginning.
    """
    reach = 0.0
    for i in range(count):
        k = count - 1 - i if sense > 0 else i
        point, line = at(chain.points, way[k], 0), at(chain.directions, way[k], 0)
        if i == 0:
            for c in range(prisms.counts[f, 0]):
                arm = minus(at(prisms.vertices[f], c, 0), point)
                across = cross(arm, line)
                reaches[k] = max(reaches[k], math.sqrt(dot(across, across)))
                reach = max(reach, math.sqrt(dot(arm, arm)))
        else:
            arm = minus(at(chain.points, way[k + sense], 0), point)
            across = cross(arm, line)
            reaches[k] = math.sqrt(dot(across, across)) + reach
            reach += math.sqrt(dot(arm, arm))
