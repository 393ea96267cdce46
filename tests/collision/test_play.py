"""Least gaps and needed margins against dense sampling, and their laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_clearance import chain, fan, gaps, hinged, moments, pairs_looked_at, random_course, shrunk_solids
from naive_distances import overlap_along_all

from hcsearch.basics.vocabulary import millimetres, play_sentence
from hcsearch.kernels.collision.gaps import first_overlap
from hcsearch.motion.collision.clearance import certify_clearance, least_gap_of_motion
from hcsearch.motion.collision.distances import deepest_cut, first_cut
from hcsearch.motion.collision.panel_prisms import MIN_PANEL_MARGIN, TOUCHING_DISTANCE, prisms_of
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.agreement import confirm_deployment
from hcsearch.springs.deployment.deployment_facts import deploy_linkage
from hcsearch.springs.deployment.play import course_of_deployment, needed_margin_of
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.subjects.resolve import resolve
from tests.linkages import linkage_named

LINKAGES = [
    chain([0.03, 0.02, 0.02, 0.04, 0.03], ["top", "bottom", "bottom", "top"]),
    chain([0.04, 0.02, 0.04], ["top", "top"]),
    fan(),
]
# Foldings that springs bring flat, in which scene, and what each needs: the least gap (mm) and the margin (mm).
DEPLOYING = [
    ("hex:0234550132:4", "default", -0.1989, 0.1),
    ("hex:022442445011:0", "default", -0.1109, 0.06),
    ("hex:022234445010:3", "hinged", 0.0, 0.01),
]


@settings(max_examples=25)
@given(st.sampled_from(LINKAGES), st.integers(0, 2**32), st.booleans(), st.sampled_from([0.2, 0.6]))
def test_the_least_gap_is_that_of_dense_sampling(linkage, seed, cubic, size):
    course = random_course(np.random.default_rng(seed), linkage, 2, size=size, cubic=cubic)
    gap = least_gap_of_motion(linkage, course, apart=hinged(linkage))
    _, states = moments(course, 400)
    cut = deepest_cut(linkage, states, hinged(linkage))
    if gap < 0.0 or cut:
        assert -cut >= gap - TOUCHING_DISTANCE
        assert gap >= -cut - 5e-5  # between the samples
    else:
        nearest = gaps(linkage, states[::40], pairs_looked_at(linkage, hinged(linkage))).min()
        assert gap - TOUCHING_DISTANCE <= nearest <= gap + 1e-3


@settings(max_examples=25)
@given(st.sampled_from(LINKAGES), st.integers(0, 2**32), st.sampled_from([5e-5, 2e-4, 8e-4]))
def test_half_an_overlap_off_every_face_is_enough(linkage, seed, margin):
    """Along any direction, two panels are further apart by two margins at least once they are shrunk by one."""
    course = random_course(np.random.default_rng(seed), linkage, 1, size=0.3)
    gap = least_gap_of_motion(linkage, course, apart=hinged(linkage))
    kind = certify_clearance(linkage, course, margin=margin, apart=hinged(linkage), measured=False).kind
    if gap > TOUCHING_DISTANCE - 2.0 * margin:
        assert kind == "clear"
    if gap < -2.0 * math.sqrt(3.0) * margin * 1.5:  # corners of panels with sharp corners move further than faces
        assert kind == "collides"


@pytest.fixture(scope="module", params=DEPLOYING, ids=lambda one: one[0])
def known(request):
    name, scene, gap, margin = request.param
    subject = resolve(name, "none.sqlite", scene=scene)
    return simulate_deployment(subject.linkage, subject.setup), 1e-3 * gap, 1e-3 * margin


def test_the_least_gap_of_a_deployment_is_that_of_its_densely_sampled_motion(known):
    deployment, gap, _ = known
    compiled, play = deployment.compiled, deployment.play
    _, states = moments(course_of_deployment(compiled, deployment.motion).course, 20)
    cut = first_cut(compiled.linkage, states, max(0.0, -gap - 1e-6), compiled.separated_pairs)
    assert play.least_gap == pytest.approx(gap, abs=1e-6)
    deepest = deepest_cut(compiled.linkage, states, compiled.separated_pairs)
    assert play.least_gap - TOUCHING_DISTANCE <= -deepest <= play.least_gap + 2e-6
    if cut is not None and gap < 0.0:
        solids = shrunk_solids(compiled.linkage, states[cut.state], 0.0)
        panel = compiled.linkage.pattern.panel_of
        one, two = ([s for s, p in zip(solids, panel, strict=True) if p == number] for number in cut.panels)
        naive = max(overlap_along_all(a, b) for a in one for b in two)
        assert naive == pytest.approx(cut.depth, abs=1e-9)
        assert gap - 2e-6 <= -naive <= gap + 4e-6


def overlaps(compiled, states, margin):
    """Whether panels shrunk by a margin overlap at any of some states."""
    pairs = np.array(pairs_looked_at(compiled.linkage, compiled.separated_pairs))
    prisms, depths = prisms_of(compiled.linkage, margin), np.zeros(len(pairs))
    return first_overlap(compiled.linkage.chain, prisms, pairs, np.ascontiguousarray(states), 1e-12, depths) >= 0


def test_the_needed_margin_is_enough_and_no_step_less_is(known):
    deployment, _, margin = known
    compiled, path = deployment.compiled, course_of_deployment(deployment.compiled, deployment.motion)
    assert deployment.play.needed_margin == pytest.approx(margin, abs=1e-12)
    _, states = moments(path.course, 20)
    assert not overlaps(compiled, states, margin)

    def kind(own):
        return certify_clearance(
            compiled.linkage, path.course, margin=own, slack=path.slacks, apart=compiled.separated_pairs, measured=False
        ).kind

    assert kind(margin) == "clear"
    assert needed_margin_of(compiled, deployment.motion, margin) == pytest.approx(margin, abs=1e-12)
    if margin > MIN_PANEL_MARGIN:
        assert kind(margin - MIN_PANEL_MARGIN) != "clear"
        assert overlaps(compiled, states, margin - 2.0 * MIN_PANEL_MARGIN)
    agreement = confirm_deployment(deployment)
    assert agreement.needed_margin >= margin - 1e-12
    assert agreement.least_gap == deployment.play.least_gap


def test_what_does_not_deploy_needs_no_margin():
    one = deploy_linkage("it", linkage_named("hex:02234400:1"), SCENES["default"])
    assert one.verdict == "collides"
    assert (one.deployment.play, one.needed_margin, one.least_gap) == (None, None, None)
    assert one.agreement.needed_margin is None


def test_no_margin_is_needed_beyond_that_of_the_scene():
    linkage = linkage_named("hex:0234550132:4")
    for margin in (1.234e-4, 2e-4):
        play = simulate_deployment(linkage, replace(SCENES["default"], margin=margin)).play
        # 0.199 mm of overlap, the half of it rounded up to a multiple of 0.01 mm
        assert play.needed_margin == pytest.approx(1e-4, abs=1e-12)
    scene = replace(SCENES["default"], margin=9.97e-5)
    assert simulate_deployment(linkage, scene).play.needed_margin == 9.97e-5


def test_gaps_are_stated_to_a_nanometre():
    stated = [millimetres(gap) for gap in (-5.6e-14, 7 * 1e-5, -1.98940123456e-4, 4e-10, math.nan, None)]
    assert stated == [0.0, 0.07, -0.19894, 0.0, None, None]
    assert math.copysign(1.0, stated[0]) == 1.0


def test_the_sentence_leaves_two_margins():
    assert play_sentence(0.065).startswith("leave 0.13 mm between faces: certified clear with panels 0.065 mm smaller")
    assert play_sentence(None) is None
