"""Openings of loops near a locked state: least squares over turns x >= 0 away from the stops, of a given sum.

The opening is the length of the closure residual in metres, by the weights of `motion.locks.tightness`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import scalar_product
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.cones import nonnegative_least_squares
from hcsearch.kernels.linkage.loops import close_loops

MAX_OPENING_STEPS, MIN_OPENING_GAIN = 60, 1e-8
"""Maximum number of steps of a minimisation of the opening, which ends where a step reduces the square by no more than
this share."""
FIRST_OPENING_DAMPING, MAX_OPENING_DAMPING = 1e-3, 1e6
"""Damping of the first step, and where a minimisation is given up, as shares of the slope's size."""


class LoopsAtStops(NamedTuple):
    """The loops of a linkage in a state where every hinge is at a stop.

    directions, points : of the hinge lines, (n, 3). starts, hinges, signs : the loops, as in `close_loops`. size : of
    the pattern, m. angles : of the state, (n,). senses : in which each hinge leaves its stop, +1 or -1. weights : of
    the closure residuals, (n_loops, 6, 6), with which their norms are lengths (m). negligible : openings (m) below
    this are zero.
    """

    directions: Reals
    points: Reals
    starts: WholeNumbers
    hinges: WholeNumbers
    signs: WholeNumbers
    size: float
    angles: Reals
    senses: Reals
    weights: Reals
    negligible: float


@compiled
def open_loops(loops: LoopsAtStops, turns: Reals, value: Reals, slope: Reals) -> float:
    """Write the weighted residual at some turns, whose length is the opening, and its derivative; return its square.

    value : shape (6 n_loops,). slope : shape (6 n_loops, n).
    """
    rows, n = slope.shape
    residual, jacobian = np.empty(rows), np.empty((rows, n))
    angles = loops.angles + loops.senses * turns
    work = np.empty((3, 4))
    starts, hinges, signs = loops.starts, loops.hinges, loops.signs
    close_loops(loops.directions, loops.points, starts, hinges, signs, angles, loops.size, residual, jacobian, work)
    value[:] = 0.0
    slope[:] = 0.0
    share = 1.0 / math.sqrt(rows // 6)
    for row in range(rows):
        first = row - row % 6
        for k in range(6):
            weight = share * loops.weights[row // 6, row % 6, k]
            value[row] += weight * residual[first + k]
            for j in range(n):
                slope[row, j] += weight * jacobian[first + k, j] * loops.senses[j]
    return scalar_product(value, value)


@compiled
def scale_turns(turns: Reals, total: float, scaled: Reals) -> None:
    """Write turns scaled to a sum, with none beyond the other stop."""
    n = len(turns)
    at_stop = np.zeros(n, np.bool_)
    while True:
        n_free, inside = 0, 0.0
        for i in range(n):
            if not at_stop[i]:
                n_free += 1
                inside += turns[i]
        remaining = total - math.pi * (n - n_free)
        is_beyond = False
        for i in range(n):
            if at_stop[i]:
                scaled[i] = math.pi
                continue
            scaled[i] = turns[i] * (remaining / inside) if inside > 0.0 else remaining / n_free
            if scaled[i] > math.pi:
                at_stop[i] = is_beyond = True
        if not is_beyond:
            return


@compiled
def _damp_turns(slope: Reals, target: Reals, damping: float, turns: Reals, damped: Reals) -> None:
    """Write the y >= 0 that minimises |slope y - target|^2 + damping^2 |y - turns|^2."""
    rows, n = slope.shape
    columns = np.zeros((n, rows + n))
    aim, residual = np.empty(rows + n), np.empty(rows + n)
    aim[:rows] = target
    aim[rows:] = damping * turns
    for j in range(n):
        columns[j, :rows] = slope[:, j]
        columns[j, rows + j] = damping
        columns[j] /= math.sqrt(scalar_product(columns[j], columns[j]))
    length = math.sqrt(scalar_product(aim, aim))
    nonnegative_least_squares(columns, aim / length, damped, residual)
    for j in range(n):
        damped[j] *= length * columns[j, rows + j] / damping


@compiled
def minimise_opening(loops: LoopsAtStops, turns: Reals, total: float) -> None:
    """Minimise the opening over turns of a given sum, from a start of the same sum, in place.

    Least squares with x >= 0, damped by Levenberg and Marquardt's method.
    """
    rows, n = 6 * (len(loops.starts) - 1), len(turns)
    value, slope, across = np.empty(rows), np.empty((rows, n)), np.empty((rows, n))
    trial_value, trial_slope, target = np.empty(rows), np.empty((rows, n)), np.empty(rows)
    damped, trial = np.empty(n), np.empty(n)
    square, damping = open_loops(loops, turns, value, slope), FIRST_OPENING_DAMPING
    for _ in range(MAX_OPENING_STEPS):
        for i in range(rows):  # the derivative with the sum rescaled
            across[i] = slope[i] - scalar_product(slope[i], turns) / total
            target[i] = scalar_product(across[i], turns) - value[i]
        size = math.sqrt(scalar_product(across.ravel(), across.ravel()) / n)
        while damping < MAX_OPENING_DAMPING:
            _damp_turns(across, target, damping * size, turns, damped)
            scale_turns(damped, total, trial)
            trial_square = open_loops(loops, trial, trial_value, trial_slope)
            if trial_square < square:
                break
            damping *= 4.0
        else:
            return
        turns[:], value[:], slope[:] = trial, trial_value, trial_slope
        damping *= 0.2
        if trial_square > (1.0 - MIN_OPENING_GAIN) * square or trial_square < loops.negligible**2:
            return
        square = trial_square
