"""Impacts at unilateral stops, and the stops that keep holding afterwards (a cone complementarity problem).

Velocities and accelerations are represented in the space of the recursion's innovations, where the inertia is the
identity: y_i = (s_i + U_i . a_i) / sqrt(d_i). There the nearest admissible vector is a least-distance problem with
inequalities, solved by nonnegative least squares (Lawson and Hanson 1974, chapter 23): Gauss's principle of least
constraint. The solution is unique even where the forces at redundant stops are not.
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals, Signs
from hcsearch.kernels.algebra import divide_row, dot, row_product, subtract_row, vector_at
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.cones import nonnegative_least_squares
from hcsearch.kernels.multibody.accelerations import DiscreteState, Mechanism, accelerate, project_state
from hcsearch.kernels.multibody.events import NEAR_STOP_ANGLE
from hcsearch.kernels.multibody.hinges import joint_momenta, kinetic_energy
from hcsearch.kernels.multibody.sweeps import (
    carried_motion,
    carry_body,
    gather_inertias,
    load_joints,
    move_bodies,
    place_bodies,
    release_joints,
)
from hcsearch.kernels.multibody.tree import (
    LINK_FIRST_SLOT,
    LINK_LAST_SLOT,
    SLOT_ROW,
    WORK_ALONG,
    WORK_DRIVE,
    WORK_HEAD_COUPLE,
    WORK_HEAD_FORCE,
    WORK_SLOT_POWER,
    BodyTree,
    Work,
)
from hcsearch.kernels.multibody.welds import MIN_ROW_PIVOT_SHARE, choose_rows, close_rows, factor_chosen_rows

MIN_STOP_MOBILITY = 1e-4
"""A joint counts as held by the loops, not by its stop, if its mobility is less than this share of that without loops;
stops are compliant by this share, so that nearly immobile joints do not require impossible forces."""


@compiled
def closure_basis(tree: BodyTree, scale: float, work: Work, rows: Reals, squares: Reals) -> int:
    """Write an orthonormal basis of the closure rows in innovation space; return its size; after `gather_inertias`."""
    n, m = len(tree.links), len(tree.rows)
    for i in range(n):
        for slot in range(tree.links[i, LINK_FIRST_SLOT], tree.links[i, LINK_LAST_SLOT]):
            root = math.sqrt(work.bodies[i, WORK_ALONG])
            rows[tree.slots[slot, SLOT_ROW], i] = work.slots[slot, WORK_SLOT_POWER] / root
    for r in range(m):
        squares[r] = row_product(rows, r, rows, r, n)
    for count in range(m):
        best = count
        for r in range(count, m):
            if squares[r] > squares[best]:
                best = r
        if squares[best] <= MIN_ROW_PIVOT_SHARE * scale:
            return count
        for k in range(n):
            rows[count, k], rows[best, k] = rows[best, k], rows[count, k]
        squares[best] = squares[count]
        for _ in range(2):  # twice is enough
            for j in range(count):
                subtract_row(rows, count, row_product(rows, j, rows, count, n), rows, j, n)
        divide_row(rows, count, math.sqrt(row_product(rows, count, rows, count, n)), n)
        for r in range(count + 1, m):
            subtract_row(rows, r, row_product(rows, count, rows, r, n), rows, count, n)
            squares[r] = row_product(rows, r, rows, r, n)
    return m


@compiled
def write_response(basis: Reals, count: int, work: Work, columns: Reals, k: int) -> float:
    """Write the response to the impulse of `load_joints` in innovation space, over its length without loops, to row k.

    Returns that length. basis : its first `count` rows are those of `closure_basis`.
    """
    n = len(work.bodies)
    for j in range(n):
        columns[k, j] = work.bodies[j, WORK_DRIVE] / math.sqrt(work.bodies[j, WORK_ALONG])
    length = math.sqrt(row_product(columns, k, columns, k, n))
    for _ in range(2):
        for row in range(count):
            subtract_row(columns, k, row_product(basis, row, columns, k, n), basis, row, n)
    divide_row(columns, k, length, n)
    return length


@compiled
def push_apart(
    tree: BodyTree, touching: Signs, needed: Reals, scale: float, work: Work, pushed: Reals, change: Reals
) -> bool:
    """Write the least change of velocities (or accelerations) that moves touching joints off their stops as required.

    Returns False, with a change of 0, where rounding hides the solution. Call `gather_inertias` first, with all joints
    free.

    touching : (n,), -1 at the lower stop, where the coordinate may only grow, 1 at the upper, 0 elsewhere.
    needed : (n,), least change away from the stop. scale : as of `choose_rows`. change : (n,), written for all joints.
    pushed : (n,), written, not 0 where a stop pushes.
    """
    n, m = len(touching), len(tree.rows)
    free = np.zeros(n, np.int8)
    basis = np.zeros((m, n))
    count = closure_basis(tree, scale, work, basis, np.empty(m))
    contacts = np.flatnonzero(touching)
    columns = np.zeros((len(contacts), n + len(contacts) + 1))
    lengths = np.empty(len(contacts))
    impulse = np.zeros(n)
    change[:] = 0.0
    pushed[:] = 0.0
    greatest = 0.0
    for k in range(len(contacts)):
        i = contacts[k]
        impulse[i] = -1.0 if touching[i] > 0 else 1.0
        load_joints(tree, free, impulse, False, work)
        impulse[i] = 0.0
        lengths[k] = write_response(basis, count, work, columns, k)
        columns[k, n + k] = MIN_STOP_MOBILITY
        greatest = max(greatest, abs(needed[i]) / lengths[k])
    if greatest == 0.0:
        return True
    sizes = np.empty(len(contacts))
    height = n + len(contacts) + 1
    for k in range(len(contacts)):
        columns[k, height - 1] = needed[contacts[k]] / lengths[k] / greatest
        sizes[k] = math.sqrt(row_product(columns, k, columns, k, height))
        divide_row(columns, k, sizes[k], height)
    target = np.zeros(height)
    target[height - 1] = 1.0
    weights, residual = np.zeros(len(contacts)), np.empty(height)
    nonnegative_least_squares(columns, target, weights, residual)
    if residual[height - 1] <= 1e-12:
        return False
    innovations = np.empty(n)
    for j in range(n):
        innovations[j] = -residual[j] / residual[height - 1] * greatest
    for k in range(len(contacts)):
        # a joint that its stop could hardly move is held by the loops
        mobility = 0.0
        for j in range(n):
            mobility += (columns[k, j] * sizes[k]) ** 2
        if weights[k] > 0.0 and mobility > MIN_STOP_MOBILITY**2:
            pushed[contacts[k]] = weights[k]
    _write_rates(tree, innovations, work, change)
    return True


@compiled
def _write_rates(tree: BodyTree, innovations: Reals, work: Work, rates: Reals) -> None:
    """Write joint velocities from their innovations, as `sweeps.release_joints` does from forces."""
    b = work.bodies
    for i in range(len(tree.links)):
        turn, shift = carried_motion(tree, i, (0.0, 0.0, 0.0), work)
        root = math.sqrt(b[i, WORK_ALONG])
        carried = (dot(vector_at(b, i, WORK_HEAD_COUPLE), turn) + dot(vector_at(b, i, WORK_HEAD_FORCE), shift)) / root
        rates[i] = (innovations[i] - carried) / root
        carry_body(tree, i, rates[i], turn, shift, work)


@compiled
def find_touching(mechanism: Mechanism, q: Reals, touching: Signs) -> bool:
    """Write -1 for joints at their lower stops, 1 at their upper ones, else 0; return whether any is at a stop."""
    hinges = mechanism.hinges
    any_touching = False
    for i in range(len(q)):
        touching[i] = 0
        if hinges.stop_stiffness == 0.0:
            if q[i] <= hinges.lower[i] + NEAR_STOP_ANGLE:
                touching[i] = -1
            elif q[i] >= hinges.upper[i] - NEAR_STOP_ANGLE:
                touching[i] = 1
        any_touching = any_touching or touching[i] != 0
    return any_touching


@compiled
def update_held_joints(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, v: Reals, scale: float, work: Work, a: Reals
) -> bool:
    """Update the set of joints held at their stops, and the accelerations; return whether the set has changed.

    slow : speed (rad/s) below which a joint at its stop is at rest.
    """
    n = len(q)
    touching = np.empty(n, np.int8)
    any_touching = find_touching(mechanism, q, touching)
    held_before = hold.held.copy()
    hold.held[:] = 0
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    if not any_touching:
        return bool(held_before.any())
    needed = np.zeros(n)
    largest = 0.0
    for i in range(n):
        if abs(v[i]) > slow:
            touching[i] = 0
        needed[i] = touching[i] * a[i]
        largest = max(largest, abs(a[i]))
    pushed, change = np.empty(n), np.empty(n)
    is_solved = push_apart(mechanism.tree, touching, needed, scale, work, pushed, change)
    changed, creeping = False, False
    for i in range(n):
        # a joint at rest without contact force or acceleration stays held, so that rounding does not decide
        stays_at_rest = abs(a[i] + change[i]) <= 1e-9 * largest
        if touching[i] and (not is_solved or pushed[i] > 0.0 or stays_at_rest):
            hold.held[i] = touching[i]
            creeping = creeping or v[i] != 0.0
            q[i] = mechanism.hinges.lower[i] if touching[i] < 0 else mechanism.hinges.upper[i]
        changed = changed or hold.held[i] != held_before[i]
    if creeping and not mechanism.overdamped:
        place_bodies(mechanism.tree, q, work)
        arrest_joints(mechanism, hold, v, scale, work)
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    return changed


@compiled
def collide_joints(
    mechanism: Mechanism,
    hold: DiscreteState,
    restitution: float,
    slow: float,
    q: Reals,
    v: Reals,
    scale: float,
    closed: float,
    work: Work,
) -> None:
    """Apply impacts to all joints that move against their stops (Newton's law of impact in Moreau's form).

    restitution : 0 to 1. slow : speed (rad/s) below which nothing bounces, so that joints that knock each other off
        their stops, ever more slowly, come to rest together.
    """
    n = len(q)
    touching = np.empty(n, np.int8)
    if not find_touching(mechanism, q, touching):
        return
    needed, velocities_before = np.zeros(n), v.copy()
    fastest = 0.0
    for i in range(n):
        if touching[i]:
            q[i] = mechanism.hinges.lower[i] if touching[i] < 0 else mechanism.hinges.upper[i]
            speed = touching[i] * v[i]  # against the stop
            fastest = max(fastest, speed)
            needed[i] = (1.0 + restitution) * speed if speed > slow else speed
    hold.held[:] = 0
    place_bodies(mechanism.tree, q, work)
    if fastest > slow:
        pushed, change = np.empty(n), np.empty(n)
        gather_inertias(mechanism.tree, hold.held, work)
        is_solved = push_apart(mechanism.tree, touching, needed, scale, work, pushed, change)
        for i in range(n):
            v[i] += change[i]
            if touching[i] and abs(v[i]) <= 1e-9 * fastest:
                v[i] = 0.0
        # half the change and the mean velocity are orthogonal at most: no impact adds energy
        if is_solved and _squared_norm(mechanism, change, work) <= 4.0 * _squared_norm(
            mechanism, velocities_before, work
        ) * (1.0 + 1e-6):
            return
        v[:] = velocities_before
    for i in range(n):
        if touching[i] and touching[i] * v[i] >= -slow:
            hold.held[i] = touching[i]
    arrest_joints(mechanism, hold, v, scale, work)
    project_state(mechanism.tree, hold.held, q, v, closed, work)


@compiled
def arrest_joints(mechanism: Mechanism, hold: DiscreteState, v: Reals, scale: float, work: Work) -> None:
    """Project velocities, in the kinetic metric, onto held joints at rest and closed loops; after `place_bodies`."""
    n = len(v)
    tree, held = mechanism.tree, hold.held
    momenta = np.empty(n)
    move_bodies(tree, v, work)
    joint_momenta(tree, work, momenta)
    gather_inertias(tree, held, work)
    choose_rows(work, scale)
    factor_chosen_rows(work, scale)
    load_joints(tree, held, momenta, False, work)
    close_rows(work, work.rates)
    release_joints(tree, held, False, work, v)
    for i in range(n):
        if held[i]:
            v[i] = 0.0


@compiled
def _squared_norm(mechanism: Mechanism, v: Reals, work: Work) -> float:
    """Return twice the kinetic energy of joint velocities; call `place_bodies` first."""
    move_bodies(mechanism.tree, v, work)
    return 2.0 * kinetic_energy(mechanism.tree, work)
