import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sectors import ISOSCELES, PRINTED, TRIANGLE, follows, round_slit_end

from hcsearch.basics.errors import PatternError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import Parameters
from hcsearch.library.assemblies.eight_r import (
    SLIT_FACETS,
    assembly_hindrance,
    eight_r,
    equal_side,
    joint_parts,
    measured_slit,
    second_angle,
    skew_symmetric_angles,
    slit_distance,
    ten_triangles,
    unit_i,
)
from hcsearch.library.assemblies.packages import flat_overlap, folded_package
from hcsearch.motion.kinematics.dh import dh_loop
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.shape.linkage import Linkage
from tests.linkages import congruent

GOLDEN = json.loads((Path(__file__).parents[1] / "golden" / "thesis_assemblies.json").read_text("utf-8"))

degrees = st.floats(5, 85).map(math.radians)
parameters = st.builds(Parameters, alpha=degrees, base=st.floats(0.01, 0.5), thickness=st.floats(0.001, 0.05))
moving = st.floats(0.05, 3.09)


@given(parameters)
@settings(max_examples=30)
def test_ten_congruent_triangles_without_overlap(values):
    pattern = ten_triangles(values)
    side = equal_side(values.alpha, values.base)
    for facet in pattern.facets:
        lengths = sorted(math.dist(facet[i - 1], facet[i]) for i in range(3))
        assert lengths == pytest.approx(sorted([side, side, values.base]))
    assert flat_overlap(pattern) == 0
    assert len(pattern.panels) == len(pattern.hinges) == 10
    assert pattern.kutzbach == 4
    linkage = Linkage(pattern)
    assert np.abs(linkage.closure(linkage.folded)[0]).max() < 1e-10


@given(parameters)
def test_a_half_turn_takes_each_panel_to_the_fourth_after_it(values):
    pattern = eight_r(values)
    turned = pattern.moved(math.pi, (equal_side(values.alpha, values.base), 0.0))
    for k in range(10):
        assert np.allclose(turned.facets[k], pattern.facets[(k + 5) % 10])
    # joints i and i + 4 lie on different faces: the half-turn exchanges mountains and valleys
    assert congruent(pattern, pattern.inverted())


def test_joints_lie_on_alternate_faces_but_where_two_meet_in_a_point():
    pattern = eight_r(Parameters())
    faces = [pattern.creases[pair].face for pair in pattern.loops[0]]
    same = [k + 1 for k in range(8) if faces[k] == faces[(k + 1) % 8]]
    assert same == [4, 8]  # a_45 = a_81 = 0
    assert faces[0] == "top"  # "line a_1 is a valley fold"


@given(parameters, moving)
def test_denavit_hartenberg_parameters(values, first):
    golden = GOLDEN["dh"]
    pattern = eight_r(values)
    linkage = Linkage(pattern)
    signs = [-sign for sign in golden["dtheta_by_dphi"]]
    loop = dh_loop(linkage, linkage.loops[0], skew_symmetric_angles(pattern, values.alpha, first), signs)
    side = equal_side(values.alpha, values.base)
    assert loop.lengths == pytest.approx(values.thickness * np.array(golden["lengths"]), abs=1e-12)
    assert loop.twists == pytest.approx(np.array(golden["twists"]) @ [values.alpha, math.pi])
    assert loop.offsets == pytest.approx(np.array(golden["offsets"]) @ [side, values.base], abs=1e-12)
    second = second_angle(values.alpha, first)
    thetas = [math.pi - first, second, -first, second, first - math.pi, -second, first, -second]  # eq. 5.2
    assert loop.variables == pytest.approx(thetas)


@given(parameters, st.floats(0, math.pi))
def test_closed_all_along_the_skew_symmetric_path(values, first):
    pattern = eight_r(values)
    angles = skew_symmetric_angles(pattern, values.alpha, first)
    assert np.abs(Linkage(pattern).closure(angles)[0]).max() < 1e-10


