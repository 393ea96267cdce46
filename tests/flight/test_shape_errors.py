"""Shapes of built arrays: by hand, against built geometry closed by Newton's method, and by laws."""

import math
from dataclasses import asdict
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.build_errors import BuildTolerances, error_map
from hcsearch.springs.flight.shape_errors import self_stresses_when_flat, shape_errors
from tests.flight.arrays import SIDE, exact_rank, greatest_errors, scaled, strip, tolerances_of
from tests.flight.naive_built import BuiltArray, built_samples
from tests.linkages import linkage_named
from tests.planned import joined

LOOPED = ("hex:0234550132:4", "square:012233230011:4", "rectangle:0122333011:1")
"""Foldings whose flat pairs are hinged, with one loop each."""


@cache
def looped(name):
    return joined(name, "hinged")


def corner_goals(built):
    """How far each corner of a facet rises for each error."""
    pattern = built.linkage.pattern
    corners = [
        (corner, panel) for facet, panel in zip(pattern.facets, pattern.panel_of, strict=True) for corner in facet
    ]
    return built.heights(np.array([corner for corner, _ in corners]), np.array([panel for _, panel in corners]))


# one hinge, by hand


def test_one_hinge_bends_two_squares_to_a_roof():
    linkage = strip(["top"])
    errors = shape_errors(linkage, tolerances_of(linkage, stops=2e-3, play=1e-3), 0)
    # heights are x t / 2 + |x| t / 2 about the hinge; of |x| the plane takes the mean, a quarter of the width
    assert errors.flatness_per_rad == pytest.approx(SIDE / 4)
    assert errors.flatness == pytest.approx(3e-3 * SIDE / 4)
    assert errors.rms_flatness_per_rad == pytest.approx(SIDE / 4 / math.sqrt(3) / math.sqrt(3))
    assert errors.rms_flatness == pytest.approx(math.hypot(2e-3, 1e-3) * SIDE / 12)
    assert errors.tilt_per_rad == pytest.approx(0.5)
    assert errors.root_tilt_per_rad == pytest.approx(1.0)
    assert errors.tilt == pytest.approx(1.5e-3)
    assert errors.angle_shares == pytest.approx((errors.flatness,))
    assert (errors.self_stresses, errors.needed_play, errors.misfit) == (0, 0.0, 0.0)


def test_a_thicker_panel_is_a_step_of_half_its_error_at_a_hinge():
    linkage = strip(["top"])
    errors = shape_errors(linkage, tolerances_of(linkage, stops=0.0, thickness=1e-4), 0)
    # a step of 1e-4 where one panel is thicker and one is thinner; the plane has the slope 3/4 of the step over a side
    assert errors.flatness == pytest.approx(0.5e-4)
    assert errors.tilt == pytest.approx(0.75e-4 / SIDE)
    assert errors.root_tilt == 0.0
    assert errors.thickness_share == pytest.approx(errors.flatness)


def test_an_axis_tilts_the_panel_by_both_ends_on_both_panels():
    linkage = strip(["bottom"])
    errors = shape_errors(linkage, tolerances_of(linkage, stops=0.0, offset=1e-5), 0)
    assert errors.root_tilt == pytest.approx(4e-5 / SIDE)
    assert errors.offset_share == pytest.approx(errors.flatness)


# the linear map against built geometry


@pytest.mark.parametrize("name", [*LOOPED, "unit-ii"])
def test_the_map_is_the_derivative_of_built_geometry(name):
    linkage = linkage_named(name) if name == "unit-ii" else looped(name)
    built = error_map(linkage, tolerances_of(linkage, 1e-3, 0.0, 1e-5, 1e-5), 1)
    plain, step = BuiltArray(linkage, 1), 1e-3 * np.diag(built.bounds)
    residual = built.closure.reshape(-1, 6, len(built.bounds)) * built.bounds
    slopes = plain.slopes(built.bounds).reshape(residual.shape)
    assert residual[:, :3] == pytest.approx(slopes[:, :3], abs=1e-8)
    # the plain residual is the shift of the drawing's origin, half way through the panels
    away = np.cross(residual[:, :3], -built.centre * [1, 1, 0], axisa=1, axisc=1)
    assert built.radius * residual[:, 3:] + away == pytest.approx(slopes[:, 3:], abs=1e-9)
    # errors that close the loops place panels the same way, whichever way leads to them
    rows, _ = built.independent_rows(built.bounds)
    closing = np.eye(len(built.bounds)) - rows.T @ rows
    rises = (np.array(plain.panels(step)) - np.array(plain.panels(-step)))[:, :, 2] @ [0.02, 0.03, 0.0, 1.0] / 2e-3
    spots, panels = np.tile([0.02, 0.03], (linkage.n_panels, 1)), np.arange(linkage.n_panels)
    heights = built.heights(spots, panels) * built.bounds
    assert heights @ closing == pytest.approx(rises @ closing, abs=1e-9)


