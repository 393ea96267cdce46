"""Forces in joints and between bodies: moment-angle laws, dampers, stops, struts and drives; their energies.

A law gives the moment that resists the joint coordinate, as cubics between breaks. A law with a snap has two branches
(thesis 2.4): above `snaps_up` it jumps from the straight branch to the bent one, and below `snaps_down` back.

Drives are position-controlled: a controller computes their targets (angle, rate and torque) once a period. Within a
period each drive interpolates the angle by the cubic through angles and rates at both ends, and the torque linearly; it
acts continuously.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, Signs, WholeNumbers
from hcsearch.kernels.algebra import (
    Vector3,
    add_vector,
    apply_symmetric,
    cross,
    dot,
    put_vector,
    rotated,
    rotated_back,
    scaled_vector,
    symmetric_at,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.tree import (
    BODY_CENTRE,
    BODY_INERTIA,
    BODY_MASS,
    LINK_PARENT,
    LINK_SLIDES,
    WORK_ARM,
    WORK_LINE,
    WORK_PLACE,
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    WORK_SPEED,
    WORK_SPIN,
    BodyTree,
    Work,
)


class Hinges(NamedTuple):
    """Laws, dampers and stops of n joints.

    pieces : (n, 2, 2), first and last piece (exclusive) of the straight and the bent branch.
    breaks : (p,), coordinate at which a piece begins; the first and last pieces extend to infinity. cubics : (p, 4),
        coefficients of 1, x, x^2, x^3, with x from the break. energies : (p,), energy stored at the break.
    snaps_up, snaps_down : (n,), infinite without a snap.
    damping : (n,). lower, upper : (n,), stops, infinite where there is none or it cannot be reached.
    stop_stiffness, stop_damping : of compliant stops; 0 where they are hard.
    friction : (n,), greatest force of Coulomb friction in the joint; no entries where no joint has any.
    ramps : (n, 3), times at which a law begins to act and acts in full, s, and the rate at which it rises during the
        whole simulation, 1/s, or 0; factors : (n,), scratch, of the laws at the time of `set_factors`. Neither has
        entries where all laws always act. Such laws have no snaps.
    """

    pieces: WholeNumbers
    breaks: Reals
    cubics: Reals
    energies: Reals
    snaps_up: Reals
    snaps_down: Reals
    damping: Reals
    lower: Reals
    upper: Reals
    stop_stiffness: float
    stop_damping: float
    friction: Reals
    ramps: Reals
    factors: Reals


class Struts(NamedTuple):
    """Springs with dampers between points of two bodies: k (l - rest) + c l' pulls the points together.

    bodies : (s, 2), -1 the ground. points : (s, 6), from the joints of both bodies.
    stiffness, damping, rests : (s,).
    """

    bodies: WholeNumbers
    points: Reals
    stiffness: Reals
    damping: Reals
    rests: Reals


@compiled
def _law_piece(hinges: Hinges, i: int, branch: int, q: float) -> tuple[int, float]:
    """Return the piece of a joint's law at a coordinate, and the coordinate in it."""
    k, last = hinges.pieces[i, branch]
    while k + 1 < last and hinges.breaks[k + 1] <= q:
        k += 1
    return k, q - hinges.breaks[k]


@compiled
def law_moment(hinges: Hinges, i: int, branch: int, q: float) -> tuple[float, float]:
    """Return the resisting moment of a joint's law at a coordinate, and the energy stored."""
    k, x = _law_piece(hinges, i, branch, q)
    c = hinges.cubics[k]
    value = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
    energy = x * (c[0] + x * (c[1] / 2.0 + x * (c[2] / 3.0 + x * c[3] / 4.0)))
    return value, hinges.energies[k] + energy


@compiled
def law_slope(hinges: Hinges, i: int, branch: int, q: float) -> float:
    """Return the slope of a joint's law at a coordinate, including its compliant stop."""
    k, x = _law_piece(hinges, i, branch, q)
    c = hinges.cubics[k]
    slope: float = c[1] + x * (2.0 * c[2] + x * 3.0 * c[3])
    if len(hinges.factors):
        slope *= hinges.factors[i]
    if hinges.stop_stiffness > 0.0 and (q < hinges.lower[i] or q > hinges.upper[i]):
        slope += hinges.stop_stiffness
    return slope


@compiled
def slope_and_damping(hinges: Hinges, i: int, branch: int, q: float) -> tuple[float, float]:
    """Return stiffness (0 or more) and damping of a joint, as implicit steps take them, with its compliant stop."""
    slope, damping = max(law_slope(hinges, i, branch, q), 0.0), hinges.damping[i]
    if hinges.stop_stiffness > 0.0 and (q < hinges.lower[i] or q > hinges.upper[i]):
        damping += hinges.stop_damping
    return slope, damping


