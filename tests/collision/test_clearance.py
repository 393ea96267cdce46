"""Certified clearance against dense sampling, its laws, and motions one knows."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from naive_clearance import (
    chain,
    distance,
    fan,
    gaps,
    hinged,
    moments,
    pairs_looked_at,
    polynomial,
    random_course,
    shrunk_solids,
    smallest_dip,
)
from scipy.optimize import brentq, minimize_scalar

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.gaps import first_overlap
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.multibody.events import largest_opening
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.motion.collision.clearance import certify_clearance
from hcsearch.motion.collision.distances import first_cut
from hcsearch.motion.collision.panel_prisms import (
    DEFAULT_PANEL_MARGIN,
    GAP_RESOLUTION,
    deepest_margin,
    kept_apart,
    longest_way,
    prisms_of,
    slack_of,
    solid_pairs,
)
from hcsearch.scenes import SCENES
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import RIGID_CREASE, VALLEY_CREASE, Pattern
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from tests.linkages import linkage_named

LINKAGES = [
    chain([0.04, 0.02, 0.04], ["top", "top"]),
    chain([0.03, 0.02, 0.02, 0.04, 0.03], ["top", "bottom", "bottom", "top"]),
    Linkage(chain([0.03, 0.02, 0.03, 0.03], ["bottom", "bottom", "bottom"]).pattern, base=2),
    fan(),
]
NAMES = ["element-8r", "hex:0234550132:4", "hex:02234400:1", "hex:022344440011:1", "square:01222300:0"]

motions = st.tuples(
    st.sampled_from(LINKAGES), st.integers(0, 2**32), st.integers(1, 3), st.booleans(), st.sampled_from([0.5, 1.0, 2.0])
)


def drawn(motion):
    linkage, seed, steps, cubic, size = motion
    return linkage, random_course(np.random.default_rng(seed), linkage, steps, size=size, cubic=cubic)


def certified(linkage, course, **options):
    return certify_clearance(linkage, course, apart=hinged(linkage), **options)


def first_sample_that_overlaps(linkage, states, margin=DEFAULT_PANEL_MARGIN, apart=None):
    """The first of some states at which shrunk panels overlap, by separating axes, and which do; -1 without."""
    pairs = np.array(pairs_looked_at(linkage, hinged(linkage) if apart is None else apart))
    depths = np.zeros(len(pairs))
    prisms = prisms_of(linkage, margin)
    number = first_overlap(linkage.chain, prisms, pairs, np.ascontiguousarray(states), 1e-13, depths)
    panel = linkage.pattern.panel_of
    return number, {tuple(sorted((panel[f], panel[g]))) for (f, g), depth in zip(pairs, depths, strict=True) if depth}


def nearest_at(linkage, course, time, panels, margin=DEFAULT_PANEL_MARGIN):
    """Distance of two shrunk panels at a time."""
    k = min(max(int(np.searchsorted(course.times, time)) - 1, 0), len(course.times) - 2)
    angles = polynomial(course, k)(time - course.times[k])
    solids, panel = shrunk_solids(linkage, angles, margin), linkage.pattern.panel_of
    one, two = ([s for s, p in zip(solids, panel, strict=True) if p == number] for number in panels)
    return min(distance(a, b) for a in one for b in two)


def agrees_with_sampling(linkage, course, clearance, count, apart=None):
    times, states = moments(course, count)
    number, overlapping = first_sample_that_overlaps(linkage, states, clearance.margin, apart)
    if clearance.kind == "clear":
        assert number < 0
        assert clearance.time is clearance.panels is None
        return
    assert clearance.gap is None
    assert nearest_at(linkage, course, clearance.time, clearance.panels, clearance.margin) < 1e-6
    if number >= 0:
        assert clearance.time <= times[number] + 1e-9
        if number == 0 or times[number - 1] < clearance.time - 1e-9:
            assert clearance.panels in overlapping
    if clearance.kind == "collides":
        k = int(np.searchsorted(times, clearance.time - 1e-9))
        assert number >= 0 or times[k - 1] < clearance.time
    assert number < 0 or number >= np.searchsorted(times, clearance.time - 1e-9)


@settings(max_examples=150)
@given(motions)
@example((LINKAGES[3], 2366, 2, False, 2.0))  # at the end of the shortest interval the panels are 1e-12 m apart
def test_the_verdict_is_that_of_two_thousand_states_a_step(motion):
    linkage, course = drawn(motion)
    clearance = certified(linkage, course, measured=False)
    agrees_with_sampling(linkage, course, clearance, 2000)
    assert clearance.kind != "undecided"  # rounding alone does not make it so
    assert clearance.bound_count > 0


@pytest.mark.parametrize("linkage", LINKAGES)
def test_random_motions_are_clear_as_well_as_not(linkage):
    rng = np.random.default_rng(3)
    kinds = [certified(linkage, random_course(rng, linkage, 2, size=1.5)).kind for _ in range(40)]
    assert {"clear", "collides"} == set(kinds)


@pytest.mark.parametrize("name", NAMES)
def test_deployments_agree_with_their_states(name):
    deployment = simulate_deployment(linkage_named(name), SCENES["default"], tolerance=1e-6)
    linkage, motion = deployment.compiled.linkage, deployment.motion
    accelerations = np.ascontiguousarray(motion.a[:, deployment.compiled.joint_of])
    course = Course(motion.times, deployment.angles.copy(), deployment.rates.copy(), accelerations, False)
    exact = certify_clearance(linkage, course, apart=deployment.compiled.separated_pairs)
    agrees_with_sampling(linkage, course, exact, 40, deployment.compiled.separated_pairs)
    assert exact.kind == deployment.clearance.kind
    if exact.kind == "collides":
        assert deployment.clearance.panels == exact.panels
        # what the loops leave open delays when it is sure
        assert exact.time <= deployment.clearance.time < exact.time + 5e-3
        return
    times, states = moments(course, 10)
    marked = np.isin(times, course.times)
    table = gaps(linkage, states, pairs_looked_at(linkage, deployment.compiled.separated_pairs))
    check_gap(exact.gap, table, marked)


def check_gap(gap, table, marked):
    """The smallest gap is right to the resolution; a dip about as deep as the rise may count or not."""
    low, high = (
        smallest_dip(table, marked, 2 * DEFAULT_PANEL_MARGIN + sign * 1.1 * GAP_RESOLUTION) for sign in (-1, 1)
    )
    own = math.inf if gap is None else gap
    assert low - 1.1 * GAP_RESOLUTION <= own <= high + 1e-9


def test_smallest_gaps_of_random_motions():
    rng = np.random.default_rng(11)
    seen = []
    for turn in range(40):
        linkage = LINKAGES[turn % len(LINKAGES)]
        course = random_course(rng, linkage, 8, size=0.2, cubic=bool(turn % 2))
        clearance = certified(linkage, course)
        if clearance.kind != "clear":
            continue
        times, states = moments(course, 80)
        table = gaps(linkage, states, pairs_looked_at(linkage, hinged(linkage)))
        check_gap(clearance.gap, table, np.isin(times, course.times))
        seen.append(clearance.gap)
    assert sum(gap is not None for gap in seen) > 10
    assert len({gap for gap in seen if gap is not None}) > 10


def swinging(times, first, second):
    """Three panels, the outer ones on top of the middle one, with given angles at rest at each time."""
    linkage = chain([0.06, 0.05, 0.03], ["top", "top"], thickness=0.001)
    angles = np.column_stack([first, second]).astype(float)
    still = np.zeros_like(angles)
    return linkage, Course(np.array(times, float), angles, still, still.copy(), False)


def test_panels_that_pass_through_each_other_between_two_states_are_found():
    linkage, course = swinging([0.0, 1e-3], [2.7, 2.7], [0.3, 3.0])
    for angles in course.angles:
        assert gaps(linkage, [angles], [(0, 2)])[0, 0] > 1e-3
    clearance = certified(linkage, course)
    assert (clearance.kind, clearance.panels) == ("collides", (0, 2))
    times, states = moments(course, 20_000)
    number, _ = first_sample_that_overlaps(linkage, states)
    assert times[number - 1] <= clearance.time <= times[number]
    # the way round the other side is free
    assert certified(*swinging([0.0, 1e-3], [2.7, 2.7], [0.3, -3.0])).kind == "clear"


def test_a_way_there_and_back_within_one_step_is_followed():
    """At both ends of the step the panels stand the same; at its middle they are through each other."""
    linkage, course = swinging([0.0, 0.01], [2.7, 2.7], [0.3, 0.3])
    course.rates[:, 1] = 1200.0, -1200.0
    middle = polynomial(course, 0)(0.005)
    assert 2.4 < middle[1] < 4.5
    clearance = certified(linkage, course)
    assert clearance.kind == "collides"
    assert 0.0 < clearance.time < 0.005


@pytest.mark.parametrize("name", ["thesis-4x4", "hex:0234550132:4", "unit-i"])
def test_touching_stacks_are_clear(name):
    linkage = linkage_named(name)
    for angles in (linkage.folded, linkage.flat):
        states = np.array([angles, angles])
        still = np.zeros_like(states)
        course = Course(np.array([0.0, 1.0]), states, still, still, False)
        assert gaps(linkage, states[:1], pairs_looked_at(linkage, hinged(linkage))).min() < 1e-12
        clearance = certified(linkage, course)
        assert (clearance.kind, clearance.gap) == ("clear", None)
        # nothing is nearer than two margins
        assert certified(linkage, course, slack=1.999 * DEFAULT_PANEL_MARGIN).kind == "clear"
        assert certified(linkage, course, slack=2.001 * DEFAULT_PANEL_MARGIN).kind == "undecided"


def test_panels_that_graze_each_other_are_not_clear():
    """The last panel swings to and fro; how far the first leans decides how deep they cut."""

    def swing(lean):
        return swinging([0.0, 0.01, 0.02], [lean] * 3, [0.3, 2.2, 0.3])

    def depth(lean):
        """Signed: at the widest swing, where they come nearest."""
        linkage, course = swing(lean)
        panels = np.array([(0, 2)])
        depths = np.zeros(1)
        shrunk, states = prisms_of(linkage, DEFAULT_PANEL_MARGIN), course.angles[1:2]
        if first_overlap(linkage.chain, shrunk, panels, states, 0.0, depths) == 0:
            return depths[0]
        return -nearest_at(linkage, course, 0.01, (0, 2))

    leans = np.linspace(1.2, 2.7, 40)
    signs = np.sign([depth(lean) for lean in leans])
    (k,) = np.flatnonzero(np.diff(signs))[:1]
    edge = brentq(depth, leans[k], leans[k + 1], xtol=1e-15, rtol=1e-15)
    kinds = []
    for lean in edge + np.array([-1e-5, -1e-14, -1e-15, 0.0, 1e-15, 1e-14, 1e-5]) * math.copysign(1, signs[k + 1]):
        kinds.append(certified(*swing(lean)).kind)
    assert kinds[0] == "clear"
    assert kinds[-1] == "collides"
    assert "clear" not in kinds[1:]


def nearest_of(linkage, course):
    """The least distance of shrunk panels in a motion of one step, by dense sampling, then by a search."""
    times, states = moments(course, 400)
    pairs = pairs_looked_at(linkage, hinged(linkage))
    table = gaps(linkage, states, pairs, DEFAULT_PANEL_MARGIN)
    k, p = np.unravel_index(table.argmin(), table.shape)

    def gap(time):
        return gaps(linkage, [polynomial(course, 0)(time)], pairs[p : p + 1], DEFAULT_PANEL_MARGIN)[0, 0]

    ends = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
    best = minimize_scalar(gap, bounds=ends, method="bounded", options={"xatol": 1e-12})
    return min(best.fun, table.min())


@settings(max_examples=15)
@given(st.sampled_from(LINKAGES), st.integers(0, 2**32))
def test_a_gap_smaller_than_the_slack_is_not_clear(linkage, seed):
    course = random_course(np.random.default_rng(seed), linkage, 1, size=0.3)
    least = nearest_of(linkage, course)
    if least == 0.0:
        assert certified(linkage, course).kind == "collides"
        return
    assert certified(linkage, course, slack=least * (1 - 1e-5) - 1e-9).kind == "clear"
    assert certified(linkage, course, slack=least * (1 + 1e-5) + 1e-9).kind == "undecided"


def test_only_deeper_overlaps_than_the_slack_collide():
    """The last panel comes down onto the first, which lies on the middle one, and into its corner by 0.05 mm."""
    linkage = chain([0.02, 0.05, 0.05], ["top", "top"], thickness=0.004)

    def gap(angle, more):
        """Between the corner and the face that comes down, both shrunk by the margin and more."""
        inset = DEFAULT_PANEL_MARGIN + more
        return (0.03 + inset) * math.sin(angle) - (0.004 - inset) * math.cos(angle) + inset

    lowest = brentq(lambda angle: gap(angle, 0.0) + 5e-5, 0.01, 0.5)
    angles = np.array([[math.pi, 1.0], [math.pi, math.pi - lowest]])
    still = np.zeros_like(angles)
    course = Course(np.array([0.0, 0.1]), angles, still, still, False)
    sure = 2.0 * brentq(lambda more: gap(lowest, more), 0.0, 1e-3)
    assert sure == pytest.approx(4.7e-5, rel=0.02)
    slacks = (0.0, 1e-6, 2e-5, sure * (1 - 1e-6), sure * (1 + 1e-6), 1e-4, 1e-3)
    verdicts = [certified(linkage, course, slack=slack) for slack in slacks]
    assert [each.panels for each in verdicts] == [(0, 2)] * 7
    assert [each.kind for each in verdicts] == ["collides"] * 4 + ["undecided"] * 3
    times = [each.time for each in verdicts]
    assert times[:4] == sorted(times[:4])  # the wider the slack, the later it is sure
    assert times[4:] == sorted(times[4:], reverse=True)  # and the earlier too near
    assert times[4] < times[0] < times[3]


def test_margins_that_leave_nothing_of_a_facet_are_refused():
    thick = chain([0.03, 0.03, 0.03], ["top", "top"], thickness=0.004)
    course = random_course(np.random.default_rng(0), thick, 1)
    assert deepest_margin(thick) == 0.002
    narrow = chain([0.03, 0.001, 0.03], ["top", "top"], thickness=0.004)
    assert deepest_margin(narrow) == pytest.approx(0.0005)
    for linkage, most in ((thick, "2"), (narrow, "0.5")):
        message = f"is not positive or leaves nothing of a panel: give more than 0 and less than {most} mm"
        for margin in (0.0, -1e-4, deepest_margin(linkage), 1.0, math.nan):
            with pytest.raises(HcsearchError, match=message):
                certify_clearance(linkage, course, margin=margin)
        certify_clearance(linkage, course, margin=0.99 * deepest_margin(linkage))


@pytest.mark.parametrize("linkage", [fan(), fan((7, 3, 4)), LINKAGES[1], linkage_named("hex:0234550132:4")])
def test_shrunk_panels_are_those_of_shapely(linkage):
    for margin in (1e-4, 0.5 * deepest_margin(linkage)):
        prisms = prisms_of(linkage, margin)
        for f, solid in enumerate(shrunk_solids(linkage, linkage.flat, margin)):
            own = prisms.vertices[f, : prisms.counts[f, 0]]
            apart = np.linalg.norm(own[:, None] - solid, axis=2)
            assert len(own) == len(solid)
            assert apart.min(axis=0).max() < 1e-12
            assert apart.min(axis=1).max() < 1e-12


def mirrored(linkage):
    """The mirror image in a plane across the sheet: hinges keep their face, and fold angles their sense."""
    pattern = linkage.pattern
    facets = tuple(tuple((x, -y) for x, y in reversed(facet)) for facet in pattern.facets)
    return Linkage(Pattern.from_polygons(facets, pattern.creases, pattern.thickness), base=linkage.base)


def reversed_order(linkage):
    """The same panels, counted from the last; hinges come in another order too."""
    pattern = linkage.pattern
    n = len(pattern.facets)
    creases = {(n - 1 - j, n - 1 - i): crease for (i, j), crease in reversed(pattern.creases.items())}
    return Linkage(Pattern.from_polygons(tuple(reversed(pattern.facets)), creases, pattern.thickness))


@settings(max_examples=40)
@given(motions)
def test_it_does_not_matter_how_one_looks(motion):
    linkage, course = drawn(motion)
    clearance = certified(linkage, course)
    for other in (
        Linkage(linkage.pattern.moved(0.7, (0.3, -0.2)), base=linkage.base),
        Linkage(linkage.pattern.moved(2.0, over=True), base=linkage.base),
        Linkage(linkage.pattern, base=linkage.n_panels - 1),
        mirrored(linkage),
    ):
        same_verdict(clearance, certified(other, course), linkage, course)
    other = reversed_order(linkage)
    n = linkage.n_panels - 1
    number = {(hinge.first, hinge.second): k for k, hinge in enumerate(linkage.pattern.hinges)}
    turned = ((n - hinge.second, n - hinge.first) for hinge in other.pattern.hinges)
    order = [number[pair if pair in number else pair[::-1]] for pair in turned]
    tables = (np.ascontiguousarray(table[:, order]) for table in course[1:4])
    last = certified(other, Course(course.times, *tables, course.cubic))
    last = replace(last, panels=last.panels and (n - last.panels[1], n - last.panels[0]))
    same_verdict(clearance, last, linkage, course)


def same_verdict(one, two, linkage, course, tolerance=1e-9):
    """The same but for rounding, which may make a dip of a gap count that is about as deep as the rise."""
    assert one.kind == two.kind
    assert one.time == pytest.approx(two.time, abs=tolerance)
    if one.time is None or one.time > tolerance:  # at the start several pairs may overlap
        assert one.panels == two.panels
    widths = [math.inf if each.gap is None else each.gap for each in (one, two)]
    if widths[0] != widths[1] and abs(widths[0] - widths[1]) > 1.01 * GAP_RESOLUTION:
        times, states = moments(course, 80)
        table = gaps(linkage, states, pairs_looked_at(linkage, hinged(linkage)))
        for width in widths:
            check_gap(width, table, np.isin(times, course.times))


@settings(max_examples=40)
@given(motions, st.floats(0.05, 0.95))
def test_a_state_more_changes_nothing_but_rounding(motion, share):
    linkage, course = drawn(motion)
    h = course.times[1] - course.times[0]
    own = polynomial(course, 0)
    rows = [own.derivative(k)(share * h) if k else own(share * h) for k in range(3)]
    tables = [np.insert(table, 1, row, axis=0) for table, row in zip(course[1:4], rows, strict=True)]
    tables[2] *= not course.cubic
    finer = Course(np.insert(course.times, 1, course.times[0] + share * h), *tables, course.cubic)
    one, two = (certified(linkage, each, measured=False) for each in (course, finer))
    same_verdict(one, two, linkage, course)


@settings(max_examples=40)
@example((LINKAGES[2], 69471861, 1, False, 0.5))
@given(motions)
def test_backwards_it_is_the_same_but_for_the_time(motion):
    linkage, course = drawn(motion)
    times = (course.times[-1] - course.times)[::-1].copy()
    tables = [sign * table[::-1] for sign, table in zip((1, -1, 1), course[1:4], strict=True)]
    one, two = certified(linkage, course), certified(linkage, Course(times, *tables, course.cubic))
    assert one.kind == two.kind
    if one.kind == "collides":
        # backwards the last collision comes first
        assert course.times[-1] - two.time >= one.time - 1e-9
    else:
        same_verdict(one, two, linkage, course)


@settings(max_examples=40)
@given(motions)
def test_each_step_alone_has_the_same_verdict(motion):
    """What is known of a pair from earlier steps saves looks, and changes nothing."""
    linkage, course = drawn(motion)
    whole = certified(linkage, course, measured=False)
    looks = 0
    for k in range(len(course.times) - 1):
        one = certified(linkage, Course(*(table[k : k + 2] for table in course[:4]), course.cubic), measured=False)
        looks += one.bound_count
        if one.kind != "clear":
            break
    assert whole.kind == one.kind
    assert whole.time == pytest.approx(one.time, abs=1e-12)
    assert whole.bound_count <= looks


def test_pairs_that_are_far_apart_are_looked_at_once():
    linkage, course = swinging(np.arange(11.0), 1e-3 * np.arange(11), np.zeros(11))
    assert certified(linkage, course, measured=False).bound_count == 1


def test_nothing_is_looked_at_without_pairs_or_steps():
    linkage = LINKAGES[0]
    course = random_course(np.random.default_rng(1), linkage, 3)
    everything = {(0, 1), (0, 2), (1, 2)}
    clearance = certify_clearance(linkage, course, apart=everything)
    assert (clearance.kind, clearance.gap, clearance.bound_count) == ("clear", None, 0)
    one = Course(*(table[:1] for table in course[:4]), False)
    assert certified(linkage, one).bound_count == 0


@given(motions, st.lists(st.sampled_from([0.0, 1e-5, 3e-4]), min_size=8, max_size=8))
def test_slack_of_each_step_is_between_the_least_and_the_most(motion, slacks):
    linkage, seed, steps, cubic, size = motion
    course = random_course(np.random.default_rng(seed), linkage, steps, cubic=cubic, size=size)
    slack = np.array(slacks)[: len(course.times) - 1]
    clearance = certified(linkage, course, slack=slack)
    least, most = (certified(linkage, course, slack=float(one)) for one in (slack.min(), slack.max()))
    if most.kind != "undecided":
        assert clearance.kind == most.kind
    if clearance.kind == "clear":
        assert least.kind == "clear"
        assert (clearance.gap is None) == (least.gap is None)
        if clearance.gap:
            assert clearance.gap == pytest.approx(least.gap + slack.min() - slack.max(), abs=1e-11)
    if clearance.kind == "collides":
        assert least.kind == "collides"
        assert least.time <= clearance.time
    even = certified(linkage, course, slack=np.full(len(slack), slack[0]))
    one = certified(linkage, course, slack=float(slack[0]))
    assert (even.kind, even.time, even.panels) == (one.kind, one.time, one.panels)


@given(st.sampled_from(LINKAGES), st.integers(0, 2**32))
def test_no_two_corners_are_further_apart_than_the_longest_way(linkage, seed):
    angles = np.random.default_rng(seed).uniform(-np.pi, np.pi, linkage.n_hinges)
    corners = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(angles)])
    assert np.linalg.norm(corners[:, None] - corners, axis=2).max() <= longest_way(linkage) + 1e-12


def test_the_longest_way_of_a_strip_is_its_length():
    strip = LINKAGES[0]
    corners = np.concatenate([solid.reshape(-1, 3) for solid in strip.solids(np.zeros(strip.n_hinges))])
    across = np.linalg.norm(corners[:, None] - corners, axis=2).max()
    assert across <= longest_way(strip) < 1.5 * across


def test_the_same_motion_gives_the_same_bits():
    rng = np.random.default_rng(8)
    courses = [random_course(rng, linkage, 3, size=0.3) for linkage in LINKAGES]
    one, two = ([certified(*each) for each in zip(LINKAGES, courses, strict=True)] for _ in range(2))
    assert one == two


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
@pytest.mark.parametrize("name", ["hex:0234550132:4", "hex:022344440011:1", "hex:023333505511:3", "unit-i"])
def test_no_panel_is_further_from_its_place_than_the_slack(name, tolerance):
    """Placed by trees from other panels, which break the loops elsewhere, panels lie within the slack."""
    scene = replace(SCENES["default"], seconds=0.3)
    deployment = simulate_deployment(linkage_named(name), scene, tolerance=tolerance, certified=False)
    compiled, motion = deployment.compiled, deployment.motion
    own = compiled.linkage
    tree = compiled.system.mechanism.tree
    gap = largest_opening(tree, (motion.times, motion.q, motion.v, motion.a), motion.cubic, work_for(tree))
    slack = slack_of(own, gap)
    trees = {}
    for base in range(own.n_panels):
        other = Linkage(own.pattern, base=base)
        trees[tuple(sorted(other.chain.hinges))] = other
    assert len(trees) > 1
    ends, shares = np.array([motion.times[:-1], motion.times[1:]]), np.linspace(0.1, 0.9, 9)[:, None]
    times = (ends[0] + shares * (ends[1] - ends[0])).ravel()
    states = compiled.of_hinges(motion.at(times), np.zeros((len(times), motion.q.shape[1])))[0]
    # where loops are widest open
    openings = np.array([np.abs(own.closure(angles)[0]).max() for angles in states])
    worst = 0.0
    for angles in states[openings.argsort()[-4:]]:
        for other in trees.values():
            for f, g in solid_pairs(own, prisms_of(own)).prisms[::5]:
                seen = [relative(linkage, angles, f, g) for linkage in (own, other)]
                worst = max(worst, np.linalg.norm(seen[0] - seen[1], axis=1).max())
    assert 1e-3 * slack < worst < slack


def test_stops_keep_panels_apart_that_lie_on_two_sides_of_their_hinge():
    """Those of all assemblies do: they only touch, at any fold angles within the stops."""
    for name, assembly in ASSEMBLIES.items():
        linkage = Linkage(assembly.build(assembly.defaults))
        assert kept_apart(linkage) == hinged(linkage), name
    rng, thesis = np.random.default_rng(4), Linkage(ASSEMBLIES["thesis-4x4"].build(ASSEMBLIES["thesis-4x4"].defaults))
    for linkage in (*LINKAGES, thesis):
        every = set(combinations(range(linkage.n_panels), 2))
        states = rng.uniform(0.0, math.pi, (20, linkage.n_hinges))
        # a tree of hinges has the fold angles of the states, the others open the loops
        tree = {tuple(sorted(pair)) for pair in in_tree(linkage)}
        assert first_cut(linkage, states, 1e-12, every - (kept_apart(linkage) & tree)) is None


def in_tree(linkage):
    """Pairs of panels that the hinges of the tree join."""
    chain, hinges = linkage.chain, linkage.pattern.hinges
    return [(hinges[h].first, hinges[h].second) for h in chain.hinges if h >= 0]


def test_a_panel_that_reaches_across_the_line_of_its_hinge_may_collide():
    """The second panel swings against a part of the first that leans over it, across the line."""
    facets = (
        ((-0.05, 0.0), (0.0, 0.0), (0.0, 0.05), (-0.05, 0.05)),
        ((-0.05, 0.05), (0.0, 0.05), (0.0, 0.1), (-0.05, 0.1)),
        ((0.0, 0.05), (0.05, 0.02), (0.05, 0.1), (0.0, 0.1)),
        ((0.0, 0.0), (0.05, 0.0), (0.05, 0.02), (0.0, 0.05)),
    )
    creases = {(0, 1): RIGID_CREASE, (1, 2): RIGID_CREASE, (0, 3): VALLEY_CREASE}
    linkage = Linkage(Pattern.from_polygons(facets, creases, 0.006))
    assert linkage.n_panels == 2
    assert kept_apart(linkage) == set()
    times, angles = np.array([0.0, 1.0]), np.array([[math.pi], [0.0]])
    course = Course(times, angles, np.zeros_like(angles), np.zeros_like(angles), True)
    assert certify_clearance(linkage, course, apart=kept_apart(linkage)).kind == "collides"
    assert certify_clearance(linkage, course, apart=hinged(linkage)).kind == "clear"


def relative(linkage, angles, f, g):
    """Corners of facet g as the panel of facet f sees them."""
    pose = linkage.poses(angles)[linkage.pattern.panel_of[f]]
    return (linkage.solids(angles)[g].reshape(-1, 3) - pose[:, 3]) @ pose[:, :3]