@given(parameters, moving)
@settings(max_examples=40)
def test_two_degrees_of_freedom(values, first):
    pattern = eight_r(values)
    assert len(pattern.panels) == len(pattern.hinges) == 8
    assert pattern.kutzbach == 2
    assert rank_at(Linkage(pattern), skew_symmetric_angles(pattern, values.alpha, first)).nullity == 2


def test_nullities_of_the_end_states():
    for pattern, expected in ((eight_r(Parameters()), 3), (ten_triangles(Parameters()), 5)):
        linkage = Linkage(pattern)
        assert rank_at(linkage, linkage.folded).nullity == rank_at(linkage, linkage.flat).nullity == expected


@given(parameters, st.floats(0, math.pi))
def test_slit_distance(values, first):
    pattern = eight_r(values)
    angles = skew_symmetric_angles(pattern, values.alpha, first)
    stated = slit_distance(values.alpha, values.thickness, first)
    assert measured_slit(pattern, angles) == pytest.approx(stated, abs=1e-12)


@given(parameters, moving)
def test_sides_of_the_slit_stay_parallel(values, first):
    pattern = eight_r(values)
    linkage = Linkage(pattern)
    third, seventh = (
        linkage.poses(skew_symmetric_angles(pattern, values.alpha, first))[pattern.panel_of[k]] for k in SLIT_FACETS
    )
    for axis in ((0, 0, 1), (0, 1, 0)):  # the panels' faces, and their walls at the slit
        assert np.abs(np.cross(third[:, :3] @ axis, seventh[:, :3] @ axis)).max() < 1e-9


@given(degrees, moving)
def test_the_slit_opens_above_45_degrees_and_interferes_below(alpha, first):
    distance = slit_distance(alpha, 0.01, first)
    if abs(alpha - math.pi / 4) > 1e-6:
        assert (distance > 0) == (alpha > math.pi / 4)
    assert slit_distance(math.pi / 4, 0.01, first) == pytest.approx(0, abs=1e-12)


def test_hindrance():
    assert assembly_hindrance(Parameters(alpha=math.radians(45))) is None
    assert assembly_hindrance(Parameters(alpha=math.radians(89))) is None
    assert "give one from 45 up" in assembly_hindrance(Parameters(alpha=math.radians(44.9)))


def test_equilateral_triangles_are_the_only_design_of_ten_triangles():
    words = [word for batch in PolygonSearch(GRIDS["triangle"], 10).batches() for word in batch.words.tolist()]
    (word,) = words
    values = Parameters(alpha=math.pi / 3)
    folded = foldings(Circuit(GRIDS["triangle"], tuple(word)))
    assert folded
    for folding in folded:
        size = (values.base, values.base, values.thickness)
        assert congruent(ten_triangles(values), folding.pattern(size, flat_pairs="hinged"))
        assert congruent(eight_r(values), folding.pattern(size))
        assert not congruent(eight_r(Parameters()), folding.pattern(size))


@given(parameters)
@settings(max_examples=20)
def test_package_of_five_layers_on_two_triangles(values):
    folded = folded_package(eight_r(values))
    assert (folded.whole_ratio, folded.n_layers, folded.is_stepped) == ("5:1", 5, False)
    assert folded.void_volume == folded.overlap_volume == 0


@pytest.mark.parametrize("alpha", [0.0, -1.0, math.pi / 2, math.nan])
def test_base_angles_that_no_triangle_has(alpha):
    with pytest.raises(PatternError, match="between 0 and 90"):
        Parameters(alpha=alpha)


@pytest.mark.parametrize("name", ["base", "thickness", "side", "width"])
@pytest.mark.parametrize("length", [0.0, -0.01, math.inf, math.nan])
def test_lengths_that_do_not_exist(name, length):
    with pytest.raises(PatternError, match="give a positive length"):
        Parameters(**{name: length})


def test_parts_of_joints():
    assert joint_parts(eight_r(Parameters())).tolist().count(0) == 4
    assert joint_parts(unit_i(Parameters())).tolist().count(0) == 12
    # at 60 degrees a loop may begin at a leg: then its elements would contradict each other
    pattern = eight_r(Parameters())
    loop = pattern.loops[0]
    begun_at_a_leg = replace(pattern, loops=(loop, loop[1:] + loop[:1]))
    assert joint_parts(begun_at_a_leg) is None
    with pytest.raises(PatternError, match="fold alike"):
        skew_symmetric_angles(begun_at_a_leg, 1.0, 1.0)


