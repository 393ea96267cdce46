"""Foldable circuits joined from pairs of half-chains; each class is written once, from its least root.

A circuit can be rooted at either end of any of its foldings, at either half-chain, and where the bisector of the flat
crease is a mirror of the panel, in two orientations. Only its least root is written: of those at the least class of edges,
the least pair of codes (first half-chain, second half-chain). The number of roots that attain it is the order of the
circuit's symmetry group. Proofs are in docs/explanation/theory.md, section 8.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import WholeNumbers
from hcsearch.kernels.circuits.chains import HalfChains, Plane, mirror_code, sum_offset
from hcsearch.kernels.compiling.compiled import lean


class Roots(NamedTuple):
    """The roots of a folding, and how their codes are read.

    h : steps of a half-chain. bits, top, flips : bits of a letter, the highest one, and the code of h highest letters.
    count : 8, or 4 on edges whose perpendicular bisector is no mirror of the panel: no symmetry maps these to themselves.
    edge_class : class of the flat creases. classes : class of the edge that each step crosses, under all symmetries.
    reflected : whether only a reflection maps a step to the least one of its class.
    """

    h: int
    bits: int
    top: np.uint64
    flips: np.uint64
    count: int
    edge_class: int
    classes: WholeNumbers
    reflected: NDArray[np.bool_]


@lean
def _least_root(
    a: np.uint64, b: np.uint64, ra: np.uint64, rb: np.uint64, roots: Roots
) -> tuple[np.uint64, np.uint64, int]:
    """Return the least of the roots of a folding, and the number of roots that attain it.

    a, b : codes of the folding's half-chains; ra, rb : the same walked from the other flat crease.
    """
    code, mate, equal = a, b, 0
    for root in range(roots.count):
        x, y = _root(root, a, b, ra, rb, roots)
        if x < code or (x == code and y < mate):
            code, mate, equal = x, y, 0
        if x == code and y == mate:
            equal += 1
    return code, mate, equal


@lean
def _root(
    root: int, a: np.uint64, b: np.uint64, ra: np.uint64, rb: np.uint64, roots: Roots
) -> tuple[np.uint64, np.uint64]:
    """Return one of the roots, as read in the frame in which its first panel is at home.

    Bit 0 of its number swaps the half-chains, by a reflection in the flat crease; bit 1 swaps the flat creases, by the h
    reflections that carry one to the other; bit 2 reflects in the bisector of the crease.
    """
    x, y = (ra, rb) if root & 2 else (a, b)
    if root & 1:
        x, y = y, x
    if (root ^ (root >> 2) ^ ((root >> 1) & roots.h)) & 1:
        x, y = roots.flips - x, roots.flips - y
    return x, y


@lean
def _order(
    a: np.uint64,
    b: np.uint64,
    ra: np.uint64,
    rb: np.uint64,
    flat: np.uint64,
    stabiliser: int,
    steps: NDArray[np.int8],
    roots: Roots,
) -> int:
    """Return the order of the circuit's symmetry group if this root is the least, else 0.

    a, b, ra, rb : as in `_least_root`, of the folding that the root belongs to.
    flat : bit k is set where crease k of the first half-chain is flat in another folding.
    stabiliser : bit i is set where root i of the folding has the same key. steps : of the first half-chain.
    """
    h, bits, flips = roots.h, roots.bits, roots.flips
    for root in range(1, roots.count):
        if (stabiliser >> root) & 1:
            x, y = _root(root, a, b, ra, rb, roots)
            if x < a or (x == a and y < b):
                return 0
    code, mate, order = _least_root(a, b, ra, rb, roots)
    if flat == 0:
        return order
    # the letters of the panels, walked forward (ahead: first half-chain, then second) and backward
    width = np.uint64(bits)
    shift = np.uint64(bits * (h - 1))
    ahead_a = (a << width) | (roots.top - (ra >> shift))
    ahead_b = (rb << width) | (roots.top - (b >> shift))
    behind_b = (b << width) | (roots.top - (rb >> shift))
    behind_a = (ra << width) | (roots.top - (a >> shift))
    k = 0
    while flat != 0:
        if flat & np.uint64(1):
            step = steps[k - 1]
            if roots.classes[step] < roots.edge_class:
                return 0
            if roots.classes[step] == roots.edge_class:
                a, rb = _window(ahead_a, ahead_b, k, h, bits), _window(ahead_b, ahead_a, k, h, bits)
                b, ra = _window(behind_a, behind_b, h + 1 - k, h, bits), _window(behind_b, behind_a, h + 1 - k, h, bits)
                if not roots.reflected[step]:  # seen from the panel beyond, which is a mirror image
                    a, b, ra, rb = flips - a, flips - b, flips - ra, flips - rb
                other_code, other_mate, equal = _least_root(a, b, ra, rb, roots)
                if other_code < code or (other_code == code and other_mate < mate):
                    return 0
                if other_code == code and other_mate == mate:
                    order += equal
        flat >>= np.uint64(1)
        k += 1
    return order


@lean
def _window(first: np.uint64, second: np.uint64, skip: int, h: int, bits: int) -> np.uint64:
    """Return the h letters after the first `skip` ones (0 < skip < h + 1) of two words of h + 1 letters each."""
    head_bits = np.uint64(bits * (h + 1 - skip))
    tail_shift = np.uint64(bits * (skip - 1))
    head = first & ((np.uint64(1) << head_bits) - np.uint64(1))
    return (head << tail_shift) | (second >> (np.uint64(bits * (h + 1)) - tail_shift))


@lean
def join_chains(
    plane: Plane,
    key: WholeNumbers,
    lists: tuple[HalfChains, HalfChains, WholeNumbers],
    classes: tuple[int, int, WholeNumbers, NDArray[np.bool_]],
    untwisted: bool,
    part: int,
    parts: int,
    group_order: int,
    state: WholeNumbers,
    words: NDArray[np.int8],
    totals: WholeNumbers,
) -> int:
    """Join the half-chains of a key to foldable circuits, one per class, until `words` is full; return their number.

    key : as for `list_chains`, followed by the key's stabiliser (see `_order`); lists : result of `list_chains`.
    classes : the last four fields of `Roots`.
    part, parts : only every parts-th of the first half-chains is used, from number `part` on.
    state : (first half-chain, second half-chain) at which to resume; at the end, the first is the number of chains.
    words : shape (capacity, n); with capacity 0, circuits are only counted.
    totals : incremented by the numbers of classes and of circuits up to translation, group_order / symmetry per class.
    """
    first, second, starts = lists
    h = plane.h
    face, stabiliser = key[1], key[4]
    half = h + 1
    offset = sum_offset(plane)
    top = np.uint64(plane.steps.following.shape[1] - 1)
    roots = Roots(h, plane.bits, top, mirror_code(plane), classes[0], classes[1], classes[2], classes[3])
    capacity = len(words)
    planes = 2 if plane.steps.directions == 4 else 4 if plane.steps.directions > 8 else 3
    all_creases = (np.uint64(1) << np.uint64(half)) - np.uint64(2)  # bits 1 .. h
    written = 0
    for i in range(state[0], len(first.codes)):
        if i % parts != part:
            continue
        lo, hi = np.int64(0), np.int64(len(second.codes))
        if untwisted:
            lo, hi = starts[offset - first.sums[i]], starts[offset - first.sums[i] + 1]
        mask = first.masks[0, i]
        for j in range(max(lo, state[1]), hi):
            if mask & second.masks[0, j] != 0:
                continue
            common = np.uint64(0)
            for w in range(1, len(first.masks)):
                common |= first.masks[w, i] & second.masks[w, j]
            if common != 0:
                continue
            flat = all_creases
            for p in range(planes):
                flat &= ~(first.flat_bit_planes[p, i] ^ second.flat_bit_planes[p, j])
            a, b, ra, rb = first.codes[i], second.codes[j], first.reversed_codes[i], second.reversed_codes[j]
            order = _order(a, b, ra, rb, flat, stabiliser, first.steps[i], roots)
            if order == 0:
                continue
            totals[0] += 1
            totals[1] += group_order // order
            if capacity == 0:
                continue
            words[written, 0] = plane.steps.back[plane.crease]
            words[written, half] = face
            for t in range(h):
                words[written, 1 + t] = first.steps[i, t]
                words[written, half + 1 + t] = plane.steps.back[second.steps[j, h - 1 - t]]
            written += 1
            if written == capacity:
                state[0] = i
                state[1] = j + 1
                return written
        state[1] = 0
    state[0] = len(first.codes)
    return written