@compiled
def set_factors(hinges: Hinges, time: float) -> None:
    """Set the factors of laws that act from a time on; call before forces and energies at another time."""
    for i in range(len(hinges.factors)):
        begin, end = hinges.ramps[i, 0], hinges.ramps[i, 1]
        if time >= end:
            hinges.factors[i] = 1.0
        else:
            hinges.factors[i] = (time - begin) / (end - begin) if time > begin else 0.0


@compiled
def joint_torques(hinges: Hinges, branches: Signs, q: Reals, v: Reals, torques: Reals) -> None:
    """Write the joint forces of laws, dampers and compliant stops (thesis eqs. 4.20 to 4.22)."""
    for i in range(len(q)):
        value, _ = law_moment(hinges, i, branches[i], q[i])
        if len(hinges.factors):
            value *= hinges.factors[i]
        value += hinges.damping[i] * v[i]
        if hinges.stop_stiffness > 0.0:
            beyond = min(q[i] - hinges.lower[i], 0.0) + max(q[i] - hinges.upper[i], 0.0)
            if beyond != 0.0:
                value += hinges.stop_stiffness * beyond + hinges.stop_damping * v[i]
        torques[i] = -value


@compiled
def add_friction(hinges: Hinges, slides: Signs, torques: Reals) -> None:
    """Add the friction of sliding joints to joint forces; slides : (n,), sign of their rates, 0 where they rest."""
    for i in range(len(hinges.friction)):
        torques[i] -= hinges.friction[i] * slides[i]


@compiled
def friction_power(hinges: Hinges, slides: Signs, v: Reals) -> float:
    """Return the power lost to the friction of sliding joints."""
    power = 0.0
    for i in range(len(hinges.friction)):
        power += hinges.friction[i] * slides[i] * v[i]
    return power


@compiled
def pull_struts(struts: Struts, work: Work) -> None:
    """Add the forces of struts to the external forces on bodies; call `move_bodies` first."""
    b = work.bodies
    for s in range(len(struts.stiffness)):
        line, speed, length = _strut(struts, s, work)
        force = struts.stiffness[s] * (length - struts.rests[s]) + struts.damping[s] * speed
        for side in range(2):
            body = struts.bodies[s, side]
            if body >= 0:
                arm = rotated(b, body, WORK_ROTATION, vector_at(struts.points, s, 3 * side))
                pull = scaled_vector(-force if side else force, line)
                add_vector(b, body, WORK_PULL_COUPLE, cross(arm, pull))
                add_vector(b, body, WORK_PULL_FORCE, pull)


@compiled
def _strut(struts: Struts, s: int, work: Work) -> tuple[Vector3, float, float]:
    """Return the unit direction from a strut's first point to the second, its rate of elongation, and its length."""
    b = work.bodies
    offset, rate = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for side in range(2):
        body = struts.bodies[s, side]
        point, velocity = vector_at(struts.points, s, 3 * side), (0.0, 0.0, 0.0)
        if body >= 0:
            arm = rotated(b, body, WORK_ROTATION, point)
            point = vector_sum(vector_at(b, body, WORK_PLACE), arm)
            velocity = vector_sum(vector_at(b, body, WORK_SPEED), cross(vector_at(b, body, WORK_SPIN), arm))
        offset, rate = vector_difference(point, offset), vector_difference(velocity, rate)
    length = math.sqrt(dot(offset, offset))
    line = scaled_vector(1.0 / length, offset) if length > 0.0 else offset
    return line, dot(line, rate), length


@compiled
def kinetic_energy(tree: BodyTree, work: Work) -> float:
    """Return the kinetic energy, J; call `move_bodies` first."""
    energy = 0.0
    b = work.bodies
    for i in range(len(tree.links)):
        spin = vector_at(b, i, WORK_SPIN)
        arm = rotated(b, i, WORK_ROTATION, vector_at(tree.bodies, i, BODY_CENTRE))
        speed = vector_sum(vector_at(b, i, WORK_SPEED), cross(spin, arm))
        body_spin = rotated_back(b, i, WORK_ROTATION, spin)
        rotational = dot(body_spin, apply_symmetric(symmetric_at(tree.bodies, i, BODY_INERTIA), body_spin))
        energy += 0.5 * (tree.bodies[i, BODY_MASS] * dot(speed, speed) + rotational)
    return energy


