import json
import math
from itertools import combinations, product
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies import ASSEMBLIES, Parameters
from hcsearch.library.assemblies import modules as m
from hcsearch.library.assemblies.modules import (
    doubled_pattern,
    mirrored_pattern,
    module_fold_angles,
    pattern_joined_along,
    square_sheet,
)
from hcsearch.library.assemblies.packages import folded_package
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.motion.paths.branches import find_branches
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, overlay

_FILE = json.loads((Path(__file__).parents[1] / "golden" / "thesis_chapter6.json").read_text("utf-8"))
GOLDEN, DEPARTURES = _FILE["assemblies"], _FILE["departures"]
NAMES = [assembly.name for assembly in m.ASSEMBLIES]
PUBLISHED = [name for name in NAMES if name in GOLDEN]
SIDE, THICK = 0.05, 0.01
SIZE = Parameters(side=SIDE, thickness=THICK)


def squares(area):
    return area / SIDE**2


def overlap(pattern):
    """Squares of panel that lie in each other's place when folded."""
    return round(folded_package(pattern).overlap_volume / (SIDE**2 * THICK), 6)


def residual(pattern, angles):
    return float(np.abs(Linkage(pattern).closure(angles)[0]).max())


def dof(pattern, grid=1.1):
    """Degrees of freedom at a state of the motion; None where equation 6.4 does not close it."""
    angles = module_fold_angles(pattern, grid)
    return rank_at(Linkage(pattern), angles).nullity if residual(pattern, angles) <= CLOSED_LOOP_RESIDUAL else None


def footprint(pattern):
    return round(squares(folded_package(pattern).footprint_area), 6)


# what the thesis says


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_facts(name):
    facts = GOLDEN[name] | DEPARTURES.get(name, {})
    pattern = ASSEMBLIES[name].build(SIZE)
    folded = folded_package(pattern)
    assert dof(pattern) == facts["dof"] == 1
    assert folded.void_volume == folded.overlap_volume == 0
    if "footprint" in facts:
        assert footprint(pattern) == facts["footprint"]
    if "area" in facts:
        assert squares(pattern.area) == pytest.approx(facts["area"])
    if "deployment_ratio" in facts:
        assert folded.whole_ratio == facts["deployment_ratio"]


@pytest.mark.parametrize("name", NAMES)
def test_packages_are_cuboids_but_for_module_iii(name):
    folded = folded_package(ASSEMBLIES[name].build(SIZE))
    assert folded.is_stepped == ("iii" in name)
    assert ("iii" in name) or len(folded.heights) == 1


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=4, deadline=None)
@given(data=st.data())
def test_modules_keep_closed_with_one_dof_for_any_size(name, data):
    lengths = st.floats(0.01, 1.0)
    parameters = Parameters(side=data.draw(lengths), thickness=data.draw(st.floats(1e-3, 0.1)))
    pattern = ASSEMBLIES[name].build(parameters)
    linkage = Linkage(pattern)
    assert dof(pattern, data.draw(st.floats(0.3, math.pi - 0.2))) == 1
    for grid, end in ((0.0, linkage.flat), (math.pi, linkage.folded)):
        assert module_fold_angles(pattern, grid) == pytest.approx(end)
        assert residual(pattern, module_fold_angles(pattern, grid)) <= CLOSED_LOOP_RESIDUAL
    assert dof(pattern, math.pi / 2) == rank_at(linkage, ASSEMBLIES[name].generic_angles(parameters)).nullity


# nullity flat and folded, Kutzbach
ENDS = {
    "module-i": (7, 4, -5),
    "modules-i-pair": (11, 6, -10),
    "modules-i-four-b": (24, 13, -24),
    "modules-i-four-c": (25, 13, -23),
    "modules-i-four-d": (23, 11, -26),
    "module-ii": (8, 4, -6),
    "modules-ii-five": (28, 12, -30),
    "module-iii": (7, 4, -5),
    "module-iii-4-1": (7, 4, -5),
    "modules-iii-pair": (9, 5, -9),
}


@pytest.mark.parametrize("name", NAMES)
def test_nullity_of_flat_and_folded_state(name):
    pattern = ASSEMBLIES[name].build(SIZE)
    assert (dof(pattern, 0.0), dof(pattern, math.pi), pattern.kutzbach) == ENDS[name]


