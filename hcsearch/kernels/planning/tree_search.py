"""Trees of closed states that grow from both ends, or from other roots, until they meet."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.planning.closed_states import PLANNING_CLOSURE_RESIDUAL, close_state
from hcsearch.kernels.planning.sliding import slide
from hcsearch.kernels.planning.space import (
    Space,
    SpaceWork,
    StateStack,
    copy_state,
    greatest_angle_change,
    greatest_magnitude,
    link_states,
    pick_state,
    place_state,
)

STATE_CELL_WIDTH = 0.15
"""Width (rad) of the cells in which states count as alike."""
MAX_STATES_PER_CELL = 2
"""States per cell that a tree keeps, besides those on the path to others."""
END_STEP_SHARE, MIN_GROWTH_STEP = 0.4, 0.003
"""Longest step as a share of the distance to the root or to an end, and its lower limit (rad)."""
MIN_GROWTH_GAIN = 2e-3
"""Least share of the distance to the target by which a step must come nearer to count as progress."""
MAX_IDLE_STEPS = 2
"""Steps without progress that are allowed before a tree grows elsewhere."""


class StateTree(NamedTuple):
    """A tree of states whose root has every hinge at a stop.

    angles : (capacity, m). parents : (capacity,), -1 for the root. size : (1,), number of states.
    keys, cell_counts : hash table of cells, and the number of states in each.
    """

    angles: Reals
    parents: WholeNumbers
    size: WholeNumbers
    keys: WholeNumbers
    cell_counts: WholeNumbers


@compiled
def new_tree(capacity: int, root: Reals) -> StateTree:
    """Return a tree that consists of its root."""
    slots = 4
    while slots < 4 * capacity:
        slots *= 2
    angles, parents, size = np.zeros((capacity, len(root))), np.full(capacity, -1), np.ones(1, np.int64)
    tree = StateTree(angles, parents, size, np.zeros(slots, np.int64), np.zeros(slots, np.int64))
    tree.angles[0] = root
    return tree


@compiled
def add_state(tree: StateTree, parent: int, angles: Reals) -> int:
    """Add a state; return its number, or -1 where the tree is full."""
    n = tree.size[0]
    if n == len(tree.parents):
        return -1
    for h in range(len(angles)):
        tree.angles[n, h] = angles[h]
    tree.parents[n] = parent
    tree.size[0] = n + 1
    return int(n)


@compiled
def nearest_state(tree: StateTree, angles: Reals, beyond: float) -> tuple[int, float]:
    """Return the nearest state beyond a squared distance (rad^2), -1 without one, and its own squared distance."""
    nearest, least_distance = -1, math.inf
    for i in range(tree.size[0]):
        total = 0.0
        for h in range(len(angles)):
            total += (tree.angles[i, h] - angles[h]) ** 2
            if total >= least_distance:
                break
        if beyond < total < least_distance:
            nearest, least_distance = i, total
    return nearest, least_distance


@compiled
def cell_slot(tree: StateTree, row: int) -> int:
    """Return the slot of a state's cell in the hash table."""
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


@compiled
def keep_new_states(tree: StateTree, first: int) -> bool:
    """Keep the branch of states from `first` to the last one in a cell that is not full; return whether any is kept."""
    end = first
    for i in range(first, tree.size[0]):
        slot = cell_slot(tree, i)
        if tree.cell_counts[slot] < MAX_STATES_PER_CELL:
            end = i + 1
            tree.cell_counts[slot] += 1
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
    """Grow a tree from a state towards a target by steps along contacts; return the last state added, or the first one.

    springs : (m,), weights of the hinges. limits : longest step (rad), greatest singular value of closure that counts
    as zero, and greatest number of steps.
    """
    longest, zero_singular_value, steps = limits
    here, there = pick_state(stack, 0), pick_state(stack, 1)
    place_state(space, tree.angles[node], -math.inf, here)
    best, idle = math.inf, 0
    for _ in range(steps):
        distance = 0.0
        for h in range(len(target)):
            offset = target[h] - here.angles[h]
            work.wanted_step[h] = springs[h] * offset
            distance += springs[h] * offset * offset
        idle = idle + 1 if distance > best * (1.0 - MIN_GROWTH_GAIN) else 0
        if distance < 1e-6 or idle > MAX_IDLE_STEPS:
            break
        best = min(best, distance)
        to_end = min(greatest_angle_change(here.angles, space.folded), greatest_magnitude(here.angles))
        to_end = min(to_end, greatest_angle_change(here.angles, tree.angles[0]))
        step_length = min(longest, max(MIN_GROWTH_STEP, END_STEP_SHARE * to_end))
        if slide(space, here, step_length, min(zero_singular_value, 0.3 * step_length), work, there) == 0.0:
            break
        added = add_state(tree, node, there.angles)
        if added < 0:
            break
        node = added
        copy_state(there, here)
    return node


