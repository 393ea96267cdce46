"""Sweeps: the order in which the edges of a graph are decided, and the frontier slot of each vertex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.basics.errors import SizeError
from hcsearch.kernels.circuits import frontier


@dataclass(frozen=True, eq=False)
class Sweep(ByValue):
    """A graph prepared for `kernels.circuits.frontier`.

    order : the edges' numbers in the graph, in the order of decision.
    steps : shape (n_edges, 9), one row per decision, columns as named in `kernels.circuits.frontier`.
    full : shape (n_edges, 2), the state in which a closing edge completes a Hamiltonian cycle, without the parity bit.
    width : greatest number of slots in use at a time.
    """

    order: tuple[int, ...]
    steps: NDArray[np.int64]
    full: NDArray[np.uint64]
    width: int


def plan_sweep(
    n_vertices: int,
    edges: Sequence[tuple[int, int]],
    ranks: Sequence[Sequence[int]],
    *,
    forced: frozenset[int] = frozenset(),
    marked: frozenset[int] = frozenset(),
) -> Sweep:
    """Plan the cheapest sweep among several vertex orders, each given by the ranks of the vertices.

    forced : edges that every cycle must use. marked : edges whose parity is tracked. Parallel edges are allowed, loops
    are not. Raises SizeError when the frontier of the best order needs more slots than a state has.
    """
    candidates = [_edge_order(edges, rank) for rank in ranks]
    order = min(candidates, key=lambda order: _cost(n_vertices, [edges[e] for e in order]))
    ordered = [edges[e] for e in order]
    first, last = _spans(n_vertices, ordered)
    slots, width = _assign_slots(first, last, ordered)
    steps = np.zeros((len(order), 9), np.int64)
    full = np.zeros((len(order), 2), np.uint64)
    remaining_degree = [0] * n_vertices
    for u, v in edges:
        remaining_degree[u] += 1
        remaining_degree[v] += 1
    all_entered = max(first)
    last_forced = max((k for k, e in enumerate(order) if e in forced), default=-1)
    occupied: set[int] = set()
    for k, (u, v) in enumerate(ordered):
        remaining_degree[u] -= 1
        remaining_degree[v] -= 1
        occupied |= {slots[u], slots[v]}
        steps[k] = (
            *(
                slots[u],
                slots[v],
                2 - remaining_degree[u],
                2 - remaining_degree[v],
                remaining_degree[u] == 0,
                remaining_degree[v] == 0,
            ),
            *(k >= all_entered and k >= last_forced, order[k] in forced, order[k] in marked),
        )
        for slot in occupied:
            full[k, slot // 12] |= np.uint64(1 << 5 * (slot % 12))
        occupied -= {slots[w] for w in (u, v) if remaining_degree[w] == 0}
    return Sweep(tuple(order), steps, full, width)


def _edge_order(edges: Sequence[tuple[int, int]], rank: Sequence[int]) -> list[int]:
    """Sort edges by their later vertex, then by their earlier one."""
    return sorted(range(len(edges)), key=lambda e: sorted((rank[edges[e][0]], rank[edges[e][1]]), reverse=True))


def _spans(n_vertices: int, ordered: Sequence[tuple[int, int]]) -> tuple[list[int], list[int]]:
    """Return the first and the last step in which each vertex occurs."""
    first, last = [-1] * n_vertices, [-1] * n_vertices
    for k, edge in enumerate(ordered):
        for vertex in edge:
            if first[vertex] < 0:
                first[vertex] = k
            last[vertex] = k
    return first, last


def _cost(n_vertices: int, ordered: Sequence[tuple[int, int]]) -> float:
    """Estimate the number of states: each frontier vertex multiplies it by about 2.2 (measured on squares)."""
    first, last = _spans(n_vertices, ordered)
    change = [0] * (len(ordered) + 1)
    for begin, end in zip(first, last, strict=True):
        change[begin] += 1
        change[end + 1] -= 1
    width, cost = 0, 0.0
    for step in change[:-1]:
        width += step
        cost += 2.2 ** min(width, 400)
    return cost


def _assign_slots(first: list[int], last: list[int], ordered: Sequence[tuple[int, int]]) -> tuple[list[int], int]:
    """Assign a free slot to each vertex from its first step to its last; return the slots and their number."""
    slots = [-1] * len(first)
    free: list[int] = []
    width = 0
    for k, edge in enumerate(ordered):
        for vertex in edge:
            if first[vertex] == k and slots[vertex] < 0:
                if not free:
                    free.append(width)
                    width += 1
                slots[vertex] = free.pop()
        for vertex in set(edge):
            if last[vertex] == k:
                free.append(slots[vertex])
    if width > frontier.FRONTIER_SLOT_COUNT:
        raise SizeError(
            f"the array is too wide: its frontier holds {width} cells, {frontier.FRONTIER_SLOT_COUNT} at most; "
            "take a narrower one"
        )
    return slots, width
