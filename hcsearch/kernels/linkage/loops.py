"""Closure of loops of revolute hinges: residuals, Jacobians, second-order terms, and poses of panels.

A hinge is a line in the flat state: a unit direction and a point. Folding hinges h_1, ..., h_k moves everything after
them by the product of the rotations about those lines, in this order (product of exponentials), so a loop is closed
when the product is the identity. Loops are concatenated: loop l is `hinges[starts[l]:starts[l + 1]]`, each hinge with
sign +1 or -1 as the loop crosses it from its first panel to its second or back.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import add_bracket, row_product, solve_factored
from hcsearch.kernels.compiling.compiled import compiled, small


@compiled
def fold_on(pose: Reals, direction: Reals, point: Reals, angle: float) -> None:
    """Multiply a pose (3 x 4, rotation and translation) from the right by the rotation about a line."""
    s = math.sin(angle)
    c = 2.0 * math.sin(0.5 * angle) ** 2  # 1 - cos, exact for small angles
    ux, uy, uz = direction[0], direction[1], direction[2]
    # the rotation minus the identity, by rows, so that fixed points stay exact
    xx, xy, xz = -c * (uy * uy + uz * uz), c * ux * uy - s * uz, c * ux * uz + s * uy
    yx, yy, yz = c * ux * uy + s * uz, -c * (ux * ux + uz * uz), c * uy * uz - s * ux
    zx, zy, zz = c * ux * uz - s * uy, c * uy * uz + s * ux, -c * (ux * ux + uy * uy)
    for i in range(3):
        a, b, d = pose[i, 0], pose[i, 1], pose[i, 2]
        x = a * xx + b * yx + d * zx
        y = a * xy + b * yy + d * zy
        z = a * xz + b * yz + d * zz
        pose[i, 0] = a + x
        pose[i, 1] = b + y
        pose[i, 2] = d + z
        pose[i, 3] -= x * point[0] + y * point[1] + z * point[2]


@compiled
def _rotation_vector(pose: Reals, vector: Reals) -> None:
    """Write axis times angle of the rotation of a pose, for angles up to pi."""
    x = pose[2, 1] - pose[1, 2]
    y = pose[0, 2] - pose[2, 0]
    z = pose[1, 0] - pose[0, 1]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (pose[0, 0] + pose[1, 1] + pose[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if cosine > -0.9:
        scale = 0.5 if sine < 1e-300 else 0.5 * angle / sine
        vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z
        return
    # near pi the skew part vanishes: the axis is the largest column of R + R^T - 2 cos I, the skew part says its sign
    best = 0
    for k in range(1, 3):
        if pose[k, k] > pose[best, best]:
            best = k
    norm = 0.0
    for i in range(3):
        vector[i] = pose[i, best] + pose[best, i] - (2.0 * cosine if i == best else 0.0)
        norm += vector[i] * vector[i]
    scale = angle / math.sqrt(norm)
    if x * vector[0] + y * vector[1] + z * vector[2] < 0.0:
        scale = -scale
    for i in range(3):
        vector[i] *= scale


@small
@compiled
def close_loops(
    directions: Reals,
    points: Reals,
    starts: WholeNumbers,
    hinges: WholeNumbers,
    signs: WholeNumbers,
    angles: Reals,
    size: float,
    residual: Reals,
    jacobian: Reals,
    pose: Reals,
) -> None:
    """Write the closure residual of every loop, and its Jacobian with respect to the fold angles.

    residual : shape (6 n_loops,), for each loop the rotation vector (rad) and the gap divided by `size`.
    jacobian : shape (6 n_loops, n_hinges), columns the screws of the hinges in the current state, relative to the first
        panel of the loop; exact where the loop is closed, else up to terms of the size of the residual.
    pose : shape (3, 4), work table; the pose at the end of the last loop.
    """
    for i in range(jacobian.shape[0]):
        for h in range(jacobian.shape[1]):
            jacobian[i, h] = 0.0
    for loop in range(len(starts) - 1):
        for i in range(3):
            for j in range(4):
                pose[i, j] = 1.0 if i == j else 0.0
        row = 6 * loop
        for k in range(starts[loop], starts[loop + 1]):
            h, sign = hinges[k], float(signs[k])
            u, q = directions[h], points[h]
            wx = sign * (pose[0, 0] * u[0] + pose[0, 1] * u[1] + pose[0, 2] * u[2])
            wy = sign * (pose[1, 0] * u[0] + pose[1, 1] * u[1] + pose[1, 2] * u[2])
            wz = sign * (pose[2, 0] * u[0] + pose[2, 1] * u[1] + pose[2, 2] * u[2])
            px = pose[0, 0] * q[0] + pose[0, 1] * q[1] + pose[0, 2] * q[2] + pose[0, 3]
            py = pose[1, 0] * q[0] + pose[1, 1] * q[1] + pose[1, 2] * q[2] + pose[1, 3]
            pz = pose[2, 0] * q[0] + pose[2, 1] * q[1] + pose[2, 2] * q[2] + pose[2, 3]
            jacobian[row, h] += wx
            jacobian[row + 1, h] += wy
            jacobian[row + 2, h] += wz
            jacobian[row + 3, h] += (py * wz - pz * wy) / size
            jacobian[row + 4, h] += (pz * wx - px * wz) / size
            jacobian[row + 5, h] += (px * wy - py * wx) / size
            fold_on(pose, u, q, sign * angles[h])
        _rotation_vector(pose, residual[row : row + 3])
        for i in range(3):
            residual[row + 3 + i] = pose[i, 3] / size


@small
@compiled
def bend_loops(starts: WholeNumbers, hinges: WholeNumbers, jacobian: Reals, velocity: Reals, bend: Reals) -> None:
    """Write the second-order closure error of moving with a velocity: the sum over i < j of v_i v_j [S_i, S_j].

    S_i are the columns of the Jacobian in the order of the loop. With accelerations w of the fold angles, a loop
    stays closed to second order when J w + bend = 0. No hinge may occur twice in a loop. Linear time: the sum over i is
    accumulated.
    """
    before = np.empty(6)
    for loop in range(len(starts) - 1):
        row = 6 * loop
        before[:] = 0.0
        bend[row : row + 6] = 0.0
        for k in range(starts[loop], starts[loop + 1]):
            h = hinges[k]
            s = jacobian[row : row + 6, h] * velocity[h]
            add_bracket(before, s, bend[row : row + 6])
            before += s


class Chain(NamedTuple):
    """Lines of hinges in the flat state, and a spanning tree of panels.

    directions, points : (n_hinges, 3). order : the panels, parents before children.
    parents, hinges, signs : for each panel, its parent (-1 if fixed in its flat position), the hinge between them, and
        the sense in which the tree crosses that hinge.
    """

    directions: Reals
    points: Reals
    order: WholeNumbers
    parents: WholeNumbers
    hinges: WholeNumbers
    signs: WholeNumbers


@compiled
def place_panels(chain: Chain, angles: Reals, poses: Reals) -> None:
    """Write the pose of every panel, shape (n_panels, 3, 4): rotation and translation from the flat position."""
    for k in range(len(chain.order)):
        panel = chain.order[k]
        pose = poses[panel]
        parent = chain.parents[panel]
        for i in range(3):
            for j in range(4):
                pose[i, j] = poses[parent, i, j] if parent >= 0 else 1.0 if i == j else 0.0
        if parent >= 0:
            h = chain.hinges[panel]
            fold_on(pose, chain.directions[h], chain.points[h], chain.signs[panel] * angles[h])


@compiled
def weigh_rows(jacobian: Reals, residual: Reals, damping: float, gram: Reals, weights: Reals) -> bool:
    """Write the x for which -J^T x is the shortest change of the angles that cancels a residual to first order.

    Solves (J J^T + d) x = residual by Cholesky, with d = `damping` plus the squared norm of the residual; returns False
    if rounding makes the matrix indefinite. The step equals that of `kinematics.closing.correction`, except in the
    directions that are excluded there by singular values: here damping alone keeps redundant loops solvable.

    gram : (r, r), work table for the factor.
    """
    r, m = jacobian.shape
    for i in range(r):
        damping += residual[i] * residual[i]
    for j in range(r):
        for i in range(j, r):
            value = row_product(jacobian, i, jacobian, j, m) + (damping if i == j else 0.0)
            value -= row_product(gram, i, gram, j, j)
            if i > j:
                gram[i, j] = value / gram[j, j]
            elif value > 0.0:
                gram[j, j] = math.sqrt(value)
            else:
                return False
    for i in range(r):
        weights[i] = residual[i]
    solve_factored(gram, weights)
    return True


@compiled
def _close_one(
    directions: Reals,
    points: Reals,
    walk: tuple[WholeNumbers, WholeNumbers, WholeNumbers],
    angles: Reals,
    size: float,
    residual: Reals,
    jacobian: Reals,
    steps: int,
) -> float:
    """Close one loop by damped Newton steps of least length; return the remaining residual."""
    n = len(angles)
    gram, weights, pose = np.empty((6, 6)), np.empty(6), np.empty((3, 4))
    largest = 0.0
    for step in range(steps + 1):
        close_loops(directions, points, walk[0], walk[1], walk[2], angles, size, residual, jacobian, pose)
        largest = 0.0
        for i in range(6):
            largest = max(largest, abs(residual[i]))
        if largest < 1e-13 or step == steps or not weigh_rows(jacobian, residual, 1e-14, gram, weights):
            break
        for k in range(n):
            for i in range(6):
                angles[k] -= jacobian[i, k] * weights[i]
    return largest


@compiled
def generic_states(
    directions: Reals, points: Reals, folded: Reals, heading: Reals, size: float, jacobians: Reals, residuals: Reals
) -> None:
    """Move each of many single loops away from its folded state, and write the Jacobian in the state reached.

    directions, points : shape (n_loops, n, 3), hinges in the order of the loop. folded : shape (n,), angles that close
        every loop. heading : shape (n,), added to the angles in each of six steps, before the loop is closed again.
    jacobians : shape (n_loops, 6, n). residuals : shape (n_loops,), greatest remaining residual; infinite if the loop
        has returned to its folded state.
    """
    n = len(folded)
    walk = (np.array([0, n]), np.arange(n), np.ones(n, np.int64))
    residual = np.empty(6)
    for loop in range(len(directions)):
        angles = folded.copy()
        for _ in range(6):
            angles += heading
            _close_one(directions[loop], points[loop], walk, angles, size, residual, jacobians[loop], 3)
        remaining = _close_one(directions[loop], points[loop], walk, angles, size, residual, jacobians[loop], 40)
        distance = 0.0
        for k in range(n):
            distance = max(distance, abs(angles[k] - folded[k]))
        residuals[loop] = remaining if distance > 1e-3 else np.inf