def test_angles_close_loops_as_the_linkage_says():
    for name in LOOPED:
        linkage = looped(name)
        built = error_map(linkage, tolerances_of(linkage), 0)
        _, jacobian = linkage.closure(linkage.flat)
        turns = built.closure[:, : linkage.n_hinges]
        # the same turns close both, whatever the origin and the unit of length
        both = np.vstack([turns, jacobian])
        assert np.linalg.matrix_rank(both) == np.linalg.matrix_rank(turns) == np.linalg.matrix_rank(jacobian)


@pytest.mark.parametrize("name", LOOPED)
@pytest.mark.parametrize("offset", [1e-6, 2e-5])
def test_no_built_array_is_less_flat_and_one_nearly_is(name, offset):
    linkage = looped(name)
    tolerances = tolerances_of(linkage, 5e-4, 5e-4, offset, 1e-5)
    errors, built, plain = shape_errors(linkage, tolerances, 0), error_map(linkage, tolerances, 0), BuiltArray(linkage)
    rng = np.random.default_rng(7)
    spread = rng.uniform(-1.0, 1.0, (300, len(built.bounds)))
    extreme = greatest_errors(built, rng.normal(size=(300, len(built.bounds))))
    samples = built_samples(plain, built, np.concatenate([spread, extreme]))
    assert len(samples) > 550
    assert plain.flatness(samples)[0].max() <= errors.flatness + errors.second_order
    worst = built_samples(plain, built, greatest_errors(built, _off_plane(built)))
    assert 0.95 * errors.flatness <= plain.flatness(worst)[0].max() <= errors.flatness + errors.second_order


def _off_plane(built):
    """The rise of each corner above the plane through many points of all panels, by least squares."""
    pattern = built.linkage.pattern
    spots, panels = [], []
    for facet, panel in zip(pattern.facets, pattern.panel_of, strict=True):
        polygon = np.array(facet)
        steps = [(i / 12, j / 12) for i in range(13) for j in range(13)]
        for k in range(1, len(polygon) - 1):
            a, b, c = polygon[[0, k, k + 1]]
            inside = [a + u * (b - a) + v * (c - a) for u, v in steps if u + v <= 1]
            spots += inside
            panels += [panel] * len(inside)
    heights = built.heights(np.array(spots), np.array(panels))
    corners = np.array([corner for facet in pattern.facets for corner in facet])
    terms = [np.column_stack([np.ones(len(points)), points]) for points in (np.array(spots), corners)]
    return corner_goals(built) - terms[1] @ np.linalg.lstsq(terms[0], heights, rcond=None)[0]


def test_exactly_drilled_arrays_stay_within_the_bound():
    linkage = looped(LOOPED[0])
    tolerances = tolerances_of(linkage, 1e-3)
    errors, built, plain = shape_errors(linkage, tolerances, 0), error_map(linkage, tolerances, 0), BuiltArray(linkage)
    rng, seen = np.random.default_rng(3), 0
    for _ in range(60):
        state = close_linkage(linkage, rng.uniform(-1e-3, 1e-3, linkage.n_hinges))
        if state.closed and np.abs(state.angles).max() <= 1e-3:
            sample = np.zeros((1, len(built.bounds)))
            sample[0, : linkage.n_hinges] = state.angles
            assert plain.flatness(sample)[0][0] <= errors.flatness + errors.second_order
            seen += 1
    assert seen > 40


# root mean squares


