"""Motions between states, and the bounds of their speeds, against SciPy's polynomials and dense sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive_clearance import chain, fan, polynomial, random_course

from hcsearch.kernels.linkage.courses import (
    COURSE_TERM_COUNT,
    bound_rates,
    path_bend,
    path_speed,
    write_course,
    write_course_angles,
    write_course_rates,
)
from hcsearch.kernels.linkage.prisms import PrismPairs
from hcsearch.motion.collision.panel_prisms import prisms_of, solid_pairs

LINKAGES = {
    "2 panels": chain([0.02, 0.03], ["top"]),
    "3 panels": chain([0.02, 0.03, 0.02], ["top", "bottom"]),
    "6 panels": chain([0.02, 0.03, 0.02, 0.01, 0.04, 0.02], ["top", "bottom", "bottom", "top", "top"]),
    "branches": fan(),
}


def written(course, k=0):
    """Coefficients of a step, and its length."""
    h = course.times[k + 1] - course.times[k]
    table = np.empty((course.angles.shape[1], COURSE_TERM_COUNT))
    ends = [row[j] for j in (k, k + 1) for row in (course.angles, course.rates, course.accelerations)]
    write_course(h, course.cubic, *ends, table)
    return table, h


def bounds(table, h):
    speeds, accelerations = np.empty(len(table)), np.empty(len(table))
    bound_rates(table, h, speeds, accelerations)
    return speeds, accelerations


@given(st.integers(0, 2**32), st.booleans())
def test_a_course_passes_through_both_states(seed, cubic):
    course = random_course(np.random.default_rng(seed), LINKAGES["6 panels"], 1, cubic=cubic)
    table, h = written(course)
    own = polynomial(course, 0)
    values = np.empty(len(table))
    for x in (0.0, 0.1, 0.5, 0.9, 1.0):
        write_course_angles(table, x, values)
        assert values == pytest.approx(own(x * h), rel=1e-10, abs=1e-10)
        write_course_rates(table, x, h, values)
        assert values == pytest.approx(own.derivative()(x * h), rel=1e-9, abs=1e-9 / h)
    shares = table[:, ::-1]
    for degree, row in enumerate((course.angles, course.rates, course.accelerations)[: 2 if cubic else 3]):
        for x in (0.0, 1.0):
            derivative = [np.polyval(np.polyder(line, degree), x) / h**degree for line in shares]
            assert derivative == pytest.approx(row[int(x)], rel=1e-9, abs=1e-9 * h**-degree)


@given(st.integers(0, 2**32), st.booleans())
def test_no_rate_exceeds_its_bound(seed, cubic):
    course = random_course(np.random.default_rng(seed), LINKAGES["6 panels"], 1, cubic=cubic)
    table, h = written(course)
    own, times = polynomial(course, 0), np.linspace(0.0, h, 501)
    for degree, bound in enumerate(bounds(table, h), start=1):
        most = np.abs(own.derivative(degree)(times)).max(axis=0)
        assert (most <= bound * (1.0 + 1e-9)).all()
        assert (bound <= 12.0 * most).all()


@given(st.floats(-3, 3), st.floats(-50, 50), st.floats(-2000, 2000), st.floats(1e-6, 0.1))
def test_bounds_are_sharp_where_acceleration_is_constant(q, v, a, h):
    ends = [np.array([x]) for x in (q, v, a, q + h * (v + 0.5 * h * a), v + h * a, a)]
    table = np.empty((1, COURSE_TERM_COUNT))
    for cubic in (False, True):
        write_course(h, cubic, *ends, table)
        speeds, accelerations = bounds(table, h)
        # coefficients are differences of angles, of which rounding leaves 1e-15
        assert speeds == pytest.approx([max(abs(v), abs(v + h * a))], rel=1e-9, abs=1e-13 / h)
        assert accelerations == pytest.approx([abs(a)], rel=1e-9, abs=1e-12 / h**2)


def seen_from(linkage, states, f, g):
    """Places of the corners of facet g as the panel of facet f sees them, shape (n_states, n_corners, 3)."""
    corners = []
    for angles in states:
        pose = linkage.poses(angles)[linkage.pattern.panel_of[f]]
        corners.append((linkage.solids(angles)[g].reshape(-1, 3) - pose[:, 3]) @ pose[:, :3])
    return np.array(corners)


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("cubic", [False, True])
@pytest.mark.parametrize("name", LINKAGES)
def test_no_point_is_faster_than_its_bound(name, cubic, back):
    linkage = LINKAGES[name]
    prisms = prisms_of(linkage)
    pairs = solid_pairs(linkage, prisms)
    rng = np.random.default_rng(len(name) + 2 * cubic)
    tight = 0.0
    for _ in range(3):
        course = random_course(rng, linkage, 1, cubic=cubic)
        table, h = written(course)
        rates = bounds(table, h)
        step = h / 400
        states = polynomial(course, 0)(np.arange(401) * step)
        for p, (f, g) in enumerate(pairs.prisms):
            places = seen_from(linkage, states, *((g, f) if back else (f, g)))
            fast = np.linalg.norm(np.diff(places, axis=0), axis=2).max() / step
            bent = np.linalg.norm(np.diff(places, 2, axis=0), axis=2).max() / step**2
            speed = path_speed(pairs, p, int(back), rates[0], prisms.panels)
            bend = path_bend(pairs, p, int(back), *rates, prisms.panels)
            assert fast <= speed * (1 + 1e-9)
            assert bent <= bend * (1 + 1e-9)
            tight = max(tight, fast / speed, bent / bend)
    assert tight > 0.2


@pytest.mark.parametrize("back", [False, True])
def test_the_bounds_of_one_hinge_that_turns_evenly_are_exact(back):
    linkage = LINKAGES["2 panels"]
    pairs = solid_pairs(linkage, prisms_of(linkage))
    corners = linkage.solids(linkage.flat)[0 if back else 1].reshape(-1, 3) - linkage.points[0]
    radius = np.linalg.norm(np.cross(corners, linkage.directions[0]), axis=1).max()
    panels = np.array(linkage.pattern.panel_of)
    speed = path_speed(pairs, 0, int(back), np.array([7.0]), panels)
    bend = path_bend(pairs, 0, int(back), np.array([7.0]), np.array([0.0]), panels)
    assert (speed, bend) == pytest.approx((7.0 * radius, 49.0 * radius), rel=1e-12)


def test_the_bounds_of_turns_about_one_line_add_up():
    """Two hinges that turn as one: |x''| = (w + w')^2 r, and no less is allowed."""
    # two prisms on panels 0 and 2, with hinge 0 from panel 0 to 1 and hinge 1 from 1 to 2
    hinges = np.array([[-1, 0, 1], [0, -1, 1], [0, 1, -1]], np.int32)
    nexts = np.array([[-1, 0, 1], [1, -1, 1], [1, 2, -1]], np.int32)
    pairs = PrismPairs(np.array([[0, 1]]), hinges, nexts, np.full((2, 2), 2.0))
    panels, speeds, none = np.array([0, 2]), np.array([3.0, 4.0]), np.zeros(2)
    assert path_speed(pairs, 0, 0, speeds, panels) == pytest.approx(14.0)
    assert [path_bend(pairs, 0, back, speeds, none, panels) for back in (0, 1)] == pytest.approx([98.0] * 2)
