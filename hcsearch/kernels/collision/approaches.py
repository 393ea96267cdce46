"""How fast two prisms come together at a time of a motion, and how far the motion has come by then."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.collision.intervals import Course, new_interval_tables, pair_distance, write_relative_pose
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.courses import COURSE_TERM_COUNT, write_course, write_course_angles
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.linkage.reaches import PrismPairs

APPROACH_INTERVAL, MAX_APPROACH_INTERVALS = 1e-4, 100
"""The approach speed is the mean over this time (s) before prisms meet; how many times that is gone back for it."""


@compiled
def angles_at(course: Course, time: float, angles: Reals) -> None:
    """Write the fold angles at a time."""
    k = min(max(int(np.searchsorted(course.times, time)) - 1, 0), len(course.times) - 2)
    h = course.times[k + 1] - course.times[k]
    q, v, a = course.angles, course.rates, course.accelerations
    if h <= 0.0:
        angles[:] = q[k + 1]
        return
    polynomials = np.empty((len(angles), COURSE_TERM_COUNT))
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], polynomials)
    write_course_angles(polynomials, (time - course.times[k]) / h, angles)


@compiled
def approach_speed(chain: Chain, prisms: Prisms, pairs: PrismPairs, p: int, course: Course, time: float) -> float:
    """Mean speed (m/s) at which the gap of a pair closed in the last `APPROACH_INTERVAL` seconds in which it was open.

    A collision is reported when prisms overlap for sure, which can be a while after they have met. 0 where they were
    not apart in all of the time that is gone back.
    """
    book = new_interval_tables(chain, prisms, pairs, course)
    last = 0.0
    for k in range(MAX_APPROACH_INTERVALS):
        before = time - APPROACH_INTERVAL * k
        if before < course.times[0]:
            return 0.0
        angles_at(course, before, book.angles)
        place_panels(chain, book.angles, book.highs[0])
        write_relative_pose(prisms, pairs, p, book.highs[0], book.seen[0])
        gap = pair_distance(prisms, pairs, p, book.seen[0], book)[0]
        if k > 0 and gap > 0.0:
            return float(max(gap - last, 0.0) / APPROACH_INTERVAL)
        last = gap
    return 0.0