@pytest.mark.parametrize("name", LOOPED)
def test_root_mean_squares_are_those_of_random_arrays(name):
    linkage = looped(name)
    tolerances = tolerances_of(linkage, 1e-3, 5e-4, 1e-6, 1e-5)
    errors, built, plain = shape_errors(linkage, tolerances, 0), error_map(linkage, tolerances, 0), BuiltArray(linkage)
    rng = np.random.default_rng(5)
    samples = plain.closed(built.deviations * rng.normal(size=(3000, len(built.bounds))), built.deviations)
    assert np.median(plain.opening(samples)) < 1e-11
    rms = math.sqrt(float((plain.flatness(samples)[1] ** 2).mean()))
    assert errors.rms_flatness == pytest.approx(rms, rel=0.05)


@pytest.mark.parametrize("name", LOOPED)
def test_needed_play_and_misfit_are_those_of_least_squares(name):
    linkage = looped(name)
    tolerances = tolerances_of(linkage, 1e-3, 5e-4, 1e-5, 1e-5)
    errors, built, n = shape_errors(linkage, tolerances, 0), error_map(linkage, tolerances, 0), linkage.n_hinges
    sizes = np.concatenate([np.full(n, 1e-3), built.bounds[n:] / np.where(built.bounds[n:] > 1e-5, math.sqrt(2), 1)])
    rng = np.random.default_rng(2)
    opened = built.closure @ (sizes[:, None] / math.sqrt(3) * rng.normal(size=(len(sizes), 4000)))
    turns = built.closure[:, :n]
    play = np.linalg.lstsq(turns, -opened, rcond=1e-9)[0]
    assert errors.needed_play == pytest.approx(np.sqrt((play**2).mean(axis=1)).max(), rel=0.05)
    left = built.radius * np.linalg.norm(opened + turns @ play, axis=0)
    assert errors.misfit == pytest.approx(math.sqrt((left**2).mean()), rel=0.05)


# self-stresses


@pytest.mark.parametrize("name", [*LOOPED, "triangle:012343454505012321:3", "hex:0223335500:4", "unit-i", "unit-ii"])
@pytest.mark.parametrize("way", ["rigid", "hinged"])
def test_self_stresses_are_what_other_ranks_say(name, way):
    linkage = linkage_named(name) if name.startswith("unit") else joined(name, way)
    _, jacobian = linkage.closure(linkage.flat)
    stresses = self_stresses_when_flat(linkage)
    assert stresses == linkage.n_rows - np.linalg.matrix_rank(jacobian, tol=1e-9)
    end = whole_end(linkage, linkage.flat)
    if end is not None:
        exact = [[Fraction(int(value)) for value in row] for row in end.columns.tolist()]
        assert stresses == linkage.n_rows - exact_rank(exact)
    # all hinges are level when flat, so that no turn of a hinge turns a loop about the upright axis
    assert stresses >= len(linkage.loops) > 0


def test_open_chains_have_no_self_stress_and_do_not_bind():
    linkage = strip(["top", "bottom", "top"])
    errors = shape_errors(linkage, tolerances_of(linkage, 1e-3, 1e-3, 1e-4, 1e-4), 2)
    assert (errors.self_stresses, errors.needed_play, errors.misfit) == (0, 0.0, 0.0)


def test_exact_parts_leave_an_array_flat():
    linkage = looped(LOOPED[0])
    errors = asdict(shape_errors(linkage, tolerances_of(linkage, 0.0), 0))
    zero = {"flatness", "rms_flatness", "tilt", "root_tilt", "second_order", "needed_play", "misfit", "offset_share"}
    assert {name: errors[name] for name in zero} == dict.fromkeys(zero, 0.0)
    assert errors["flatness_per_rad"] > 0.0


# laws

LENGTHS = ("flatness", "rms_flatness", "tilt", "root_tilt", "needed_play", "misfit")
MIXED = {"stops": 1e-3, "play": 2e-4, "offset": 3e-6, "thickness": 1e-5}


@settings(max_examples=15)
@given(st.sampled_from(LOOPED), st.floats(1e-3, 1.0))
def test_all_numbers_are_proportional_to_the_tolerances(name, by):
    linkage = looped(name)
    tolerances = tolerances_of(linkage, **MIXED)
    whole, part = (asdict(shape_errors(linkage, one, 0)) for one in (tolerances, scaled(tolerances, by)))
    for number in LENGTHS:
        assert part[number] == pytest.approx(by * whole[number], rel=1e-6, abs=1e-15)
    assert part["flatness_per_rad"] == whole["flatness_per_rad"]


