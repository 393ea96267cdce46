"""One-sided stops of joints: impulses of impacts, and which stops go on holding (a cone complementarity problem).

Velocities and accelerations are taken in the space of the recursion's innovations, where the inertia is the identity:
y_i = (s_i + U_i . a_i) / sqrt(d_i). There the nearest admissible vector is a least-distance problem with inequalities,
solved by nonnegative least squares (Lawson and Hanson 1974, chapter 23): Gauss's principle of least constraint. The
answer is unique even where the forces at redundant stops are not.
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.arrays import Reals, Signs
from hcsearch.kernels.algebra.rows import divide_row, row_product, subtract_row
from hcsearch.kernels.algebra.vectors import cross, dot, vector_at, vector_sum
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.cones import nonnegative_least_squares
from hcsearch.kernels.multibody.sweeps import carry_body, load_joints
from hcsearch.kernels.multibody.tree import (
    LINK_FIRST_SLOT,
    LINK_LAST_SLOT,
    LINK_PARENT,
    SLOT_ROW,
    WORK_ALONG,
    WORK_ARM,
    WORK_DRIVE,
    WORK_HEAD_COUPLE,
    WORK_HEAD_FORCE,
    WORK_SHIFTING,
    WORK_SLOT_POWER,
    WORK_TURNING,
    BodyTree,
    Work,
)
from hcsearch.kernels.multibody.welds import MIN_ROW_PIVOT_SHARE

MIN_STOP_MOBILITY = 1e-4
"""A joint whose stop could move it by less than this share of what it would without loops is held by the loops: stops
give way that much, so that nearly immobile joints do not ask for impossible forces."""


@lean
def _closure_basis(tree: BodyTree, scale: float, work: Work, rows: Reals, left: Reals) -> int:
    """Write an orthonormal basis of the closure rows in the space of innovations, by rows; how many; after `gather`."""
    n, m = len(tree.links), len(tree.rows)
    for i in range(n):
        for slot in range(tree.links[i, LINK_FIRST_SLOT], tree.links[i, LINK_LAST_SLOT]):
            rows[tree.slots[slot, SLOT_ROW], i] = work.slots[slot, WORK_SLOT_POWER] / math.sqrt(
                work.bodies[i, WORK_ALONG]
            )
    for r in range(m):
        left[r] = row_product(rows, r, rows, r, n)
    for count in range(m):
        best = count
        for r in range(count, m):
            if left[r] > left[best]:
                best = r
        if left[best] <= MIN_ROW_PIVOT_SHARE * scale:
            return count
        for k in range(n):
            rows[count, k], rows[best, k] = rows[best, k], rows[count, k]
        left[best] = left[count]
        for _ in range(2):  # twice is enough
            for j in range(count):
                subtract_row(rows, count, row_product(rows, j, rows, count, n), rows, j, n)
        divide_row(rows, count, math.sqrt(row_product(rows, count, rows, count, n)), n)
        for r in range(count + 1, m):
            subtract_row(rows, r, row_product(rows, count, rows, r, n), rows, count, n)
            left[r] = row_product(rows, r, rows, r, n)
    return m


@compiled
def push_apart(
    tree: BodyTree, touching: Signs, wanted: Reals, scale: float, work: Work, pushed: Reals, change: Reals
) -> bool:
    """The least change of velocities (or accelerations) that gives touching joints what they want at least.

    touching : (n,), -1 where the joint is at its lower stop and may only grow, 1 at its upper, 0 elsewhere.
    wanted : (n,), least change away from the stop. scale : of `choose`. change : (n,), of all joints.
    pushed : (n,), not 0 where a stop pushes.
    False, and nothing changed, where rounding hides the answer. After `gather` with all joints free.
    """
    n, m = len(touching), len(tree.rows)
    free = np.zeros(n, np.int8)
    basis = np.zeros((m, n))
    count = _closure_basis(tree, scale, work, basis, np.empty(m))
    which = np.flatnonzero(touching)
    columns = np.zeros((len(which), n + len(which) + 1))
    wholes = np.empty(len(which))
    impulse = np.zeros(n)
    change[:] = 0.0
    pushed[:] = 0.0
    greatest = 0.0
    for k in range(len(which)):
        i = which[k]
        impulse[i] = -1.0 if touching[i] > 0 else 1.0
        load_joints(tree, free, impulse, False, work)
        impulse[i] = 0.0
        for j in range(n):
            columns[k, j] = work.bodies[j, WORK_DRIVE] / math.sqrt(work.bodies[j, WORK_ALONG])
        wholes[k] = math.sqrt(row_product(columns, k, columns, k, n))
        for _ in range(2):
            for b in range(count):
                subtract_row(columns, k, row_product(basis, b, columns, k, n), basis, b, n)
        divide_row(columns, k, wholes[k], n)
        columns[k, n + k] = MIN_STOP_MOBILITY
        greatest = max(greatest, abs(wanted[i]) / wholes[k])
    if greatest == 0.0:
        return True
    sizes = np.empty(len(which))
    height = n + len(which) + 1
    for k in range(len(which)):
        columns[k, height - 1] = wanted[which[k]] / wholes[k] / greatest
        sizes[k] = math.sqrt(row_product(columns, k, columns, k, height))
        divide_row(columns, k, sizes[k], height)
    target = np.zeros(height)
    target[height - 1] = 1.0
    weights, left = np.zeros(len(which)), np.empty(height)
    nonnegative_least_squares(columns, target, weights, left)
    if left[height - 1] <= 1e-12:
        return False
    innovations = np.empty(n)
    for j in range(n):
        innovations[j] = -left[j] / left[height - 1] * greatest
    for k in range(len(which)):
        # a stop that could hardly move its joint is left to the loops
        mobile = 0.0
        for j in range(n):
            mobile += (columns[k, j] * sizes[k]) ** 2
        if weights[k] > 0.0 and mobile > MIN_STOP_MOBILITY**2:
            pushed[which[k]] = weights[k]
    _release(tree, innovations, work, change)
    return True


@lean
def _release(tree: BodyTree, innovations: Reals, work: Work, rates: Reals) -> None:
    """Write the velocities of joints from their innovations, as `sweeps.release` does from forces."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, LINK_PARENT]
        turn, shift = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if p >= 0:
            turn, shift = vector_at(b, p, WORK_TURNING), vector_at(b, p, WORK_SHIFTING)
        shift = vector_sum(shift, cross(turn, vector_at(b, i, WORK_ARM)))
        root = math.sqrt(b[i, WORK_ALONG])
        carried = (dot(vector_at(b, i, WORK_HEAD_COUPLE), turn) + dot(vector_at(b, i, WORK_HEAD_FORCE), shift)) / root
        rates[i] = (innovations[i] - carried) / root
        carry_body(tree, i, rates[i], turn, shift, work)