MAX_TREE_STEP = 0.12
"""Longest step (rad)."""
MAX_SEARCH_PIECE = 0.1
"""Longest straight piece (rad)."""
SEARCH_ZERO_SINGULAR_VALUE = 1e-7
"""Singular values of the closure Jacobian up to this count as zeros."""
MAX_SEARCH_HALVINGS = 12
"""Pieces are halved no more often than this."""
MIN_TREE_ROOM = 200
"""Free capacity (states) that a tree needs to grow."""
TREES_MET, TREES_GOING, TREES_FULL = 0, 1, 2
"""Result of a search: the trees have met; may still meet; have no room to grow."""


class Meeting(NamedTuple):
    """The place where two trees met.

    nodes : (2,), a state of each. bridge : closed states from the first to the second. bridge_size : (1,), their
    number.
    """

    nodes: WholeNumbers
    bridge: Reals
    bridge_size: WholeNumbers


@compiled
def fan_out(
    space: Space, tree: StateTree, start_count: int, tries: int, seed: int, stack: StateStack, work: SpaceWork
) -> int:
    """Add random states near the root, with the states that lead to them; return how many were reached.

    Most hinges cannot turn by themselves there: angles are moved off their stops, or either way between them, at random
    and closed. States are sampled at several distances, as regions that are blocked near the root may be open further
    out.
    """
    np.random.seed(seed)
    m = len(space.folded)
    angles, between = np.empty(m), np.empty((MIN_TREE_ROOM, m))
    reached = 0
    root = tree.angles[0].copy()
    for k in range(tries):
        if reached == start_count or tree.size[0] + MIN_TREE_ROOM >= len(tree.parents):
            break
        off = (0.01, 0.03, 0.06, 0.12, 0.25)[np.random.randint(5)]
        power = (0.5, 1.0, 2.0, 4.0)[np.random.randint(4)]
        for h in range(m):
            angles[h] = np.random.random() ** power
            if root[h] < 1.0 and k % 2 and space.folded[h] < 1.0:
                angles[h] *= 0.1  # pairs that are flat in both states need not open
        widest = angles.max()
        for h in range(m):
            turn = off * angles[h] / widest
            if 0.0 < root[h] < math.pi:
                turn *= 1.0 if np.random.random() < 0.5 else -1.0
            angles[h] = min(abs(root[h] - turn), math.pi)
        closed = close_state(space.loops, angles, PLANNING_CLOSURE_RESIDUAL, 0.0, 30, work.closing)
        if not closed or greatest_angle_change(angles, root) < 0.3 * off:
            continue
        if not place_state(space, angles, space.min_gap, pick_state(stack, 0)):
            continue
        count = link_states(space, root, angles, MAX_SEARCH_PIECE, MAX_SEARCH_HALVINGS, stack, work, between)
        if count < 0:
            continue
        node = 0
        for i in range(count):
            node = add_state(tree, node, between[i])
        add_state(tree, node, angles)
        reached += 1
    return reached


@compiled
def search_trees(
    space: Space,
    first: StateTree,
    second: StateTree,
    rounds: int,
    seed: int,
    stack: StateStack,
    work: SpaceWork,
    meeting: Meeting,
) -> int:
    """Grow two trees in turn until they meet; return MET, GOING after the given rounds, or FULL.

    Each round one tree grows: by soft springs from a random state, towards a random state of the other tree, into a
    random direction, or from its nearest state towards random angles. Where it reaches a new cell it is linked with
    the root of the other tree, where that is near, or the other tree's nearest states grow towards it.
    """
    np.random.seed(seed)
    m = len(space.folded)
    target, springs = np.empty(m), np.ones(m)
    for _ in range(rounds):
        swapped = np.random.random() < 0.5
        tree, other = (second, first) if swapped else (first, second)
        full = tree.size[0] + MIN_TREE_ROOM >= len(tree.parents)
        if full and other.size[0] + MIN_TREE_ROOM >= len(other.parents):
            return TREES_FULL
        if full:
            continue
        goal = other.angles[0]
        springs[:] = 1.0
        node, steps = _choose(space, tree, other, goal, target, springs)
        longest = MAX_TREE_STEP * (1.0 if np.random.random() < 0.7 else 0.3)
        zero_singular_value = SEARCH_ZERO_SINGULAR_VALUE if np.random.random() < 0.7 else 0.3 * longest
        before = tree.size[0]
        node = grow_towards(space, tree, node, target, springs, (longest, zero_singular_value, steps), stack, work)
        if tree.size[0] == before:
            continue
        last = tree.size[0]
        if not keep_new_states(tree, before):
            if np.random.random() > 0.05:
                continue
            tree.size[0] = last  # a tree without a new state tries to reach the other now and then all the same
        node = tree.size[0] - 1
        if _reach_root(space, tree, node, goal, stack, work, meeting) or _reach_tree(
            space, tree, other, node, stack, work, meeting
        ):
            if swapped:
                _turn_around(meeting)
            return TREES_MET
    return TREES_GOING


