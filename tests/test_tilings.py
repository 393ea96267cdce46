"""The tilings of all grids, and the tables of their steps, against polygons that are reflected one from another."""

import itertools
import math
from functools import cache

import numpy as np
import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.designs.grid.turning import edge_classes, step_tables
from tests import naive

ORDERS = {"triangle": 12, "square": 8, "rectangle": 4, "hex": 12, "right45": 8} | dict.fromkeys(
    ("rhombus", "kite", "right30", "obtuse"), 12
)
KINDS = {"triangle": 2, "rhombus": 3, "kite": 6, "right45": 4, "right30": 12, "obtuse": 6} | dict.fromkeys(
    ("square", "rectangle", "hex"), 1
)

every_grid = pytest.mark.parametrize("grid", GRIDS.values(), ids=str)


def cell(grid, x, y, kind):
    return (x, y, kind) if grid.kinds > 1 else (x, y)


def block(grid, reach):
    """All cells at the lattice points within reach of the origin."""
    span = range(-reach, reach + 1)
    return [cell(grid, x, y, kind) for x in span for y in span for kind in range(grid.kinds)]


def drawn(grid, cell):
    return naive.drawn_cell(grid.lattice_corners(cell))


def to_home(*cells):
    """Cells moved so that the least corner of the first one lies at the origin."""
    x, y = cells[0][0]
    return tuple(naive.moved(cell, -x, -y) for cell in cells)


@cache
def drawn_steps(grid):
    """The cells on both sides of the edge that each step crosses, the first one at home."""
    listed = []
    for (kind, target), (x, y) in zip(grid.step_kinds, grid.steps, strict=True):
        px, py = grid.point(cell(grid, 0, 0, kind))
        to = grid.cell((px + x, py + y))
        assert (*to, 0)[2] == target
        listed.append(to_home(drawn(grid, cell(grid, 0, 0, kind)), drawn(grid, to)))
    return listed


def step_between(grid, one, other):
    return drawn_steps(grid).index(to_home(one, other))


@every_grid
def test_cells_tile_the_plane(grid):
    cells = [drawn(grid, c) for c in block(grid, 1)]
    assert grid.kinds == KINDS[grid.name]
    assert {naive.area(corners) for corners in cells} == {abs(naive.area(grid.polygon))}
    (ox, oy), (ax, ay), (bx, by) = (grid.point(cell(grid, x, y, 0)) for x, y in ((0, 0), (1, 0), (0, 1)))
    twice = 2 * grid.corner_scale**2 * ((ax - ox) * (by - oy) - (ay - oy) * (bx - ox))
    assert grid.kinds * naive.area(grid.polygon) == twice  # the cells of one lattice point fill its parallelogram
    for one, other in itertools.combinations(cells, 2):
        assert lie_apart(one, other) or lie_apart(other, one)


def lie_apart(one, other):
    """Whether an edge of the first cell has all of the other one on its far side."""
    return any(
        all(naive.area((p, q, corner)) <= 0 for corner in other) for p, q in zip(one, one[1:] + one[:1], strict=True)
    )


@every_grid
def test_cells_are_the_mirror_images_of_the_polygon(grid):
    reflected = set(naive.distances(grid, naive.drawn_cell(grid.polygon), 18))
    near = {drawn(grid, c) for c in block(grid, 1)}
    assert near <= reflected
    assert len(near) == 9 * grid.kinds
    assert drawn(grid, cell(grid, 0, 0, 0)) == naive.drawn_cell(grid.polygon)


@every_grid
def test_neighbours_are_mirror_images_and_share_two_corners(grid):
    for here in block(grid, 1):
        point, corners, kind = grid.point(here), grid.lattice_corners(here), (*here, 0)[2]
        assert naive.area(corners) > 0
        steps = list(grid.neighbours(point))
        assert [step for step, _ in steps] == list(grid.leaving[kind]) == sorted(grid.leaving[kind])
        images = [drawn(grid, grid.cell(to)) for _, to in steps]
        assert set(images) == set(naive.around(grid, drawn(grid, here)))
        for i, ((step, to), image) in enumerate(zip(steps, images, strict=True)):
            ends = grid.edge_corners(here, step)
            assert ends == (corners[i], corners[(i + 1) % len(corners)])
            assert set(ends) == set(corners) & set(image)
            assert (grid.backwards[step], point) in grid.neighbours(to)
            assert ends[::-1] == grid.edge_corners(grid.cell(to), grid.backwards[step])