@pytest.mark.parametrize("name", ["module-i", "modules-i-pair", "module-ii", "module-iii", "modules-iii-pair"])
def test_one_motion_within_the_stops_opens_the_folded_stack(name):
    pattern = ASSEMBLIES[name].build(SIZE)
    linkage = Linkage(pattern)
    (only,) = find_branches(linkage, linkage.folded, stops=True).finite
    opening = module_fold_angles(pattern, math.pi - 1e-6) - linkage.folded
    assert only.direction == pytest.approx(opening / np.linalg.norm(opening), abs=1e-5)


# the vertex and module I


def test_dihedral_angles_of_a_vertex():
    # (6.4): phi_1 = phi_4 on the diagonals, tan(phi_2 / 2) = cos(pi / 4) tan(phi_1 / 2) on the grid
    vertex = square_sheet(("./", "/."), SIDE, THICK)
    phi = math.pi - module_fold_angles(vertex, 2.0)
    diagonal = [hinge.face == "top" for hinge in vertex.hinges]
    assert sum(diagonal) == 2
    assert set(np.round(phi[diagonal], 12)) == {round(2 * math.atan(math.sqrt(2) * math.tan((math.pi - 2.0) / 2)), 12)}
    assert dof(vertex, 2.0) == 1
    assert vertex.kutzbach == 0


def test_bricard_loop_of_a_vertex_closes_with_one_sign_of_6_3_put_right():
    lengths, twists = (1, 0, 1, 1, 0, 1), np.array([-1, 2, 1, -1, 2, 1]) * math.pi / 4  # (6.2)

    def opening(thetas):
        pose = np.eye(4)
        for theta, length, twist in zip(thetas, lengths, twists, strict=True):
            c, s, ct, st_ = math.cos(theta), math.sin(theta), math.cos(twist), math.sin(twist)
            pose = pose @ [
                [c, -s * ct, s * st_, length * c],
                [s, c * ct, -c * st_, length * s],
                [0, st_, ct, 0],
                [0, 0, 0, 1],
            ]
        return np.abs(pose - np.eye(4)).max()

    for first in (0.4, 1.3, 2.5):
        other = 2 * math.atan(math.cos(math.pi / 4) * math.tan(first / 2))
        phi = (first, other, other, first, other, other)
        signs, turns = (-1, 1, -1, -1, 1, 1), (0, 0, 0, 0, 0, -math.pi)  # (6.3) as printed
        assert opening([s * p + t for s, p, t in zip(signs, phi, turns, strict=True)]) > 0.8
        closing = [
            k
            for k, sign, turn in product(range(6), (-1, 1), (0.0, math.pi))
            if opening([(sign if i == k else signs[i]) * phi[i] + (turn if i == k else turns[i]) for i in range(6)])
            < 1e-9
        ]
        assert closing == [2]  # theta_3 = phi_3 - pi, and no other change of one line


def test_facets_of_module_i():
    areas = [round(squares(area), 6) for area in facet_areas(m.module_i(SIZE))]
    facts = GOLDEN["module-i"]
    assert areas.count(0.25) == facts["small_triangles"]
    assert areas.count(0.5) == facts["large_triangles"]
    assert areas.count(1.0) == facts["squares"]


def facet_areas(pattern):
    for facet in pattern.facets:
        x, y = np.array(facet).T
        yield 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_uncut_corners_of_module_i_would_lie_in_each_others_place():
    uncut = square_sheet((".//", "///", "//."), SIDE, THICK)
    assert overlap(uncut) == 1.0
    assert dof(uncut) == 1


def test_module_i_folds_flat_along_each_of_its_aligned_creases():
    pattern = m.module_i(SIZE)
    lines = {}
    for k, hinge in enumerate(pattern.hinges):
        dx, dy = np.sign(np.round([hinge.end[i] - hinge.start[i] for i in (0, 1)], 9))
        dx, dy = (dx, dy) if (dx, dy) > (0, 0) else (-dx, -dy)
        offset = round((dx * hinge.start[1] - dy * hinge.start[0]) / SIDE, 6)
        lines.setdefault((dx, dy, offset), []).append(k)
    # two lines each way and three diagonals
    assert len(lines) == ENDS["module-i"][0] == 7
    for hinges in lines.values():
        angles = np.zeros(len(pattern.hinges))
        angles[hinges] = 1.0
        assert residual(pattern, angles) <= CLOSED_LOOP_RESIDUAL


