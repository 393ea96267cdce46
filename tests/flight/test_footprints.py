"""Footprints of stacks in rectangles: by hand, against dense turns, and laws."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.springs.flight.stowage import Footprint, footprint_of
from tests.strategies import writings

lengths = st.floats(0.01, 0.3)


def rectangle(length, width):
    return Footprint(np.array([(0, 0), (length, 0), (length, width), (0, width)], float), 5, 0.006)


def least_excess(footprint, length, width, count=3601):
    """The least over dense turns of what a footprint is longer or wider than a rectangle."""
    angles = np.linspace(0.0, math.pi, count)
    turned = footprint.corners @ np.array([np.cos(angles), np.sin(angles)])
    across = footprint.corners @ np.array([-np.sin(angles), np.cos(angles)])
    return np.maximum(np.ptp(turned, axis=0) - length, np.ptp(across, axis=0) - width).min()


@given(lengths, lengths, lengths, lengths)
def test_a_rectangle_lies_in_another_by_the_criterion_of_carver(p, q, a, b):
    p, q, a, b = max(p, q), min(p, q), max(a, b), min(a, b)
    root = math.sqrt(max(p * p + q * q - a * a, 0.0))
    limit = a if p <= a else (2 * p * q * a + (p * p - q * q) * root) / (p * p + q * q)
    fits = q <= b if p <= a else b >= limit
    assume(abs(q - b) > 1e-6 and abs(p - a) > 1e-6 and abs(b - limit) > 1e-6)
    assert rectangle(p, q).lies_in(a, b) == fits


@given(st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)), min_size=3, max_size=9), lengths, lengths)
def test_a_footprint_lies_where_a_dense_search_finds_a_turn(points, length, width):
    hull = shapely.convex_hull(shapely.MultiPoint(points))
    assume(hull.area > 1e-5)
    footprint = Footprint(shapely.get_coordinates(hull)[:-1], 5, 0.006)
    excess = least_excess(footprint, length, width)
    # between dense turns widths change by less than the diameter times half of their distance
    near = 0.3 * math.pi / 3600
    if footprint.lies_in(length, width):
        assert excess <= near
    else:
        assert excess > 0.0


@given(lengths, lengths, st.floats(0.0, 0.1), st.floats(0.0, 0.1))
def test_what_lies_in_a_rectangle_lies_in_greater_ones(length, width, more, wider):
    footprint = footprint_of(Folding.from_notation("hex:0234550132:4").linkage())
    if footprint.lies_in(length, width):
        assert footprint.lies_in(length + more, width + wider)
        assert footprint.lies_in(width + wider, length + more)


def test_two_stacks_of_squares_by_hand():
    footprint = footprint_of(Folding.from_notation("square:0122223000:1").linkage())
    # two squares of 50 mm side by side, five layers of 6 mm
    assert (footprint.layers, footprint.thickness) == (5, 0.006)
    assert footprint.greatest_thickness((0.1, 0.05, 0.031)) == pytest.approx(0.0062)
    assert footprint.greatest_thickness((0.031, 0.1, 0.05)) == pytest.approx(0.0062)
    assert footprint.greatest_thickness((0.1, 0.1, 0.04)) == pytest.approx(0.008)
    assert footprint.greatest_layers((0.1, 0.05, 0.03)) == 5
    assert footprint.greatest_layers((0.1, 0.05, 0.0299)) == 4
    # standing on a long side, 50 mm high stacks may be thick
    assert footprint.greatest_thickness((0.1, 0.05, 0.1)) == pytest.approx(0.02)
    assert footprint.greatest_thickness((0.099, 0.09, 0.049)) == 0.0
    assert footprint.greatest_layers((0.099, 0.09, 0.049)) == 0


def test_a_strip_that_lies_only_obliquely_is_found():
    strip = rectangle(0.12, 0.01)
    assert strip.lies_in(0.1, 0.1)  # along the diagonal it needs 0.13 / sqrt(2) = 0.092
    assert not strip.lies_in(0.1, 0.05)


@pytest.mark.parametrize("notation", ["square:0122223000", "hex:0234550132", "triangle:0123434501"])
def test_footprints_do_not_hang_on_how_a_circuit_is_written(notation):
    room = (0.11, 0.088, 0.1)

    def figures(circuit):
        footprints = [footprint_of(folding.linkage()) for folding in foldings(circuit)]
        return sorted(
            (one.layers, round(one.greatest_thickness(room), 12), one.lies_in(0.1, 0.06)) for one in footprints
        )

    circuit = Circuit.from_notation(notation)
    assert figures(circuit)
    assert all(figures(other) == figures(circuit) for other in writings(circuit))
