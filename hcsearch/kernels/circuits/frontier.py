"""Hamiltonian cycles of arbitrary graphs by frontier states, edge by edge.

Edges are decided one by one, out or in. The decided edges constrain the rest of the graph only through the vertices
that have both decided and open edges, the frontier. Each of them occupies a slot, with value 0 for degree 0, 1 for
degree 2, and 2 + s for the end of a path whose other end is in slot s. A state is two words of 12 slots with 5 bits
each, and the parity of marked edges in a further bit. As slots are fixed, equal states are equal words.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Bitsets, Integers16, Integers32, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled

FRONTIER_SLOT_COUNT = 24
PARITY_BIT = np.uint64(1 << 60)
CHILD_COMPLETE = -2
CHILD_DEAD = -1
SATURATED_COUNT = 1 << 61

# columns of a sweep's table, one row per edge (see `enumeration.sweep`)
(
    SWEEP_SLOT_U,
    SWEEP_SLOT_V,
    SWEEP_NEED_U,
    SWEEP_NEED_V,
    SWEEP_FREE_U,
    SWEEP_FREE_V,
    SWEEP_ENTERED,
    SWEEP_FORCED,
    SWEEP_MARKED,
) = range(9)

_BITS = np.uint64(5)
_MASK = np.uint64(31)
_ONE = np.uint64(1)
_LOW_SLOTS = 12


@compiled
def _get(lo: np.uint64, hi: np.uint64, slot: int) -> int:
    if slot < _LOW_SLOTS:
        return int((lo >> (_BITS * np.uint64(slot))) & _MASK)
    return int((hi >> (_BITS * np.uint64(slot - _LOW_SLOTS))) & _MASK)


@compiled
def _put(lo: np.uint64, hi: np.uint64, slot: int, value: int) -> tuple[np.uint64, np.uint64]:
    if slot < _LOW_SLOTS:
        shift = _BITS * np.uint64(slot)
        return (lo & ~(_MASK << shift)) | (np.uint64(value) << shift), hi
    shift = _BITS * np.uint64(slot - _LOW_SLOTS)
    return lo, (hi & ~(_MASK << shift)) | (np.uint64(value) << shift)


@compiled
def _find(lo: np.uint64, hi: np.uint64, table: Integers32, next_lo: Bitsets, next_hi: Bitsets, size: int) -> int:
    """Return the index of a state among `size` known ones; a new state is appended, with index `size`."""
    mask = np.uint64(len(table) - 1)
    h = (lo ^ (hi * np.uint64(0x9E3779B97F4A7C15))) * np.uint64(0xD6E8FEB86659FD93)
    h ^= h >> np.uint64(32)
    h *= np.uint64(0xD6E8FEB86659FD93)
    entry = (h ^ (h >> np.uint64(29))) & mask
    while True:
        index = table[entry]
        if index < 0:
            table[entry] = size
            next_lo[size] = lo
            next_hi[size] = hi
            return size
        if next_lo[index] == lo and next_hi[index] == hi:
            return int(index)
        entry = (entry + _ONE) & mask


@compiled
def _degree(value: int) -> int:
    if value == 0:
        return 0
    return 2 if value == 1 else 1


@compiled
def advance_states(
    step: WholeNumbers,
    full_lo: np.uint64,
    full_hi: np.uint64,
    lo: Bitsets,
    hi: Bitsets,
    table: Integers32,
    next_lo: Bitsets,
    next_hi: Bitsets,
    child: Integers32,
) -> int:
    """Decide one edge for every state; return the number of states after it.

    full_lo, full_hi : the state in which a closing edge completes a cycle: all slots in use at degree 2, parity right.
    child : shape (len(lo), 2), state after 'out' and after 'in', `CHILD_DEAD`, or `CHILD_COMPLETE` if a cycle closes.
    """
    u, v = step[SWEEP_SLOT_U], step[SWEEP_SLOT_V]
    size = 0
    for i in range(len(lo)):
        a, b = _get(lo[i], hi[i], u), _get(lo[i], hi[i], v)
        child[i, 0] = child[i, 1] = CHILD_DEAD
        if step[SWEEP_FORCED] == 0 and _degree(a) >= step[SWEEP_NEED_U] and _degree(b) >= step[SWEEP_NEED_V]:
            x, y = lo[i], hi[i]
            if step[SWEEP_FREE_U]:
                x, y = _put(x, y, u, 0)
            if step[SWEEP_FREE_V]:
                x, y = _put(x, y, v, 0)
            child[i, 0] = _find(x, y, table, next_lo, next_hi, size)
            size += child[i, 0] == size
        if a == 1 or b == 1 or _degree(a) + 1 < step[SWEEP_NEED_U] or _degree(b) + 1 < step[SWEEP_NEED_V]:
            continue
        x, y = lo[i], hi[i]
        if step[SWEEP_MARKED]:
            x ^= PARITY_BIT
        if a == 2 + v:
            if step[SWEEP_ENTERED]:
                x, y = _put(x, y, u, 1)
                x, y = _put(x, y, v, 1)
                if x == full_lo and y == full_hi:
                    child[i, 1] = CHILD_COMPLETE
            continue
        end_u = u if a == 0 else a - 2
        end_v = v if b == 0 else b - 2
        x, y = _put(x, y, u, 1)
        x, y = _put(x, y, v, 1)
        x, y = _put(x, y, end_u, 2 + end_v)
        x, y = _put(x, y, end_v, 2 + end_u)
        if step[SWEEP_FREE_U]:
            x, y = _put(x, y, u, 0)
        if step[SWEEP_FREE_V]:
            x, y = _put(x, y, v, 0)
        child[i, 1] = _find(x, y, table, next_lo, next_hi, size)
        size += child[i, 1] == size
    return size


@compiled
def add_counts(child: Integers32, counts: WholeNumbers, after: WholeNumbers, total: WholeNumbers) -> None:
    """Add the count of each state to its children, or to `total` if a cycle closes; in 32-bit limbs without carry."""
    limbs = counts.shape[1]
    for i in range(len(child)):
        for choice in range(2):
            to = child[i, choice]
            if to >= 0:
                for limb in range(limbs):
                    after[to, limb] += counts[i, limb]
            elif to == CHILD_COMPLETE:
                for limb in range(limbs):
                    total[limb] += counts[i, limb]


@compiled
def carry_limbs(counts: WholeNumbers) -> bool:
    """Carry limbs, so that all but the last are below 2^32; return whether the last one overflows."""
    overflow = False
    limbs = counts.shape[1]
    for i in range(len(counts)):
        for limb in range(limbs - 1):
            counts[i, limb + 1] += counts[i, limb] >> 32
            counts[i, limb] &= 0xFFFFFFFF
        overflow |= counts[i, limbs - 1] >> 32 != 0
    return overflow


@compiled
def count_completions(child: Integers32, after: WholeNumbers, counts: WholeNumbers) -> None:
    """Count the completions of each state from those of its children; counts saturate at `SATURATED_COUNT`."""
    for i in range(len(child)):
        total = np.int64(0)
        for choice in range(2):
            to = child[i, choice]
            if to >= 0:
                total += after[to]
            elif to == CHILD_COMPLETE:
                total += 1
        counts[i] = total if total < SATURATED_COUNT else SATURATED_COUNT


@compiled
def _live(to: int, counts: WholeNumbers, offset: int) -> bool:
    return to == CHILD_COMPLETE or (to >= 0 and counts[offset + to] > 0)


@compiled
def list_completions(
    layer: int, offsets: WholeNumbers, child: Integers32, counts: WholeNumbers, start: WholeNumbers, masks: Bitsets
) -> None:
    """Write the sets of edges from `layer` on that complete each of its states; those of state s start at start[s]."""
    n_edges = len(offsets) - 1
    node = np.empty(n_edges + 1, np.int64)
    choice = np.empty(n_edges + 1, np.int64)
    written = 0
    for s in range(offsets[layer + 1] - offsets[layer]):
        start[s] = written
        if counts[offsets[layer] + s] == 0:
            continue
        k = layer
        node[k] = s
        choice[k] = -1
        while k >= layer:
            choice[k] += 1
            if choice[k] > 1:
                k -= 1
                continue
            next_state = child[offsets[k] + node[k], choice[k]]
            if next_state == CHILD_COMPLETE:
                for e in range(layer, k + 1):
                    if choice[e] == 1:
                        masks[written, e >> 6] |= _ONE << np.uint64(63 - (e & 63))
                written += 1
            elif _live(next_state, counts, offsets[k + 1]):
                k += 1
                node[k] = next_state
                choice[k] = -1
    start[offsets[layer + 1] - offsets[layer]] = written


@compiled
def permute_masks(masks: Bitsets, permutations: Integers32, images: Bitsets) -> None:
    """Write the images, shape (n_masks, n_permutations, words), of edge sets under permutations of the edges."""
    for i in range(len(masks)):
        for word in range(masks.shape[1]):
            bits = masks[i, word]
            e = word * 64
            while bits != 0:
                if bits >> np.uint64(63):
                    for g in range(len(permutations)):
                        to = permutations[g, e]
                        images[i, g, to >> 6] |= _ONE << np.uint64(63 - (to & 63))
                bits <<= _ONE
                e += 1


@compiled
def list_masks(
    layer: int,
    offsets: WholeNumbers,
    child: Integers32,
    counts: WholeNumbers,
    permutations: Integers32,
    start: WholeNumbers,
    tails: Bitsets,
    tail_images: Bitsets,
    rank: WholeNumbers,
    edge_sets: Bitsets,
    symmetry: Integers16,
) -> int:
    """Write cycles number rank[0] .. rank[1] - 1 that are least among their images; return how many were written.

    Every cycle consists of decisions down to `layer` and one of the tails of the state reached, so there are no dead
    ends. Returns early, with rank[0] advanced, if `edge_sets` might not have room for the tails of the next state.

    permutations : shape (n_permutations, n_edges), the symmetries except the identity, acting on edges.
    """
    words = edge_sets.shape[1]
    n_images = len(permutations)
    head = np.zeros(words, np.uint64)
    images = np.zeros((n_images, words), np.uint64)
    node = np.zeros(layer + 1, np.int64)
    choice = np.zeros(layer + 1, np.int64)
    # go to the walk that holds cycle number rank[0]
    skip = rank[0]
    for k in range(layer):
        to = child[offsets[k] + node[k], 0]
        below = counts[offsets[k + 1] + to] if to >= 0 else 0
        choice[k] = 0
        if skip >= below:
            skip -= below
            choice[k] = 1
            to = child[offsets[k] + node[k], 1]
        node[k + 1] = to
    written = 0
    while rank[0] < rank[1]:
        state = node[layer]
        first, last = start[state] + skip, start[state + 1]
        last = min(last, first + rank[1] - rank[0])
        if written + last - first > len(edge_sets):
            if written > 0:
                return written
            last = first + len(edge_sets)
        head[:] = 0
        images[:] = 0
        for e in range(layer):
            if choice[e] == 1:
                head[e >> 6] |= _ONE << np.uint64(63 - (e & 63))
                for g in range(n_images):
                    to = permutations[g, e]
                    images[g, to >> 6] |= _ONE << np.uint64(63 - (to & 63))
        for tail in range(first, last):
            ties = 1
            is_least = True
            for g in range(n_images):
                order = 0
                for word in range(words):
                    x = images[g, word] | tail_images[tail, g, word]
                    y = head[word] | tails[tail, word]
                    if x != y:
                        order = -1 if x < y else 1
                        break
                if order < 0:
                    is_least = False
                    break
                ties += order == 0
            if is_least:
                for word in range(words):
                    edge_sets[written, word] = head[word] | tails[tail, word]
                symmetry[written] = ties
                written += 1
        rank[0] += last - first
        if last < start[state + 1]:
            skip = last - start[state]
            continue
        skip = 0
        # the next walk: change the last 'out' that can be an 'in', then descend
        k = layer - 1
        while k >= 0:
            if choice[k] == 0 and _live(child[offsets[k] + node[k], 1], counts, offsets[k + 1]):
                break
            k -= 1
        if k < 0:
            break
        choice[k] = 1
        node[k + 1] = child[offsets[k] + node[k], 1]
        for below in range(k + 1, layer):
            to = child[offsets[below] + node[below], 0]
            choice[below] = 0
            if not _live(to, counts, offsets[below + 1]):
                choice[below] = 1
                to = child[offsets[below] + node[below], 1]
            node[below + 1] = to
    return written


@compiled
def trace_masks(masks: Bitsets, edges: WholeNumbers, back: WholeNumbers, words: NDArray[np.int8]) -> None:
    """Write each cycle, given as an edge set, as the numbers of its steps.

    edges : shape (n_edges, 3), the cells (u, v) of each edge and the step from u to v. back : the step back of each
    step.
    """
    n = words.shape[1]
    neighbours = np.empty((n, 2), np.int64)
    steps = np.empty((n, 2), np.int8)
    degree = np.empty(n, np.int64)
    for i in range(len(masks)):
        degree[:] = 0
        for e in range(len(edges)):
            if (masks[i, e >> 6] >> np.uint64(63 - (e & 63))) & _ONE:
                u, v, d = edges[e, 0], edges[e, 1], edges[e, 2]
                neighbours[u, degree[u]] = v
                steps[u, degree[u]] = d
                degree[u] += 1
                neighbours[v, degree[v]] = u
                steps[v, degree[v]] = back[d]
                degree[v] += 1
        cell = 0
        last_cell = -1
        for k in range(n):
            side = 1 if k > 0 and neighbours[cell, 0] == last_cell else 0
            words[i, k] = steps[cell, side]
            last_cell = cell
            cell = neighbours[cell, side]
