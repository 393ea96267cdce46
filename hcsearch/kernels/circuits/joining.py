"""Foldable circuits joined from pairs of half-chains; each class is written once, from its least root.

A circuit can be rooted at either end of any of its foldings, at either half-chain, and where the bisector of the flat
crease is a mirror of the panel, in two orientations. Only its least root is written: of those at the least class of
edges, the least pair of codes (first half-chain, second half-chain). The number of roots that attain it is the order of
the circuit's symmetry group. Proofs are in docs/explanation/theory.md, section 8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import WholeNumbers
from hcsearch.kernels.circuits.chains import HalfChains, Plane, bit_plane_count, mirror_code, sum_offset
from hcsearch.kernels.compiling.compiled import compiled

_Letters = tuple[int, int, np.uint64, np.uint64, int]
"""h, bits of a letter, the highest letter, the code of h highest letters, and the number of roots of a folding.

Roots are 8, or 4 where no symmetry maps a flat crease onto itself and its panel onto itself but the identity.
"""


@compiled
def _least_root(
    a: np.uint64, b: np.uint64, ra: np.uint64, rb: np.uint64, letters: _Letters
) -> tuple[np.uint64, np.uint64, int]:
    """Return the least of the roots of a folding, and the number of roots that attain it.

    a, b : codes of the folding's half-chains; ra, rb : the same walked from the other flat crease, and, as that is
    carried home by h reflections, mirrored where h is odd.
    """
    flips = letters[3]
    code, mate, equal = a, b, 0
    for half in range(2):  # loops of constant length, which compilers unroll
        for root in range(4):
            x, y = _root(root, a, b, ra, rb, flips)
            if half == 1:
                x, y = flips - x, flips - y
            if x < code or (x == code and y < mate):
                code, mate, equal = x, y, 0
            if x == code and y == mate:
                equal += 1
        if letters[4] == 4:
            break
    return code, mate, equal


@compiled
def _root(
    root: int, a: np.uint64, b: np.uint64, ra: np.uint64, rb: np.uint64, flips: np.uint64
) -> tuple[np.uint64, np.uint64]:
    """Return one of the roots, as read where its first panel is at home.

    Bit 0 of its number swaps the half-chains, by a reflection in the flat crease; bit 1 swaps the flat creases; bit 2
    reflects in the bisector of the crease.
    """
    x, y = (ra, rb) if root & 2 else (a, b)
    if root & 1:
        x, y = y, x
    if (root ^ (root >> 2)) & 1:
        x, y = flips - x, flips - y
    return x, y


@compiled
def _order(
    a: np.uint64,
    b: np.uint64,
    ra: np.uint64,
    rb: np.uint64,
    flat: np.uint64,
    stabiliser: int,
    mirrored: np.uint64,
    letters: _Letters,
) -> int:
    """Return the order of the circuit's symmetry group if this root is the least, else 0.

    a, b : codes of the folding's half-chains; ra, rb : the same walked from the other flat crease.
    flat : bit k is set where crease k of the first half-chain is flat in another folding, and of the same class.
    stabiliser : bit i is set where root i of the folding has the same key. mirrored : bit k is set where the panel
    beyond crease k, to be at home, must be reflected.
    """
    h, bits, top, flips, count = letters
    is_odd = h & 1 == 1
    home_a, home_b = (flips - ra, flips - rb) if is_odd else (ra, rb)
    if stabiliser > 1:
        for root in range(1, 8):
            if root < count and (stabiliser >> root) & 1:
                x, y = _root(root, a, b, home_a, home_b, flips)
                if x < a or (x == a and y < b):
                    return 0
    # the letters of the panels, walked forward (ahead: first half-chain, then second) and backward
    width = np.uint64(bits)
    shift = np.uint64(bits * (h - 1))
    ahead_a = (a << width) | (top - (ra >> shift))
    ahead_b = (rb << width) | (top - (b >> shift))
    behind_b = (b << width) | (top - (rb >> shift))
    behind_a = (ra << width) | (top - (a >> shift))
    code, mate, order = _least_code(a, b, home_a, home_b, letters), np.uint64(0), 0
    for are_compared in range(2):  # first only codes, by which most circuits are seen to have a lesser root
        if are_compared:
            code, mate, order = _least_root(a, b, home_a, home_b, letters)
        others, k = flat, 0
        while others != 0:
            if others & np.uint64(1):
                x, rx = _window(ahead_a, ahead_b, k, h, bits), _window(behind_b, behind_a, h + 1 - k, h, bits)
                y, ry = _window(behind_a, behind_b, h + 1 - k, h, bits), _window(ahead_b, ahead_a, k, h, bits)
                if (mirrored >> np.uint64(k)) & np.uint64(1):
                    x, y, rx, ry = flips - x, flips - y, flips - rx, flips - ry
                if is_odd:
                    rx, ry = flips - rx, flips - ry
                if not are_compared:
                    if _least_code(x, y, rx, ry, letters) < code:
                        return 0
                else:
                    other_code, other_mate, equal = _least_root(x, y, rx, ry, letters)
                    if other_code == code and other_mate < mate:
                        return 0
                    if other_code == code and other_mate == mate:
                        order += equal
            others >>= np.uint64(1)
            k += 1
    return order


@compiled
def _least_code(a: np.uint64, b: np.uint64, ra: np.uint64, rb: np.uint64, letters: _Letters) -> np.uint64:
    """Return the first code of the least root, as of `_least_root`."""
    flips = letters[3]
    if letters[4] == 4:
        return min(a, ra, flips - max(b, rb))
    return min(a, b, ra, rb, flips - max(a, b, ra, rb))


@compiled
def _window(first: np.uint64, second: np.uint64, skip: int, h: int, bits: int) -> np.uint64:
    """Return the h letters after the first `skip` ones (0 < skip < h + 1) of two words of h + 1 letters each."""
    head_bits = np.uint64(bits * (h + 1 - skip))
    tail_shift = np.uint64(bits * (skip - 1))
    head = first & ((np.uint64(1) << head_bits) - np.uint64(1))
    return (head << tail_shift) | (second >> (np.uint64(bits * (h + 1)) - tail_shift))


@compiled
def join_chains(
    plane: Plane,
    key: WholeNumbers,
    lists: tuple[HalfChains, HalfChains, WholeNumbers],
    root_count: int,
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
    root_count : see `_Letters`.
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
    letters = (h, plane.bits, top, mirror_code(plane), root_count)
    capacity = len(words)
    planes = bit_plane_count(plane)
    written = 0
    for i in range(state[0], len(first.codes)):
        if i % parts != part:
            continue
        lo, hi = np.int64(0), np.int64(len(second.codes))
        if untwisted:
            lo, hi = starts[offset - first.sums[i]], starts[offset - first.sums[i] + 1]
        # loaded once, as kernels cannot know that no other array shares the memory
        mask, a, ra = first.masks[0, i], first.codes[i], first.reversed_codes[i]
        lower, same, mirrored = first.crease_sets[0, i], first.crease_sets[1, i], first.crease_sets[2, i]
        plane_0, plane_1 = first.flat_bit_planes[0, i], first.flat_bit_planes[1, i]
        plane_2, plane_3 = first.flat_bit_planes[2, i], first.flat_bit_planes[3, i]
        for j in range(max(lo, state[1]), hi):
            if mask & second.masks[0, j] != 0:
                continue
            common = np.uint64(0)
            for w in range(1, len(first.masks)):
                common |= first.masks[w, i] & second.masks[w, j]
            if common != 0:
                continue
            folded = (plane_0 ^ second.flat_bit_planes[0, j]) | (plane_1 ^ second.flat_bit_planes[1, j])
            if planes > 2:
                folded |= plane_2 ^ second.flat_bit_planes[2, j]
            if planes > 3:
                folded |= plane_3 ^ second.flat_bit_planes[3, j]
            flat = ~folded
            if flat & lower:
                continue
            b, rb = second.codes[j], second.reversed_codes[j]
            order = _order(a, b, ra, rb, flat & same, stabiliser, mirrored, letters)
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