@compiled
def joint_momenta(tree: BodyTree, work: Work, momenta: Reals) -> None:
    """Write joint momenta: the mass matrix times the joint velocities; call `move_bodies` first."""
    n = len(tree.links)
    b = work.bodies
    momentum_sums = np.zeros((n, 6))  # angular momentum about the joint, momentum
    for i in range(n):
        spin = vector_at(b, i, WORK_SPIN)
        arm = rotated(b, i, WORK_ROTATION, vector_at(tree.bodies, i, BODY_CENTRE))
        momentum = scaled_vector(tree.bodies[i, BODY_MASS], vector_sum(vector_at(b, i, WORK_SPEED), cross(spin, arm)))
        body_momentum = apply_symmetric(
            symmetric_at(tree.bodies, i, BODY_INERTIA), rotated_back(b, i, WORK_ROTATION, spin)
        )
        put_vector(momentum_sums, i, 0, vector_sum(rotated(b, i, WORK_ROTATION, body_momentum), cross(arm, momentum)))
        put_vector(momentum_sums, i, 3, momentum)
    for i in range(n - 1, -1, -1):
        angular, momentum = vector_at(momentum_sums, i, 0), vector_at(momentum_sums, i, 3)
        momenta[i] = dot(vector_at(b, i, WORK_LINE), momentum if tree.links[i, LINK_SLIDES] else angular)
        p = tree.links[i, LINK_PARENT]
        if p >= 0:
            add_vector(momentum_sums, p, 0, vector_sum(angular, cross(vector_at(b, i, WORK_ARM), momentum)))
            add_vector(momentum_sums, p, 3, momentum)


@compiled
def write_energies(
    tree: BodyTree, hinges: Hinges, struts: Struts, branches: Signs, q: Reals, work: Work, parts: Reals
) -> None:
    """Write kinetic energy, energy of laws and struts, gravitational energy, and energy of compliant stops, (4,).

    Call `move_bodies` first. The sum decreases by `lost_power`, and by the energy lost in snaps and impacts.
    """
    parts[:] = 0.0
    parts[0] = kinetic_energy(tree, work)
    b = work.bodies
    for i in range(len(tree.links)):
        _, stored = law_moment(hinges, i, branches[i], q[i])
        if len(hinges.factors):
            stored *= hinges.factors[i]
        parts[1] += stored
        x, y, z = vector_sum(
            vector_at(b, i, WORK_PLACE), rotated(b, i, WORK_ROTATION, vector_at(tree.bodies, i, BODY_CENTRE))
        )
        height = tree.gravity[0] * x + tree.gravity[1] * y + tree.gravity[2] * z
        parts[2] -= tree.bodies[i, BODY_MASS] * height
        if hinges.stop_stiffness > 0.0:
            beyond = min(q[i] - hinges.lower[i], 0.0) + max(q[i] - hinges.upper[i], 0.0)
            if beyond != 0.0:
                parts[3] += 0.5 * hinges.stop_stiffness * beyond * beyond
    for s in range(len(struts.stiffness)):
        _, _, length = _strut(struts, s, work)
        parts[1] += 0.5 * struts.stiffness[s] * (length - struts.rests[s]) ** 2


@compiled
def lost_power(hinges: Hinges, struts: Struts, q: Reals, v: Reals, work: Work) -> float:
    """Return the power lost in dampers, including those of compliant stops and struts; call `move_bodies` first.

    What makes laws rise gives power: it counts as a negative loss.
    """
    power = 0.0
    for i in range(len(hinges.factors)):
        if hinges.ramps[i, 2] > 0.0:
            _, stored = law_moment(hinges, i, 0, q[i])
            power -= hinges.ramps[i, 2] * stored
    for i in range(len(q)):
        power += hinges.damping[i] * v[i] * v[i]
        if hinges.stop_stiffness > 0.0 and (q[i] < hinges.lower[i] or q[i] > hinges.upper[i]):
            power += hinges.stop_damping * v[i] * v[i]
    for s in range(len(struts.stiffness)):
        _, growth, _ = _strut(struts, s, work)
        power += struts.damping[s] * growth * growth
    return power


TARGET_ANGLE, TARGET_RATE, TARGET_TORQUE = 0, 1, 2
"""Columns of `Work.drive_targets`, one row per drive: rad, rad/s, N m."""


