"""Motions between their states: polynomials through what is known at both ends of each step."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals


def interpolate_motion(nodes: Reals, q: Reals, v: Reals, a: Reals | None, times: Reals) -> Reals:
    """Coordinates at given times, shape (len(times), n), of a motion with states at `nodes`, (k,), s.

    q, v, a : (k, n), coordinates, velocities, accelerations. Quintics, with an error of O(h^6) of a step of length h;
    cubics, O(h^4), where accelerations are None.
    """
    times = np.asarray(times, float)
    k = np.clip(np.searchsorted(nodes, times, side="right") - 1, 0, len(nodes) - 2)
    h = (nodes[k + 1] - nodes[k])[:, None]
    x = np.divide(times[:, None] - nodes[k][:, None], h, out=np.zeros_like(h), where=h > 0.0)
    q0, rise = q[k], q[k + 1] - q[k]
    v0, v1 = h * v[k], h * v[k + 1]
    if a is None:
        cubic: Reals = q0 + x * (v0 + x * (3 * rise - 2 * v0 - v1 + x * (v0 + v1 - 2 * rise)))
        return cubic
    a0, a1 = h * h * a[k], h * h * a[k + 1]
    c3 = 10 * rise - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15 * rise + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    c5 = 6 * rise - 3 * (v0 + v1) - 0.5 * (a0 - a1)
    quintic: Reals = q0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
    return quintic