@every_grid
def test_cells_and_lattice_points_correspond(grid):
    middles = {}
    for corners in naive.distances(grid, naive.drawn_cell(grid.polygon), 20):
        x, y = (sum(values) / len(corners) / grid.corner_scale for values in zip(*corners, strict=True))
        middles[x, y] = corners
    reach = range(-5, 6)
    for point in itertools.product(reach, reach):
        assert (grid._on_lattice(point) in grid._residues) == (point in middles)
        if point in middles:
            assert grid.point(grid.cell(point)) == point
            assert drawn(grid, grid.cell(point)) == middles[point]
    for here in block(grid, 2):
        assert grid.cell(grid.point(here)) == here
        assert grid.cell_of_bit(*grid.row_of(here)) == here
    assert len({grid.row_of(here) for here in block(grid, 2)}) == 25 * grid.kinds


@every_grid
def test_point_group_is_all_symmetries_and_maps_cells_to_cells(grid):
    assert len(grid.point_group) == ORDERS[grid.name]
    assert {isometry.matrix for isometry in grid.point_group} == set(naive.isometries(grid))
    assert grid.point_group[0].matrix == (1, 0, 0, 1)
    m = grid.directions
    for isometry in grid.point_group:
        a, b, c, d = isometry.matrix
        assert isometry.sign == a * d - b * c
        for here in block(grid, 1):
            image = grid.cell(isometry(grid.point(here)))
            assert drawn(grid, image) == naive.mapped(isometry.matrix, drawn(grid, here))
        for step, pair in enumerate(drawn_steps(grid)):
            images = [naive.mapped(isometry.matrix, corners) for corners in pair]
            assert isometry.steps[step] == step_between(grid, *images)
            turned = isometry.sign * grid.step_directions[step] + isometry.offset
            assert grid.step_directions[isometry.steps[step]] == turned % m


@every_grid
def test_steps_lie_at_equal_angles_in_order_and_cross_their_edges_at_right_angles(grid):
    first = math.atan2(*reversed(grid.position(grid.steps[0])))
    assert list(grid.step_directions) == sorted(grid.step_directions)
    assert set(grid.step_directions) == set(range(grid.directions))
    for step, (vector, direction) in enumerate(zip(grid.steps, grid.step_directions, strict=True)):
        x, y = grid.position(vector)
        angle = math.atan2(y, x) - first - 2 * math.pi * direction / grid.directions
        assert math.remainder(angle, 2 * math.pi) == pytest.approx(0)
        assert grid.step_towards(grid.step_kinds[step][0], direction) == step
    here = cell(grid, 2, 1, grid.kinds - 1)
    corners = grid.corners(here)
    for (step, to), a, b in zip(grid.neighbours(grid.point(here)), corners, corners[1:] + corners[:1], strict=True):
        x, y = grid.position(grid.steps[step])
        assert x * (b[0] - a[0]) + y * (b[1] - a[1]) == pytest.approx(0)
        middle = grid.position(tuple(v / 2 for v in grid.edge(grid.point(here), to)))
        assert math.dist(a, middle) + math.dist(middle, b) == pytest.approx(math.dist(a, b))


@every_grid
def test_labels_are_the_edges_of_the_polygon_and_the_first_is_of_length_one(grid):
    home = cell(grid, 0, 0, 0)
    sides = zip(grid.polygon, grid.polygon[1:] + grid.polygon[:1], strict=True)
    assert [grid.edge_corners(home, step) for step in grid.labels] == list(sides)
    corners = dict(zip(grid.lattice_corners(home), grid.corners(home), strict=True))
    assert math.dist(*(corners[end] for end in grid.polygon[:2])) == pytest.approx(1)


