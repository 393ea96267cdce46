"""The step that closes loops is the damped least-squares solution, and leaves alone what is zero but for rounding."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.kernels.linkage.closing_steps import damped_step
from hcsearch.motion.kinematics.closing import correction


@given(st.integers(0, 9), st.integers(0, 9), st.integers(0, 9), st.integers(0, 2**32 - 1), st.floats(-4.0, 1.0))
def test_the_step_is_that_of_a_general_solver(m, n, rank, seed, exponent):
    rng = np.random.default_rng(seed)
    jacobian, residual = rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n)), rng.normal(size=m)
    damping = 10.0**exponent
    below = np.vstack([jacobian, damping * np.eye(n)])
    known = np.linalg.lstsq(below, -np.r_[residual, np.zeros(n)], rcond=None)[0]
    allowed = 1e-12 * (1.0 + np.abs(jacobian).max(initial=0.0)) / damping**2
    assert damped_step(jacobian, residual, damping) == pytest.approx(known, abs=allowed)


@given(st.integers(0, 2**32 - 1), st.floats(-14.0, -1.0))
def test_redundant_loops_turn_no_hinge_much_more_than_the_residual_asks(seed, exponent):
    rng = np.random.default_rng(seed)
    loop, size = rng.normal(size=(6, 10)), 10.0**exponent
    residual = size * rng.normal(size=6)
    twice = correction(np.vstack([loop, loop]), np.r_[residual, residual])
    least = np.abs(np.linalg.svd(loop, compute_uv=False)).min()
    assert np.linalg.norm(twice) <= 1.1 * np.linalg.norm(residual) / least + size
    apart = correction(np.vstack([loop, loop]), np.r_[residual, -residual])  # no step closes such loops
    assert np.linalg.norm(apart) <= 10.0 * np.linalg.norm(residual) + 1e-5
