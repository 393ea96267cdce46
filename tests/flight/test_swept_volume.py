"""Swept boxes against dense samples of motions, by hand, and for motions that are not straight between states."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.springs.flight.moving_room import SWEPT_RESOLUTION_SHARE, placed_solids, swept_box
from tests.collision.naive_clearance import chain, fan, moments, random_course
from tests.planned import SAMPLES, planned

LINKAGES = [chain([0.04, 0.03], ["top"]), chain([0.03, 0.02, 0.02, 0.04], ["top", "bottom", "bottom"]), fan()]


def corners_of(box):
    low = np.array(box.corner)
    return low, low + box.sides


def sampled_box(linkage, course, root, count=200):
    """The box around the panels at many moments of a motion: it is never greater than the true one."""
    points = np.array([np.concatenate(placed_solids(linkage, state, root)) for state in moments(course, count)[1]])
    return points.min(axis=(0, 1)), points.max(axis=(0, 1))


@settings(max_examples=40)
@given(st.sampled_from(LINKAGES), st.integers(0, 2**32), st.integers(1, 3), st.booleans(), st.data())
def test_a_swept_box_holds_every_moment_and_is_no_wider_than_its_resolution(linkage, seed, steps, cubic, data):
    course = random_course(np.random.default_rng(seed), linkage, steps, cubic=cubic)
    root = data.draw(st.integers(0, linkage.n_panels - 1))
    low, high = corners_of(swept_box(linkage, course, 0.0, root))
    least, greatest = sampled_box(linkage, course, root)
    assert (low <= least + 1e-12).all()
    assert (high >= greatest - 1e-12).all()
    # a panel of less than 0.1 m that turns by less than 0.5 rad between two samples comes near enough to its extremes
    turned = np.abs(np.diff(moments(course, 200)[1], axis=0)).sum(axis=1).max()
    allowed = SWEPT_RESOLUTION_SHARE * linkage.pattern.size + 0.5 * 0.2 * turned
    assert (least - low <= allowed).all()
    assert (high - greatest <= allowed).all()


def test_a_lid_sweeps_its_diagonal():
    linkage = chain([0.04, 0.03], ["top"])
    times = np.linspace(0.0, 1.0, 3)
    angles = math.pi * (1.0 - times[:, None])
    motion = Course(times, angles, np.full((3, 1), -math.pi), np.zeros((3, 1)), True)
    box = swept_box(linkage, motion, 0.0, 0)
    # the hinge is at x = 0.04, z = 0.004; the far bottom corner is the farthest from it
    radius = math.hypot(0.03, 0.004)
    resolution = SWEPT_RESOLUTION_SHARE * linkage.pattern.size
    assert box.sides == pytest.approx((0.04 + radius, 0.03, 0.004 + radius), abs=2 * resolution)
    assert all(side >= exact for side, exact in zip(box.sides, (0.04 + radius, 0.03, 0.004 + radius), strict=True))
    assert box.volume == pytest.approx(math.prod(box.sides))


def test_one_hinge_after_the_other_is_held_though_ends_lie_on_a_straight_line():
    """Both angles are monotone between two states; straight between them the strip never reaches so far."""
    linkage = chain([0.03, 0.03, 0.03], ["top", "top"])
    times = np.array([0.0, 1.0, 2.0])
    angles = np.array([[math.pi, math.pi], [0.0, math.pi], [0.0, 0.0]])
    motion = Course(times, angles, np.zeros_like(angles), np.zeros_like(angles), True)
    low, high = corners_of(swept_box(linkage, motion, 0.0, 0))
    least, greatest = sampled_box(linkage, motion, 0)
    assert (low <= least).all()
    assert (high >= greatest).all()


@pytest.mark.parametrize("name", SAMPLES)
def test_the_box_of_a_proved_path_holds_its_panels_for_every_root(name):
    sample = planned(name)
    motion, slack = sample.proof.motion, sample.proof.slack
    for root in (0, sample.linkage.n_panels - 1):
        low, high = corners_of(swept_box(sample.linkage, motion, slack, root))
        least, greatest = sampled_box(sample.linkage, motion, root, 3)
        assert (low <= least - 0.999 * slack).all()
        assert (high >= greatest + 0.999 * slack).all()
        assert (least - low <= 2 * SWEPT_RESOLUTION_SHARE * sample.linkage.pattern.size + slack).all()


def test_the_slack_widens_every_side():
    linkage, rng = LINKAGES[1], np.random.default_rng(1)
    course = random_course(rng, linkage, 2)
    tight, wide = (swept_box(linkage, course, slack, 1) for slack in (0.0, 0.01))
    assert np.array(wide.sides) - tight.sides == pytest.approx([0.02] * 3)


def test_a_state_alone_sweeps_its_own_box_and_no_state_is_refused():
    linkage = LINKAGES[0]
    still = Course(np.zeros(1), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)), True)
    assert swept_box(linkage, still, 0.0, 0).sides == pytest.approx((0.07, 0.03, 0.004))
    nothing = Course(np.empty(0), np.empty((0, 1)), np.empty((0, 1)), np.empty((0, 1)), True)
    with pytest.raises(HcsearchError, match="give a state or more"):
        swept_box(linkage, nothing, 0.0, 0)
