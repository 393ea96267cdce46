"""Linkages: closure of loops, its derivatives, and the two ends of every folding."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.folding import Folding, foldings
from hcsearch.shape.linkage import Linkage
from tests import naive
from tests.strategies import circuits


def size(grid, unit=1.0):
    """Panels of 50 mm, or 50 x 40 mm, and 6 mm thick."""
    return (0.05 * unit, (0.04 if grid.name == "rectangle" else 0.05) * unit, 0.006 * unit)


@st.composite
def patterns(draw, **options):
    circuit = draw(circuits(even=True).filter(foldings))
    folding: Folding = draw(st.sampled_from(foldings(circuit)))
    return folding, folding.pattern(size(circuit.grid), **options)


@given(patterns(flat_pairs="hinged"), st.booleans())
def test_both_ends_close_and_lie_in_their_layers(drawn, merged):
    folding, pattern = drawn
    if merged:
        pattern = folding.pattern(size(folding.circuit.grid), flat_pairs="merged")
    linkage = Linkage(pattern)
    for angles in (linkage.flat, linkage.folded):
        assert np.abs(linkage.closure(angles)[0]).max(initial=0.0) < 1e-12
    thickness = pattern.thickness
    # the held panel, not always the lowest, keeps its place; stacks grow by one thickness a layer
    solids = linkage.solids(linkage.folded)
    bottoms = np.array([solid[:, :, 2].min() for solid in solids])
    layers = (bottoms - bottoms.min()) / thickness
    assert layers == pytest.approx(np.array(folding.layers), abs=1e-9) or layers == pytest.approx(
        max(folding.layers) - np.array(folding.layers), abs=1e-9
    )
    for stack in folding.stacks:
        outlines = [np.sort(np.round(solids[panel][0, :, :2], 9), axis=0) for panel in stack]
        for outline in outlines[1:]:
            assert outline == pytest.approx(outlines[0], abs=1e-9)


@given(patterns(flat_pairs="hinged"), st.integers(0, 2**32 - 1))
def test_closure_is_the_product_of_rotation_matrices(drawn, seed):
    _, pattern = drawn
    linkage = Linkage(pattern)
    angles = np.random.default_rng(seed).uniform(-0.4, 0.4, linkage.n_hinges)
    residual, _ = linkage.closure(angles)
    (loop,) = linkage.loops
    twin = naive.around_the_loop(linkage.directions, linkage.points, loop, angles)
    assert residual[3:] * pattern.size == pytest.approx(twin[:3, 3], abs=1e-12)
    assert naive.rotation(residual[:3]) == pytest.approx(twin[:3, :3], abs=1e-9)


@given(patterns(flat_pairs="hinged"), st.booleans(), st.integers(0, 2**32 - 1))
def test_jacobian_and_bend_are_the_derivatives_of_the_residual(drawn, flat, seed):
    _, pattern = drawn
    linkage = Linkage(pattern)
    start = linkage.flat if flat else linkage.folded
    velocity = np.random.default_rng(seed).normal(size=linkage.n_hinges)
    _, jacobian = linkage.closure(start)
    h = 1e-4
    ahead, back = (linkage.closure(start + sign * h * velocity)[0] for sign in (1, -1))
    scale = np.linalg.norm(velocity) ** 2
    assert (ahead - back) / (2 * h) == pytest.approx(jacobian @ velocity, abs=1e-5 * scale * linkage.n_hinges)
    # along the null space the second derivative is the bend alone
    _, singular, vt = np.linalg.svd(jacobian)
    null = vt[np.count_nonzero(singular > 1e-9) :]
    slow = null.T @ (null @ velocity)
    ahead, back = (linkage.closure(start + sign * h * slow)[0] for sign in (1, -1))
    assert (ahead + back) / h**2 == pytest.approx(linkage.bend(jacobian, slow), abs=1e-5 * scale * linkage.n_hinges)


@given(patterns(flat_pairs="merged"))
def test_loops_are_closed_walks_and_independent(drawn):
    _, pattern = drawn
    linkage = Linkage(pattern)
    assert len(linkage.loops) == linkage.n_hinges - linkage.n_panels + 1
    for loop in linkage.loops:
        ends = []
        for h, sign in loop:
            hinge = pattern.hinges[h]
            ends.append((hinge.first, hinge.second) if sign == 1 else (hinge.second, hinge.first))
        assert all(before[1] == after[0] for before, after in zip(ends, ends[1:] + ends[:1], strict=True))
    assert linkage._independent(linkage.loops)


def test_rotations_by_almost_pi_are_told_apart():
    """The residual is the rotation vector also where its sine vanishes."""
    from hcsearch.kernels.linkage.loops import _rotation_vector

    rng = np.random.default_rng(5)
    for angle in (0.0, 1e-9, 1.0, 3.0, math.pi - 1e-6, math.pi - 1e-9, math.pi):
        for _ in range(20):
            axis = rng.normal(size=3)
            axis /= np.linalg.norm(axis)
            pose, vector = np.zeros((3, 4)), np.empty(3)
            pose[:, :3] = naive.rotation(angle * axis)
            _rotation_vector(pose, vector)
            assert naive.rotation(vector) == pytest.approx(pose[:, :3], abs=1e-7)
            assert np.linalg.norm(vector) == pytest.approx(angle, abs=1e-7)


@given(patterns(), st.sampled_from([1e-6, 1e6]))
def test_residual_and_jacobian_do_not_depend_on_the_unit_of_length(drawn, unit):
    folding, pattern = drawn
    scaled = Linkage(folding.pattern(size(folding.circuit.grid, unit)))
    angles = np.linspace(0.0, 1.0, len(pattern.hinges))
    for one, two in zip(Linkage(pattern).closure(angles), scaled.closure(angles), strict=True):
        assert one == pytest.approx(two, rel=1e-9, abs=1e-9)