class Targets(NamedTuple):
    """Drives of d joints, and the courses that they follow.

    joints : (d,). stiffness, damping : (d,), torque per error of angle (N m/rad) and of rate (N m s/rad).
    period : of the controller, s. times : (k,), s, from 0. cubics : (k - 1, d, 4), angles between two times as
        coefficients of 1, x, x^2, x^3, with x the time since the first. torques : (k, d), N m, linear in between.
    """

    joints: WholeNumbers
    stiffness: Reals
    damping: Reals
    period: float
    times: Reals
    cubics: Reals
    torques: Reals


@compiled
def no_targets() -> Targets:
    """Return the targets of a mechanism without drives."""
    none = np.zeros(0)
    return Targets(np.zeros(0, np.int64), none, none, 1.0, none, np.zeros((0, 0, 4)), np.zeros((0, 0)))


@compiled
def _piece(times: Reals, time: float) -> int:
    """Return the last piece of a course that begins at or before a time."""
    low, high = 0, len(times) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if times[middle] <= time:
            low = middle
        else:
            high = middle
    return low


@compiled
def _planned(targets: Targets, piece: int, drive: int, time: float) -> tuple[float, float, float]:
    """Return angle, rate and torque of a course at a time; the rate is 0 after its end."""
    first, last = targets.times[piece], targets.times[piece + 1]
    x = min(time, last) - first
    c = targets.cubics[piece, drive]
    angle = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
    rate = 0.0 if time >= last else c[1] + x * (2.0 * c[2] + x * 3.0 * c[3])
    begun, ended = targets.torques[piece, drive], targets.torques[piece + 1, drive]
    return angle, rate, begun + (ended - begun) * x / (last - first)


@compiled
def write_drive_targets(targets: Targets, time: float, work: Work) -> None:
    """Write the targets of all drives at a time, interpolated between two controller updates."""
    if not len(targets.joints):
        return
    h = targets.period
    begun = h * math.floor(time / h)
    first, last = _piece(targets.times, begun), _piece(targets.times, begun + h)
    x = (time - begun) / h
    for d in range(len(targets.joints)):
        q0, v0, t0 = _planned(targets, first, d, begun)
        q1, v1, t1 = _planned(targets, last, d, begun + h)
        rise = q1 - q0
        b, c = 3.0 * rise - h * (2.0 * v0 + v1), h * (v0 + v1) - 2.0 * rise
        work.drive_targets[d, TARGET_ANGLE] = q0 + x * (h * v0 + x * (b + x * c))
        work.drive_targets[d, TARGET_RATE] = v0 + x * (2.0 * b + x * 3.0 * c) / h
        work.drive_targets[d, TARGET_TORQUE] = t0 + x * (t1 - t0)


@compiled
def add_drive_torques(targets: Targets, q: Reals, v: Reals, work: Work, torques: Reals) -> None:
    """Add the torques of drives to joint forces; call `write_drive_targets` first."""
    for d in range(len(targets.joints)):
        torques[targets.joints[d]] += _torque(targets, d, q, v, work)


@compiled
def add_drive_inertia(targets: Targets, g: float, guess: Reals, work: Work) -> None:
    """Add the inertia of drives in an implicit stage to joints, and its forces at guessed accelerations.

    g : the step times the diagonal coefficient, s.
    """
    for d in range(len(targets.joints)):
        i = targets.joints[d]
        ahead = g * (targets.damping[d] + g * targets.stiffness[d])
        work.added_inertia[i] += ahead
        work.torques[i] += ahead * guess[i]


@compiled
def add_drive_torques_ahead(targets: Targets, h: float, q: Reals, v: Reals, work: Work) -> None:
    """The same as `add_drive_torques`, but implicit over a time h, at the end of which the targets were written."""
    for d in range(len(targets.joints)):
        i = targets.joints[d]
        work.added_inertia[i] += h * targets.damping[d] + h * h * targets.stiffness[d]
        work.torques[i] += _torque(targets, d, q, v, work) - h * targets.stiffness[d] * v[i]


@compiled
def driving_power(targets: Targets, q: Reals, v: Reals, work: Work) -> float:
    """Return the power of all drives, W; call `write_drive_targets` first."""
    power = 0.0
    for d in range(len(targets.joints)):
        power += _torque(targets, d, q, v, work) * v[targets.joints[d]]
    return power


@compiled
def _torque(targets: Targets, d: int, q: Reals, v: Reals, work: Work) -> float:
    i, target = targets.joints[d], work.drive_targets[d]
    torque: float = targets.stiffness[d] * (target[TARGET_ANGLE] - q[i]) + targets.damping[d] * (
        target[TARGET_RATE] - v[i]
    )
    return torque + float(target[TARGET_TORQUE])
