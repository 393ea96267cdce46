"""Torque margins in their plain form: by random closed rates, and by a linear program for each state."""

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import linprog

from hcsearch.motion.kinematics.closing import close_linkage

ROUNDING = 1e-9


def random_closed_states(linkage, count, seed, widest=1.5):
    """Closed states within the stops, from random changes of the packed angles."""
    rng = np.random.default_rng(seed)
    states = []
    while len(states) < count:
        guess = linkage.folded + np.where(linkage.folded > 1.0, -1.0, 1.0) * rng.uniform(0.1, widest, linkage.n_hinges)
        closed = close_linkage(linkage, guess)
        if closed.closed and closed.angles.min() > 0.0 and closed.angles.max() < np.pi:
            states.append(closed.angles)
    return np.array(states)


def closed_basis(jacobian):
    return null_space(jacobian, rcond=1e-9) if len(jacobian) else np.eye(jacobian.shape[1])


def best_random_ratio(jacobian, torques, friction, senses, count, rng):
    """The best ratio of random closed rates that stops allow: half of them near the projected torques."""
    basis = closed_basis(jacobian)
    z = rng.normal(size=(count, basis.shape[1]))
    z[::2] = basis.T @ torques + rng.normal(size=z[::2].shape) * rng.uniform(0.0, 1.0, (len(z[::2]), 1))
    rates = z @ basis.T
    allowed = (senses * rates >= 0.0).all(axis=1)
    ratios = (rates @ torques) / (np.abs(rates) @ friction)
    return max(0.0, ratios[allowed].max(initial=0.0))


def primal(jacobian, torques, friction, senses):
    """The margin as the greatest power of rates, by HiGHS; infinite where it is unbounded."""
    n = jacobian.shape[1]
    bounds = [(0.0, 0.0 if sense < 0 else None) for sense in senses]
    bounds += [(0.0, 0.0 if sense > 0 else None) for sense in senses]
    closed = np.c_[jacobian, -jacobian] if len(jacobian) else None
    found = linprog(
        -np.r_[torques, -torques],
        A_eq=closed,
        b_eq=None if closed is None else np.zeros(len(jacobian)),
        A_ub=np.r_[friction, friction][None],
        b_ub=[1.0],
        bounds=bounds,
    )
    assert found.status in (0, 3), found.message
    assert len(bounds) == 2 * n
    return np.inf if found.status == 3 else -found.fun


def dual(jacobian, torques, friction, senses):
    """The margin as the least factor of friction that a wrench allows, by HiGHS; infinite where there is none."""
    height = len(jacobian)
    rows, sides = [], []
    for k, sense in enumerate(senses):
        for sign in (1.0, -1.0):
            if sense == -sign:
                continue  # the hinge presses against its stop on this side
            rows.append([*(sign * jacobian[:, k]), -friction[k]])
            sides.append(-sign * torques[k])
    bounds = [(None, None)] * height + [(0.0, None)]
    found = linprog(np.r_[np.zeros(height), 1.0], A_ub=np.array(rows), b_ub=sides, bounds=bounds)
    assert found.status in (0, 2), found.message
    return np.inf if found.status == 2 else found.fun
