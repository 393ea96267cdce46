"""Gaps to the craft, against dense samples and by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from hcsearch.springs.flight.moving_room import craft_clearance, craft_corners, placed_solids
from tests.collision.naive_clearance import distance

SIDE, THICK = 0.1, 0.01


def strip(count: int, face: str = "top") -> Linkage:
    """Squares in a row, hinged on one face."""
    facets = tuple(tuple((SIDE * (k + x), SIDE * y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))) for k in range(count))
    creases = {(k, k + 1): Crease(face, closes=True) for k in range(count - 1)}
    return Linkage(Pattern.from_polygons(facets, creases, THICK))


def turning(linkage: Linkage, start, end, count: int = 5) -> Course:
    """A motion at constant rates."""
    times = np.linspace(0.0, 1.0, count)
    angles = start + times[:, None] * (end - start)
    rates = np.tile(end - start, (count, 1))
    return Course(times, angles, rates, np.zeros_like(angles), True)


def test_a_panel_that_turns_up_stays_above_a_box_below():
    linkage = strip(2)
    motion = turning(linkage, np.array([math.pi]), np.zeros(1))
    box = (0.05, -0.05, -0.06, 0.1, 0.1, 0.05)  # under the second panel, 10 mm below the sheet
    gap = craft_clearance(linkage, motion, 0.0, [box], 0)
    assert gap == pytest.approx(0.01, abs=3e-6)
    assert gap <= 0.01
    assert craft_clearance(linkage, motion, 1e-3, [box], 0) == pytest.approx(gap - 2e-3)


def test_the_root_is_left_out_and_a_box_in_the_way_is_cut():
    linkage = strip(2)
    motion = turning(linkage, np.array([math.pi]), np.zeros(1))
    under_root = (-0.04, -0.04, -0.05, 0.08, 0.08, 0.05)
    assert craft_clearance(linkage, motion, 0.0, [under_root], 0) > 0.009
    above_root = (-0.04, -0.04, 0.015, 0.08, 0.08, 0.05)
    assert craft_clearance(linkage, motion, 0.0, [above_root], 0) < -0.004


def test_without_boxes_there_is_nothing_to_measure():
    with pytest.raises(HcsearchError, match="give boxes of the craft"):
        craft_clearance(strip(2), turning(strip(2), np.ones(1), np.zeros(1)), 0.0, [], 0)


@settings(max_examples=25)
@given(st.tuples(*(st.floats(-0.2, 0.2) for _ in range(3))), st.integers(0, 2))
def test_gaps_are_never_above_those_of_samples(corner, root):
    linkage = strip(3)
    start, end = np.array([2.5, 1.5]), np.array([0.2, 0.1])
    box = (*corner, 0.03, 0.04, 0.05)
    gap = craft_clearance(linkage, turning(linkage, start, end), 0.0, [box], root)
    (corners,) = craft_corners(linkage, [box], root)
    states = start + np.linspace(0.0, 1.0, 200)[:, None] * (end - start)
    solids = [solid for state in states for k, solid in enumerate(placed_solids(linkage, state, root)) if k != root]
    least = min(distance(solid, corners) for solid in solids)
    assert gap <= least + 1e-12
    # between two samples no point moves by more than 7 mm; below 0 is a depth, which these distances do not tell
    assert least == 0.0 or gap >= least - 0.007
