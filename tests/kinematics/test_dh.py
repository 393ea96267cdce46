"""Denavit-Hartenberg loops against the thesis's numbers, products of exponentials and the screw Jacobian."""

import json
import math
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.kinematics.dh import (
    DHLoop,
    HingeLines,
    _common_normals,
    dh_closure_jacobian,
    dh_jacobian,
    dh_loop,
    dh_of_lines,
    flat_hinge_lines,
    hinge_lines,
    stacked_jacobian,
    transforms,
)
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests import golden
from tests.strategies import circuits

PI = math.pi
A16 = json.loads(Path(golden.__file__).with_name("thesis_a16.json").read_text(encoding="utf-8"))
ANGLES = st.floats(-PI, PI)


def first_frame(lines):
    """Pose of frame 1 in the coordinates of the lines."""
    x, origins, _ = _common_normals(lines)
    z = lines.directions[0]
    return np.vstack([np.column_stack([x[0], np.cross(z, x[0]), z, origins[0]]), [0.0, 0.0, 0.0, 1.0]])


def closure_matrix(loop):
    """T_21 T_32 ... T_1n: the identity where the loop is closed (eqs. 2.3 and A1)."""
    return reduce(np.matmul, transforms(loop))


def screw_map(frame, closure=None):
    """The linear map from the screw Jacobian of a loop to its D-H Jacobian, (12, 6).

    frame : pose of frame 1 in the coordinates of the screws, each a rotation and the velocity at the origin (metres).
    closure : closure matrix of the loop, the identity unless given. There, an angular component comes twice, with
        both signs, and a velocity once; the map has full rank in any case, so both Jacobians have one null space.
    """
    closed, inverse, twists = np.eye(4) if closure is None else closure, np.linalg.inv(frame), np.zeros((6, 4, 4))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        twists[k, i, j], twists[k, j, i], twists[k + 3, k, 3] = -1.0, 1.0, 1.0
    return np.column_stack([(inverse @ twist @ frame @ closed)[:3].ravel() for twist in twists])


# the thesis's two loops: parameters as printed, variables from dihedral angles


def eight_r(alpha, thickness, d, phi):
    """Eqs. 5.3 and 5.2."""
    base = 2 * d * math.cos(alpha)
    return DHLoop(
        thickness * np.array([1, 1, 1, 0, 1, 1, 1, 0.0]),
        np.array([-alpha, alpha, alpha, PI - alpha, alpha, -alpha, -alpha, alpha - PI]),
        np.array([0, 0, base, -d, 0, 0, base, -d]),
        np.array([PI, 0, 0, 0, -PI, 0, 0, 0]) + EIGHT_R_SIGNS * phi,
    )


def six_r(thickness, phi, theta_3):
    """Eqs. 6.2 and 6.3, with theta_3 as a function of phi_3."""
    theta = np.array([0, 0, 0, 0, 0, -PI]) + [-1, 1, 0, -1, 1, 1] * phi
    theta[2] = theta_3(phi[2])
    twists = np.array([-1, 2, 1, -1, 2, 1]) * PI / 4
    return DHLoop(thickness * np.array([1, 0, 1, 1, 0, 1.0]), twists, np.zeros(6), theta)


EIGHT_R_SIGNS = np.array([-1, 1, -1, 1, 1, -1, 1, -1])  # d theta / d phi of eq. 5.2
SIX_R_SIGNS = np.array([-1, 1, 1, -1, 1, 1])  # of eq. 6.3, theta_3 corrected


def gap(loop):
    return np.abs(closure_matrix(loop) - np.eye(4)).max()


def moved_together(alpha, phi):
    """Dihedral angles of eq. 5.24."""
    return np.array([phi, 2 * math.atan2(math.tan(phi / 2), math.cos(alpha))] * 4)


def vertex_angles(phi):
    """Dihedral angles of eq. 6.4."""
    second = 2 * math.atan(math.cos(PI / 4) * math.tan(phi / 2))
    return np.array([phi, second, second, phi, second, second])