# arrays of modules I


def drawn(letters):
    """A sheet from letters by square."""
    columns, rows = ([place[k] for place in letters] for k in (0, 1))
    return square_sheet(
        [
            "".join(letters.get((i, j), " ") for i in range(min(columns), max(columns) + 1))
            for j in range(max(rows), min(rows) - 1, -1)
        ],
        SIDE,
        THICK,
    )


def module_letters(dx=0, dy=0):
    rows = ("./<", "///", ">/.")
    return {(dx + i, dy + 2 - j): letter for j, row in enumerate(rows) for i, letter in enumerate(row)}


def test_two_modules_i_fold_onto_one_square_in_two_ways_one_of_which_shares_diagonals():
    counts = {}
    for dx, dy in product(range(-2, 3), repeat=2):
        if (dx, dy) <= (0, 0):
            continue
        one, two = module_letters(), module_letters(dx, dy)
        # where they differ, the creases of both divide the square along /
        union = one | two | {place: "/" for place in one.keys() & two.keys() if one[place] != two[place]}
        pattern = drawn(union)
        if footprint(pattern) == 1 and overlap(pattern) == 0 and dof(pattern) == 1:
            shared = sum(one[place] == two[place] == "/" for place in one.keys() & two.keys())
            counts[dx, dy] = (shared, round(squares(pattern.area)))
    assert counts == {(1, -1): (2, 12), (1, -2): (0, 14), (2, -1): (0, 14)}
    pair = m.modules_i_pair(SIZE)
    assert squares(pair.area) == pytest.approx(12)
    assert len(pair.panels) == len(drawn(module_letters() | module_letters(1, -1)).panels) + 1 == 26


def blocks(places):
    """Modules I and mirror images of them, three squares a block, with all neighbours merged."""
    placed = []
    for i, j in places:
        block = m.module_i(SIZE)
        step = 3 * SIDE
        block = mirrored_pattern(block, "x", 0.5 * step) if i % 2 else block
        block = mirrored_pattern(block, "y", 0.5 * step) if j % 2 else block
        placed.append(block.moved(shift=(step * i, step * j)))
    pattern = overlay(placed)
    for axis, k in product(("x", "y"), range(-6, 7)):
        pattern = pattern_joined_along(pattern, axis, 3 * SIDE * k)
    return pattern


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        (((0, 0), (1, 0), (0, -1), (1, -1)), (1, 0, 4)),  # a block around the corner of a whole square: (b)
        (((0, 0), (1, 0), (2, 0), (3, 0)), (1, 0, 4)),  # a row: (c)
        (((0, 0), (1, 0), (2, 0), (2, 1)), (1, 0, 4)),  # an L, the one alternative
        (((0, 0), (1, 0), (2, 0), (2, -1)), (1, 8, 3)),  # the other L, S and T: two modules in one place
        (((0, 0), (1, 0), (1, 1), (2, 1)), (1, 8, 3)),
        (((0, 0), (1, 0), (1, -1), (2, -1)), (1, 8, 3)),
        (((0, 0), (1, 0), (2, 0), (1, 1)), (1, 8, 3)),
        (((0, 0), (1, 0), (2, 0), (1, -1)), (1, 8, 3)),
        (((0, 0), (1, 0), (2, 0), (3, 0), (4, 0)), (1, 8, 4)),  # a fifth one in the row comes to the first one's place
    ],
)
def test_mirror_images_of_module_i_that_fold_onto_four_squares(places, expected):
    pattern = blocks(places)
    assert (dof(pattern), overlap(pattern), footprint(pattern)) == expected


def test_block_and_row_are_those_of_the_named_assemblies():
    for build, places in (
        (m.modules_i_block, ((0, 0), (1, 0), (0, -1), (1, -1))),
        (m.modules_i_row, ((0, 0), (1, 0), (2, 0), (3, 0))),
    ):
        ours, theirs = build(SIZE), blocks(places)
        assert (len(ours.panels), len(ours.hinges)) == (len(theirs.panels), len(theirs.hinges))


