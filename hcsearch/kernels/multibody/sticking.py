"""Coulomb friction in joints at rest: which of them stick, and which begin to slide (a box complementarity problem).

A sliding joint has the force -f sign(v). A joint at rest is held while a force within f holds it; at its stop, any
force that pushes off the stop, too. By Gauss's principle the accelerations minimise

    (a - a0)' M (a - a0) / 2 + sum of f_i |a_i| over the joints at rest,  with closed loops and stops,

so that they are unique. The dual problem is for the holding forces, within their bounds (`boxed_quadratics`); its
matrix are the mobilities of the joints at rest with closed loops, from their responses in innovation space (`stops`).
Forces of redundant joints are made unique by a slight compliance. Friction makes no impulses, as its forces are finite.
Proofs: docs/explanation/flight_friction.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, Signs, WholeNumbers
from hcsearch.kernels.algebra import row_product, scalar_product
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.boxed_quadratics import minimise_in_box
from hcsearch.kernels.multibody.accelerations import HELD_BY_FRICTION, DiscreteState, Mechanism, accelerate
from hcsearch.kernels.multibody.hinges import joint_momenta
from hcsearch.kernels.multibody.stops import (
    MIN_STOP_MOBILITY,
    arrest_joints,
    closure_basis,
    find_touching,
    update_held_joints,
    write_response,
)
from hcsearch.kernels.multibody.sweeps import load_joints, place_bodies
from hcsearch.kernels.multibody.tree import BodyTree, Work

REST_SPEED_SHARE = 1e-6
"""A joint is at rest up to this rate, as a share of the speed below which stops do not bounce."""
ALL_AT_REST_SHARE = 1e-4
"""All joints come to rest together where no rate exceeds this share: one after the other they would disturb each other,
as loops tie their rates together."""
SLIDING_SHARE = 1e-9
"""A joint begins to slide where its acceleration, by its mobility, is more than this share of the greatest one that
joints at rest would have without friction; and where it is not due to the compliance of others."""
MAX_PROXIMAL_STEPS = 20
"""Greatest number of solutions in each of which the compliance acts only on the change of forces from the one before,
so that it vanishes; near singular states it takes several."""
RESTING_ACCELERATION_SHARE = 1e-6
"""Nothing moves where no acceleration exceeds this share of the greatest one that there would be without friction."""
CREEP_SHARE = 0.1
"""Ratio of the acceleration due to the compliance to the least one that counts as sliding."""
MAX_ARREST_SHARE = 1e-2
"""Greatest change of rates, in the same share, where a joint comes to rest: at a dead point one joint rests for a
moment, though others move."""


class RestingJoints(NamedTuple):
    """The decision on joints at rest.

    held, slides : (n,), as of `DiscreteState`. forces : (n,), by which joints at rest are held, N m.
    """

    held: Signs
    slides: Signs
    forces: Reals


@compiled
def decide_resting_joints(
    mechanism: Mechanism,
    hold: DiscreteState,
    slow: float,
    q: Reals,
    v: Reals,
    scale: float,
    work: Work,
    resting: RestingJoints,
) -> None:
    """Decide which joints at rest stay there, held by friction or stops, and which way the others begin to slide.

    Joints that neither stick nor slide are held by the loops: friction does no work in them.

    slow : speed (rad/s) below which a joint at its stop is at rest.
    """
    n, hinges = len(q), mechanism.hinges
    touching, a, is_resting = np.empty(n, np.int8), np.empty(n), np.empty(n, np.bool_)
    _find_resting(mechanism, slow, q, v, touching, is_resting, resting)
    hold = DiscreteState(resting.held, hold.branches, hold.cut_branches, resting.slides)
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    joints = np.flatnonzero(is_resting)
    if not len(joints):
        return
    gram, lengths = _mobilities(mechanism.tree, joints, scale, work)
    mobile = np.diag(gram) > MIN_STOP_MOBILITY**2
    lower = np.where(touching[joints] > 0, -math.inf, -hinges.friction[joints]) * lengths
    upper = np.where(touching[joints] < 0, math.inf, hinges.friction[joints]) * lengths
    linear, forces, rates = a[joints] / lengths, np.zeros(len(joints)), np.empty(len(joints))
    least = _bounded_forces(gram, linear, lower, upper, mobile, forces, rates)
    for k in range(len(joints)):
        i = joints[k]
        resting.forces[i] = forces[k] / lengths[k]
        if abs(rates[k]) <= least:
            _hold_joint(i, touching[i], mobile[k], resting)
        elif hinges.friction[i] > 0.0:
            sense = rates[k] if abs(v[i]) <= REST_SPEED_SHARE * slow else v[i]
            resting.slides[i] = 1 if sense > 0.0 else -1
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    least = SLIDING_SHARE * np.abs(linear).max()
    for k in range(len(joints)):
        # the others hold a joint that should begin to slide, but does not: rounding decided
        i = joints[k]
        starts = resting.slides[i] != 0 and abs(v[i]) <= REST_SPEED_SHARE * slow
        if starts and resting.slides[i] * a[i] <= least * lengths[k]:
            _hold_joint(i, touching[i], mobile[k], resting)


@compiled
def _find_resting(
    mechanism: Mechanism,
    slow: float,
    q: Reals,
    v: Reals,
    touching: Signs,
    is_resting: Flags,
    resting: RestingJoints,
) -> None:
    """Write which joints are at rest, and at which stops; free all, and let those slide that do not rest."""
    find_touching(mechanism, q, touching)
    for i in range(len(q)):
        friction = mechanism.hinges.friction[i]
        if abs(v[i]) > slow:
            touching[i] = 0
        is_resting[i] = touching[i] != 0 or (friction > 0.0 and abs(v[i]) <= REST_SPEED_SHARE * slow)
        resting.held[i], resting.slides[i], resting.forces[i] = 0, 0, 0.0
        if friction > 0.0 and not is_resting[i]:
            resting.slides[i] = 1 if v[i] > 0.0 else -1


@compiled
def _hold_joint(i: int, touching: int, mobile: bool, resting: RestingJoints) -> None:
    """Hold a joint at its stop, or by friction unless the loops hold it."""
    resting.slides[i] = 0
    resting.held[i] = touching
    if touching == 0 and mobile:
        resting.held[i] = HELD_BY_FRICTION


@compiled
def _bounded_forces(
    gram: Reals, linear: Reals, lower: Reals, upper: Reals, mobile: Flags, forces: Reals, rates: Reals
) -> float:
    """Write the forces that hold joints at rest within bounds, and the accelerations that they leave, over lengths.

    Returns the least of these that counts as sliding, infinite where no forces are found.

    gram : (k, k), mobilities; overwritten. linear : (k,), accelerations without the forces. mobile : (k,), whether not
    the loops hold the joint.
    """
    compliance, count = MIN_STOP_MOBILITY**2, len(linear)
    largest, creep, before = np.abs(linear).max(), 0.0, np.zeros(count)
    for k in range(count):
        gram[k, k] += compliance
    for _ in range(MAX_PROXIMAL_STEPS):
        before[:] = forces
        if not minimise_in_box(gram, linear - compliance * before, lower, upper, forces):
            return math.inf
        creep = 0.0
        for k in range(count):
            if mobile[k]:
                creep = max(creep, compliance * abs(forces[k] - before[k]))
        if creep <= CREEP_SHARE * SLIDING_SHARE * largest:
            break
    for k in range(count):
        rates[k] = linear[k] - compliance * before[k] + scalar_product(gram[k], forces)
    return float(max(SLIDING_SHARE * largest, creep / CREEP_SHARE))


@compiled
def _mobilities(tree: BodyTree, joints: WholeNumbers, scale: float, work: Work) -> tuple[Reals, Reals]:
    """Return the mobilities of joints with closed loops, (k, k), and their lengths without, (k,).

    The mobilities are those over the lengths of both joints. Call `gather_inertias` first, with all joints free.
    """
    n, count = len(tree.links), len(joints)
    basis, columns, lengths = np.zeros((len(tree.rows), n)), np.empty((count, n)), np.empty(count)
    size = closure_basis(tree, scale, work, basis, np.empty(len(tree.rows)))
    free, impulse = np.zeros(n, np.int8), np.zeros(n)
    for k in range(count):
        impulse[joints[k]] = 1.0
        load_joints(tree, free, impulse, False, work)
        impulse[joints[k]] = 0.0
        lengths[k] = write_response(basis, size, work, columns, k)
    gram = np.empty((count, count))
    for k in range(count):
        for j in range(count):
            gram[k, j] = row_product(columns, k, columns, j, n)
    return gram, lengths


@compiled
def settle_joints(
    mechanism: Mechanism,
    hold: DiscreteState,
    slow: float,
    joint: int,
    q: Reals,
    v: Reals,
    scale: float,
    work: Work,
    a: Reals,
) -> bool:
    """Update the joints that stick, slide, and are held at stops, and the accelerations; return whether they changed.

    joint : that has just come to rest, -1 for none. Others as of `decide_resting_joints`.
    """
    n = len(q)
    if np.abs(v).max() <= ALL_AT_REST_SHARE * slow:
        v[:] = 0.0
    elif joint >= 0:
        _arrest_one(mechanism, hold, slow, joint, q, v, scale, work)
    resting = RestingJoints(np.empty(n, np.int8), np.empty(n, np.int8), np.empty(n))
    decide_resting_joints(mechanism, hold, slow, q, v, scale, work, resting)
    changed, creeping = False, False
    for i in range(n):
        changed = changed or resting.held[i] != hold.held[i] or resting.slides[i] != hold.slides[i]
        hold.held[i], hold.slides[i] = resting.held[i], resting.slides[i]
        creeping = creeping or (hold.held[i] != 0 and v[i] != 0.0)
        if hold.held[i] == -1:
            q[i] = mechanism.hinges.lower[i]
        elif hold.held[i] == 1:
            q[i] = mechanism.hinges.upper[i]
    if creeping:
        place_bodies(mechanism.tree, q, work)
        arrest_joints(mechanism, hold, v, scale, work)
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    return changed


@compiled
def _arrest_one(
    mechanism: Mechanism, hold: DiscreteState, slow: float, joint: int, q: Reals, v: Reals, scale: float, work: Work
) -> None:
    """Set the rate of a joint that comes to rest to 0, and with it those that the loops tie to it.

    Not at a dead point, where the rates of others would have to change.
    """
    before, held_before = v.copy(), hold.held[joint]
    hold.held[joint] = HELD_BY_FRICTION
    place_bodies(mechanism.tree, q, work)
    arrest_joints(mechanism, hold, v, scale, work)
    hold.held[joint] = held_before
    if np.abs(v - before).max() > MAX_ARREST_SHARE * slow:
        v[:] = before


@compiled
def forces_hold(mechanism: Mechanism, hold: DiscreteState, forces: Reals, grip: float) -> bool:
    """Return whether given forces of held joints are such as friction and stops can have, up to a rounding error.

    If not, other forces may still hold them, where joints are redundant. grip : N m.
    """
    for i in range(len(forces)):
        if hold.held[i]:
            pull = abs(forces[i]) if hold.held[i] == HELD_BY_FRICTION else hold.held[i] * forces[i]
            if pull > mechanism.hinges.friction[i] + grip:
                return False
    return True


@compiled
def any_started(mechanism: Mechanism, hold: DiscreteState, slow: float, v: Reals) -> bool:
    """Return whether a joint with friction moves that neither stuck nor slid before, as the loops held it."""
    for i in range(len(hold.slides)):
        is_idle = mechanism.hinges.friction[i] > 0.0 and not hold.held[i] and not hold.slides[i]
        if is_idle and abs(v[i]) > REST_SPEED_SHARE * slow:
            return True
    return False


@compiled
def any_slips(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, v: Reals, scale: float, work: Work
) -> bool:
    """Return whether some held joint cannot be held in a state."""
    n = len(q)
    resting = RestingJoints(np.empty(n, np.int8), np.empty(n, np.int8), np.empty(n))
    decide_resting_joints(mechanism, hold, slow, q, v, scale, work, resting)
    return bool(((hold.held != 0) & (resting.held == 0)).any())


@compiled
def nothing_moves(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, v: Reals, scale: float, work: Work
) -> bool:
    """Return whether no joint slides, and those that are not held are at rest without an acceleration."""
    a = np.empty(len(q))
    for i in range(len(q)):
        if hold.slides[i] or (not hold.held[i] and abs(v[i]) > REST_SPEED_SHARE * slow):
            return False
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    largest = _greatest_free(hold.held, a)
    return largest == 0.0 or largest <= RESTING_ACCELERATION_SHARE * frictionless_acceleration(
        mechanism, hold, slow, q, scale, work
    )


@compiled
def only_creeps(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, rate: float, scale: float, work: Work
) -> bool:
    """Return whether joints, from rest, would not reach a rate, as dampers would slow down any motion so fast.

    Also true where friction holds all joints. Unlike accelerations, it does not depend on the rounding of small rates.
    """
    n = len(q)
    rest = DiscreteState(hold.held.copy(), hold.branches, hold.cut_branches, hold.slides.copy())
    v, a, momenta = np.zeros(n), np.empty(n), np.empty(n)
    settle_joints(mechanism, rest, slow, -1, q.copy(), v, scale, work, a)
    largest = _greatest_free(rest.held, a)
    if largest == 0.0:
        return True
    for i in range(n):
        v[i] = 0.0 if rest.held[i] else rate * a[i] / largest
    accelerate(mechanism, rest, q, v, scale, True, work, a)
    joint_momenta(mechanism.tree, work, momenta)
    power = 0.0  # of kinetic energy
    for i in range(n):
        power += 0.0 if rest.held[i] else momenta[i] * a[i]
    return power <= 0.0


@compiled
def frictionless_acceleration(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, scale: float, work: Work
) -> float:
    """Return the greatest acceleration of a joint from rest without friction."""
    n = len(q)
    free = DiscreteState(np.zeros(n, np.int8), hold.branches, hold.cut_branches, np.zeros(n, np.int8))
    a = np.empty(n)
    update_held_joints(mechanism, free, slow, q.copy(), np.zeros(n), scale, work, a)
    return _greatest_free(free.held, a)


@compiled
def _greatest_free(held: Signs, a: Reals) -> float:
    """Return the greatest acceleration of a joint that is not held."""
    largest = 0.0
    for i in range(len(a)):
        if not held[i]:
            largest = max(largest, abs(a[i]))
    return largest
