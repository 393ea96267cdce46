"""Certified clearance: verdicts on whether prisms stay apart at all times of a motion, and their smallest gap.

A time interval in which no direction separates two panels is halved until one does, or until the interval is too short
to matter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.collision.intervals import (
    MAX_INTERVAL_HALVINGS,
    Course,
    IntervalTables,
    bound_gap,
    halve_interval,
    new_interval_tables,
    pair_distance,
    start_step_intervals,
    write_relative_pose,
)
from hcsearch.kernels.collision.least_gaps import smallest_dip
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.courses import write_course_angles
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms

MOTION_CLEAR, MOTION_COLLIDES, MOTION_UNDECIDED = 0, 1, 2
"""Verdicts: apart at all times; overlapping at a time; too near to decide."""
PLACEMENT_ROUNDING = 1e-12
"""Displacement of panels by rounding, m."""


class ClearanceTolerances(NamedTuple):
    """Tolerances of the clearance check, m.

    slacks : greatest displacement of panels from where they are placed, of each step between k states, (k - 1,).
        margin : by which prisms are shrunk on every face. max_margin : margin at which a panel would vanish.
        resolution : of the smallest gap.
    """

    slacks: Reals
    margin: float
    max_margin: float
    resolution: float


class ClearanceReport(NamedTuple):
    """The result of a search, written into tables of one entry each.

    times : s, when a pair collides or comes too near. pairs : that pair. gaps : m, smallest gap in a dip, infinite
        without one. bound_counts : how often the gap of a pair was bounded.
    """

    times: Reals
    pairs: WholeNumbers
    gaps: Reals
    bound_counts: WholeNumbers


@compiled
def judge_clearance(
    chain: Chain,
    prisms: Prisms,
    shrunk: Prisms,
    pairs: PrismPairs,
    course: Course,
    tolerances: ClearanceTolerances,
    measured: bool,
    report: ClearanceReport,
) -> int:
    """Return the verdict on a motion; if it is clear and to be measured, write its smallest gap too.

    Steps of one slack in a row are judged together.
    """
    slacks, largest, first = tolerances.slacks, PLACEMENT_ROUNDING, 0
    report.gaps[0] = math.inf
    report.bound_counts[0] = 0
    verdict, time, pair = MOTION_CLEAR, 0.0, 0
    while first < len(slacks):
        last = first + 1
        while last < len(slacks) and slacks[last] == slacks[first]:
            last += 1
        slack = max(slacks[first], PLACEMENT_ROUNDING)
        part = _part(course, first, last + 1)
        judged = _judge_part(chain, prisms, shrunk, pairs, part, slack, tolerances, report)
        if judged == MOTION_COLLIDES:
            return MOTION_COLLIDES
        if judged == MOTION_UNDECIDED and verdict == MOTION_CLEAR:
            verdict, time, pair = MOTION_UNDECIDED, report.times[0], report.pairs[0]
        largest, first = max(largest, slack), last
    if verdict == MOTION_UNDECIDED:
        report.times[0], report.pairs[0] = time, pair
    elif measured:
        rise, resolution = 2.0 * tolerances.margin, tolerances.resolution
        # where pairs approach and part again shows in the whole motion only
        gap, bound_count = smallest_dip(chain, prisms, pairs, course, rise, resolution)
        report.gaps[0] = max(gap - largest, 0.0)
        report.bound_counts[0] += bound_count
    return verdict


@compiled
def _part(course: Course, begin: int, end: int) -> Course:
    """Return the course between the states of a range."""
    times, angles, rates, accelerations = course.times, course.angles, course.rates, course.accelerations
    return Course(times[begin:end], angles[begin:end], rates[begin:end], accelerations[begin:end], course.cubic)


@compiled
def _judge_part(
    chain: Chain,
    prisms: Prisms,
    shrunk: Prisms,
    pairs: PrismPairs,
    course: Course,
    slack: float,
    tolerances: ClearanceTolerances,
    report: ClearanceReport,
) -> int:
    """Return the verdict on steps of one slack.

    Panels that come nearer than the slack need not collide: only those certainly do that still overlap when shrunk
    further by half the slack.
    """
    if search_collision(chain, shrunk, pairs, course, slack, report) == MOTION_CLEAR:
        return MOTION_CLEAR
    if tolerances.margin + 0.5 * slack >= tolerances.max_margin:
        return MOTION_UNDECIDED
    time, pair = report.times[0], report.pairs[0]
    k = max(np.searchsorted(course.times, time) - 1, 0)
    remainder = _part(course, k, len(course.times))
    inner_vertices = shrunk.vertices + (0.5 * slack / tolerances.margin) * (shrunk.vertices - prisms.vertices)
    inner = Prisms(
        shrunk.panels, shrunk.counts, inner_vertices, shrunk.middles, shrunk.reaches, shrunk.normals, shrunk.edges
    )
    if search_collision(chain, inner, pairs, remainder, 0.0, report) == MOTION_COLLIDES:
        return MOTION_COLLIDES
    report.times[0], report.pairs[0] = time, pair
    return MOTION_UNDECIDED


@compiled
def search_collision(
    chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, slack: float, report: ClearanceReport
) -> int:
    """Search a motion for the first time at which a gap may be within the slack; return the verdict."""
    tables = new_interval_tables(chain, prisms, pairs, course)
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, slack, tables)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = tables.end_shares[top] - tables.start_shares[top]
            undecided = _bound_pairs(prisms, pairs, slack, share * h, top, tables, report)
            if not undecided:
                top -= 1
            elif share <= 0.5**MAX_INTERVAL_HALVINGS:
                p = tables.pair_lists[top, 0]
                report.times[0], report.pairs[0] = course.times[k] + tables.end_shares[top] * h, p
                return MOTION_COLLIDES if _overlap(chain, prisms, pairs, p, top, tables) else MOTION_UNDECIDED
            else:
                halve_interval(chain, undecided, top, tables)
                top += 1
    return MOTION_CLEAR


@compiled
def _overlap(chain: Chain, prisms: Prisms, pairs: PrismPairs, p: int, top: int, tables: IntervalTables) -> bool:
    """Return whether a pair overlaps at the end of an interval, or 1, 3, 7, 15 ... times its length later in the step.

    The interval is of the shortest length: at its end rounding may still hide an overlap.
    """
    poses, share = tables.end_poses[top], tables.end_shares[top]
    advance = share - tables.start_shares[top]
    while True:
        write_relative_pose(prisms, pairs, p, poses, tables.relative_poses[1])
        if pair_distance(prisms, pairs, p, tables.relative_poses[1], tables)[0] <= 0.0:
            return True
        share += advance
        advance *= 2.0
        if share > 1.0:
            return False
        write_course_angles(tables.course, share, tables.angles)
        place_panels(chain, tables.angles, poses)


@compiled
def _bound_pairs(
    prisms: Prisms,
    pairs: PrismPairs,
    slack: float,
    duration: float,
    top: int,
    tables: IntervalTables,
    report: ClearanceReport,
) -> int:
    """Bound the gaps of the pairs of an interval; move those within the slack to the front, and return their number."""
    undecided = 0
    for i in range(tables.pair_counts[top]):
        p = tables.pair_lists[top, i]
        report.bound_counts[0] += 1
        if not bound_gap(prisms, pairs, p, slack, duration, top, tables)[0] > slack:
            tables.pair_lists[top, undecided] = p
            undecided += 1
    return undecided