def test_ring_of_four_modules_i_has_a_void_and_must_be_hinged_on_the_diagonals_face():
    ring = m.modules_i_ring(SIZE)
    centre = (3 * SIDE, 3 * SIDE)
    assert not any(polygon_contains(facet, centre) for facet in ring.facets)
    assert squares(ring.area) == pytest.approx(32)  # of 36: the void has two squares, the outer corners as much
    half = doubled_pattern(m.module_i(SIZE), "x", 3 * SIDE)
    assert dof(doubled_pattern(half, "y", 3 * SIDE)) is None  # merged along both mirrors
    other = doubled_pattern(half, "y", 3 * SIDE, MOUNTAIN_CREASE)
    assert overlap(other) > 0
    assert dof(other) is None  # it would have to open beyond flat


def polygon_contains(facet, point):
    corners = np.array(facet)
    edges = np.roll(corners, -1, axis=0) - corners
    away = np.array(point) - corners
    return bool((edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0] > 0).all())


# module II


def test_module_ii_has_ten_bodies_around_its_slit():
    pattern = m.module_ii(SIZE)
    on_mirror = [
        hinge for hinge in pattern.hinges if abs(hinge.start[1] - 2 * SIDE) + abs(hinge.end[1] - 2 * SIDE) < 1e-9
    ]
    assert len(on_mirror) == 2
    left, right = on_mirror
    graph = nx.Graph()
    graph.add_edges_from((h.first, h.second) for h in pattern.hinges if h not in on_mirror)
    bodies = nx.shortest_path_length(graph, left.first, right.first) + nx.shortest_path_length(
        graph, left.second, right.second
    )
    assert bodies + 2 == GOLDEN["module-ii"]["loop"]
    assert 6 * (10 - 1) - 5 * 10 == 4  # inputs of that loop by the criterion


def test_module_ii_must_be_hinged_on_the_face_of_the_diagonals():
    half = doubled_pattern(square_sheet(("\\.", ".\\"), SIDE, THICK).inverted(), "x", 2 * SIDE)
    right, wrong = (doubled_pattern(half, "y", 0.0, crease) for crease in (MOUNTAIN_CREASE, VALLEY_CREASE))
    assert (overlap(right), dof(right)) == (0, 1)
    assert overlap(wrong) > 0
    angles = module_fold_angles(right, 1.1)
    hinges = [k for k, hinge in enumerate(right.hinges) if abs(hinge.start[1]) + abs(hinge.end[1]) < 1e-9]
    angles[hinges] *= -1  # on the other face the same motion turns these hinges the other way
    assert residual(wrong, angles) <= CLOSED_LOOP_RESIDUAL
    # one on each face does not close at all
    (pair, *_) = [pair for pair in right.edges if pair in right.creases and on_axis(right.segment(pair))]
    mixed = right.with_creases({pair: VALLEY_CREASE})
    assert min(residual(mixed, turned(mixed, hinges, s)) for s in np.linspace(-3, 3, 61)) > 0.1


def on_axis(ends):
    return abs(ends[0][1]) + abs(ends[1][1]) < 1e-9


def turned(pattern, hinges, angle):
    angles = module_fold_angles(pattern, 1.1)
    angles[hinges] = angle
    return angles


def test_embedded_module_ii_shares_six_panels_and_six_joints_with_each_of_four():
    facts = GOLDEN["modules-ii-five"]
    module = m.module_ii(SIZE)
    embedded = module.moved(shift=(2 * SIDE, 2 * SIDE))
    centres = {tuple(np.round(np.mean(facet, axis=0), 6)): k for k, facet in enumerate(embedded.facets)}
    for x, y in product((0, 4 * SIDE), repeat=2):
        grey = module.moved(shift=(x, y))
        common = {k: centres.get(tuple(np.round(np.mean(facet, axis=0), 6))) for k, facet in enumerate(grey.facets)}
        facets = [k for k, other in common.items() if other is not None]
        assert len({grey.panel_of[k] for k in facets}) == facts["shared_panels"]
        pairs = [pair for pair, crease in grey.creases.items() if crease.face and set(pair) <= set(facets)]
        assert len({grey.hinge_of(pair) for pair in pairs}) == facts["shared_hinges"]


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ((1, 2), (2, 0, 4)),  # nothing embedded: modules that hang together nowhere
        ((2, 3), (1, 0, 4)),  # more rows
        ((3, 2), (1, 32, 4)),  # a third column folds into the place of the first
    ],
)
def test_only_rows_can_be_added_to_modules_ii(size, expected):
    pattern = m.modules_ii(Parameters(side=SIDE, thickness=THICK, size=size))
    assert (dof(pattern), overlap(pattern), footprint(pattern)) == expected


