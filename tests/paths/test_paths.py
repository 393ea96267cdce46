import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import folding_of
from hcsearch.library.assemblies.eight_r import joint_parts, second_angle, skew_symmetric_angles, unit_i, unit_ii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.motion.kinematics.local import local_at
from hcsearch.motion.paths.following import PathLimits, Stepping, follow_path
from hcsearch.motion.paths.stepping import PREDICTORS, PathStep, Walker
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern

UNITS = {"I": unit_i, "II": unit_ii}
few = settings(max_examples=8)


class Unit:
    """A unit with its exact motion (thesis 5.24)."""

    def __init__(self, name, **parameters):
        self.parameters = Parameters(**parameters)
        self.pattern = UNITS[name](self.parameters)
        self.linkage = Linkage(self.pattern)
        self.legs = joint_parts(self.pattern) == 1
        self.ratio = math.cos(self.parameters.alpha)

    def at(self, first):
        return skew_symmetric_angles(self.pattern, self.parameters.alpha, first)

    @property
    def opening(self):
        return -np.where(self.legs, 1.0, self.ratio)

    @property
    def folding(self):
        return np.where(self.legs, self.ratio, 1.0)

    def error(self, angles):
        k = int(np.flatnonzero(~self.legs)[0])
        wanted = []
        for first in math.pi - np.atleast_2d(angles)[:, k]:
            second = second_angle(self.parameters.alpha, first)
            wanted.append(math.pi - np.where(self.legs, second, first))
        return np.abs(np.atleast_2d(angles) - wanted).max()


@cache
def unit(name):
    return Unit(name)


@cache
def design_8r():
    """The 8R element of the search: ten regular triangles, flat pairs rigid."""
    folding = folding_of(Circuit.from_notation("triangle:0123434501"), 3)
    return Linkage(folding.pattern((0.05, 0.05, 0.006)))


