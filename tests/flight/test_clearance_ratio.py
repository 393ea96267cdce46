"""Gaps over stacks of tolerances: stacks by hand and against built chains, gaps against states one by one."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.collision.panel_prisms import margin_of, prisms_of
from hcsearch.motion.locks.end_locks import layer_contacts
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Pattern
from hcsearch.springs.flight.build_errors import BuildTolerances, error_map
from hcsearch.springs.flight.clearance_ratio import clearance_ratio, tolerance_stacks
from tests.collision.naive_distances import feature_distance
from tests.flight.arrays import SIDE, THICKNESS, scaled, strip, tolerances_of
from tests.flight.naive_built import BuiltArray
from tests.planned import along, planned

NAMES = ("hex:0234550132:4", "rectangle:0122333011:1")


def stack_of(linkage, tolerances, pair):
    return float(tolerance_stacks(linkage, tolerances, np.array([pair]))[0][0])


def test_a_stack_is_the_sum_of_errors_times_arms():
    linkage = strip(["top", "top"])
    corner = math.hypot(SIDE, THICKNESS)  # of the last panel, from the axis of its hinge
    reach = math.hypot(corner, SIDE / 2)  # from the middle of that hinge
    arms = (SIDE + reach, corner)
    angles = BuildTolerances((1e-3, 3e-3), (0.0, 1e-3))
    assert stack_of(linkage, angles, (0, 2)) == pytest.approx(1e-3 * arms[0] + 4e-3 * arms[1])
    assert stack_of(linkage, tolerances_of(linkage, 0.0, thickness=1e-4), (0, 2)) == pytest.approx(3e-4)
    turn = math.asin(2 * math.sqrt(2) * 1e-5 / SIDE)
    shift = 2 * (2 * math.sqrt(2) * 1e-5 + turn * (SIDE + 2 * reach))
    assert stack_of(linkage, tolerances_of(linkage, 0.0, offset=1e-5), (0, 2)) == pytest.approx(shift)


def chain_shift(linkage, way, angles, errors):
    """Change of the place of the last panel of a row of hinges by errors, seen from the first, at some fold angles."""
    plain, nothing = BuiltArray(linkage), np.zeros_like(errors)
    nothing[:, : linkage.n_hinges] = angles
    placed = []
    for sample in (nothing, nothing + errors):
        pose = np.tile(np.eye(4), (len(errors), 1, 1))
        for hinge, sign in way:
            step = plain.across(sample, hinge)
            pose = pose @ (step if sign == 1 else np.linalg.inv(step))
        placed.append(pose)
    return placed[1] - placed[0]


@settings(max_examples=20)
@given(st.sampled_from(NAMES), st.integers(0, 2**32 - 1), st.floats(1e-4, 0.05))
def test_no_built_chain_moves_its_panels_further_than_the_stack(name, seed, angle):
    linkage, rng = planned(name).linkage, np.random.default_rng(seed)
    one, two = rng.choice(linkage.n_panels, 2, replace=False).tolist()
    tolerances = tolerances_of(linkage, angle, angle / 3, 0.01 * angle, 0.01 * angle)
    bounds = error_map(linkage, tolerances, 0).bounds
    errors = np.where(rng.random((100, 1)) < 0.5, 1.0, rng.random((100, 1))) * np.sign(
        rng.normal(size=(100, len(bounds)))
    )
    way = hinge_tree(linkage.pattern, one).way(two)
    shift = chain_shift(linkage, way, rng.uniform(0.0, math.pi, linkage.n_hinges), errors * bounds)
    faces = (-linkage.pattern.thickness / 2, linkage.pattern.thickness / 2)
    corners = np.array(
        [(*corner, z, 1.0) for k in linkage.pattern.panels[two] for corner in linkage.pattern.facets[k] for z in faces]
    )
    moved = np.linalg.norm(shift @ corners.T, axis=1).max()
    assert moved + tolerances.thickness <= stack_of(linkage, tolerances, (one, two)) * (1 + 1e-9)


def test_a_straight_chain_bent_one_way_nearly_reaches_its_stack():
    linkage = strip(["top"] * 4)
    tolerances = tolerances_of(linkage, 1e-3)
    errors = np.zeros((1, 5 * linkage.n_hinges + linkage.n_panels))
    errors[:, : linkage.n_hinges] = 1e-3
    way = hinge_tree(linkage.pattern, 0).way(4)
    shift = chain_shift(linkage, way, np.zeros(4), errors)
    moved = float(np.linalg.norm(shift @ [5 * SIDE, SIDE, -THICKNESS / 2, 1.0]))
    assert 0.9 * stack_of(linkage, tolerances, (0, 4)) < moved < stack_of(linkage, tolerances, (0, 4))


def naive_gaps(linkage, margin, states):
    """The least distance of two panels that no hinge joins, shrunk by a margin, at each of some states."""
    prisms = prisms_of(linkage, margin)
    joined = {tuple(sorted((hinge.first, hinge.second))) for hinge in linkage.pattern.hinges}
    gaps = []
    for angles in states:
        poses = linkage.poses(angles)
        solids = [
            prisms.vertices[k, : prisms.counts[k, 0]] @ poses[panel][:, :3].T + poses[panel][:, 3]
            for k, panel in enumerate(prisms.panels)
        ]
        pairs = [(i, j) for i in range(len(solids)) for j in range(i) if (j, i) not in joined]
        gaps.append(min(feature_distance(solids[i], solids[j]) for i, j in pairs))
    return np.array(gaps)


def test_the_gap_is_no_greater_than_at_any_state_and_two_margins_in_the_flat_state():
    known = planned(NAMES[1])
    motion, margin = known.proof.motion, 5e-4
    ratio = clearance_ratio(known.linkage, motion, known.proof.slack, tolerances_of(known.linkage), margin)
    states = np.concatenate([along(known, np.linspace(*motion.times[[0, -1]], 6)), known.linkage.flat[None]])
    gaps = naive_gaps(known.linkage, margin, states)
    assert 0.9 * gaps.min() < ratio.gap <= gaps.min()
    assert gaps[-1] == pytest.approx(2 * margin)


@settings(max_examples=10)
@given(st.sampled_from(NAMES), st.floats(0.1, 10.0))
def test_the_ratio_falls_as_tolerances_rise_and_rises_with_the_margin(name, by):
    known = planned(name)
    tolerances = tolerances_of(known.linkage, 1e-4, 1e-5, 0.0, 1e-5)
    arguments = known.linkage, known.proof.motion, known.proof.slack
    margin = margin_of(known.linkage)
    one, other = (clearance_ratio(*arguments, changed, margin) for changed in (tolerances, scaled(tolerances, by)))
    assert other.ratio == pytest.approx(one.ratio / by)
    wider = clearance_ratio(*arguments, tolerances, 2 * margin)
    assert wider.ratio > one.ratio
    looser = clearance_ratio(*arguments[:2], known.proof.slack + 1e-5, tolerances, margin)
    assert looser.gap == pytest.approx(one.gap - 1e-5) or looser.ratio <= one.ratio


def opening(linkage):
    """All hinges turn evenly from packed to flat."""
    angles = np.array([linkage.folded, linkage.flat])
    rates = np.tile(linkage.flat - linkage.folded, (2, 1))
    return Course(np.array([0.0, 1.0]), angles, rates, np.zeros_like(angles), True)


def test_panels_that_meet_have_no_ratio_left():
    linkage = strip(["top", "top"])  # rolled up: the last panel would lie in the first
    ratio = clearance_ratio(linkage, opening(linkage), 0.0, tolerances_of(linkage), 1e-4)
    assert (ratio.ratio, ratio.gap, ratio.hinges) == (0.0, 0.0, 2)


def test_nothing_is_compared_without_tolerances_or_pairs():
    known = planned(NAMES[0])
    exact = tolerances_of(known.linkage, 0.0)
    assert clearance_ratio(known.linkage, known.proof.motion, known.proof.slack, exact, 1e-4) is None
    pair = strip(["top"])
    assert clearance_ratio(pair, opening(pair), 0.0, tolerances_of(pair), 1e-4) is None


def test_a_zigzag_is_nearest_when_packed():
    linkage = strip(["top", "bottom"])
    ratio = clearance_ratio(linkage, opening(linkage), 0.0, tolerances_of(linkage), 1e-4)
    assert ratio.gap == pytest.approx(THICKNESS + 2e-4, abs=2e-6)


def test_panels_face_to_face_are_exempt():
    """A long panel carries two short ones side by side, on which another long one lies, joined to one of them."""
    places = [(0, 0), (1, 0), (-1, 0), (2, 0), (-1, 1), (-2, 1)]
    squares = [[(SIDE * (x + u), SIDE * (y + v)) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))] for x, y in places]
    creases = {(0, 1): RIGID_CREASE, (0, 2): VALLEY_CREASE, (1, 3): VALLEY_CREASE}
    creases |= {(2, 4): MOUNTAIN_CREASE, (4, 5): RIGID_CREASE}
    linkage = Linkage(Pattern.from_polygons(squares, creases, THICKNESS))
    (contact,) = layer_contacts(linkage)
    assert {linkage.pattern.panel_of[contact.below], linkage.pattern.panel_of[contact.above]} == {2, 3}
    ratio = clearance_ratio(linkage, opening(linkage), 0.0, tolerances_of(linkage), 1e-4)
    # the short ones are two margins apart, and so are those face to face, with one more hinge between them
    assert ratio.gap <= 2e-4
    assert ratio.hinges == 2


def test_a_margin_that_leaves_nothing_is_refused():
    known = planned(NAMES[0])
    with pytest.raises(HcsearchError, match="leaves nothing of a panel"):
        clearance_ratio(known.linkage, known.proof.motion, 0.0, tolerances_of(known.linkage), 1.0)