@given(st.floats(0.02, PI / 2 - 0.02), st.floats(0, PI - 0.001))
def test_eq_5_24_closes_the_8r_for_every_base_angle(alpha, phi):
    assert gap(eight_r(alpha, 0.01, 0.03, moved_together(alpha, phi))) < 1e-14


@given(st.floats(0, PI - 0.001))
def test_eq_6_3_closes_with_its_third_sign_corrected(phi):
    dihedral = vertex_angles(phi)
    assert gap(six_r(0.01, dihedral, lambda phi_3: phi_3 - PI)) < 1e-14
    # as printed, hinge 3 is 2 phi_3 - pi off: right for phi_3 = pi / 2 only
    assert gap(six_r(0.01, dihedral, lambda phi_3: -phi_3)) >= 0.9 * abs(math.cos(dihedral[2])) - 1e-14


def test_a_i_of_the_matrices_is_the_length_beside_its_twist():
    loop = six_r(0.01, vertex_angles(1.0), lambda phi_3: phi_3 - PI)
    other = DHLoop(np.roll(loop.lengths, 1), loop.twists, loop.offsets, loop.variables)
    assert gap(loop) < 1e-15
    assert gap(other) > 1e-3


def unit_ii():
    """Jacobian of the four 8R elements of unit II, folded, in millimetres, merged as eq. 5.25 says."""
    alpha = 7 * PI / 18
    loop = eight_r(alpha, 10, 15 / math.cos(alpha), np.zeros(8))
    walks = [tuple((column - 1, 1) for column in columns) for columns in A16["columns"].values()]
    return stacked_jacobian([loop] * 4, walks, 24)


def test_columns_of_unit_ii_merge_the_joints_of_eq_5_25():
    a, h, f, g = (dict(enumerate(columns, 1)) for columns in A16["columns"].values())
    assert a[1] == h[1]
    assert (f[6], f[7], f[8], f[5]) == (a[8], a[7], a[6], g[5])
    assert (h[2], h[3], h[4]) == (g[4], g[3], g[2])
    assert sorted({*a.values(), *h.values(), *f.values(), *g.values()}) == list(range(1, 25))


def test_singular_values_and_null_space_of_unit_ii_as_published():
    jacobian = unit_ii()
    values = np.linalg.svd(jacobian, compute_uv=False)
    assert values[:20] == pytest.approx(A16["singular_values"], rel=2e-5)
    assert values[20:].max() < 1e-13
    published = np.array(A16["null_space"])
    assert published.T @ published == pytest.approx(np.eye(4), abs=2e-4)
    null = null_space(jacobian)
    assert np.linalg.norm(published - null @ (null.T @ published), axis=0).max() < 2e-4
    assert published @ A16["c"] == pytest.approx(np.array(A16["p"]), abs=2e-4)


# lines in space: any n of them are a closed loop

WHOLE = st.integers(-2, 2).map(float)
TRIPLES = st.tuples(WHOLE, WHOLE, WHOLE)


@st.composite
def line_loops(draw):
    """Lines that are often parallel, meet or coincide; normals that are along none of them."""
    n = draw(st.integers(2, 7))
    directions = np.array([draw(TRIPLES.map(lambda v: v if any(v) else (0.0, 0.0, 1.0))) for _ in range(n)])
    points = np.array([draw(TRIPLES) for _ in range(n)])
    for i in draw(st.sets(st.integers(1, n - 1))):
        directions[i], points[i] = directions[i - 1] * draw(st.sampled_from([-1.0, 1.0])), points[i - 1]
    unit = directions / np.linalg.norm(directions, axis=1)[:, None]
    return HingeLines(unit, points, np.tile([1, math.sqrt(2), math.sqrt(3)], (n, 1)))


def turns_apart(one, two):
    """Greatest difference of angles up to whole turns."""
    return np.abs(np.angle(np.exp(1j * (one - two)))).max()


