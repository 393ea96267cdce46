"""Existence proofs for a piece of a motion whose loops are nearly closed: one closed state in a ball about each state.

With screws J_k of the hinges at a state c, seen from the first panel of a loop, folding by d more closes the loop to
T(c + d) = exp(d_1 J_1) ... exp(d_m J_m) T(c), exactly. At the middle of a piece S J has orthonormal rows, V; a closed
state beside a state x of the piece is x + V^T y, where y = y - S F(x + V^T y), F the twist of T - 1. That map is a
contraction of a ball, so there is one such y, and it changes continuously along the piece (Newton-Kantorovich theorem).
F and the derivative of the map are entire: both are computed at some nodes of the piece and bounded between them. Only
deviations from the course are bounded by norms (docs/explanation/motion.md). So the bounds depend on the motion of a
loop, not on the number of its hinges. Rounding errors are added to all computed values.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import row_product, subtract_row
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import fold_on
from hcsearch.kernels.planning.closed_states import Group, Loops, write_closure
from hcsearch.kernels.planning.series import centre_screws

MAX_CONTRACTION_FACTOR = 0.5
"""Greatest contraction factor that is accepted: the ball is then twice the Newton step."""
CHEBYSHEV_NODE_COUNT = 9
"""Chebyshev nodes of a piece at which its loops are computed; odd, so that its middle is one of them."""
LEBESGUE_CONSTANT = 2.0 / math.pi * math.log(CHEBYSHEV_NODE_COUNT) + 1.0
"""Greatest ratio of the interpolation polynomial to the values at its nodes."""
LOOP_POSE_ROUNDING = 4e-15
"""Rounding error of T of a loop for each of its hinges, relative to 1 and the distance of hinges: a product of
rotations is a sum of three products of two entries, each known to a few units in the last place, as the hinges'
places are."""
MAX_TURN_NORM = 1.0
"""Greatest sum of the norms of screws times the turns of their hinges in half a piece (so that norms grow by e at
most)."""
MAX_LOOP_DEVIATION = 0.05
"""Greatest deviation of T of a loop from 1 at states of a tube; a half turn, whose twist is 0 as well, exceeds it."""
PIECE_WANDER_SHARE = 0.9
"""Share of the deviation limit that a piece itself may use: the rest is for joining it to the piece before."""


class PieceTables(NamedTuple):
    """Tables of one piece; k equations, r = 6 n_loops.

    jacobian : (r, m), screws about the middle of each loop. basis : (k, m), orthonormal rows V of the span of those of
    the equations. scaling : (k, r), S. residual : (r,). middles : (n_loops, 3) and lengths : (n_loops,), of the axes
    that screws are given in. norms : (n_loops, m), upper bounds of those of J_k, as a matrix, and of ad(J_k).
    centred_course : (m, 4), the course about the middle of the piece. angles : (m,). poses : (n_loops, 3, 4).
    wander_bounds : (m,), rad, of the deviations of closed states. tube_radii : (m,), rad, of the deviations of all
    states of the tube from the course. screws : (NODES, moving hinges of all loops, 6). reduced_jacobian : (r, k), J
    V^T. contraction_matrices : (NODES, k, k), S J V^T - 1. turn_sums, wander_sums, column_sums : (n_loops,), sums over
    hinges of norms times their turns, their deviations, and the column norms of V. column_norms : (m,), of V.
    """

    jacobian: Reals
    basis: Reals
    scaling: Reals
    residual: Reals
    middles: Reals
    lengths: Reals
    norms: Reals
    centred_course: Reals
    angles: Reals
    poses: Reals
    wander_bounds: Reals
    tube_radii: Reals
    screws: Reals
    reduced_jacobian: Reals
    contraction_matrices: Reals
    turn_sums: Reals
    wander_sums: Reals
    column_sums: Reals
    column_norms: Reals


@compiled
def new_piece_tables(loops: Loops, group: Group) -> PieceTables:
    """Return empty tables."""
    m, count = len(loops.chain.points), len(loops.starts) - 1
    r, k = 6 * count, len(group.rows)
    return PieceTables(
        np.zeros((r, m)),
        np.zeros((k, m)),
        np.zeros((k, r)),
        np.zeros(r),
        np.zeros((count, 3)),
        np.zeros(count),
        np.zeros((count, m)),
        np.zeros((m, 4)),
        np.zeros(m),
        np.zeros((max(count, 1), 3, 4)),  # the first also serves the walks of `close_loops`
        np.zeros(m),
        np.zeros(m),
        np.zeros((CHEBYSHEV_NODE_COUNT, len(group.hinges), 6)),
        np.zeros((r, k)),
        np.zeros((CHEBYSHEV_NODE_COUNT, k, k)),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(m),
    )


@compiled
def prove_piece(
    loops: Loops,
    group: Group,
    course: Reals,
    shares: tuple[float, float],
    joined: Reals,
    limit: float,
    tables: PieceTables,
) -> tuple[float, float]:
    """Return the contraction factor of a piece, infinite if not proved, and the deviation of its closed states (rad).

    joined : (m,), deviations of the closed states of the piece before, or of the end. States of both are joined where
    the pieces meet: F is 0 at both ends of the straight segment between them, so that between it is at most an eighth
    of its second derivative there; closed states lie beside that segment, off by no more than `bow`. limit : rad,
    greatest deviation.
    """
    low, high = shares
    _shift(course, 0.5 * (low + high), 0.5 * (high - low), tables.centred_course)
    for h in range(len(tables.angles)):
        tables.angles[h] = tables.centred_course[h, 0]
    max_norm = _screws(loops, group, tables)
    tables.tube_radii[:] = 0.0
    if _turns(group, 1.0, tables) > MAX_TURN_NORM:
        return math.inf, math.inf
    strength = _scale(group, tables)
    if not math.isfinite(strength):
        return math.inf, math.inf
    for h in range(len(tables.column_norms)):
        column = 0.0
        for i in range(len(tables.basis)):
            column += tables.basis[i, h] ** 2
        tables.column_norms[h] = math.sqrt(column)
    newton, opening, rounding = _opening(loops, group, strength, max_norm, tables)
    radius = newton / (1.0 - MAX_CONTRACTION_FACTOR)
    wander = joined_wander = 0.0
    for h in range(len(joined)):
        tables.wander_bounds[h] = tables.column_norms[h] * radius
        tables.tube_radii[h] = tables.wander_bounds[h] + joined[h]
        wander += tables.wander_bounds[h]
        joined_wander += joined[h]
    if not wander <= PIECE_WANDER_SHARE * limit:
        return math.inf, max(wander, 1.01 * limit)
    _wanders(group, tables)
    total = 0.0
    for loop in range(len(tables.wander_sums)):
        total += tables.wander_sums[loop] ** 4
    bow = 1.05 * strength * math.sqrt(total)
    wander = max(wander, joined_wander)
    for h in range(len(joined)):
        if group.moving[h]:
            tables.wander_bounds[h] += tables.column_norms[h] * bow
            tables.tube_radii[h] += tables.column_norms[h] * bow
            wander += tables.column_norms[h] * bow
    _wanders(group, tables)
    if _turns(group, 1.0, tables) > MAX_TURN_NORM:
        return math.inf, math.inf
    return _contraction(group, strength, opening, rounding, tables), wander


@compiled
def _shift(course: Reals, centre: float, half: float, centred: Reals) -> None:
    """Write the cubics about the centre of a piece, in units of half its length."""
    for h in range(len(course)):
        a, b, c, d = course[h, 0], course[h, 1], course[h, 2], course[h, 3]
        centred[h, 0] = a + centre * (b + centre * (c + centre * d))
        centred[h, 1] = half * (b + centre * (2.0 * c + 3.0 * centre * d))
        centred[h, 2] = half * half * (c + 3.0 * centre * d)
        centred[h, 3] = half**3 * d


@compiled
def _screws(loops: Loops, group: Group, tables: PieceTables) -> float:
    """Write the screws at the angles, about the middle of each loop in its unit of length; return their greatest norm.

    The screws of hinges that do not move are left in other axes.
    """
    write_closure(loops, tables.angles, tables.residual, tables.jacobian, tables.poses[0])
    tables.norms[:] = 0.0
    max_norm = 0.0
    for loop in range(len(loops.starts) - 1):
        hinges = group.hinges[group.starts[loop] : group.starts[loop + 1]]
        norms = tables.norms[loop]
        tables.lengths[loop] = centre_screws(tables.jacobian, 6 * loop, hinges, tables.middles[loop], norms)
        for h in hinges:
            # norms of the matrix, (1 + moment^2)^(1/2), and of ad: of [[1, 0], [moment, 1]], which is the greater
            moment = norms[h]
            norms[h] = 0.5 * (moment + math.sqrt(moment * moment + 4.0)) * (1.0 + 1e-14)
            max_norm = max(max_norm, norms[h])
    return max_norm


@compiled
def _scale(group: Group, tables: PieceTables) -> float:
    """Write S and V with S J = V, orthonormal rows, by Gram-Schmidt; return the norm of S, infinite without one."""
    basis, scaling, rows = tables.basis, tables.scaling, group.rows
    k, m = basis.shape
    r = scaling.shape[1]
    for i in range(k):
        for h in range(m):
            basis[i, h] = 0.0
        for j in range(r):
            scaling[i, j] = rows[i, j]
            if rows[i, j] != 0.0:
                for h in range(m):
                    if group.moving[h]:
                        basis[i, h] += rows[i, j] * tables.jacobian[j, h]
        for _ in range(2):
            for j in range(i):
                part = row_product(basis, i, basis, j, m)
                subtract_row(basis, i, part, basis, j, m)
                subtract_row(scaling, i, part, scaling, j, r)
        norm = math.sqrt(row_product(basis, i, basis, i, m))
        if norm < 1e-13:
            return math.inf
        for h in range(m):
            basis[i, h] /= norm
        for j in range(r):
            scaling[i, j] /= norm
    total = 0.0
    for i in range(k):
        total += row_product(scaling, i, scaling, i, r)
    return math.sqrt(total)


@compiled
def _turns(group: Group, radius: float, tables: PieceTables) -> float:
    """Write the sums of norms times greatest turns of hinges, for |x| up to `radius`; return the greatest sum.

    It is the exponent of all bounds: of the matrices, and of the screws of later hinges.
    """
    worst = 0.0
    for loop in range(len(tables.turn_sums)):
        total = 0.0
        for k in range(group.starts[loop], group.starts[loop + 1]):
            h = group.hinges[k]
            c = tables.centred_course[h]
            turn = radius * (abs(c[1]) + radius * (abs(c[2]) + radius * abs(c[3]))) + tables.tube_radii[h]
            total += tables.norms[loop, h] * turn
        tables.turn_sums[loop] = total
        worst = max(worst, total)
    return worst


@compiled
def _wanders(group: Group, tables: PieceTables) -> None:
    """Write the sums of norms times the greatest deviations of states of the tube from the course."""
    for loop in range(len(tables.wander_sums)):
        total = 0.0
        for k in range(group.starts[loop], group.starts[loop + 1]):
            total += tables.norms[loop, group.hinges[k]] * tables.tube_radii[group.hinges[k]]
        tables.wander_sums[loop] = total


@compiled
def _opening(
    loops: Loops, group: Group, strength: float, max_norm: float, tables: PieceTables
) -> tuple[float, float, float]:
    """Return bounds of the Newton steps and of the opening of loops in the piece (rad), and the rounding error of T.

    T - 1 is entire in the share of the piece, so that its interpolation at Chebyshev nodes is off by no more than
    4 M g^-n / (g - 1), with M its bound on an ellipse whose half axes sum to g (Trefethen, Approximation Theory and
    Approximation Practice, theorem 8.2). Also writes S J V^T - 1 at the nodes.
    """
    newton = opening = 0.0
    r, m = tables.jacobian.shape
    k = len(tables.basis)
    for node in range(CHEBYSHEV_NODE_COUNT):
        x = math.cos(math.pi * (node + 0.5) / CHEBYSHEV_NODE_COUNT)
        for h in range(m):
            c = tables.centred_course[h]
            tables.angles[h] = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
        opening = max(opening, _twists(loops, group, node, tables))
        total = 0.0
        for i in range(k):
            step = 0.0
            for j in range(r):
                step += tables.scaling[i, j] * tables.residual[j]
            total += step * step
        newton = max(newton, math.sqrt(total))
    remainder = math.inf
    for g in (8.0, 16.0, 32.0, 64.0):
        bound = 0.0
        if _turns(group, 0.5 * (g + 1.0 / g), tables) < 50.0:
            for loop in range(len(tables.turn_sums)):
                bound += (math.exp(tables.turn_sums[loop]) * (1.0 + opening) - 1.0) ** 2
            # the 3: entries of T - 1 are at most those of three rows of its norm
            remainder = min(remainder, 4.0 * math.sqrt(3.0 * bound) * g ** (1 - CHEBYSHEV_NODE_COUNT) / (g - 1.0))
    max_reach = 0.0
    for h in range(m):
        point = loops.chain.points[h]
        max_reach = max(max_reach, math.sqrt(point[0] ** 2 + point[1] ** 2 + point[2] ** 2))
    rounding = math.sqrt(len(tables.lengths)) * LOOP_POSE_ROUNDING * m
    shortest = math.inf
    for loop in range(len(tables.lengths)):
        shortest = min(shortest, tables.lengths[loop])
    rounding *= 1.0 + max_norm + max_reach / (loops.size * shortest)
    newton = LEBESGUE_CONSTANT * newton + strength * (remainder + rounding)
    return newton, LEBESGUE_CONSTANT * opening + remainder + rounding, rounding


@compiled
def _twists(loops: Loops, group: Group, node: int, tables: PieceTables) -> float:
    """Write the twist of T - 1 of every loop at the angles, about its middle; return the norm of all entries of T - 1.

    Also writes the screws of the moving hinges at these angles.
    """
    total = 0.0
    for loop in range(len(loops.starts) - 1):
        pose, size = tables.poses[loop], loops.size
        pose[:] = 0.0
        pose[0, 0] = pose[1, 1] = pose[2, 2] = 1.0
        row, middle, length = 6 * loop, tables.middles[loop], tables.lengths[loop]
        place = group.starts[loop]
        for k in range(loops.starts[loop], loops.starts[loop + 1]):
            h, sign = loops.hinges[k], float(loops.signs[k])
            u, q = loops.chain.directions[h], loops.chain.points[h]
            if group.moving[h]:
                screw = tables.screws[node, place]
                place += 1
                wx = sign * (pose[0, 0] * u[0] + pose[0, 1] * u[1] + pose[0, 2] * u[2])
                wy = sign * (pose[1, 0] * u[0] + pose[1, 1] * u[1] + pose[1, 2] * u[2])
                wz = sign * (pose[2, 0] * u[0] + pose[2, 1] * u[1] + pose[2, 2] * u[2])
                px = (pose[0, 0] * q[0] + pose[0, 1] * q[1] + pose[0, 2] * q[2] + pose[0, 3]) / size - middle[0]
                py = (pose[1, 0] * q[0] + pose[1, 1] * q[1] + pose[1, 2] * q[2] + pose[1, 3]) / size - middle[1]
                pz = (pose[2, 0] * q[0] + pose[2, 1] * q[1] + pose[2, 2] * q[2] + pose[2, 3]) / size - middle[2]
                screw[0], screw[1], screw[2] = wx, wy, wz
                screw[3] = (py * wz - pz * wy) / length
                screw[4] = (pz * wx - px * wz) / length
                screw[5] = (px * wy - py * wx) / length
            fold_on(pose, u, q, sign * tables.angles[h])
        tables.residual[row] = 0.5 * (pose[2, 1] - pose[1, 2])
        tables.residual[row + 1] = 0.5 * (pose[0, 2] - pose[2, 0])
        tables.residual[row + 2] = 0.5 * (pose[1, 0] - pose[0, 1])
        for i in range(3):
            shift = pose[i, 3] / size - middle[i]
            for j in range(3):
                shift += pose[i, j] * middle[j]
                total += (pose[i, j] - (1.0 if i == j else 0.0)) ** 2
            tables.residual[row + 3 + i] = shift / length
            total += tables.residual[row + 3 + i] ** 2
    return math.sqrt(total)


@compiled
def _contraction(group: Group, strength: float, opening: float, rounding: float, tables: PieceTables) -> float:
    """Return the contraction factor of the map over all states within `tube_radii` of the course.

    Its derivative is 1 - S (1 + E) J V^T. On the course D = S J V^T - 1 is entire, and interpolated at the nodes as T
    is, except for a linear part, which is bounded as it is. Off the course screws differ by no more than e^turns
    wanders, and the norm of E does not exceed the deviation of T from 1.
    """
    k = len(tables.basis)
    for loop in range(len(tables.column_sums)):
        total = 0.0
        for j in range(group.starts[loop], group.starts[loop + 1]):
            total += tables.norms[loop, group.hinges[j]] * tables.column_norms[group.hinges[j]]
        tables.column_sums[loop] = total
    spread = 0.0
    for node in range(CHEBYSHEV_NODE_COUNT):
        length = _feel(group, node, tables)
        if node == CHEBYSHEV_NODE_COUNT // 2:
            spread = length
    n, matrices = CHEBYSHEV_NODE_COUNT, tables.contraction_matrices
    first, last = math.cos(math.pi * 0.5 / n), math.cos(math.pi * (n - 0.5) / n)
    linear = worst = 0.0
    for i in range(k):
        for j in range(k):
            slope = (matrices[0, i, j] - matrices[n - 1, i, j]) / (first - last)
            linear += slope * slope
            tables.reduced_jacobian[i, j] = slope
    for node in range(CHEBYSHEV_NODE_COUNT):
        x = math.cos(math.pi * (node + 0.5) / CHEBYSHEV_NODE_COUNT)
        total = 0.0
        for i in range(k):
            for j in range(k):
                total += (tables.contraction_matrices[node, i, j] - x * tables.reduced_jacobian[i, j]) ** 2
        worst = max(worst, total)
    factor = math.sqrt(linear) + LEBESGUE_CONSTANT * math.sqrt(worst)
    screw_change = deviation = 0.0
    for loop in range(len(tables.column_sums)):
        grown, wander = math.exp(tables.turn_sums[loop]) * tables.column_sums[loop], tables.wander_sums[loop]
        screw_change += (grown * wander) ** 2
        deviation += 25.0 * wander * wander
        tables.column_sums[loop] = grown
    opening += math.sqrt(deviation)
    if opening > MAX_LOOP_DEVIATION:
        return math.inf
    # J V^T is S^-1 (1 + D), no more than 1.5 of what it is in the middle where the factor is 1/2; the rest is rounding
    factor += strength * (math.sqrt(screw_change) + 2.0 * spread * opening)
    total = 0.0
    for loop in range(len(tables.column_sums)):
        total += tables.column_sums[loop] ** 2
    factor += strength * math.sqrt(total) * 4.0 * rounding
    remainder = math.inf
    for g in (8.0, 16.0, 32.0, 64.0):
        if _turns(group, 0.5 * (g + 1.0 / g), tables) < 50.0:
            total = 0.0
            for loop in range(len(tables.turn_sums)):
                total += (math.exp(tables.turn_sums[loop]) * tables.column_sums[loop]) ** 2
            bound = math.sqrt(1.0 * k) + strength * math.sqrt(total)
            remainder = min(remainder, 4.0 * bound * g ** (1 - CHEBYSHEV_NODE_COUNT) / (g - 1.0))
    return factor + remainder


@compiled
def _feel(group: Group, node: int, tables: PieceTables) -> float:
    """Write S J V^T - 1 at a node; return the norm of J V^T."""
    k, r = tables.scaling.shape
    reduced = tables.reduced_jacobian
    reduced[:] = 0.0
    for loop in range(len(tables.lengths)):
        row = 6 * loop
        for place in range(group.starts[loop], group.starts[loop + 1]):
            h = group.hinges[place]
            for i in range(6):
                value = tables.screws[node, place, i]
                for j in range(k):
                    reduced[row + i, j] += value * tables.basis[j, h]
    total = 0.0
    for i in range(r):
        for j in range(k):
            total += reduced[i, j] ** 2
    for i in range(k):
        for j in range(k):
            value = -1.0 if i == j else 0.0
            for row in range(r):
                value += tables.scaling[i, row] * reduced[row, j]
            tables.contraction_matrices[node, i, j] = value
    return math.sqrt(total)
