import math
import random

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.designs.folding import foldings
from hcsearch.library.assemblies import Parameters
from hcsearch.library.assemblies.eight_r import ten_triangles, unit_i, unit_ii
from hcsearch.library.assemblies.packages import LayerColumn, Package, flat_overlap, folded_package
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, Pattern
from tests.strategies import circuits

SQUARES = tuple(((x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x, 1.0)) for x in map(float, range(8)))


def strip(creases, thickness=0.1):
    """Squares in a row."""
    return Pattern.from_polygons(SQUARES[: len(creases) + 1], {(k, k + 1): c for k, c in enumerate(creases)}, thickness)


def naive_column(pattern, point):
    """Layers filled over one point, by polygons one at a time."""
    linkage = Linkage(pattern)
    solids = linkage.solids(linkage.folded)
    lowest = min(solid[..., 2].min() for solid in solids)
    layers = []
    for solid in solids:
        if shapely.Polygon(solid[0, :, :2]).contains(shapely.Point(point)):
            layers.append(round((solid[..., 2].min() - lowest) / pattern.thickness))
    return tuple(sorted(layers))


@given(circuits(even=True), st.booleans(), st.floats(0.001, 0.05))
@settings(max_examples=40)
def test_two_stacks_are_full(circuit, hinged, thickness):
    width = 0.04 if circuit.grid.name == "rectangle" else 0.05
    for folding in foldings(circuit):
        pattern = folding.pattern((0.05, width, thickness), flat_pairs="hinged" if hinged else "rigid")
        folded = folded_package(pattern)
        n = circuit.n
        assert folded.whole_ratio == f"{n // 2}:1"
        assert [(column.layers, column.panels) for column in folded.columns] == [(tuple(range(n // 2)), n // 2)]
        assert folded.footprint_area == pytest.approx(2 * pattern.area / n)
        assert folded.height == pytest.approx(n // 2 * thickness)
        assert not folded.is_stepped
        assert folded.void_volume == folded.overlap_volume == 0


@pytest.mark.parametrize("build", [unit_i, unit_ii, ten_triangles])
def test_columns_as_a_naive_twin_finds_them(build):
    pattern = build(Parameters(alpha=math.radians(63)))
    folded = folded_package(pattern)
    linkage = Linkage(pattern)
    corners = np.concatenate([solid[0, :, :2] for solid in linkage.solids(linkage.folded)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    chance = random.Random(5)
    points = [[chance.uniform(a, b) for a, b in zip(low, high, strict=True)] for _ in range(400)]
    columns = [naive_column(pattern, point) for point in points]
    areas = {column.layers: column.area for column in folded.columns}
    assert set(columns) - {()} == set(areas)
    box = float(np.prod(high - low))
    for layers, area in areas.items():
        assert columns.count(layers) / 400 == pytest.approx(area / box, abs=0.1)


@given(st.floats(0.01, 0.5), st.floats(-3, 3), st.booleans())
def test_a_package_does_not_depend_on_where_the_pattern_lies(thickness, turn, over):
    pattern = unit_ii(Parameters(thickness=thickness))
    folded, moved = folded_package(pattern), folded_package(pattern.moved(turn, (1.0, 2.0), over=over))
    assert folded.whole_ratio == moved.whole_ratio
    assert folded.heights == moved.heights
    assert folded.footprint_area == pytest.approx(moved.footprint_area)


def test_volume_is_kept_where_nothing_is_empty_or_shared():
    for build in (unit_i, unit_ii):
        pattern = build(Parameters())
        folded = folded_package(pattern)
        filled = sum(column.panels * column.area for column in folded.columns) * pattern.thickness
        assert filled == pytest.approx(pattern.area * pattern.thickness)


def test_a_stair():
    flat = Crease("top", closes=False)
    folded = folded_package(strip([VALLEY_CREASE, flat]))
    # the first panel lies on the second, and the third beside them
    assert sorted((column.panels, round(column.area, 9)) for column in folded.columns) == [(1, 1.0), (2, 1.0)]
    assert folded.is_stepped
    assert folded.heights == (1, 2)
    assert folded.whole_ratio == "3:2"


def test_voids_and_overlaps():
    # three panels rolled up: the last one would lie where the second is, on the first
    rolled = folded_package(strip([VALLEY_CREASE, VALLEY_CREASE]))
    assert rolled.overlap_volume == pytest.approx(0.1)
    column = LayerColumn((0, 1, 1, 4), 2.0)
    assert (column.panels, column.gaps, column.overlaps) == (4, 2, 1)
    made = Package(8.0, 0.1, (column,))
    assert made.void_volume == pytest.approx(0.4)
    assert made.overlap_volume == pytest.approx(0.2)
    assert (made.n_layers, made.height, made.ratio, made.whole_ratio) == (5, pytest.approx(0.5), 4.0, "4:1")


def test_a_ratio_that_is_none_of_whole_numbers():
    assert Package(math.pi, 0.1, (LayerColumn((0,), 1.0),)).whole_ratio is None


def test_a_rigid_sheet_is_its_own_package():
    folded = folded_package(strip([RIGID_CREASE, RIGID_CREASE]))
    assert (folded.whole_ratio, folded.n_layers, folded.heights, folded.is_stepped) == ("1:1", 1, (1,), False)


def test_no_folded_state():
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    squares = tuple(tuple((x + a, y + b) for a, b in corners) for x, y in corners)
    ring = {
        (0, 1): VALLEY_CREASE,
        (1, 2): VALLEY_CREASE,
        (2, 3): VALLEY_CREASE,
        (0, 3): MOUNTAIN_CREASE,
    }  # the last hinge line lies too low
    with pytest.raises(PatternError, match="no folded state"):
        folded_package(Pattern.from_polygons(squares, ring, 0.1))


def test_overlap_in_the_flat_state():
    triangles = (((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), ((0.2, -0.5), (0.9, 0.4), (0.1, 0.3)))
    both = Pattern.from_polygons(triangles, {}, 0.1)
    expected = shapely.Polygon(triangles[0]).intersection(shapely.Polygon(triangles[1])).area
    assert flat_overlap(both) == pytest.approx(expected)
    assert flat_overlap(strip([RIGID_CREASE, RIGID_CREASE])) == 0