@compiled
def _choose(
    space: Space, tree: StateTree, other: StateTree, goal: Reals, target: Reals, springs: Reals
) -> tuple[int, int]:
    """Choose a target and spring weights for a tree; return the state to grow from and the greatest number of steps."""
    m = len(target)
    kind = np.random.random()
    node = np.random.randint(tree.size[0])
    if kind < 0.15:
        target[:] = goal
        for h in range(m):
            springs[h] = math.exp(-3.5 * np.random.random())
        return node, 60
    if kind < 0.3:
        target[:] = other.angles[np.random.randint(other.size[0])]
        return nearest_state(tree, target, -1.0)[0], 30
    if kind < 0.5:
        for h in range(m):
            target[h] = tree.angles[node, h] + 2.0 * np.random.normal()
        return node, 12
    for h in range(m):
        target[h] = math.pi * min(max(1.3 * np.random.random() - 0.15, 0.0), 1.0)
    return nearest_state(tree, target, -1.0)[0], 12


@compiled
def _reach_root(
    space: Space, tree: StateTree, node: int, goal: Reals, stack: StateStack, work: SpaceWork, meeting: Meeting
) -> bool:
    """Try to link a state with the root of the other tree, if that is near; return whether it succeeded."""
    if greatest_angle_change(tree.angles[node], goal) > 0.5:
        return False
    before = tree.size[0]
    last = grow_towards(
        space, tree, node, goal, np.ones(len(goal)), (MAX_SEARCH_PIECE, SEARCH_ZERO_SINGULAR_VALUE, 40), stack, work
    )
    count = link_states(
        space, tree.angles[last], goal, MAX_SEARCH_PIECE, MAX_SEARCH_HALVINGS, stack, work, meeting.bridge
    )
    if count < 0:
        tree.size[0] = before
        return False
    meeting.nodes[0], meeting.nodes[1], meeting.bridge_size[0] = last, 0, count
    return True


@compiled
def _reach_tree(
    space: Space, tree: StateTree, other: StateTree, node: int, stack: StateStack, work: SpaceWork, meeting: Meeting
) -> bool:
    """Try to link a state with the nearest states of the other tree, which may grow; return whether it succeeded."""
    beyond = -1.0
    for attempt in range(3):
        if other.size[0] + MIN_TREE_ROOM >= len(other.parents):
            return False
        start, distance = nearest_state(other, tree.angles[node], beyond)
        if start < 0 or (attempt > 0 and distance > 1.0):
            return False
        beyond, before = distance, other.size[0]
        limits = (MAX_TREE_STEP, SEARCH_ZERO_SINGULAR_VALUE, 40)
        last = grow_towards(space, other, start, tree.angles[node], np.ones(len(space.folded)), limits, stack, work)
        if greatest_angle_change(other.angles[last], tree.angles[node]) < 0.3:
            count = link_states(
                space, tree.angles[node], other.angles[last], MAX_SEARCH_PIECE, 8, stack, work, meeting.bridge
            )
            if count >= 0:
                meeting.nodes[0], meeting.nodes[1], meeting.bridge_size[0] = node, last, count
                return True
        if keep_new_states(other, before):
            return False
    return False


@compiled
def _turn_around(meeting: Meeting) -> None:
    """Reverse a meeting, so that it starts from the second tree."""
    meeting.nodes[0], meeting.nodes[1] = meeting.nodes[1], meeting.nodes[0]
    count = meeting.bridge_size[0]
    meeting.bridge[:count] = meeting.bridge[:count][::-1].copy()
