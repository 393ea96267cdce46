"""Courses of fold angles between two states: polynomials in the step, and bounds of speeds and accelerations."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.prisms import PrismPairs

COURSE_TERM_COUNT = 6
"""Coefficients of a course: a quintic in the share of the step, or a cubic if accelerations are unknown."""


@compiled
def write_course(
    h: float, cubic: bool, q0: Reals, v0: Reals, a0: Reals, q1: Reals, v1: Reals, a1: Reals, course: Reals
) -> None:
    """Write the polynomials, shape (n, 6), through the states at both ends of a step of length h (s)."""
    for i in range(len(q0)):
        rise, s0, s1, b0, b1 = q1[i] - q0[i], h * v0[i], h * v1[i], h * h * a0[i], h * h * a1[i]
        course[i, 0], course[i, 1] = q0[i], s0
        if cubic:
            course[i, 2], course[i, 3] = 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise
            course[i, 4] = course[i, 5] = 0.0
        else:
            course[i, 2] = 0.5 * b0
            course[i, 3] = 10.0 * rise - 6.0 * s0 - 4.0 * s1 - 1.5 * b0 + 0.5 * b1
            course[i, 4] = -15.0 * rise + 8.0 * s0 + 7.0 * s1 + 1.5 * b0 - b1
            course[i, 5] = 6.0 * rise - 3.0 * (s0 + s1) - 0.5 * (b0 - b1)


@compiled
def course_polynomials(times: Reals, angles: Reals, rates: Reals, accelerations: Reals, cubic: bool) -> Reals:
    """Return the polynomials of all steps, (k - 1, n, 6), through states at times (k,); all others (k, n)."""
    courses = np.empty((len(times) - 1, angles.shape[1], COURSE_TERM_COUNT))
    for k in range(len(courses)):
        h, after = times[k + 1] - times[k], k + 1
        write_course(
            h,
            cubic,
            angles[k],
            rates[k],
            accelerations[k],
            angles[after],
            rates[after],
            accelerations[after],
            courses[k],
        )
    return courses


@compiled
def write_course_angles(course: Reals, x: float, angles: Reals) -> None:
    """Write the angles at a share x of the step."""
    for i in range(len(angles)):
        value = course[i, COURSE_TERM_COUNT - 1]
        for k in range(COURSE_TERM_COUNT - 2, -1, -1):
            value = course[i, k] + x * value
        angles[i] = value


@compiled
def write_course_rates(course: Reals, x: float, h: float, rates: Reals) -> None:
    """Write the rates (rad/s) at a share x of a step of length h (s)."""
    for i in range(len(rates)):
        value = (COURSE_TERM_COUNT - 1) * course[i, COURSE_TERM_COUNT - 1]
        for k in range(COURSE_TERM_COUNT - 2, 0, -1):
            value = k * course[i, k] + x * value
        rates[i] = value / h


@compiled
def write_course_accelerations(course: Reals, x: float, h: float, accelerations: Reals) -> None:
    """Write the accelerations (rad/s^2) at a share x of a step of length h (s)."""
    for i in range(len(accelerations)):
        value = 0.0
        for k in range(COURSE_TERM_COUNT - 1, 1, -1):
            value = k * (k - 1) * course[i, k] + x * value
        accelerations[i] = value / (h * h)


@compiled
def bound_rates(course: Reals, h: float, speeds: Reals, accelerations: Reals) -> None:
    """Write upper bounds of |rate| (rad/s) and |acceleration| (rad/s^2) in the step.

    A polynomial is bounded by its Bernstein coefficients.
    """
    for i in range(len(speeds)):
        speeds[i] = accelerations[i] = 0.0
        for k in range(
            COURSE_TERM_COUNT - 1
        ):  # of a polynomial of degree 4, sums over j of C(k, j) / C(4, j) times coefficient j
            value, share = course[i, 1], 1.0
            for j in range(1, k + 1):
                share *= (k - j + 1) / (COURSE_TERM_COUNT - 1 - j)
                value += share * (j + 1) * course[i, j + 1]
            speeds[i] = max(speeds[i], abs(value))
        for k in range(COURSE_TERM_COUNT - 2):
            value, share = 2.0 * course[i, 2], 1.0
            for j in range(1, k + 1):
                share *= (k - j + 1) / (COURSE_TERM_COUNT - 2 - j)
                value += share * (j + 1) * (j + 2) * course[i, j + 2]
            accelerations[i] = max(accelerations[i], abs(value))
        speeds[i] /= h
        accelerations[i] /= h * h


@compiled
def path_speed(pairs: PrismPairs, p: int, side: int, speeds: Reals, panels: WholeNumbers) -> float:
    """Return an upper bound of the speed (m/s) of points of a pair's second prism relative to the panel of the first.

    Each hinge on the path between the panels turns everything beyond it.

    side : 1 for points of the first prism relative to the second panel. panels : of the prisms.
    """
    g = pairs.prisms[p, 1 - side]
    panel, target = panels[pairs.prisms[p, side]], panels[g]
    hinges, nexts, reaches = pairs.hinges[target], pairs.nexts[target], pairs.reaches[g]
    speed = 0.0
    while panel != target:
        hinge = hinges[panel]
        if hinge >= 0:  # none joins panels that stand still
            speed += speeds[hinge] * reaches[hinge]
        panel = nexts[panel]
    return speed


@compiled
def path_bend(pairs: PrismPairs, p: int, side: int, speeds: Reals, accelerations: Reals, panels: WholeNumbers) -> float:
    """Return an upper bound of the acceleration (m/s^2) of points of a pair's second prism relative to the first panel.

    |x''| <= sum of r_l (a_l + w_l (w_l + 2 sum of w_k over k before l)). side, panels : as of `path_speed`.
    """
    g = pairs.prisms[p, 1 - side]
    panel, target = panels[pairs.prisms[p, side]], panels[g]
    hinges, nexts, reaches = pairs.hinges[target], pairs.nexts[target], pairs.reaches[g]
    acceleration = speed_sum = 0.0
    while panel != target:
        hinge = hinges[panel]
        if hinge >= 0:
            w = speeds[hinge]
            acceleration += reaches[hinge] * (accelerations[hinge] + w * (w + 2.0 * speed_sum))
            speed_sum += w
        panel = nexts[panel]
    return acceleration
