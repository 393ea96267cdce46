"""Cuts of all angles that tell the states of one part of the closed states from those of others."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.motion.locks.boxes import (
    MAX_BOX_ANGLE,
    MAX_RECUTS,
    MIN_CUT_WIDTH,
    BoxCuts,
    CutLeaf,
    divided_leaves,
    leaves_around,
    states_in,
    whole_box,
)


def rooms(boxes):
    """How much room boxes take, each."""
    return [float(np.prod(high - low)) for low, high in boxes]


def two_clouds(rng, n, count):
    """States of two parts, in a row of blobs which belong to either by chance."""
    blobs = rng.uniform(0.0, np.pi, (count, 1, n))
    states = np.clip(blobs + rng.uniform(-0.4, 0.4, (count, 30, n)), 0.0, np.pi)
    first = np.arange(count) % 2 == 0
    return states[first].reshape(-1, n), states[~first].reshape(-1, n)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(2, 6))
def test_each_leaf_holds_states_of_one_kind_and_all_of_them_fill_the_whole(seed, n, count):
    own, others = two_clouds(np.random.default_rng(seed), n, count)
    assume(np.abs(own[:, None] - others).max(axis=2).min() > 10 * MIN_CUT_WIDTH)
    leaves = leaves_around(own, others)
    assert leaves is not None
    boxes = [leaf.box for leaf in leaves]
    inside = [leaf.box for leaf in leaves if leaf.inside]
    assert all((np.minimum(a[1], b[1]) <= np.maximum(a[0], b[0])).any() for a, b in combinations(boxes, 2))
    assert math.isclose(sum(rooms(boxes)), MAX_BOX_ANGLE**n, rel_tol=1e-9)
    assert all(any(len(states_in(box, state[None])) for box in inside) for state in own)
    assert not any(len(states_in(box, others)) for box in inside)
    assert all((low >= 0.0).all() and (high <= MAX_BOX_ANGLE).all() and (low <= high).all() for low, high in boxes)


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.booleans())
def test_new_states_divide_no_box_but_theirs(seed, n, mine):
    rng = np.random.default_rng(seed)
    own, others = two_clouds(rng, n, 4)
    leaves = leaves_around(own, others)
    assume(leaves is not None)
    state = rng.uniform(0.0, np.pi, (1, n))
    kinds = (np.concatenate([own, state]), others) if mine else (own, np.concatenate([others, state]))
    kept = divided_leaves(leaves, *kinds)
    assume(kept is not None)
    assert all(leaf in kept for leaf in leaves if not len(states_in(leaf.box, state)))
    assert all(leaf.inside == mine for leaf in kept if len(states_in(leaf.box, state)))


def test_a_wide_void_is_cut_in_the_middle():
    rng = np.random.default_rng(2)
    own, others = rng.uniform([0.0, 0.0], [1.0, 3.1], (200, 2)), rng.uniform([2.0, 0.0], [3.1, 3.1], (200, 2))
    leaves = divided_leaves([CutLeaf(whole_box(2), inside=True)], own, others)
    assert leaves is not None
    assert [leaf.inside for leaf in leaves] == [True, False]
    assert leaves[0].box[1][0] == 0.5 * (own[:, 0].max() + others[:, 0].min())


def test_states_that_are_the_same_cannot_be_cut_apart():
    state = np.full((1, 3), 0.7)
    assert leaves_around(state, state) is None


@pytest.mark.parametrize("asked", [True, False])
def test_cuts_are_kept_once_that_is_asked_for_or_after_eight_times(asked):
    rng = np.random.default_rng(4)
    own, others = two_clouds(rng, 2, 4)
    cuts = BoxCuts()
    for count in range(MAX_RECUTS):
        laid = cuts.boxes_around(own[: len(own) - count], others)
        assert equal(laid, inside(leaves_around(own[: len(own) - count], others)))
        if asked:
            cuts.freeze()
            break
    more, left = np.concatenate([others, rng.uniform(0.0, np.pi, (50, 2))]), own[:30]
    last = leaves_around(own[: len(own) - count], others)
    assert equal(cuts.boxes_around(left, more), inside(divided_leaves(last, left, more)))
    assert not equal(inside(divided_leaves(last, left, more)), inside(leaves_around(left, more)))


def inside(leaves):
    """Boxes that are taken in."""
    return [leaf.box for leaf in leaves if leaf.inside]


def equal(some, others):
    """Whether boxes are equal, one by one."""
    return len(some) == len(others) and np.array_equal(np.array(some), np.array(others))
