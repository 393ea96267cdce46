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
from hcsearch.kernels.algebra.vectors import at, cross, dot, plus
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.cones import nonnegative
from hcsearch.kernels.multibody.sweeps import carry, load
from hcsearch.kernels.multibody.tree import (
    ALONG,
    ARM,
    DRIVE,
    FIRST,
    HEAD_COUPLE,
    HEAD_FORCE,
    LAST,
    PARENT,
    POWER,
    ROW,
    SHIFTING,
    TURNING,
    Tree,
    Work,
)
from hcsearch.kernels.multibody.welds import INDEPENDENT

SOFT = 1e-4
"""A joint whose stop could move it by less than this share of what it would without loops is held by the loops: stops
give way that much, so that nearly immobile joints do not ask for impossible forces."""


@lean
def _closure_basis(tree: Tree, scale: float, work: Work, rows: Reals, left: Reals) -> int:
    """Write an orthonormal basis of the closure rows in the space of innovations, by rows; how many; after `gather`."""
    n, m = len(tree.links), len(tree.rows)
    for i in range(n):
        for slot in range(tree.links[i, FIRST], tree.links[i, LAST]):
            rows[tree.slots[slot, ROW], i] = work.slots[slot, POWER] / math.sqrt(work.bodies[i, ALONG])
    for r in range(m):
        left[r] = row_product(rows, r, rows, r, n)
    for count in range(m):
        best = count
        for r in range(count, m):
            if left[r] > left[best]:
                best = r
        if left[best] <= INDEPENDENT * scale:
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
    tree: Tree, touching: Signs, wanted: Reals, scale: float, work: Work, pushed: Reals, change: Reals
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
        load(tree, free, impulse, False, work)
        impulse[i] = 0.0
        for j in range(n):
            columns[k, j] = work.bodies[j, DRIVE] / math.sqrt(work.bodies[j, ALONG])
        wholes[k] = math.sqrt(row_product(columns, k, columns, k, n))
        for _ in range(2):
            for b in range(count):
                subtract_row(columns, k, row_product(basis, b, columns, k, n), basis, b, n)
        divide_row(columns, k, wholes[k], n)
        columns[k, n + k] = SOFT
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
    nonnegative(columns, target, weights, left)
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
        if weights[k] > 0.0 and mobile > SOFT**2:
            pushed[which[k]] = weights[k]
    _release(tree, innovations, work, change)
    return True


@lean
def _release(tree: Tree, innovations: Reals, work: Work, rates: Reals) -> None:
    """Write the velocities of joints from their innovations, as `sweeps.release` does from forces."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, PARENT]
        turn, shift = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if p >= 0:
            turn, shift = at(b, p, TURNING), at(b, p, SHIFTING)
        shift = plus(shift, cross(turn, at(b, i, ARM)))
        root = math.sqrt(b[i, ALONG])
        carried = (dot(at(b, i, HEAD_COUPLE), turn) + dot(at(b, i, HEAD_FORCE), shift)) / root
        rates[i] = (innovations[i] - carried) / root
        carry(tree, i, rates[i], turn, shift, work)
