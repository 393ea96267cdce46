import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies import Parameters
from hcsearch.library.assemblies.eight_r import (
    UNIT_I_JOINTS,
    UNIT_II_JOINTS,
    UNIT_III_JOINTS,
    assemble_unit,
    eight_r,
    read_crease_matches,
    second_angle,
    skew_symmetric_angles,
    unit_i,
    unit_ii,
    unit_iii,
)
from hcsearch.library.assemblies.overlays import join_patterns, joinings, placements
from hcsearch.library.assemblies.packages import flat_overlap, folded_package
from hcsearch.motion.kinematics.dh import dh_closure_jacobian
from hcsearch.motion.kinematics.numerical_rank import decide_rank, rank_at
from hcsearch.shape.linkage import Linkage
from tests.linkages import congruent

A16 = json.loads((Path(__file__).parents[1] / "golden" / "thesis_a16.json").read_text("utf-8"))["singular_values"]

parameters = st.builds(
    Parameters, alpha=st.floats(10, 84).map(math.radians), base=st.floats(0.01, 0.5), thickness=st.floats(0.002, 0.05)
)
units = pytest.mark.parametrize("unit", [unit_i, unit_ii, unit_iii])


def in_millimetres(jacobian):
    scaled = jacobian.copy()
    scaled[3::4] *= 1e3
    return scaled


@units
@given(parameters)
@settings(max_examples=15)
def test_panels_and_joints(unit, values):
    pattern = unit(values)
    assert [len(panel) for panel in pattern.panels].count(1) == 14
    assert [len(panel) for panel in pattern.panels].count(2) == 7
    assert len(pattern.hinges) == 24
    assert pattern.kutzbach == 0
    assert len(pattern.loops) == 4
    assert pattern.area == pytest.approx(2.8 * eight_r(values).area)
    assert flat_overlap(pattern) == 0


@units
@given(parameters)
@settings(max_examples=15)
def test_folded_on_two_triangles_and_a_parallelogram(unit, values):
    folded = folded_package(unit(values))
    assert folded.whole_ratio == "7:1"
    assert folded.heights == (5, 9)
    assert folded.is_stepped
    assert folded.void_volume == folded.overlap_volume == 0
    assert folded.height == pytest.approx(9 * values.thickness)


@units
@given(parameters, st.floats(0, math.pi))
@settings(max_examples=25)
def test_closed_all_along_the_skew_symmetric_path(unit, values, first):
    pattern = unit(values)
    angles = skew_symmetric_angles(pattern, values.alpha, first)
    assert np.abs(Linkage(pattern).closure(angles)[0]).max() < 1e-9


@units
@given(parameters, st.floats(0.1, 3.0))
@settings(max_examples=25)
def test_one_degree_of_freedom_and_which(unit, values, first):
    pattern = unit(values)
    linkage = Linkage(pattern)
    angles = skew_symmetric_angles(pattern, values.alpha, first)
    _, jacobian = linkage.closure(angles)
    assert rank_at(linkage, angles).rank == 23
    # the one motion is that of eq. 5.24: a small step along it agrees with the null space
    motion = np.linalg.svd(jacobian)[2][-1]
    step = skew_symmetric_angles(pattern, values.alpha, first + 1e-6) - skew_symmetric_angles(
        pattern, values.alpha, first - 1e-6
    )
    assert abs(motion @ step) == pytest.approx(np.linalg.norm(step), rel=1e-6)


@units
def test_nullity_four_at_both_ends(unit):
    for degrees in (46, 60, 70, 80):
        linkage = Linkage(unit(Parameters(alpha=math.radians(degrees))))
        assert rank_at(linkage, linkage.folded).nullity == rank_at(linkage, linkage.flat).nullity == 4


def test_singular_values_of_the_appendix():
    linkage = Linkage(unit_ii(Parameters(alpha=7 * math.pi / 18, base=0.030, thickness=0.010)))
    jacobian = in_millimetres(dh_closure_jacobian(linkage, linkage.folded))
    assert jacobian.shape == (48, 24)
    values = np.linalg.svd(jacobian, compute_uv=False)
    assert values[:20] == pytest.approx(A16, rel=5e-5)
    assert values[20:].max() < 1e-12


@units
@given(parameters, st.floats(0.1, 3.0))
@settings(max_examples=15)
def test_both_forms_of_the_jacobian_have_one_rank(unit, values, first):
    linkage = Linkage(unit(values))
    angles = skew_symmetric_angles(linkage.pattern, values.alpha, first)
    jacobian = dh_closure_jacobian(linkage, angles)
    jacobian[3::4] /= linkage.pattern.size
    rank = decide_rank(np.linalg.svd(jacobian, compute_uv=False), linkage.n_hinges)
    assert rank.rank == rank_at(linkage, angles).rank == 23


@pytest.mark.parametrize(
    ("unit", "steps"), [(unit_i, UNIT_I_JOINTS), (unit_ii, UNIT_II_JOINTS), (unit_iii, UNIT_III_JOINTS)]
)
def test_joints_that_merge_have_equal_angles_in_both_elements(unit, steps):
    """Eqs. 5.7 and 5.25 with 5.24: joints of one parity merge with joints of the same."""
    for equation in " ".join(steps).split():
        one, two = equation.split("=")
        assert int(one[1]) % 2 == int(two[1]) % 2


