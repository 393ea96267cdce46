"""Closure of welds: residual, the rows that are independent, and the forces that keep them closed.

Loops of overconstrained linkages have rows that say nothing new where the loops are closed, but contradict the others
as soon as rounding opens them: solved with all rows they lock. So at the start of each step independent rows are
chosen by pivoted Cholesky of the Delassus matrix, and stay for the step; the projection afterwards closes all rows.
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.algebra.vectors import cross, dot, rotated, vector_at, vector_difference, vector_sum
from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.multibody.tree import (
    ROW_FREE_TURN,
    ROW_KIND,
    ROW_WELD,
    WAY_ARM_A,
    WAY_ARM_B,
    WAY_DIRECTION,
    WELD_BODY_A,
    WELD_BODY_B,
    WELD_FRAME,
    WELD_POINT_A,
    WORK_PLACE,
    WORK_ROTATION,
    WORK_SPEED,
    WORK_SPIN,
    BodyTree,
    Work,
)

MIN_ROW_PIVOT_SHARE = 1e-11
"""A row is chosen when its pivot is above this share of the largest Delassus entry with all joints free."""


@lean
def weld_errors(tree: BodyTree, work: Work, errors: Reals) -> float:
    """Write the closure residual: turns (rad) and gaps over the size; return the largest; after `place`."""
    worst = 0.0
    b = work.bodies
    for r in range(len(tree.rows)):
        weld, kind = tree.rows[r, ROW_WELD], tree.rows[r, ROW_KIND]
        first, second = tree.welds[weld, WELD_BODY_A], tree.welds[weld, WELD_BODY_B]
        way = vector_at(work.ways, r, WAY_DIRECTION)
        if kind < 3:
            # half the sum of a_k x b_k over the axes of both bodies is the axis times the sine of the angle between;
            # where b may turn about one axis, that axis alone says how it tilts, however far b has turned
            free = tree.rows[r, ROW_FREE_TURN]
            turn = (0.0, 0.0, 0.0)
            for k in range(3):
                if free < 0 or free == k:
                    own = vector_at(tree.weld_places, weld, WELD_FRAME + 3 * k)
                    here = rotated(b, first, WORK_ROTATION, own) if first >= 0 else own
                    turn = vector_sum(turn, cross(here, rotated(b, second, WORK_ROTATION, own)))
            value = (0.5 if free < 0 else 1.0) * dot(way, turn)
        else:
            own = vector_at(tree.weld_places, weld, WELD_POINT_A)
            # from the joint of body a to the point of body b, less to its own
            gap = (
                vector_difference(vector_at(work.ways, r, WAY_ARM_A), rotated(b, first, WORK_ROTATION, own))
                if first >= 0
                else vector_difference(
                    vector_sum(vector_at(b, second, WORK_PLACE), vector_at(work.ways, r, WAY_ARM_B)), own
                )
            )
            value = dot(way, gap) / tree.size
        errors[r] = value
        worst = max(worst, abs(value))
    return worst


@lean
def weld_rates(tree: BodyTree, work: Work, rates: Reals) -> float:
    """Write the relative velocities of the welded bodies along the rows; return the largest; after `move`."""
    worst = 0.0
    b = work.bodies
    for r in range(len(tree.rows)):
        weld = tree.rows[r, ROW_WELD]
        way = vector_at(work.ways, r, WAY_DIRECTION)
        value = 0.0
        for side in range(2):
            body = tree.welds[weld, side]
            if body < 0:
                continue
            part = dot(way, vector_at(b, body, WORK_SPIN))
            if tree.rows[r, ROW_KIND] >= 3:
                arm = vector_at(work.ways, r, WAY_ARM_B if side else WAY_ARM_A)
                flow = vector_sum(vector_at(b, body, WORK_SPEED), cross(vector_at(b, body, WORK_SPIN), arm))
                part = dot(way, flow) / tree.size
            value += part if side else -part
        rates[r] = value
        worst = max(worst, abs(value))
    return worst


@lean
def choose_rows(work: Work, scale: float) -> None:
    """Choose independent rows by pivoted Cholesky of the Delassus matrix, the largest pivots first.

    scale : largest diagonal entry of the Delassus matrix with all joints free.
    """
    m = len(work.chosen)
    left = work.pivots  # -inf once chosen
    for r in range(m):
        left[r] = work.delassus[r, r]
    count = 0
    factor = work.factor
    for k in range(m):
        best = -1
        for r in range(m):
            if left[r] > -np.inf and (best < 0 or left[r] > left[best]):
                best = r
        if left[best] <= MIN_ROW_PIVOT_SHARE * scale:
            break
        work.chosen[k] = best
        count += 1
        pivot = math.sqrt(left[best])
        left[best] = -np.inf
        for r in range(m):  # column k of the factor, by row of the Delassus matrix
            if left[r] > -np.inf:
                value = work.delassus[r, best]
                for j in range(k):
                    value -= factor[r, j] * factor[best, j]
                factor[r, k] = value / pivot
                left[r] -= factor[r, k] ** 2
        factor[best, k] = pivot
    work.chosen_count[0] = count


@lean
def factor_chosen_rows(work: Work, scale: float) -> bool:
    """Cholesky factor of the Delassus matrix on the chosen rows; whether they are still independent."""
    count = work.chosen_count[0]
    factor, chosen = work.factor, work.chosen
    least = 1e-3 * MIN_ROW_PIVOT_SHARE * scale
    good = True
    for k in range(count):
        r = chosen[k]
        for j in range(k + 1):
            value = work.delassus[r, chosen[j]]
            for i in range(j):
                value -= factor[r, i] * factor[chosen[j], i]
            if j < k:
                factor[r, j] = value / factor[chosen[j], j]
            else:
                if value < least:
                    value, good = least, False
                factor[r, k] = math.sqrt(value)
    return good


@lean
def close_rows(work: Work, unwanted: Reals) -> None:
    """Forces of the rows that take away what is unwanted of each; 0 for rows not chosen; after `factor_chosen_rows`."""
    count = work.chosen_count[0]
    factor, chosen, forces = work.factor, work.chosen, work.forces
    forces[:] = 0.0
    for k in range(count):
        r = chosen[k]
        value = -unwanted[r]
        for j in range(k):
            value -= factor[r, j] * forces[chosen[j]]
        forces[r] = value / factor[r, k]
    for k in range(count - 1, -1, -1):
        r = chosen[k]
        value = forces[r]
        for j in range(k + 1, count):
            value -= factor[chosen[j], k] * forces[chosen[j]]
        forces[r] = value / factor[r, k]
