"""Flat-folded states of a linkage, its junctions: every hinge at a stop, 0 or pi, and all loops closed.

Packed and flat are two of them. There are few, 2 to 24 in all for 10 and 12 panels on a tiling. Motions branch there,
and which of them a component of the closed states contains tells it from others.

A loop is closed where the half turns of its first half end where those of its second half, gone backwards, do: so the
products of both halves are listed and matched (Horowitz and Sahni, doi:10.1145/321812.321823), 2^(k/2) of each for k
hinges. On a tiling half turns map a lattice to itself (docs/explanation/theory.md, 25): two products are equal, or
differ by a step of the lattice, which rounding does not come near. So there this is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Flags, Reals, WholeNumbers
from hcsearch.basics.equality import ByValue
from hcsearch.kernels.planning.space import Space, StateStack, pick_state, place_state
from hcsearch.shape.linkage import Linkage, Walk

MAX_JUNCTION_LOOP_HINGES = 36
"""Hinges of the longest loop whose junctions are listed: there are 2^18 products of each half."""
MAX_JUNCTION_COUNT = 20_000
"""Junctions that are listed, at most."""
EQUAL_POSE_TOLERANCE = 1e-9
"""Poses whose entries, lengths over the pattern's size, differ by no more are one; rounding is 1e-14."""


@dataclass(frozen=True, eq=False)
class Junctions(ByValue):
    """Flat-folded closed states, in the order of their hinges as binary numbers.

    states : (k, n_hinges), rad, entries 0 and pi. complete : whether these are all; else a loop has more than
    `MAX_JUNCTION_LOOP_HINGES` hinges, or there are more than `MAX_JUNCTION_COUNT`.
    """

    states: Reals
    complete: bool


def junctions_of(linkage: Linkage) -> Junctions:
    """All flat-folded closed states of a linkage, packed and flat among them."""
    known, complete = np.zeros((1, linkage.n_hinges), bool), True
    listed: set[int] = set()
    for walk in linkage.loops:
        if len(walk) > MAX_JUNCTION_LOOP_HINGES:
            return Junctions(np.zeros((0, linkage.n_hinges)), False)
        own, whole = _closed(linkage, walk)
        hinges = [hinge for hinge, _ in walk]
        shared = [k for k, hinge in enumerate(hinges) if hinge in listed]
        listed.update(hinges)
        one, two, fits = _matched(_numbers(known[:, [hinges[k] for k in shared]]), _numbers(own[:, shared]))
        known = known[one]
        known[:, hinges] = own[two]
        complete = complete and whole and fits
    for hinge in set(range(linkage.n_hinges)) - listed:  # in no loop: it turns freely
        turned = known.copy()
        turned[:, hinge] = True
        known = np.concatenate([known, turned])[:MAX_JUNCTION_COUNT]
        complete = complete and 2 * len(turned) <= MAX_JUNCTION_COUNT
    return Junctions(math.pi * known[np.lexsort(known.T[::-1])], complete)


def clear_junctions(linkage: Linkage, space: Space, stack: StateStack) -> Reals:
    """The junctions beside packed and flat at which all pairs of a space keep apart, shape (k, n_hinges)."""
    states = junctions_of(linkage).states
    inner = states.any(axis=1) & (states != space.folded).any(axis=1)
    return np.array(
        [state for state in states[inner] if place_state(space, state, space.least, pick_state(stack, 0))], float
    ).reshape(-1, linkage.n_hinges)


def _closed(linkage: Linkage, walk: Walk) -> tuple[Flags, bool]:
    """Which hinges of a loop are closed, a row for each state in which the loop is; and whether these are all."""
    hinges = [hinge for hinge, _ in walk]
    turns = _half_turns(linkage.directions[hinges], linkage.points[hinges] / linkage.pattern.size)
    middle = len(hinges) // 2
    # half turns are their own inverses: the second half, backwards, is the product of its turns from the last on
    one, two = _products(turns[:middle]), _products(turns[: middle - 1 : -1] if middle else turns[::-1])
    first, second, fits = _matched(*_alike(one, two))
    same = np.abs(one[first] - two[second]).max(axis=(1, 2), initial=0.0) <= EQUAL_POSE_TOLERANCE
    bits = [_bits(first[same], middle), _bits(second[same], len(hinges) - middle)[:, ::-1]]
    return np.concatenate(bits, axis=1), fits


def _half_turns(directions: Reals, points: Reals) -> Reals:
    """Half turns about lines, shape (k, 4, 4): x -> 2 u (u . x) - x, seen from a point of the line."""
    turns = np.zeros((len(directions), 4, 4))
    turns[:, :3, :3] = 2.0 * directions[:, :, None] * directions[:, None] - np.eye(3)
    turns[:, :3, 3] = points - np.einsum("kij,kj->ki", turns[:, :3, :3], points)
    turns[:, 3, 3] = 1.0
    return turns


def _products(turns: Reals) -> Reals:
    """Products of all subsets of turns, in order, shape (2^k, 4, 4); turn j is in subset i where bit j of i is 1."""
    products = np.eye(4)[None]
    for turn in turns:
        products = np.concatenate([products, products @ turn])
    return products


def _bits(numbers: WholeNumbers, count: int) -> Flags:
    """The lowest bits of numbers, shape (k, count), the lowest first."""
    bits: Flags = (numbers[:, None] >> np.arange(count)) & 1 == 1
    return bits


def _numbers(bits: Flags) -> WholeNumbers:
    """Rows of bits, no more than `MAX_JUNCTION_LOOP_HINGES`, as numbers, the lowest first."""
    numbers: WholeNumbers = bits @ (1 << np.arange(bits.shape[1]))
    return numbers


def _alike(one: Reals, two: Reals) -> tuple[WholeNumbers, WholeNumbers]:
    """A number for each pose of two lists: the same where poses are equal, and seldom where they are not.

    Poses are sorted by one sum of their entries; a number ends where the next sum is further off than by rounding.
    """
    weights = np.random.default_rng(0).uniform(0.5, 1.0, 12)
    sums = np.concatenate([one, two])[:, :3].reshape(-1, 12) @ weights
    order = np.argsort(sums, kind="stable")
    numbers = np.empty(len(sums), np.int64)
    numbers[order] = np.cumsum(np.diff(sums[order], prepend=sums[order[0]]) > 12.0 * EQUAL_POSE_TOLERANCE)
    return numbers[: len(one)], numbers[len(one) :]


def _matched(one: WholeNumbers, two: WholeNumbers) -> tuple[WholeNumbers, WholeNumbers, bool]:
    """Places of equal numbers in two lists, all pairs or the first `MAX_JUNCTION_COUNT`; and whether these are all."""
    order = np.argsort(two, kind="stable")
    low, high = (np.searchsorted(two[order], one, side) for side in ("left", "right"))
    ends = np.cumsum(high - low)
    total = int(ends[-1]) if len(ends) else 0
    pairs = np.arange(min(total, MAX_JUNCTION_COUNT))
    first = np.searchsorted(ends, pairs, "right")
    return first, order[low[first] + pairs - (ends - high + low)[first]], total <= MAX_JUNCTION_COUNT