@pytest.mark.parametrize("name", LOOPED)
def test_what_the_map_leaves_out_falls_as_the_square_of_the_tolerances(name):
    linkage = looped(name)
    whole, part = (
        shape_errors(linkage, scaled(tolerances_of(linkage, **MIXED), by), 0).second_order for by in (1.0, 1e-3)
    )
    # multipliers that are as good may differ by a factor, as rounding chooses among them
    assert 0.0 < part < 3e-6 * whole


@settings(max_examples=15)
@given(st.sampled_from(LOOPED), st.floats(-3.0, 3.0), st.booleans(), st.integers(0, 9))
def test_a_moved_or_mirrored_array_and_another_root_change_nothing(name, turn, over, root):
    linkage = looped(name)
    moved = Linkage(linkage.pattern.placed(Isometry.by(turn, (0.3, -0.2), reflects=over)))
    tolerances = tolerances_of(linkage, **MIXED)
    here, there = (asdict(shape_errors(one, tolerances, root)) for one in (linkage, moved))
    for number in (*LENGTHS, "flatness_per_rad", "tilt_per_rad", "root_tilt_per_rad", "rms_flatness_per_rad"):
        assert there[number] == pytest.approx(here[number], rel=1e-6, abs=1e-15)
    elsewhere = asdict(shape_errors(linkage, tolerances, (root + 3) % linkage.n_panels))
    for number in set(LENGTHS) - {"root_tilt"}:
        assert elsewhere[number] == pytest.approx(here[number], rel=1e-6, abs=1e-15)


@settings(max_examples=15)
@given(st.sampled_from(LOOPED), st.integers(0, 2**32 - 1))
def test_parts_add_up_to_the_flatness_and_a_tighter_hinge_never_harms(name, seed):
    linkage, rng = looped(name), np.random.default_rng(seed)
    tolerances = tolerances_of(linkage, **MIXED)
    errors = shape_errors(linkage, tolerances, 0)
    assert sum(errors.angle_shares) + errors.offset_share + errors.thickness_share == pytest.approx(errors.flatness)
    ratios = rng.uniform(0.0, 1.0, linkage.n_hinges)
    stops, play = (tuple((ratios * np.array(part)).tolist()) for part in (tolerances.stops, tolerances.play))
    tighter = shape_errors(linkage, BuildTolerances(stops, play, tolerances.offset, tolerances.thickness), 0)
    assert tighter.flatness <= errors.flatness * (1 + 1e-9)


@pytest.mark.parametrize("size", [2.0, 10.0])
def test_an_array_of_another_size_is_as_flat_in_proportion(size):
    folding = Folding.from_notation(LOOPED[0])
    small, large = (folding.linkage(f"{by * 50:g}x{by * 6:g}", flat_pairs="hinged") for by in (1.0, size))
    one, other = (
        shape_errors(linkage, tolerances_of(linkage, 1e-3, 0.0, by * 1e-5, by * 1e-5), 0)
        for linkage, by in ((small, 1.0), (large, size))
    )
    assert other.flatness == pytest.approx(size * one.flatness, rel=1e-6)
    assert other.misfit == pytest.approx(size * one.misfit, rel=1e-6)
    assert other.tilt == pytest.approx(one.tilt, rel=1e-6)
    assert other.needed_play == pytest.approx(one.needed_play, rel=1e-6)


def test_wrong_tolerances_are_refused():
    linkage = strip(["top", "top"])
    with pytest.raises(HcsearchError, match="give 2 of them"):
        shape_errors(linkage, BuildTolerances((1e-3,), (0.0,)), 0)
    with pytest.raises(HcsearchError, match="give 0 to 2"):
        shape_errors(linkage, tolerances_of(linkage), 3)
    with pytest.raises(HcsearchError, match="not negative"):
        tolerances_of(linkage, offset=-1e-6)
    with pytest.raises(HcsearchError, match="give both"):
        BuildTolerances((1e-3,), ())