@pytest.mark.parametrize("steps", [UNIT_I_JOINTS, UNIT_II_JOINTS, UNIT_III_JOINTS])
@pytest.mark.parametrize("degrees", [60, 70])
def test_with_the_other_labels_the_elements_do_not_fit(steps, degrees):
    """With line a_i between A_i and A_{i+1}, joint i + 1 here, the conditions 5.7 and 5.25 cannot be met."""
    element = eight_r(Parameters(alpha=math.radians(degrees)))

    def relabelled(equation):
        return "=".join(f"{joint[0]}{int(joint[1]) % 8 + 1}" for joint in equation.split("="))

    others = [" ".join(map(relabelled, step.split())) for step in steps]
    assert assemble_unit(element, steps).kutzbach == 0
    with pytest.raises(PatternError, match="0 ways"):
        assemble_unit(element, others)


def test_b_is_turned_over_and_c_is_not():
    element = eight_r(Parameters())
    for joints, over in (("b1=a7 b2=a8", True), ("d7=a1 d8=a2", True), ("f6=a8 f7=a7 f8=a6", False)):
        (placement,) = placements(element, element, read_crease_matches(element, "a", element, joints[0], joints))
        assert placement.reflects is over


@pytest.mark.parametrize("unit", [unit_i, unit_ii])
def test_units_equal_their_mirror_images(unit):
    pattern = unit(Parameters())
    assert congruent(pattern, pattern.inverted())
    assert not congruent(unit_i(Parameters()), unit_ii(Parameters()))


@given(parameters, st.floats(-3, 3), st.booleans())
@settings(max_examples=10)
def test_elements_may_lie_anywhere(values, turn, over):
    element = eight_r(values)
    moved = element.moved(turn, (0.3, -0.2), over=over)
    assert congruent(element, moved)
    assert congruent(assemble_unit(moved, UNIT_I_JOINTS), unit_i(values))


def test_joining_needs_creases_that_leave_one_way():
    element = eight_r(Parameters())
    with pytest.raises(PatternError, match="leave one"):
        join_patterns(element, element, read_crease_matches(element, "a", element, "b", "b1=a2"))  # a base on a leg
    assert (
        joinings(element, element, read_crease_matches(element, "a", element, "b", "b1=a1 b2=a2")) == []
    )  # adds nothing


@pytest.mark.parametrize("text", ["b9=a1", "b0=a1", "c1=a1", "b1", "bx=a1", "b1=a"])
def test_joints_that_do_not_exist(text):
    element = eight_r(Parameters())
    with pytest.raises(PatternError, match="names no joints"):
        read_crease_matches(element, "a", element, "b", text)


def test_second_angle():
    assert second_angle(1.0, 0.0) == 0.0
    assert second_angle(1.0, math.pi) == pytest.approx(math.pi)
    assert math.cos(1.0) * math.tan(second_angle(1.0, 0.7) / 2) == pytest.approx(math.tan(0.35))


def deepest(pattern, angles):
    """Depth to which two panels cut through each other, by separating axes of all pairs of prisms of triangles."""
    solids = np.array(Linkage(pattern).solids(angles))
    up, edges = solids[:, 1, 0] - solids[:, 0, 0], np.roll(solids[:, 0], -1, axis=1) - solids[:, 0]
    normals = np.concatenate([up[:, None], np.cross(edges, up[:, None])], axis=1)
    sides = np.concatenate([up[:, None], edges], axis=1)
    corners = solids.reshape(len(solids), -1, 3)
    of, n = pattern.panel_of, len(solids)
    i, j = np.array([(i, j) for i in range(n) for j in range(i) if of[i] != of[j]]).T
    across = np.cross(sides[i][:, :, None], sides[j][:, None]).reshape(len(i), -1, 3)
    axes = np.concatenate([normals[i], normals[j], across], axis=1)
    lengths = np.linalg.norm(axes, axis=2)
    usable = lengths > 1e-9 * lengths.max()  # parallel edges span no axis
    axes /= np.where(usable, lengths, 1.0)[..., None]
    one, two = (np.einsum("kaj,kbj->kab", axes, corners[k]) for k in (i, j))
    reach = np.minimum(one.max(axis=2) - two.min(axis=2), two.max(axis=2) - one.min(axis=2))
    return float(np.where(usable, reach, np.inf).min(axis=1).max())


@pytest.mark.parametrize("unit", [eight_r, unit_i, unit_ii])
def test_panels_stay_clear_of_each_other_from_45_degrees_up(unit):
    """Thesis 5.3.1, at sampled states of the motion: panels touch at their hinges and nowhere cut deeper."""
    for degrees, clear in ((40, False), (44, False), (45, True), (60, True), (80, True)):
        values = Parameters(alpha=math.radians(degrees))
        pattern = unit(values)
        depths = [
            deepest(pattern, skew_symmetric_angles(pattern, values.alpha, first)) for first in (0.2, 0.8, 1.6, 2.4, 3.0)
        ]
        assert (max(depths) < 1e-9) == clear, degrees
