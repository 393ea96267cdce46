"""Trees of closed states that grow from an end of the motion, or from another state with every hinge at a stop."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.planning.sliding import slide
from hcsearch.kernels.planning.space import (
    Space,
    SpaceWork,
    StateStack,
    copy_state,
    greatest_angle_change,
    greatest_magnitude,
    pick_state,
    place_state,
)

STATE_CELL_WIDTH = 0.15
"""Width (rad) of the cells by which states count as alike."""
MAX_STATES_PER_CELL = 2
"""States of a cell that a tree keeps, beside those on the way to others."""
END_STEP_SHARE, MIN_GROWTH_STEP = 0.4, 0.003
"""A step is no longer than this share of the way to the root or to an end, but at least so long (rad)."""
MIN_GROWTH_GAIN = 2e-3
"""A step that brings the target nearer by less than this share does not help."""
MAX_IDLE_STEPS = 2
"""Steps that may not help before a tree grows elsewhere."""


class StateTree(NamedTuple):
    """States that hang on the root, at which every hinge is at a stop.

    angles : (capacity, m). parents : (capacity,), -1 for the root. size : (1,), how many states there are.
    keys, hits : hash table of cells, and how many states each has.
    """

    angles: Reals
    parents: WholeNumbers
    size: WholeNumbers
    keys: WholeNumbers
    hits: WholeNumbers


@compiled
def new_tree(capacity: int, root: Reals) -> StateTree:
    """A tree that is its root."""
    slots = 4
    while slots < 4 * capacity:
        slots *= 2
    tree = StateTree(
        np.zeros((capacity, len(root))),
        np.full(capacity, -1),
        np.ones(1, np.int64),
        np.zeros(slots, np.int64),
        np.zeros(slots, np.int64),
    )
    tree.angles[0] = root
    return tree


@lean
def add_state(tree: StateTree, parent: int, angles: Reals) -> int:
    """Add a state; its number, -1 where the tree is full."""
    n = tree.size[0]
    if n == len(tree.parents):
        return -1
    for h in range(len(angles)):
        tree.angles[n, h] = angles[h]
    tree.parents[n] = parent
    tree.size[0] = n + 1
    return int(n)


@lean
def nearest_state(tree: StateTree, angles: Reals, beyond: float) -> tuple[int, float]:
    """The nearest state of a tree beyond some squared distance (rad^2), and the square of its own; -1 without."""
    best, least = -1, math.inf
    for i in range(tree.size[0]):
        total = 0.0
        for h in range(len(angles)):
            total += (tree.angles[i, h] - angles[h]) ** 2
            if total >= least:
                break
        if beyond < total < least:
            best, least = i, total
    return best, least


@lean
def cell_slot(tree: StateTree, row: int) -> int:
    """The slot of the cell of a state in the hash table."""
    key = 1469598103934665603
    for h in range(tree.angles.shape[1]):
        key = (key ^ math.floor(tree.angles[row, h] / STATE_CELL_WIDTH + 0.5)) * 1099511628211
    key |= 1  # 0 is an empty slot
    slots = len(tree.keys)
    slot = (key ^ (key >> 29)) & (slots - 1)
    while tree.keys[slot] != 0 and tree.keys[slot] != key:
        slot = (slot + 1) & (slots - 1)
    tree.keys[slot] = key
    return slot


@lean
def keep_new_states(tree: StateTree, first: int) -> bool:
    """Of the states from `first` on, a line, keep those up to the last whose cell is not full; whether there is one."""
    end = first
    for i in range(first, tree.size[0]):
        slot = cell_slot(tree, i)
        if tree.hits[slot] < MAX_STATES_PER_CELL:
            end = i + 1
            tree.hits[slot] += 1
    tree.size[0] = end
    return end > first


@compiled
def grow_towards(
    space: Space,
    tree: StateTree,
    node: int,
    target: Reals,
    springs: Reals,
    limits: tuple[float, float, int],
    stack: StateStack,
    work: SpaceWork,
) -> int:
    """Grow a tree from a state towards a target by steps along contacts; the last state that was added, or the first.

    springs : (m,), weights of the hinges. limits : longest step (rad), singular directions of closure that count as
    free, and steps at most.
    """
    longest, least, steps = limits
    here, there = pick_state(stack, 0), pick_state(stack, 1)
    place_state(space, tree.angles[node], -math.inf, here)
    best, idle = math.inf, 0
    for _ in range(steps):
        left = 0.0
        for h in range(len(target)):
            way = target[h] - here.angles[h]
            work.want[h] = springs[h] * way
            left += springs[h] * way * way
        idle = idle + 1 if left > best * (1.0 - MIN_GROWTH_GAIN) else 0
        if left < 1e-6 or idle > MAX_IDLE_STEPS:
            break
        best = min(best, left)
        to_end = min(greatest_angle_change(here.angles, space.folded), greatest_magnitude(here.angles))
        to_end = min(to_end, greatest_angle_change(here.angles, tree.angles[0]))
        own = min(longest, max(MIN_GROWTH_STEP, END_STEP_SHARE * to_end))
        if slide(space, here, own, min(least, 0.3 * own), work, there) == 0.0:
            break
        added = add_state(tree, node, there.angles)
        if added < 0:
            break
        node = added
        copy_state(there, here)
    return node
