"""What happens between the states of a motion: how far its loops open there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.courses import TERMS, follow, write_course
from hcsearch.kernels.multibody.sweeps import place
from hcsearch.kernels.multibody.tree import Tree, Work
from hcsearch.kernels.multibody.welds import weld_errors

Reals = NDArray[np.float64]


@compiled
def opening(tree: Tree, count: int, times: Reals, q: Reals, v: Reals, a: Reals, cubic: bool, work: Work) -> float:
    """Greatest closure residual (rad, or gap over size) at the first `count` states and at three places between each.

    A polynomial through exact states and rates at both ends strays most in the middle, or first to one side, then to
    the other.
    """
    n = q.shape[1]
    course, angles = np.empty((n, TERMS)), np.empty(n)
    worst = 0.0
    for k in range(count):
        place(tree, q[k], work)
        worst = max(worst, weld_errors(tree, work, work.errors))
        h = times[k + 1] - times[k] if k + 1 < count else 0.0
        if h > 0.0:
            write_course(h, cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
            for share in (0.25, 0.5, 0.75):
                follow(course, share, angles)
                place(tree, angles, work)
                worst = max(worst, weld_errors(tree, work, work.errors))
    return worst
