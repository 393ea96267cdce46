"""Mass properties of prisms against plain sums over triangles, and how they move with the polygon."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.springs.dynamics.body_trees import joined_body, prism_body


@st.composite
def polygons(draw):
    """A convex polygon: points of an ellipse somewhere, counterclockwise."""
    n = draw(st.integers(3, 8))
    gaps = np.array(draw(st.lists(st.floats(0.5, 2.0), min_size=n, max_size=n)))
    turns = 2 * math.pi * np.cumsum(gaps) / gaps.sum()
    a, b, x, y = (draw(st.floats(*ends)) for ends in ((0.1, 2.0), (0.1, 2.0), (-5.0, 5.0), (-5.0, 5.0)))
    return [(x + a * math.cos(t), y + b * math.sin(t)) for t in turns]


thicknesses, densities = st.floats(0.01, 1.0), st.floats(0.1, 10.0)


def summed(corners, thickness, density):
    """Mass, centre and inertia by quadrature: triangles from the first corner, exact for squares of coordinates."""
    points, masses = [], []
    heights = thickness * (0.5 + np.array([-0.5, 0.5]) / math.sqrt(3))
    first = np.array(corners[0])
    for one, two in itertools.pairwise(corners[1:]):
        triangle = np.array([first, one, two])
        (ax, ay), (bx, by) = triangle[1] - first, triangle[2] - first
        for k in range(3):
            middle = 0.5 * (triangle[k] + triangle[k - 1])
            for z in heights:
                points.append([*middle, z])
                masses.append(density * thickness * 0.5 * (ax * by - ay * bx) / 6)
    points, masses = np.array(points), np.array(masses)
    centre = masses @ points / masses.sum()
    inertia = sum(m * ((p - centre) @ (p - centre) * np.eye(3) - np.outer(p - centre, p - centre))
                  for m, p in zip(masses, points, strict=True))  # fmt: skip
    return masses.sum(), centre, inertia


def assert_same(one, two):
    assert one.mass == pytest.approx(two.mass, rel=1e-12)
    assert one.centre == pytest.approx(two.centre, abs=1e-12)
    assert one.inertia == pytest.approx(two.inertia, rel=1e-9, abs=1e-12 * max(1.0, two.mass))


@settings(max_examples=50)
@given(polygons(), thicknesses, densities)
def test_a_prism_is_the_sum_of_its_triangles(corners, thickness, density):
    body = prism_body(corners, thickness, density)
    mass, centre, inertia = summed(corners, thickness, density)
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert body.centre == pytest.approx(centre, abs=1e-12)
    assert body.inertia == pytest.approx(inertia, rel=1e-9, abs=1e-12 * mass)


def test_a_brick_has_the_inertia_of_the_textbook():
    body = prism_body([(1, 1), (3, 1), (3, 4), (1, 4)], 0.5, 2.0)
    assert body.mass == pytest.approx(6.0)
    assert body.centre == pytest.approx([2.0, 2.5, 0.25])
    sizes = np.array([2.0, 3.0, 0.5]) ** 2
    assert body.inertia == pytest.approx(np.diag(6.0 / 12 * (sizes.sum() - sizes)), abs=1e-12)


@settings(max_examples=50)
@given(polygons(), thicknesses, st.floats(-3.0, 3.0), st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)))
def test_a_turned_and_moved_polygon_makes_a_turned_and_moved_body(corners, thickness, angle, shift):
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    moved = [tuple(turn[:2, :2] @ corner + shift) for corner in corners]
    one, two = prism_body(corners, thickness, 1.0), prism_body(moved, thickness, 1.0)
    assert two.mass == pytest.approx(one.mass, rel=1e-10)
    assert two.centre == pytest.approx(turn @ one.centre + [*shift, 0.0], abs=1e-10)
    assert two.inertia == pytest.approx(turn @ one.inertia @ turn.T, rel=1e-8, abs=1e-10)


@settings(max_examples=50)
@given(polygons(), thicknesses, st.data())
def test_the_parts_of_a_prism_joined_are_the_prism(corners, thickness, data):
    whole = prism_body(corners, thickness, 3.0)
    if len(corners) > 3:
        cut = data.draw(st.integers(2, len(corners) - 2))
        parts = [corners[: cut + 1], [corners[0], *corners[cut:]]]
        assert_same(joined_body(prism_body(part, thickness, 3.0) for part in parts), whole)
    assert_same(joined_body(whole.share(part) for part in (0.25, 0.75)), whole)


@given(polygons(), thicknesses)
def test_inertia_about_a_point_is_least_about_the_centre(corners, thickness):
    body = prism_body(corners, thickness, 1.0)
    assert body.about(body.centre) == pytest.approx(body.inertia)
    way = np.array([0.0, 0.0, 2.0])
    assert body.about(body.centre + way) == pytest.approx(body.inertia + body.mass * np.diag([4.0, 4.0, 0.0]))
    assert body.inertia[0, 0] + body.inertia[1, 1] > body.inertia[2, 2] > 0.0