@pytest.mark.parametrize(
    ("grid", "angles", "longest"),
    [
        ("rhombus", [60, 120, 60, 120], 1),
        ("kite", [90, 60, 90, 120], 1),
        ("right45", [45, 90, 45], math.sqrt(2)),
        ("right30", [60, 90, 30], 1),
        ("obtuse", [30, 120, 30], math.sqrt(3)),
    ],
)
def test_panels_have_the_angles_and_the_given_edge_that_docs_name(grid, angles, longest):
    grid = GRIDS[grid]
    corners = [complex(*corner) for corner in grid.corners(cell(grid, 0, 0, 0))]
    sides = [b - a for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    bends = [math.degrees(np.angle(-before / after)) for before, after in zip(sides[-1:] + sides, sides, strict=False)]
    rings = [bends[k:] + bends[:k] for k in range(len(bends))]
    assert any(ring == pytest.approx(wanted) for ring in rings for wanted in (angles, angles[::-1]))
    assert max(map(abs, sides)) == pytest.approx(longest)


@every_grid
def test_two_colours_are_enough_where_no_walk_of_odd_length_comes_back(grid):
    steps = naive.distances(grid, naive.drawn_cell(grid.polygon), 9)
    pairs = [(near, steps[to]) for one, near in steps.items() for to in naive.around(grid, one) if to in steps]
    assert grid.has_two_colours == all((near - far) % 2 for near, far in pairs)


def turn_form(grid, path, sign):
    """A path of cells as its least image under rotations (sign 1) or reflections (-1)."""
    images = [
        to_home(*(naive.mapped(matrix, corners) for corners in path))
        for matrix in naive.isometries(grid)
        if matrix[0] * matrix[3] - matrix[1] * matrix[2] == sign
    ]
    return min(images)


@pytest.mark.parametrize("grid", [grid for grid in GRIDS.values() if not grid.stretched], ids=str)
def test_step_tables_against_drawn_cells(grid):
    tables, m = step_tables(grid), grid.directions
    paths, forms = {}, {}
    for step, (one, two) in enumerate(drawn_steps(grid)):
        assert tables.back[step] == step_between(grid, two, one)
        edges = {step_between(grid, two, to): to for to in naive.around(grid, two)}
        onward = {to: three for to, three in edges.items() if three != one}
        assert set(tables.following[step]) == set(onward)
        turns = [turn_between(grid, step, to) for to in tables.following[step]]
        assert turns == sorted(turns, reverse=True) == tables.turns[step].tolist()
        assert np.flatnonzero(tables.codes[step] >= 0).tolist() == sorted(onward)
        codes = tables.codes[step, tables.following[step]]
        assert codes.tolist() == [tables.first_codes[step] + k for k in range(len(codes))]
        for to, three in onward.items():
            paths[step, to] = path = (one, two, three)
            code = tables.codes[step, to]
            assert forms.setdefault(code, turn_form(grid, path, 1)) == turn_form(grid, path, 1)
            assert tables.code_turns[code] == turn_between(grid, step, to)
        # the images of the first panel's edges in the edge that the step crosses
        crossed = sorted(set(one) & set(two))
        for to in naive.around(grid, one):
            ends = {naive.mirrored(grid, corner, crossed) for corner in set(one) & set(to)}
            image = next(edge for edge, beyond in edges.items() if set(two) & set(beyond) == ends)
            edge = step_between(grid, one, to)
            assert tables.carried[step, edge] == image == grid.carried(step, edge)
        assert np.count_nonzero(tables.carried[step] >= 0) == len(one)
    assert sorted(forms) == list(range(len(tables.code_turns)))
    assert len(set(forms.values())) == len(forms)
    assert len(forms) <= 1 << tables.code_bits
    assert tables.directions == m
    assert tables.directed.tolist() == list(grid.step_directions)
    assert tables.leaving.tolist() == [list(steps) for steps in grid.leaving]
    number = {form: code for code, form in forms.items()}
    for (step, to), path in paths.items():
        code = tables.codes[step, to]
        assert tables.mirrored[code] == number[turn_form(grid, path, -1)]
        assert tables.reversed[code] == number[turn_form(grid, path[::-1], -1)]
    for code, start in enumerate(tables.starts.tolist()):
        first = [step for step, to in paths if tables.codes[step, to] == code and grid.step_kinds[step][0] == 0]
        assert start == min(first, default=-1)


def turn_between(grid, step, to):
    """The turn from one step to another by the angle of their vectors, left positive."""
    before, after = (complex(*grid.position(grid.steps[s])) for s in (step, to))
    return round(np.angle(after / before) * grid.directions / (2 * math.pi))


@every_grid
def test_classes_of_edges_against_drawn_cells(grid):
    grid = grid.tiling
    classes, pairs = edge_classes(grid), drawn_steps(grid)
    turned = [turn_form(grid, pair, 1) for pair in pairs]
    flipped = [turn_form(grid, pair, -1) for pair in pairs]
    orbits = [min(forms) for forms in zip(turned, flipped, strict=True)]
    assert len(classes.firsts) == len(set(orbits))
    for edge_class, first in enumerate(classes.firsts):
        same = [step for step, orbit in enumerate(orbits) if orbit == orbits[first]]
        assert np.flatnonzero(classes.classes == edge_class).tolist() == same
        assert first == min(step for step in same if grid.step_kinds[step][0] == 0)
        assert [bool(classes.reflected[step]) for step in same] == [turned[step] != turned[first] for step in same]
        # a mirror of the panel that swaps the ends of the edge keeps all distances between corners
        one, two = pairs[first]
        place = next(k for k in range(len(one)) if {one[k], one[(k + 1) % len(one)]} == set(one) & set(two))
        ring = one[place:] + one[:place]
        other = (ring[1], ring[0], *ring[:1:-1])
        assert classes.bisected[edge_class] == (lengths(grid, ring) == lengths(grid, other))


def lengths(grid, ring):
    vectors = [(a[0] - b[0], a[1] - b[1]) for a, b in itertools.combinations(ring, 2)]
    return [naive.product(grid, vector, vector) for vector in vectors]