@given(line_loops())
def test_parameters_give_the_lines_they_were_taken_from(lines):
    loop, frame = dh_of_lines(lines), first_frame(lines)
    assert gap(loop) < 1e-11
    assert loop.lengths.min() > -1e-14
    back = hinge_lines(loop)
    turn, shift = frame[:3, :3], frame[:3, 3]
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-14)
    assert back.directions @ turn.T == pytest.approx(lines.directions, abs=1e-12)
    off_line = np.cross(back.points @ turn.T + shift - lines.points, lines.directions)
    assert np.abs(off_line).max() < 1e-11


@given(line_loops())
def test_lines_give_the_parameters_they_were_made_of(lines):
    loop = dh_of_lines(lines)
    again = dh_of_lines(hinge_lines(loop))
    assert again.lengths == pytest.approx(loop.lengths, abs=1e-10)
    assert again.offsets == pytest.approx(loop.offsets, abs=1e-10)
    assert turns_apart(again.twists, loop.twists) < 1e-10
    assert turns_apart(again.variables, loop.variables) < 1e-10
    assert first_frame(hinge_lines(loop)) == pytest.approx(np.eye(4), abs=1e-10)


@given(line_loops())
def test_x_follows_the_common_normal_and_z_the_hinge(lines):
    loop = dh_of_lines(lines)
    here = hinge_lines(loop)
    z, x, origin = here.directions, here.normals, here.points
    ahead = np.roll(origin, -1, axis=0) - origin
    along = loop.offsets[:, None] * z + loop.lengths[:, None] * np.roll(x, -1, axis=0)
    assert ahead == pytest.approx(along, abs=1e-11)
    assert np.einsum("ij,ij->i", x, z) == pytest.approx(np.zeros(len(z)), abs=1e-12)
    assert np.einsum("ij,ij->i", x, np.roll(z, 1, axis=0)) == pytest.approx(np.zeros(len(z)), abs=1e-12)


# loops of linkages


def linkage_of(facets, pairs, faces, thickness):
    return Linkage(Pattern.from_polygons(tuple(facets), dict(zip(pairs, map(Crease, faces), strict=True)), thickness))


def ring(facets, faces, thickness):
    """Hinge 1 joins the last facet and the first."""
    n = len(facets)
    return linkage_of(facets, [(0, n - 1), *((k, k + 1) for k in range(n - 1))], faces, thickness)


def letters(text):
    return ["top" if letter == "t" else "bottom" for letter in text]


def eight_r_panels(alpha, d, thickness):
    """The 8R element about its slit V1 V3: three triangles and a parallelogram, and the same turned by half a turn."""
    base, height = 2 * d * math.cos(alpha), d * math.sin(alpha)
    v1, v2, v3, v4 = (0.0, 0.0), (base, 0.0), (base / 2, height), (-base / 2, height)
    apex, end = (base / 2, -height), (base * math.cos(2 * alpha), -base * math.sin(2 * alpha))
    half = [(v1, end, apex), (v1, apex, v2), (v1, v2, v3), (v1, v4, (end[0] + v4[0], end[1] + v4[1]), end)]
    turned = [tuple((v3[0] - x, v3[1] - y) for x, y in facet) for facet in half]
    facets = [*half[:3], turned[3], *turned[:3], half[3]]
    return ring(facets, letters("tbtbbtbt"), thickness)


def six_r_panels(thickness):
    """The 6-crease vertex of module I."""
    rim = [(math.cos(PI / 4 * k), math.sin(PI / 4 * k)) for k in (0, 1, 3, 4, 5, 7)]
    facets = [((0.0, 0.0), rim[k], rim[(k + 1) % 6]) for k in range(6)]
    return ring(facets, letters("tbbtbb"), thickness)