# module III


def diagonals(columns, rows, width, height):
    """Letters of a sheet with creases x in columns, y in rows, and / through every vertex up to the next crease."""
    letters = dict.fromkeys(product(range(width), range(height)), ".")
    for vertex in product(columns, rows):
        for step in (1, -1):
            i, j = vertex
            while True:
                place = (i, j) if step == 1 else (i - 1, j - 1)
                if place not in letters:
                    break
                letters[place] = "/"
                i, j = i + step, j + step
                if i in columns or j in rows:
                    break
    return ["".join(letters[i, j] for i in range(width)) for j in range(height - 1, -1, -1)]


def test_of_two_creases_each_way_in_16_squares_only_module_iii_moves():
    moving = []
    for columns, rows in product(combinations(range(1, 4), 2), repeat=2):
        letters = diagonals(columns, rows, 4, 4)
        if dof(square_sheet(letters, SIDE, THICK, (columns, rows))) is not None:
            moving.append((columns, rows, letters))
    assert moving == [((1, 3), (1, 3), ["././", "/./.", "././", "/./."])]


def test_folded_vertices_of_module_iii_that_share_no_diagonal_coincide_eight_panels_high():
    # so no package of 16 squares on four is a cuboid: around this point it is eight high, four is the mean
    pattern = m.module_iii(SIZE)
    linkage = Linkage(pattern)
    solids = linkage.solids(linkage.folded)

    def images(x, y):
        places = [
            tuple(np.round(solid[0, k, :2] / SIDE, 6))
            for facet, solid in zip(pattern.facets, solids, strict=True)
            for k, corner in enumerate(facet)
            if math.dist(corner, (x * SIDE, y * SIDE)) < 1e-9
        ]
        return len(places), set(places)

    a, b, c, d = images(1, 3), images(3, 3), images(1, 1), images(3, 1)
    assert [count for count, _ in (a, b, c, d)] == [6] * 4
    assert a[1] == d[1]
    assert len(a[1] | b[1] | c[1]) == 3
    columns = folded_package(pattern).columns
    assert {n: sum(squares(c.area) for c in columns if c.panels == n) for n in (4, 8)} == pytest.approx({4: 2, 8: 1})


def test_another_outline_of_module_iii_does_fold_16_squares_onto_four():
    pattern = m.module_iii_4_1(SIZE)
    folded = folded_package(pattern)
    assert (squares(pattern.area), footprint(pattern)) == (pytest.approx(16), 4)
    assert folded.whole_ratio == GOLDEN["module-iii"]["deployment_ratio"]
    assert folded.heights == (1, 4, 6, 8)
    assert folded.void_volume == folded.overlap_volume == 0
    assert dof(pattern) == 1


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ((2, 1), (1, 0, 4, 24)),
        ((3, 1), (1, 0, 4, 32)),
        ((5, 1), (1, 0, 4, 48)),
        ((1, 2), (1, 0, 4, 24)),
        ((2, 2), (1, 4, 4, 36)),  # a row added to two columns
    ],
)
def test_modules_iii_can_be_added_along_one_direction(size, expected):
    pattern = m.modules_iii(Parameters(side=SIDE, thickness=THICK, size=size))
    assert (dof(pattern), overlap(pattern), footprint(pattern), round(squares(pattern.area))) == expected


def test_pair_of_modules_iii_is_stepped():
    folded = folded_package(m.modules_iii(SIZE))
    assert folded.is_stepped
    assert folded.heights == (4, 8)
    assert folded.whole_ratio == "6:1"


def test_angles_are_refused_without_diagonals():
    with pytest.raises(PatternError, match="no array of modules"):
        module_fold_angles(square_sheet(("..",), SIDE, THICK), 1.0)
