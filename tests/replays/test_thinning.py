from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.subjects.replay import thin_states

TOLERANCES = st.sampled_from([0.0, 1e-3, 0.1, 3.0])


@st.composite
def motions(draw, jumps: bool = False):
    """Places and fold angles; jumps : some steps have no length, so that two states are at one place."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    k = draw(st.integers(1, 30))
    steps = random.uniform(0.01, 1.0, k) * (random.random(k) > 0.3 if jumps else 1.0)
    wild = random.uniform(-3.0, 3.0, (k, 3))
    smooth = np.sin(np.cumsum(steps)[:, None] * [0.1, 0.5, 1.0])
    return np.cumsum(steps), draw(st.sampled_from([wild, smooth]))


def greatest_error(at, angles, kept) -> float:
    """By how much the line through two kept states misses one between them at most: one state, one hinge at a time."""
    worst = 0.0
    for before, after in pairwise(kept):
        for k in range(before + 1, after):
            share = (at[k] - at[before]) / (at[after] - at[before])
            for h in range(angles.shape[1]):
                line = (1.0 - share) * angles[before, h] + share * angles[after, h]
                worst = max(worst, abs(line - angles[k, h]))
    return worst


@given(motions() | motions(jumps=True), TOLERANCES)
def test_the_error_is_the_greatest_of_all_states_and_within_the_tolerance(motion, tolerance):
    kept, error = thin_states(*motion, tolerance)
    assert error == pytest.approx(greatest_error(*motion, kept.tolist()), abs=1e-12)
    assert error <= tolerance


@given(motions() | motions(jumps=True), TOLERANCES)
def test_ends_and_both_states_of_a_jump_are_kept_and_none_comes_twice(motion, tolerance):
    at, angles = motion
    kept, _ = thin_states(at, angles, tolerance)
    jumps = np.flatnonzero(np.diff(at) == 0.0)
    assert {0, len(at) - 1, *jumps, *(jumps + 1)} <= set(kept.tolist())
    assert (np.diff(kept) > 0).all()


@given(motions(), st.floats(1e-6, 1.0))
def test_what_is_kept_is_not_thinned_again_and_a_line_keeps_its_ends_alone(motion, tolerance):
    at, angles = motion
    kept, _ = thin_states(at, angles, tolerance)
    again, error = thin_states(at[kept], angles[kept], tolerance)
    assert len(again) <= len(kept)
    assert error <= tolerance
    line = np.outer(at, [1.0, -2.0])
    assert thin_states(at, line, tolerance)[0].tolist() == sorted({0, len(at) - 1})