def same_loop(one, two):
    parameters = [(one.lengths, two.lengths), (one.offsets, two.offsets)]
    return (
        max(np.abs(a - b).max() for a, b in parameters) < 1e-14
        and max(turns_apart(one.twists, two.twists), turns_apart(one.variables, two.variables)) < 1e-13
    )


@pytest.mark.parametrize("alpha", [0.6, PI / 3, 7 * PI / 18])
def test_panels_of_the_8r_have_the_parameters_of_eq_5_3(alpha):
    linkage = eight_r_panels(alpha, 0.04, 0.01)
    for phi in (0.0, 0.4, 2.0):
        dihedral = moved_together(alpha, phi)
        loop = dh_loop(linkage, linkage.walk(range(8)), PI - dihedral, -EIGHT_R_SIGNS)
        assert same_loop(loop, eight_r(alpha, 0.01, 0.04, dihedral))
        assert np.abs(linkage.closure(PI - dihedral)[0]).max() < 1e-13


def test_panels_of_the_vertex_of_module_i_have_the_parameters_of_eq_6_2():
    linkage = six_r_panels(0.01)
    for phi in (0.0, 0.4, 2.0):
        dihedral = vertex_angles(phi)
        loop = dh_loop(linkage, linkage.walk(range(6)), PI - dihedral, -SIX_R_SIGNS)
        assert same_loop(loop, six_r(0.01, dihedral, lambda phi_3: phi_3 - PI))
        assert np.abs(linkage.closure(PI - dihedral)[0]).max() < 1e-13


@st.composite
def linkages(draw):
    """A ring of the panels of a circuit, with hinges on any faces; or 3 x 2 panels about two vertices."""
    if draw(st.booleans()):
        circuit = draw(circuits())
        facets = [tuple((0.04 * x, 0.03 * y) for x, y in circuit.grid.corners(cell)) for cell in circuit.cells]
        pairs = [(0, len(facets) - 1), *((k, k + 1) for k in range(len(facets) - 1))]
    else:
        lines, rows = (0.0, 0.03, 0.07, 0.09), (0.0, 0.05, 0.08)
        facets = [
            ((lines[i], rows[j]), (lines[i + 1], rows[j]), (lines[i + 1], rows[j + 1]), (lines[i], rows[j + 1]))
            for j in range(2)
            for i in range(3)
        ]
        pairs = [(0, 1), (1, 2), (3, 4), (4, 5), (0, 3), (1, 4), (2, 5)]
    faces = draw(st.lists(st.sampled_from(["top", "bottom"]), min_size=len(pairs), max_size=len(pairs)))
    return linkage_of(facets, pairs, faces, 0.01)


def fold_angles(draw, linkage):
    n = linkage.n_hinges
    return np.array(draw(st.lists(ANGLES, min_size=n, max_size=n)))


def exponential(direction, point, angle):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(angle * direction).as_matrix()
    pose[:3, 3] = point - pose[:3, :3] @ point
    return pose


@given(st.data())
def test_closure_is_the_product_of_exponentials(data):
    linkage = data.draw(linkages())
    angles = fold_angles(data.draw, linkage)
    for walk in linkage.loops:
        signs = data.draw(st.lists(st.sampled_from([-1, 1]), min_size=len(walk), max_size=len(walk)))
        frame = first_frame(flat_hinge_lines(linkage, walk, signs))
        steps = [exponential(s * linkage.directions[h], linkage.points[h], angles[h]) for h, s in walk]
        matrix = closure_matrix(dh_loop(linkage, walk, angles, signs))
        assert matrix == pytest.approx(np.linalg.inv(frame) @ reduce(np.matmul, steps) @ frame, abs=1e-12)
        flat = dh_loop(linkage, walk, linkage.flat, signs)
        assert gap(flat) < 1e-13