def row(n):
    """Squares in a row, folded like a map."""
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    facets = tuple(tuple((0.05 * (k + x), 0.05 * y) for x, y in corners) for k in range(n))
    return Linkage(
        Pattern.from_polygons(
            facets, {(k, k + 1): MOUNTAIN_CREASE if k % 2 else VALLEY_CREASE for k in range(n - 1)}, 0.006
        )
    )


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize("method", PREDICTORS)
def test_every_method_opens_a_unit_along_its_exact_path(name, method):
    it = unit(name)
    stepping = Stepping(method=method, step=0.05 if method == "increment" else None)
    path = follow_path(it.linkage, it.linkage.folded, it.opening, stepping=stepping, limits=PathLimits(events=False))
    assert path.outcome == "flat", path.sentence
    assert (path.end == 0.0).all()
    assert path.residuals.max() <= CLOSED_LOOP_RESIDUAL
    assert it.error(path.angles) < 1e-8
    assert path.angles.min() >= -1e-9
    assert path.angles.max() <= math.pi + 1e-9
    assert (path.nullities[0], path.nullities[len(path.nullities) // 2], path.nullities[-1]) == (4, 1, 4)
    assert path.steps == len(path.angles) - 1 == len(path.lengths) - 1 == len(path.least_singular_values) - 1
    assert path.evaluations >= path.steps
    assert path.success


@few
@given(
    st.sampled_from(sorted(UNITS)),
    st.floats(46, 80),
    st.floats(0.05, 0.5),
)
def test_there_and_back_along_the_exact_path(name, degrees, share):
    it = Unit(name, alpha=math.radians(degrees), base=0.03, thickness=0.03 * share)
    there = follow_path(it.linkage, it.linkage.flat, it.folding)
    assert there.outcome == "folded", there.sentence
    assert (there.end == it.linkage.folded).all()
    back = follow_path(it.linkage, there.end, -there.velocity)
    assert back.outcome == "flat", back.sentence
    assert (back.end == 0.0).all()
    assert back.lengths[-1] == pytest.approx(there.lengths[-1], rel=1e-4)
    for path in (there, back):
        assert path.residuals.max() <= CLOSED_LOOP_RESIDUAL
        assert it.error(path.angles) < 1e-7


def test_the_8r_element_of_the_search_goes_skew_symmetrically_from_folded_to_flat_and_back():
    linkage = design_8r()
    legs = np.arange(8) % 2 == 1
    for start, way, goal in (
        (linkage.folded, -np.where(legs, 2.0, 1.0), "flat"),
        (linkage.flat, np.where(legs, 1.0, 2.0), "folded"),
    ):
        path = follow_path(linkage, start, way, stepping=Stepping(tolerance=1e-05))
        assert path.outcome == goal
        first = math.pi - path.angles[:, 0]
        second = 2 * np.arctan2(np.sin(first / 2), 0.5 * np.cos(first / 2))
        # two degrees of freedom: closure does not correct the way, so it drifts by what steps are chosen for
        assert np.abs(math.pi - path.angles - np.where(legs, second[:, None], first[:, None])).max() < 1e-5


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_paths_know_no_unit_of_length(scale):
    it, scaled = unit("II"), Unit("II", base=0.03 * scale, thickness=0.01 * scale)
    paths = [
        follow_path(
            u.linkage,
            u.at(0.5),
            u.opening,
            stepping=Stepping(adaptive=False, step=0.2),
            limits=PathLimits(length=5.0, events=False),
        )
        for u in (it, scaled)
    ]
    # rounding shows where a step comes near a singular state
    assert np.abs(paths[0].angles - paths[1].angles).max() < 1e-8


ORDERS = {"euler": 1, "taylor": 2, "adams": 3, "runge-kutta": 4, "hermite": 5}


@pytest.mark.parametrize("method", ORDERS)
def test_predictions_are_of_their_order(method):
    if method == "hermite":  # with one degree of freedom only
        linkage, start, way = unit("II").linkage, unit("II").at(1.2), unit("II").opening
    else:
        linkage, way = design_8r(), np.linspace(-1.0, 0.5, 8)
        start = close_linkage(linkage, np.linspace(1.0, 1.8, 8)).angles
    local = local_at(linkage, start)
    tangent = local.tangent(way) / np.linalg.norm(local.tangent(way))
    last = PathStep(local, tangent, 0.0)
    errors = []
    for h in (0.2, 0.1):
        back = Walker(linkage, PREDICTORS["runge-kutta"]).advance(None, PathStep(local, -tangent, 0.0), h).step
        advance = Walker(linkage, PREDICTORS[method]).advance(
            PathStep(back.local, -back.tangent, -back.length), last, h
        )
        assert advance.order == ORDERS[method]
        errors.append(advance.error)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(advance.order + 1, abs=0.7)


def test_higher_order_is_nearer_without_correction():
    it = unit("II")
    errors = {}
    for method in ("euler", "taylor", "runge-kutta"):
        path = follow_path(
            it.linkage,
            it.at(0.8),
            it.opening,
            stepping=Stepping(method=method, adaptive=False, corrections=0, step=0.02),
            limits=PathLimits(length=2.0),
        )
        assert path.success
        errors[method] = it.error(path.angles)
    assert errors["runge-kutta"] < 0.01 * errors["taylor"] < 1e-4 * errors["euler"]


def test_a_correction_a_step_keeps_the_loops_closed():
    it = unit("II")
    limits = PathLimits(length=3.0)
    residuals = [
        follow_path(
            it.linkage,
            it.at(0.5),
            it.opening,
            stepping=Stepping(adaptive=False, step=0.2, corrections=k),
            limits=limits,
        ).residuals.max()
        for k in (0, 1, 2)
    ]
    assert residuals[2] <= residuals[1] < 1e-4 * residuals[0]


def exact_singular_states(it):
    """Dihedral angles phi_1 where a singular value of the exact path vanishes, by brute force."""

    def least(first):
        return np.linalg.svd(it.linkage.closure(it.at(first))[1], compute_uv=False)[22]

    grid = np.linspace(0.02, math.pi - 0.02, 600)
    values = [least(first) for first in grid]
    lengths = []
    for k in range(1, len(grid) - 1):
        if values[k] < min(values[k - 1], values[k + 1]):
            turn = minimize_scalar(least, bounds=(grid[k - 1], grid[k + 1]), method="bounded", options={"xatol": 1e-12})
            lengths += [turn.x] if turn.fun < 1e-7 else []
    return lengths


@pytest.mark.parametrize(("name", "number"), [("I", 2), ("II", 3)])
@pytest.mark.parametrize("method", ["hermite", "euler"])
def test_singular_states_on_the_way_are_found_and_are_no_branches(name, number, method):
    it = unit(name)
    wanted = exact_singular_states(it)
    assert len(wanted) == number
    path = follow_path(it.linkage, it.linkage.folded, it.opening, stepping=Stepping(method=method))
    assert [(event.kind, event.nullity) for event in path.events] == [("shaky", 2)] * number
    first = int(np.flatnonzero(~it.legs)[0])
    assert [math.pi - event.angles[first] for event in path.events] == pytest.approx(wanted, abs=1e-7)
    for event in path.events:
        assert it.error(event.angles) < 1e-8


def test_beyond_flat_without_stops_the_flat_state_is_a_bifurcation():
    it = unit("II")
    limits = PathLimits(goal="none", stops=False, length=3.0)
    path = follow_path(it.linkage, it.at(math.pi - 0.4), it.opening, limits=limits)
    assert path.outcome == "length"
    assert path.end.max() < 0
    (event,) = [event for event in path.events if event.kind == "bifurcation"]
    assert event.nullity == 4
    assert np.abs(event.angles).max() < 1e-8
    stopped = follow_path(it.linkage, it.at(math.pi - 0.4), it.opening, limits=replace(limits, at_bifurcation="stop"))
    assert stopped.outcome == "branch"
    assert np.abs(stopped.end).max() < 1e-8


@few
@example(7501)  # closes beyond a stop
@given(st.integers(0, 10_000))
def test_a_motion_ends_where_a_hinge_comes_to_its_stop(seed):
    linkage = design_8r()
    rng = np.random.default_rng(seed)
    start = close_linkage(linkage, rng.uniform(0.8, 1.6, 8)).angles
    path = follow_path(linkage, start, rng.standard_normal(8), limits=PathLimits(goal="none", events=False))
    assert path.residuals.max() <= CLOSED_LOOP_RESIDUAL
    beyond = np.flatnonzero(np.minimum(start, math.pi - start) < -1e-9)
    if len(beyond):
        assert (path.outcome, path.stopped_hinges, len(path.angles)) == ("stopped", tuple(beyond), 1)
        assert "beyond" in path.sentence
        return
    assert path.angles.min() >= -1e-9
    assert path.angles.max() <= math.pi + 1e-9
    if path.outcome == "stopped":
        margins = np.minimum(path.end, math.pi - path.end)
        assert path.stopped_hinges
        assert np.abs(margins[list(path.stopped_hinges)]).max() < 1e-9
        assert "stops" in path.sentence


@pytest.mark.parametrize("n", [2, 7, 40])
def test_an_open_chain_opens_straight(n):
    linkage = row(n)
    path = follow_path(linkage, linkage.folded)
    assert path.outcome == "flat"
    assert (path.nullities == n - 1).all()
    assert np.ptp(path.angles, axis=1).max() < 1e-12


def test_paths_that_cannot_go_on_say_why():
    it = unit("II")
    linkage = it.linkage
    thin = Unit("II", thickness=1e-9 * 0.03)
    assert follow_path(thin.linkage, thin.linkage.folded, thin.opening).outcome == "undecided"
    assert "not closed" in follow_path(linkage, np.full(24, 0.3)).sentence
    state = local_at(linkage, it.at(1.0))
    assert "branches" in follow_path(linkage, state.angles, state.right[0]).sentence
    assert follow_path(linkage, linkage.folded, it.opening, limits=PathLimits(max_steps=3)).outcome == "out of budget"
    shut = follow_path(linkage, linkage.folded, -it.opening)
    assert (shut.outcome, shut.steps, len(shut.stopped_hinges)) == ("stopped", 0, 24)
    assert follow_path(linkage, linkage.flat).sentence == "flat at the start"


def test_wrong_options_are_refused():
    with pytest.raises(HcsearchError, match="no method 'magic': choose one of increment, euler"):
        Stepping(method="magic")
    with pytest.raises(HcsearchError, match="give adaptive=False"):
        Stepping(corrections=1)


def test_a_path_may_have_a_length():
    it = unit("II")
    path = follow_path(it.linkage, it.at(1.0), it.opening, limits=PathLimits(length=0.7))
    assert path.outcome == "length"
    assert path.lengths[-1] == pytest.approx(0.7, abs=1e-6)
