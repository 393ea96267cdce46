"""Drawings on each of the nine grids: the grid is told by the shape of the panels, however these are drawn."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.search.own_patterns.fold_reading import POINT_ERROR_SHARE, parse_fold
from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design
from tests.export.exports import exported, written
from tests.export.test_fold_reading import drawn, letters_of
from tests.strategies import SIZES, circuits, words

FOLDINGS = {
    grid: next(
        folding.notation
        for n in SIZES[grid]
        for word in (words(grid, n) if n % 2 == 0 else [])
        for folding in foldings(Circuit(GRIDS[grid], word))
    )
    for grid in GRIDS
}
"""A folding of each grid, of as few panels as have any."""
POLYGONS = {
    "parallelogram": ([0, 0], [2, 0], [2.5, math.sqrt(0.75)], [0.5, math.sqrt(0.75)]),
    "flat rhombus": ([0, 0], [1, 0], [1.8, 0.6], [0.8, 0.6]),
    "blunt kite": ([0, 0], [2, -1], [3, 0], [2, 1]),
    "trapezium": ([0, 0], [2, 0], [1.5, 1], [0.5, 1]),
    "isosceles triangle": ([0, 0], [1, 0], [0.5, 2]),
    "scalene triangle": ([0, 0], [4, 0], [1, 2.5]),
    "stretched hexagon": ([2, 0], [1, 1], [-1, 1], [-2, 0], [-1, -1], [1, -1]),
    "pentagon": ([0, 0], [2, 0], [2, 1], [1, 2], [0, 1]),
    "heptagon": tuple([math.cos(k), math.sin(k)] for k in np.arange(7) * math.tau / 7),
}


def changed(data, points):
    return parse_fold(json.dumps(data | {"vertices_coords": points.tolist()}))


@pytest.mark.parametrize("grid", GRIDS)
@given(st.data())
@settings(max_examples=15)
def test_a_drawing_that_is_turned_scaled_mirrored_and_rough_shows_its_circuit_and_folding(grid, data):
    circuit = data.draw(circuits(grids=(grid,), even=True).filter(foldings))
    folding = data.draw(st.sampled_from(foldings(circuit)))
    stretched = circuit.grid.stretched
    side = data.draw(st.floats(0.01, 100.0))
    turn = data.draw(st.floats(-0.7, 0.7) if stretched else st.floats(-4.0, 4.0))
    size = (1.0, 0.8) if stretched else (1.0, 1.0)
    plain = drawn(circuit, letters_of(folding), turn=turn, scale=side, size=size)
    points = np.array(plain["vertices_coords"])
    if data.draw(st.booleans()):
        points[:, 1] *= -1.0
    shortest = min(math.dist(*points[edge]) for edge in plain["edges_vertices"])
    noise = np.random.default_rng(data.draw(st.integers(0, 2**32))).uniform(-1.0, 1.0, points.shape)
    design = recognise_design(changed(plain, points + 0.5 * POINT_ERROR_SHARE * shortest * noise))
    assert design.circuit == circuit
    assert len(design.creases) == 1
    assert (design.length, design.width) == pytest.approx((side, size[1] * side), rel=3e-3)


@pytest.mark.parametrize("grid", [grid for grid in GRIDS if grid != "square"])  # stretched squares are rectangles
@pytest.mark.parametrize("stretch", [0.996, 1.004])
def test_a_drawing_that_is_stretched_a_little_shows_its_circuit(grid, stretch):
    for word in words(grid, SIZES[grid][-1])[:20]:
        circuit = Circuit(GRIDS[grid], word)
        plain = drawn(circuit, "U" * circuit.n, turn=0.3, size=(1.0, 0.7 if circuit.grid.stretched else 1.0))
        design = recognise_design(changed(plain, np.array(plain["vertices_coords"]) * (1.0, stretch)))
        assert design.circuit == circuit
        assert design.length == pytest.approx(1.0, rel=5e-3)


@pytest.mark.parametrize("grid", GRIDS)
def test_a_file_of_this_program_shows_the_folding_and_the_size_of_its_panels(grid):
    value = exported(FOLDINGS[grid], panel="80x60x7" if grid == "rectangle" else "80x7")
    drawing = parse_fold(written(value))
    design = recognise_design(drawing)
    assert [folding.notation for folding in design.foldings] == [FOLDINGS[grid]]
    assert drawn_panel_size(design, drawing) == ("80x60x7" if grid == "rectangle" else "80x80x7")


@pytest.mark.parametrize("grid", GRIDS)
def test_a_panel_of_another_shape_is_named(grid):
    circuit = Circuit.from_notation(FOLDINGS[grid].rpartition(":")[0])
    faces, points = [], []
    for cell in circuit.cells:
        corners = circuit.grid.corners(cell)
        faces.append([len(points) + k for k in range(len(corners))])
        points += corners
    points[faces[-1][0]] = tuple(0.9 * np.array(points[faces[-1][0]]) + 0.1 * np.array(points[faces[-1][2]]))
    data = {"vertices_coords": points, "faces_vertices": faces}
    with pytest.raises(
        PatternError, match=rf"^panel {circuit.n - 1} at \(.*\) is no cell of the \w+ grid that panel 0"
    ):
        recognise_design(parse_fold(json.dumps(data)))


@pytest.mark.parametrize("shape", POLYGONS)
def test_a_shape_of_no_grid_is_refused_with_all_shapes(shape):
    points = POLYGONS[shape]
    data = {"vertices_coords": points, "faces_vertices": [list(range(len(points)))]}
    with pytest.raises(
        PatternError, match=r": draw equal equilateral triangles, .* or 30-30-120 triangles edge"
    ) as error:
        recognise_design(parse_fold(json.dumps(data)))
    for name in ("isosceles right triangles", "30-60-90 triangles", "60-120 rhombuses", "60-90-120-90 kites"):
        assert name in str(error.value)
    assert "\n" not in str(error.value)
