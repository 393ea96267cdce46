"""Closed states of a linkage: projection onto the nearest one within the stops, and the closure Jacobian there.

Screws of hinges that turn about parallel lines, or about one line, generate a group of fewer dimensions than that of
all motions (docs/explanation/motion.md, 8): closure is as many equations as that group has dimensions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, WholeNumbers
from hcsearch.kernels.algebra import divide_row, row_product, subtract_row
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import Chain, close_loops, weigh_rows

PLANNING_CLOSURE_RESIDUAL = 1e-10
"""Closure residual (rad, or gap over size) of a closed state."""
STOPPED_HINGE_ANGLE = 1e-9
"""A hinge within this distance of a stop (rad) is at the stop."""
REDUNDANT_SINGULAR_VALUE = 1e-9
"""Singular values of the closure Jacobian up to this count as zeros."""
CLOSING_DAMPING = 1e-13
"""Damping of the closure equations, which keeps those of redundant loops solvable."""


class Loops(NamedTuple):
    """The loops of a linkage, see `kernels.linkage.loops`.

    size : m, of the pattern.
    """

    chain: Chain
    starts: WholeNumbers
    hinges: WholeNumbers
    signs: WholeNumbers
    size: float


class Closing(NamedTuple):
    """Work tables of one Gauss-Newton step.

    residual (r,), jacobian (r, m), gram (r, r) and right_side (r,) : of the equations of a step. basis : (r, m),
    orthonormal rows that span those of the Jacobian. pose : (3, 4), the pose at the end of a walk along a loop. held :
    (m,), hinges that stay at a stop. fixed : (m,), hinges that do not turn at all; none in a new table.
    """

    residual: Reals
    jacobian: Reals
    gram: Reals
    right_side: Reals
    basis: Reals
    pose: Reals
    held: Flags
    fixed: Flags


@compiled
def new_closing(loops: Loops) -> Closing:
    """Return empty tables."""
    m, r = len(loops.chain.points), 6 * (len(loops.starts) - 1)
    rows, gram, basis = np.zeros((r, m)), np.zeros((r, r)), np.zeros((r, m))
    held, fixed = np.zeros(m, np.bool_), np.zeros(m, np.bool_)
    return Closing(np.zeros(r), rows, gram, np.zeros(r), basis, np.zeros((3, 4)), held, fixed)


@compiled
def write_closure(loops: Loops, angles: Reals, residual: Reals, jacobian: Reals, pose: Reals) -> None:
    """Write closure residuals and their Jacobian, as `close_loops` does; pose : (3, 4), room for the pose of a walk."""
    lines, size = loops.chain, loops.size
    starts, hinges, signs = loops.starts, loops.hinges, loops.signs
    close_loops(lines.directions, lines.points, starts, hinges, signs, angles, size, residual, jacobian, pose)


@compiled
def largest_closure_residual(loops: Loops, angles: Reals, work: Closing) -> float:
    """Return the greatest closure residual; write all residuals and the Jacobian."""
    write_closure(loops, angles, work.residual, work.jacobian, work.pose)
    worst = 0.0
    for i in range(len(work.residual)):
        worst = max(worst, abs(work.residual[i]))
    return worst


@compiled
def close_state(loops: Loops, angles: Reals, tolerance: float, overshoot: float, steps: int, work: Closing) -> bool:
    """Move fold angles to the nearest closed state within the stops; return whether that state is closed.

    overshoot : rad, by which hinges may be beyond a stop. Damped Gauss-Newton steps of least length. Hinges that a step
    would take further beyond stay at that limit.
    """
    m = len(angles)
    for h in range(m):
        work.held[h] = work.fixed[h]
        if work.fixed[h]:
            continue
        angles[h] = min(max(angles[h], -overshoot), math.pi + overshoot)
    for _ in range(steps):
        worst = largest_closure_residual(loops, angles, work)
        if worst < tolerance:
            return True
        if not worst < 1.0:
            return False
        for h in range(m):
            for i in range(len(work.residual) if work.held[h] else 0):
                work.jacobian[i, h] = 0.0
        if not weigh_rows(work.jacobian, work.residual, CLOSING_DAMPING, work.gram, work.right_side):
            return False
        for h in range(m):
            if work.held[h]:
                continue
            for i in range(len(work.right_side)):
                angles[h] -= work.jacobian[i, h] * work.right_side[i]
            if not -overshoot <= angles[h] <= math.pi + overshoot:
                angles[h] = min(max(angles[h], -overshoot), math.pi + overshoot)
                work.held[h] = True
    return largest_closure_residual(loops, angles, work) < tolerance


@compiled
def write_closure_basis(work: Closing, zero_singular_value: float) -> int:
    """Write orthonormal rows that span those of the Jacobian; return how many there are.

    Gram-Schmidt orthogonalization, done twice, with the longest row first; rows no longer than `zero_singular_value`
    count as zero.
    """
    r, m = work.jacobian.shape
    basis = work.basis
    for i in range(r):
        for h in range(m):
            basis[i, h] = work.jacobian[i, h]
    for rank in range(r):
        best, longest_square = rank, 0.0
        for i in range(rank, r):
            squared_length = row_product(basis, i, basis, i, m)
            if squared_length > longest_square:
                best, longest_square = i, squared_length
        if math.sqrt(longest_square) <= zero_singular_value:
            return rank
        for h in range(m):
            basis[rank, h], basis[best, h] = basis[best, h], basis[rank, h]
        for again in range(2):
            for j in range(rank if again else 0):
                subtract_row(basis, rank, row_product(basis, rank, basis, j, m), basis, j, m)
            divide_row(basis, rank, math.sqrt(row_product(basis, rank, basis, rank, m)), m)
        for i in range(rank + 1, r):
            subtract_row(basis, i, row_product(basis, i, basis, rank, m), basis, rank, m)
    return int(r)


@compiled
def remove_span(basis: Reals, rank: int, table: Reals, row: int) -> None:
    """Remove from a row of a table its component in the span of a basis."""
    m = basis.shape[1]
    for j in range(rank):
        subtract_row(table, row, row_product(table, row, basis, j, m), basis, j, m)


@compiled
def keep_closed(loops: Loops, angles: Reals, table: Reals, row: int, work: Closing) -> None:
    """Project a rate, a row of a table, onto the rates that keep loops closed and turn no hinge that is at a stop."""
    largest_closure_residual(loops, angles, work)
    for h in range(len(angles)):
        if work.fixed[h] or angles[h] < STOPPED_HINGE_ANGLE or angles[h] > math.pi - STOPPED_HINGE_ANGLE:
            table[row, h] = 0.0
            for i in range(len(work.residual)):
                work.jacobian[i, h] = 0.0
    rank = write_closure_basis(work, REDUNDANT_SINGULAR_VALUE)
    for _ in range(2):
        remove_span(work.basis, rank, table, row)


class Group(NamedTuple):
    """The hinges that turn, and the equations by which their loops close.

    rows : (k, 6 n_loops), orthonormal: the part of the twists of T - 1 that is to vanish. moving : (m,), whether a
    hinge turns. starts, hinges : the hinges that turn, of each loop in order, in the format of `Loops`.
    """

    rows: Reals
    moving: Flags
    starts: WholeNumbers
    hinges: WholeNumbers