def test_only_isosceles_triangles_close_around_the_slit():
    assert follows(ISOSCELES, PRINTED)  # both equations, one for each arrangement, as the thesis has it
    assert follows(ISOSCELES, [round_slit_end(mirrored=False), TRIANGLE])  # one end of the slit says it already
    assert follows(TRIANGLE, PRINTED)  # so the printed pair needs no sum of angles besides
    assert not follows(ISOSCELES, [TRIANGLE])
    ends = [round_slit_end(mirrored=True), ((6, 0, 0), 2), TRIANGLE]  # kites: six equal sectors at both ends
    for angle in range(3):
        coefficients = [0, 0, 0]
        coefficients[angle] = 3
        assert follows((coefficients, 1), ends)  # equilateral


@given(st.integers(-5, 5), st.integers(-5, 5), st.integers(-5, 5), st.lists(st.integers(-3, 3), min_size=2, max_size=2))
def test_combinations_of_equations_follow(a, b, c, shares):
    equations = [((a, b, 2), c), ((b, 1, a), 1)]
    s, t = shares
    combined = [s * x + t * y for x, y in zip(equations[0][0], equations[1][0], strict=True)]
    assert follows((combined, s * c + t), equations)
    if np.linalg.matrix_rank([list(x) for x, _ in equations]) == 2:
        assert not follows((combined, s * c + t + 1), equations)


def closure_error(alpha, angles):
    """E of thesis eq. 5.6 with 5.2, 5.3 and 5.5 written out, dihedral angles phi_1 to phi_8."""
    signs = [-sign for sign in GOLDEN["dh"]["dtheta_by_dphi"]]
    twists = np.array(GOLDEN["dh"]["twists"]) @ [alpha, math.pi]
    offsets = np.array(GOLDEN["dh"]["offsets"]) @ [3.0, 6.0 * math.cos(alpha)]
    steps = []
    for k, (sign, twist, a, d) in enumerate(zip(signs, twists, GOLDEN["dh"]["lengths"], offsets, strict=True)):
        theta = -sign * angles[k] + (math.pi if k == 0 else -math.pi if k == 4 else 0.0)
        c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(twist), math.sin(twist)
        steps.append(np.array([[c, -ca * s, sa * s, a * c], [s, ca * c, -sa * c, a * s], [0, sa, ca, d], [0, 0, 0, 1]]))
    first, second = (np.linalg.multi_dot(half) for half in (steps[:4], steps[4:]))
    return first - np.linalg.inv(second)


def test_equations_of_unit_i_are_those_of_equilateral_triangles():
    """Eqs. 5.13 and 5.16 with 5.10 at arbitrary angles: right at 60 degrees, wrong at others."""
    phi = np.array([0.7, 1.9, 2.4, 1.1])
    t1, t2, t3, t4 = t = np.tan(phi / 2)
    all_eight = phi[[0, 1, 2, 3, 2, 3, 0, 1]]
    below = np.prod(1 + t**2)
    first = 6 * (t1 * t2 - t3 * t4) * (t2 * (t3 - t4) + t1 * t4) / below
    bracket = 4 * (t1 + t3) - 2 * (t2 + t4) + 2 * t1 * t3 * (t2 + t4) - t2 * t4 * (t1 + t3)
    third = 3 * t2 * t4 * (t3 - t1) * bracket / (2 * below)
    error = closure_error(math.pi / 3, all_eight)
    assert (error[0, 0], error[2, 2]) == pytest.approx((first, third), abs=1e-12)
    error = closure_error(math.radians(70), all_eight)
    assert abs(error[0, 0] - first) > 0.01
    assert abs(error[2, 2] - third) > 0.01
    for degrees in (50, 60, 70):  # eq. 5.24 needs no such angle
        alpha = math.radians(degrees)
        assert np.abs(closure_error(alpha, [1.2, second_angle(alpha, 1.2)] * 4)).max() < 1e-12