@given(st.data())
def test_jacobian_is_the_derivative(data):
    linkage = data.draw(linkages())
    angles, walk, step = fold_angles(data.draw, linkage), linkage.loops[0], 1e-5
    jacobian = dh_jacobian(dh_loop(linkage, walk, angles))
    for k, (hinge, _) in enumerate(walk):
        change = step * np.eye(linkage.n_hinges)[hinge]
        ahead, behind = (closure_matrix(dh_loop(linkage, walk, angles + c)) for c in (change, -change))
        assert jacobian[:, k] == pytest.approx((ahead - behind)[:3].ravel() / (2 * step), abs=1e-9)


def screws(linkage, angles):
    """The screw Jacobian with its velocities in metres, loop by loop."""
    jacobian = linkage.closure(angles)[1].reshape(-1, 6, linkage.n_hinges)
    jacobian[:, 3:] *= linkage.pattern.size
    return jacobian.reshape(-1, linkage.n_hinges)


@given(st.data())
def test_jacobian_is_an_image_of_the_screw_jacobian(data):
    linkage = data.draw(linkages())
    angles = fold_angles(data.draw, linkage)
    stacked, columns = dh_closure_jacobian(linkage, angles), screws(linkage, angles)
    for k, walk in enumerate(linkage.loops):
        frame = first_frame(flat_hinge_lines(linkage, walk))
        to_dh = screw_map(frame, closure_matrix(dh_loop(linkage, walk, angles)))
        jacobian, expected = stacked[12 * k : 12 * k + 12], to_dh @ columns[6 * k : 6 * k + 6]
        assert jacobian == pytest.approx(expected, abs=1e-12)
        assert np.linalg.matrix_rank(to_dh) == 6


@given(st.data())
def test_closed_loops_have_one_null_space_in_both_forms(data):
    linkage = data.draw(linkages())
    angles = linkage.flat
    if data.draw(st.booleans()):
        closed = close_linkage(linkage, 0.5 * fold_angles(data.draw, linkage))
        assume(closed.closed)
        angles = closed.angles
    rank = rank_at(linkage, angles).rank
    assume(rank is not None)
    (_, _, here), (_, values, there) = map(
        np.linalg.svd, (dh_closure_jacobian(linkage, angles), screws(linkage, angles))
    )
    here, there = here[rank:], there[rank:]
    # both forms are equal where loops are closed, which is left open by 1e-12, over the least singular value
    assert here @ there.T @ there == pytest.approx(here, abs=1e-10 / min(values[:rank], default=1.0))


def test_map_at_closed_states_doubles_rotations_and_keeps_velocities():
    matrix = screw_map(np.eye(4))
    assert (matrix.T @ matrix).tolist() == np.diag([2.0, 2, 2, 1, 1, 1]).tolist()


@given(st.data())
def test_signs_of_hinges_change_no_singular_value(data):
    linkage = data.draw(linkages())
    angles = fold_angles(data.draw, linkage)
    loops, walks = [], []
    for walk in linkage.loops:
        signs = data.draw(st.lists(st.sampled_from([-1, 1]), min_size=len(walk), max_size=len(walk)))
        loops.append(dh_loop(linkage, walk, angles, signs))
        walks.append(tuple((hinge, sign) for (hinge, _), sign in zip(walk, signs, strict=True)))
    jacobian = stacked_jacobian(loops, walks, linkage.n_hinges)
    # reversing z_1 turns frame 1 by half a turn, and reversing the others does nothing
    assert np.abs(jacobian) == pytest.approx(np.abs(dh_closure_jacobian(linkage, angles)), abs=1e-12)
    values, plain = (np.linalg.svd(m, compute_uv=False) for m in (jacobian, dh_closure_jacobian(linkage, angles)))
    assert values == pytest.approx(plain, abs=1e-12)


def test_transforms_are_poses():
    steps = transforms(eight_r(1.0, 0.01, 0.04, np.linspace(0.1, 2, 8)))
    assert steps[:, 3].tolist() == [[0, 0, 0, 1]] * 8
    assert np.linalg.det(steps[:, :3, :3]) == pytest.approx(np.ones(8))
