"""A piece of a motion whose loops are nearly closed: a ball beside each of its states holds just one closed state.

With screws J_k of the hinges at a state c, seen from the first panel of a loop, folding by d more closes the loop to
T(c + d) = exp(d_1 J_1) ... exp(d_m J_m) T(c), exactly. So how far screws change in a piece is bounded by norms, without
sampling (docs/explanation/motion.md). At the middle of a piece S J has orthonormal rows, V; a closed state beside a
state x of the piece is x + V^T y, where y = y - S F(x + V^T y), F the twist of T - 1. That map is a contraction of a
ball, so there is one such y, and it changes continuously along the piece (Newton and Kantorovich's theorem). Rounding
is added to what is computed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.algebra.rows import row_product, subtract_row
from hcsearch.kernels.algebra.vectors import Vector, cross
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import fold_on
from hcsearch.kernels.planning.closing import Loops, write_closure
from hcsearch.typing import Reals, Whole

CONTRACTION = 0.5
"""Greatest factor of a contraction that is asked for: the ball is then twice the Newton step."""
NODES = 9
"""Places of a piece at which its loops are computed (Chebyshev's)."""
LEBESGUE = 2.0 / math.pi * math.log(NODES) + 1.0
"""What an interpolation through them may exceed their values by."""
ROUNDING = 4e-15
"""Error of T of a loop for each of its hinges, over 1 and the distance of hinges: a product of rotations is a sum of
three products of two entries, each known to a few units in the last place, as the hinges' places are."""

CENTRED = 6
"""How often the middle of a loop is brought nearer to its lines: one that is far off them makes bounds loose."""


class Tables(NamedTuple):
    """Tables of one piece.

    jacobian, basis : (r, m), screws about the middle of each loop, and orthonormal rows V of the same span. scaling :
    (r, r), S. residual : (r,). middles : (n_loops, 3) and lengths : (n_loops,), of the axes that screws are given in.
    norms : (n_loops, m), what those of J_k, as a matrix, and of ad(J_k) do not exceed. about : (m, 4), the course about
    the middle of the piece. angles : (m,). poses : (n_loops, 3, 4). far : (m,), what angles change by at most.
    beside : (m,), what those of closed states wander by. past, turned : (6, r), see `_contraction`.
    """

    jacobian: Reals
    basis: Reals
    scaling: Reals
    residual: Reals
    middles: Reals
    lengths: Reals
    norms: Reals
    about: Reals
    angles: Reals
    poses: Reals
    far: Reals
    beside: Reals
    past: Reals
    turned: Reals


@compiled
def tables_for(loops: Loops) -> Tables:
    """Empty tables."""
    m, count = len(loops.chain.points), len(loops.starts) - 1
    r = 6 * count
    return Tables(
        np.zeros((r, m)),
        np.zeros((r, m)),
        np.zeros((r, r)),
        np.zeros(r),
        np.zeros((count, 3)),
        np.zeros(count),
        np.zeros((count, m)),
        np.zeros((m, 4)),
        np.zeros(m),
        np.zeros((max(count, 1), 3, 4)),  # the first also serves the walks of `close_loops`
        np.zeros(m),
        np.zeros(m),
        np.zeros((6, r)),
        np.zeros((6, r)),
    )


@lean
def prove_piece(
    loops: Loops, course: Reals, shares: tuple[float, float], joined: Reals, tables: Tables
) -> tuple[float, float]:
    """The factor of the contraction in a piece, infinite without one, and what its closed states wander by (rad).

    joined : (m,), what those of the piece before, or of the end, wander by. States of both are joined where the pieces
    meet: F is 0 at both ends of the straight way between them, so that between it is at most an eighth of its second
    derivative there; closed states lie beside that way, off by no more than `bow`. The norms of screws grow by no more
    than e within `far`: hence the 3, and the 0.75, which is 2 e / 8 and a tenth.
    """
    low, high = shares
    _shift(course, 0.5 * (low + high), 0.5 * (high - low), tables.about)
    for h in range(len(tables.angles)):
        tables.angles[h] = tables.about[h, 0]
    most = _screws(loops, tables)
    strength = _scale(tables)
    if not math.isfinite(strength):
        return math.inf, math.inf
    newton, off = _opening(loops, strength, most, tables)
    radius = newton / (1.0 - CONTRACTION)
    wander = total = other = 0.0
    for h in range(len(tables.far)):
        column = 0.0
        for i in range(len(tables.basis)):
            column += tables.basis[i, h] ** 2
        tables.beside[h] = math.sqrt(column) * radius
        wander += tables.beside[h]
        other += joined[h]
    total = wander + other
    bow = 0.75 * math.sqrt(len(tables.lengths)) * strength * (most * total) ** 2
    for h in range(len(tables.far)):
        about = tables.about
        tables.beside[h] += bow
        tables.far[h] = abs(about[h, 1]) + abs(about[h, 2]) + abs(about[h, 3]) + tables.beside[h] + joined[h]
    wander = max(wander, other) + len(tables.far) * bow
    if most * (total + wander) > 0.1:
        return math.inf, math.inf
    # what T differs from 1 by at states of the tube; on the way between two closed states it is of second order
    off += 3.0 * most * wander + (most * total) ** 2
    return _contraction(loops, strength, off, tables), wander


@lean
def _shift(course: Reals, centre: float, half: float, about: Reals) -> None:
    """Write cubics about the centre of a piece, in the share of half its length."""
    for h in range(len(course)):
        a, b, c, d = course[h, 0], course[h, 1], course[h, 2], course[h, 3]
        about[h, 0] = a + centre * (b + centre * (c + centre * d))
        about[h, 1] = half * (b + centre * (2.0 * c + 3.0 * centre * d))
        about[h, 2] = half * half * (c + 3.0 * centre * d)
        about[h, 3] = half**3 * d


@lean
def _screws(loops: Loops, tables: Tables) -> float:
    """Write the screws at the angles, about the middle of each loop in its own unit of length; their greatest norm."""
    write_closure(loops, tables.angles, tables.residual, tables.jacobian, tables.poses[0])
    tables.norms[:] = 0.0
    most = 0.0
    for loop in range(len(loops.starts) - 1):
        hinges = loops.hinges[loops.starts[loop] : loops.starts[loop + 1]]
        tables.lengths[loop] = centre(tables.jacobian, 6 * loop, hinges, tables.middles[loop], tables.norms[loop])
        for h in hinges:
            most = max(most, tables.norms[loop, h])
    return most


@lean
def centre(jacobian: Reals, row: int, hinges: Whole, middle: Reals, norms: Reals) -> float:
    """Write the screws of a loop, six rows from one on, about its middle and in its own unit of length, returned.

    That is the root of their mean square moment. hinges : of the loop. middle : (3,), and norms : (m,), of the hinges
    of the loop, as in `Tables`, written.
    """
    count = len(hinges)
    middle[:] = 0.0
    for _ in range(CENTRED):
        _move_middle(jacobian, row, hinges, middle)
    total = 0.0
    for h in hinges:
        for i in range(3):
            total += jacobian[row + 3 + i, h] ** 2 / count
    length = max(math.sqrt(total), 1e-3)
    for h in hinges:
        moment = 0.0
        for i in range(3):
            jacobian[row + 3 + i, h] /= length
            moment += jacobian[row + 3 + i, h] ** 2
        norms[h] = 1.5 + math.sqrt(moment)
    return length


@lean
def _move_middle(jacobian: Reals, row: int, hinges: Whole, middle: Reals) -> None:
    """Move the middle of a loop to the mean of the points of its lines that are nearest to it."""
    count = len(hinges)
    x = y = z = 0.0
    for h in hinges:
        foot = cross(_part(jacobian, row, h), _part(jacobian, row + 3, h))
        x, y, z = x + foot[0] / count, y + foot[1] / count, z + foot[2] / count
    for h in hinges:
        moved = cross((x, y, z), _part(jacobian, row, h))
        for i in range(3):
            jacobian[row + 3 + i, h] -= moved[i]
    middle[0] += x
    middle[1] += y
    middle[2] += z


@lean
def _part(jacobian: Reals, row: int, h: int) -> Vector:
    """Three entries of a column from a row on."""
    return jacobian[row, h], jacobian[row + 1, h], jacobian[row + 2, h]


@lean
def _scale(tables: Tables) -> float:
    """Write S and V with S J = V, orthonormal rows, by Gram and Schmidt's; the norm of S, infinite without one."""
    basis, scaling = tables.basis, tables.scaling
    r, m = basis.shape
    for i in range(r):
        for h in range(m):
            basis[i, h] = tables.jacobian[i, h]
        for j in range(r):
            scaling[i, j] = 1.0 if i == j else 0.0
        for _ in range(2):
            for j in range(i):
                part = row_product(basis, i, basis, j, m)
                subtract_row(basis, i, part, basis, j, m)
                subtract_row(scaling, i, part, scaling, j, r)
        long = math.sqrt(row_product(basis, i, basis, i, m))
        if long < 1e-13:
            return math.inf
        for h in range(m):
            basis[i, h] /= long
        for j in range(r):
            scaling[i, j] /= long
    total = 0.0
    for i in range(r):
        total += row_product(scaling, i, scaling, i, r)
    return math.sqrt(total)


@lean
def _opening(loops: Loops, strength: float, most: float, tables: Tables) -> tuple[float, float]:
    """What a Newton step is not longer than in the piece (rad), and what loops are open by (rad, in their own unit).

    T - 1 is entire in the share of the piece, so that its interpolation at Chebyshev's nodes is off by no more than
    4 M g^-n / (g - 1), with M its bound on an ellipse whose half axes sum to g (Trefethen, Approximation Theory and
    Approximation Practice, theorem 8.2).
    """
    newton = off = 0.0
    r, m = tables.jacobian.shape
    for node in range(NODES):
        x = math.cos(math.pi * (node + 0.5) / NODES)
        for h in range(m):
            c = tables.about[h]
            tables.angles[h] = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
        worst = _twists(loops, tables)
        off = max(off, worst)
        total = 0.0
        for i in range(r):
            step = 0.0
            for j in range(r):
                step += tables.scaling[i, j] * tables.residual[j]
            total += step * step
        newton = max(newton, math.sqrt(total))
    least = math.inf
    for g in (8.0, 16.0, 32.0, 64.0):
        z = 0.5 * (g + 1.0 / g)
        bound = 0.0
        for loop in range(len(loops.starts) - 1):
            total = 0.0
            for h in range(m):
                c = tables.about[h]
                total += tables.norms[loop, h] * z * (abs(c[1]) + z * (abs(c[2]) + z * abs(c[3])))
            bound += (math.exp(total) * (1.0 + off) - 1.0) ** 2 if total < 50.0 else math.inf
        least = min(least, 4.0 * math.sqrt(bound) * g ** (1 - NODES) / (g - 1.0))
    reach = 0.0
    for h in range(m):
        point = loops.chain.points[h]
        reach = max(reach, math.sqrt(point[0] ** 2 + point[1] ** 2 + point[2] ** 2))
    rounding = math.sqrt(len(tables.lengths)) * ROUNDING * m
    shortest = math.inf
    for loop in range(len(tables.lengths)):
        shortest = min(shortest, tables.lengths[loop])
    rounding *= 1.0 + most + reach / (loops.size * shortest)
    return LEBESGUE * newton + strength * (least + rounding), LEBESGUE * off + least + rounding


@lean
def _twists(loops: Loops, tables: Tables) -> float:
    """Write the twist of T - 1 of every loop at the angles, about its middle; the norm of all entries of T - 1."""
    total = 0.0
    for loop in range(len(loops.starts) - 1):
        pose = tables.poses[loop]
        pose[:] = 0.0
        pose[0, 0] = pose[1, 1] = pose[2, 2] = 1.0
        for k in range(loops.starts[loop], loops.starts[loop + 1]):
            h = loops.hinges[k]
            fold_on(pose, loops.chain.directions[h], loops.chain.points[h], loops.signs[k] * tables.angles[h])
        row, middle = 6 * loop, tables.middles[loop]
        tables.residual[row] = 0.5 * (pose[2, 1] - pose[1, 2])
        tables.residual[row + 1] = 0.5 * (pose[0, 2] - pose[2, 0])
        tables.residual[row + 2] = 0.5 * (pose[1, 0] - pose[0, 1])
        for i in range(3):
            shift = pose[i, 3] / loops.size - middle[i]
            for j in range(3):
                shift += pose[i, j] * middle[j]
                total += (pose[i, j] - (1.0 if i == j else 0.0)) ** 2
            tables.residual[row + 3 + i] = shift / tables.lengths[loop]
            total += tables.residual[row + 3 + i] ** 2
    return math.sqrt(total)


@lean
def _contraction(loops: Loops, strength: float, off: float, tables: Tables) -> float:
    """What the map shrinks distances by, at all states that differ from the middle by no more than `far`.

    Its derivative is 1 - S (1 + E) J(x) V^T. Of J(x) V^T the part of loop l is, summed by parts over its hinges, J V^T
    and the sum of (W_{k+1} - W_k) P_k, where W_k is Ad of the hinges before k less 1, and P_k the part of J V^T of
    the hinges after k. To first order W_{k+1} - W_k is d_k ad(J_k); the rest is bounded by norms.
    """
    r = len(tables.basis)
    factor = spread = 0.0
    for loop in range(len(loops.starts) - 1):
        row = 6 * loop
        total = 0.0
        for k in range(loops.starts[loop], loops.starts[loop + 1]):
            total += tables.far[loops.hinges[k]] * tables.norms[loop, loops.hinges[k]]
        if total > 1.0:
            return math.inf
        tables.past[:] = 0.0
        for k in range(loops.starts[loop + 1] - 1, loops.starts[loop] - 1, -1):
            h = loops.hinges[k]
            own = tables.far[h] * tables.norms[loop, h]
            total -= own  # of the hinges before
            length = _turn(row, h, tables)
            factor += tables.far[h] * _scaled(row, tables)
            rest = math.expm1(total) * own + math.exp(total) * (math.expm1(own) - own)
            factor += strength * rest * length
            for i in range(6):
                for j in range(r):
                    tables.past[i, j] += tables.jacobian[row + i, h] * tables.basis[j, h]
        for i in range(6):
            for j in range(r):
                spread += tables.past[i, j] ** 2
    # the twist of a screw times T - 1 is no longer than `off` times the screw, of J(x) V^T, which is J V^T and half of
    # it at most; and J, and 1 - S J V^T, are known but for rounding
    m = tables.basis.shape[1]
    return float(factor + strength * math.sqrt(spread) * (3.0 * off + 100.0 * m * 1.2e-16))


@lean
def _turn(row: int, h: int, tables: Tables) -> float:
    """Write ad(J_h) P, of what is summed so far; the norm of P."""
    w = (tables.jacobian[row, h], tables.jacobian[row + 1, h], tables.jacobian[row + 2, h])
    v = (tables.jacobian[row + 3, h], tables.jacobian[row + 4, h], tables.jacobian[row + 5, h])
    past, turned = tables.past, tables.turned
    total = 0.0
    for j in range(past.shape[1]):
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            turned[i, j] = w[a] * past[b, j] - w[b] * past[a, j]
            turned[3 + i, j] = w[a] * past[3 + b, j] - w[b] * past[3 + a, j] + v[a] * past[b, j] - v[b] * past[a, j]
            total += past[i, j] ** 2 + past[3 + i, j] ** 2
    return math.sqrt(total)


@lean
def _scaled(row: int, tables: Tables) -> float:
    """The norm of S times what `_turn` wrote, for a loop whose rows begin at `row`."""
    r = len(tables.scaling)
    total = 0.0
    for i in range(r):
        for j in range(r):
            value = 0.0
            for k in range(6):
                value += tables.scaling[i, row + k] * tables.turned[k, j]
            total += value * value
    return math.sqrt(total)
