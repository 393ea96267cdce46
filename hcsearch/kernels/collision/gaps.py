"""Gaps between panels at many states: distances of their prisms, or how deep these cut into each other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Flags, Reals, WholeNumbers
from hcsearch.kernels.collision.distances import gap_along, hull_gap
from hcsearch.kernels.collision.overlaps import prism_overlap
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import Prisms, copy_prisms, place_prisms, sphere_distance, turn_axes


class PanelPairs(NamedTuple):
    """Pairs of panels, and those of their prisms.

    prisms : (q, 2). starts : (p + 1,), pair k of panels has those from `starts[k]` up to `starts[k + 1]`.
    """

    prisms: WholeNumbers
    starts: WholeNumbers


class _Memory(NamedTuple):
    """Where the last search of each pair of prisms ended, and of each pair of panels the nearest pair of prisms.

    gaps, ways, corners : (q,), (q, 3), (q, 4), of `closest`. axes : (q,), of `overlap`. nearest : (p,).
    turned : (f,), whether the axes of a prism are those of this state.
    """

    gaps: Reals
    ways: Reals
    corners: WholeNumbers
    axes: WholeNumbers
    nearest: WholeNumbers
    turned: Flags


@compiled
def gaps_at(
    chain: Chain, prisms: Prisms, pairs: PanelPairs, states: Reals, reach: float, allowed: float, gaps: Reals
) -> None:
    """Write the gaps of pairs of panels at states: the least distance of their prisms, or minus how deep these cut.

    states : (k, n_hinges), fold angles. reach : of a gap beyond it, a lower bound beyond it is written. allowed :
        prisms that cut no deeper into each other touch: gap 0. gaps : (k, p), written.
    """
    placed = copy_prisms(prisms)
    poses = np.empty((len(chain.order), 3, 4))
    q = len(pairs.prisms)
    memory = _Memory(
        np.full(q, -np.inf),
        np.zeros((q, 3)),
        np.full((q, 4), -1),
        np.zeros(q, np.int64),
        pairs.starts[:-1].copy(),
        np.zeros(len(prisms.panels), np.bool_),
    )
    for k in range(len(states)):
        place_panels(chain, states[k], poses)
        place_prisms(prisms, poses, placed)
        _write(prisms, placed, poses, pairs, reach, allowed, memory, gaps[k])


@lean
def _write(
    prisms: Prisms,
    placed: Prisms,
    poses: Reals,
    pairs: PanelPairs,
    reach: float,
    allowed: float,
    memory: _Memory,
    gaps: Reals,
) -> None:
    """The gaps at one state."""
    ways, corners, nearest = memory.ways, memory.corners, memory.nearest
    memory.turned[:] = False
    for p in range(len(gaps)):
        begin, best, least = pairs.starts[p], nearest[p], math.inf
        # the nearest prisms of the last state come first: others need not be searched where a bound is no less
        for turn in range(begin - 1, pairs.starts[p + 1]):
            k = best if turn < begin else turn
            if turn == best:
                continue
            one, two = pairs.prisms[k, 0], pairs.prisms[k, 1]
            enough = min(reach, least)
            gap = sphere_distance(placed, one, two)
            if gap < enough:
                first, second = placed.vertices[one], placed.vertices[two]
                a, b = placed.counts[one, 0], placed.counts[two, 0]
                way = (ways[k, 0], ways[k, 1], ways[k, 2])
                if memory.gaps[k] >= enough:
                    gap = gap_along(first, a, second, b, way)
                if not gap >= enough:
                    at = (corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3])
                    gap, way, at = hull_gap(first, a, second, b, way, at)
                    memory.gaps[k] = gap
                    ways[k, 0], ways[k, 1], ways[k, 2] = way
                    corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3] = at
            if gap < least:
                least = gap
                nearest[p] = k
        if least < -allowed:
            # that deep along one direction: how deep along all?
            least = -_deepest(prisms, placed, poses, pairs, p, allowed, memory)
        gaps[p] = least if least > 0.0 or least < -allowed else 0.0


@lean
def _deepest(
    prisms: Prisms, placed: Prisms, poses: Reals, pairs: PanelPairs, pair: int, allowed: float, memory: _Memory
) -> float:
    """How deep the prisms of two panels cut into each other; any that is allowed where it is."""
    depth = 0.0
    for p in range(pairs.starts[pair], pairs.starts[pair + 1]):
        for side in range(2):
            f = pairs.prisms[p, side]
            if not memory.turned[f]:
                turn_axes(prisms, poses, placed, f)
                memory.turned[f] = True
        depth = max(depth, prism_overlap(placed, pairs.prisms[p, 0], pairs.prisms[p, 1], allowed, memory.axes, p))
    return depth
