"""How fast two prisms come together at a time of a motion, and how far the motion has come by then."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.courses import TERMS, follow, write_course
from hcsearch.kernels.intervals import Course, book_for, nearest, relate
from hcsearch.kernels.loops import Chain, place_panels
from hcsearch.kernels.paths import Pairs
from hcsearch.kernels.prisms import Prisms

Reals = NDArray[np.float64]

BEFORE = 1e-4
"""The approach speed is the mean over this time before the collision (s)."""


@compiled
def angles_at(course: Course, time: float, angles: Reals) -> None:
    """Write the fold angles at a time."""
    k = min(max(int(np.searchsorted(course.times, time)) - 1, 0), len(course.times) - 2)
    h = course.times[k + 1] - course.times[k]
    q, v, a = course.angles, course.rates, course.accelerations
    if h <= 0.0:
        angles[:] = q[k + 1]
        return
    polynomials = np.empty((len(angles), TERMS))
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], polynomials)
    follow(polynomials, (time - course.times[k]) / h, angles)


@compiled
def approach(chain: Chain, prisms: Prisms, pairs: Pairs, p: int, course: Course, time: float) -> float:
    """Mean speed (m/s) at which the gap of a pair closed in the last `BEFORE` seconds; 0 where it did not."""
    wait = min(BEFORE, time - course.times[0])
    if wait <= 0.0:
        return 0.0
    book = book_for(chain, prisms, pairs, course)
    gaps = np.empty(2)
    for i in range(2):
        angles_at(course, time - wait * i, book.angles)
        place_panels(chain, book.angles, book.highs[0])
        relate(prisms, pairs, p, book.highs[0], book.seen[0])
        gaps[i] = max(nearest(prisms, pairs, p, book.seen[0], book)[0], 0.0)
    return float(max(gaps[1] - gaps[0], 0.0) / wait)
