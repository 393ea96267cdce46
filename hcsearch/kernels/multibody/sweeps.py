"""Articulated-body recursions: outward for positions and velocities, inward for inertias, outward for accelerations.

Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 7 and 8, in world axes about the joints, so that bodies
far from the origin lose no accuracy. The forces that close loops are carried inward together with the inertias; the
effect of each row's unit force along each joint gives the Delassus matrix as a sum over joints (Rodriguez, Jain and
Kreutz-Delgado 1992). A held joint is skipped in all three recursions: its bodies move as one.
"""

from __future__ import annotations

from hcsearch.basics.array_values import Reals, Signs
from hcsearch.kernels.algebra import (
    Vector3,
    add_symmetric,
    add_vector,
    apply_symmetric,
    cross,
    dot,
    outer_product,
    put_vector,
    rotated,
    rotated_back,
    rotated_symmetric,
    rotation,
    scaled_vector,
    symmetric_at,
    turn_row,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.tree import (
    BODY_AXIS,
    BODY_CENTRE,
    BODY_INERTIA,
    BODY_MASS,
    BODY_OFFSET,
    LINK_FIRST_SLOT,
    LINK_LAST_SLOT,
    LINK_PARENT,
    LINK_SLIDES,
    ROW_KIND,
    ROW_SLOT_A,
    ROW_SLOT_B,
    ROW_WELD,
    SLOT_ABOVE,
    SLOT_ROW,
    WAY_ARM_A,
    WAY_ARM_B,
    WAY_DIRECTION,
    WELD_BODY_A,
    WELD_BODY_B,
    WELD_FRAME,
    WELD_POINT_B,
    WORK_ALONG,
    WORK_ARM,
    WORK_BIAS_COUPLE,
    WORK_BIAS_FORCE,
    WORK_COUPLES,
    WORK_CROSSED,
    WORK_DRIFT,
    WORK_DRIVE,
    WORK_FORCES,
    WORK_HEAD_COUPLE,
    WORK_HEAD_FORCE,
    WORK_LINE,
    WORK_PLACE,
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    WORK_SHIFTING,
    WORK_SLOT_COUPLE,
    WORK_SLOT_FORCE,
    WORK_SLOT_POWER,
    WORK_SPEED,
    WORK_SPIN,
    WORK_SPIN_DRIFT,
    WORK_TURNING,
    BodyTree,
    Work,
)


@compiled
def place_bodies(tree: BodyTree, q: Reals, work: Work) -> None:
    """Write the positions of all bodies, and directions and points of the closure rows."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, LINK_PARENT]
        axis = vector_at(tree.bodies, i, BODY_AXIS)
        arm = vector_at(tree.bodies, i, BODY_OFFSET)
        x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
        line, origin = axis, (0.0, 0.0, 0.0)
        if p >= 0:
            arm, line = rotated(b, p, WORK_ROTATION, arm), rotated(b, p, WORK_ROTATION, axis)
            x, y = vector_at(b, p, WORK_ROTATION), vector_at(b, p, WORK_ROTATION + 3)
            z = vector_at(b, p, WORK_ROTATION + 6)
            origin = vector_at(b, p, WORK_PLACE)
        if tree.links[i, LINK_SLIDES]:
            arm = vector_sum(arm, scaled_vector(q[i], line))
        else:
            columns = rotation(axis, q[i])
            x, y, z = turn_row(x, columns), turn_row(y, columns), turn_row(z, columns)
        put_vector(b, i, WORK_ROTATION, x)
        put_vector(b, i, WORK_ROTATION + 3, y)
        put_vector(b, i, WORK_ROTATION + 6, z)
        put_vector(b, i, WORK_LINE, line)
        put_vector(b, i, WORK_ARM, arm)
        put_vector(b, i, WORK_PLACE, vector_sum(origin, arm))
    for r in range(len(tree.rows)):
        weld, kind = tree.rows[r, ROW_WELD], tree.rows[r, ROW_KIND]
        first, second = tree.welds[weld, WELD_BODY_A], tree.welds[weld, WELD_BODY_B]
        direction = vector_at(tree.weld_places, weld, WELD_FRAME + 3 * (kind if kind < 3 else kind - 3))
        arm = rotated(b, second, WORK_ROTATION, vector_at(tree.weld_places, weld, WELD_POINT_B))
        put_vector(work.row_lines, r, WAY_ARM_B, arm)
        if first >= 0:
            direction = rotated(b, first, WORK_ROTATION, direction)
            # body a carries the row where body b is, which may be elsewhere along directions that are not closed
            arm = vector_difference(vector_sum(vector_at(b, second, WORK_PLACE), arm), vector_at(b, first, WORK_PLACE))
        put_vector(work.row_lines, r, WAY_DIRECTION, direction)
        put_vector(work.row_lines, r, WAY_ARM_A, arm)


@compiled
def move_bodies(tree: BodyTree, v: Reals, work: Work) -> None:
    """Write velocities of all bodies, and velocity-dependent accelerations; call `place_bodies` first."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, LINK_PARENT]
        spin, speed = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if p >= 0:
            spin, speed = vector_at(b, p, WORK_SPIN), vector_at(b, p, WORK_SPEED)
        arm = vector_at(b, i, WORK_ARM)
        joint_velocity = scaled_vector(v[i], vector_at(b, i, WORK_LINE))
        spin_velocity = cross(spin, arm)
        speed = vector_sum(speed, spin_velocity)
        drift = cross(spin, spin_velocity)
        if tree.links[i, LINK_SLIDES]:
            put_vector(b, i, WORK_SPIN, spin)
            put_vector(b, i, WORK_SPEED, vector_sum(speed, joint_velocity))
            put_vector(b, i, WORK_SPIN_DRIFT, (0.0, 0.0, 0.0))
            put_vector(b, i, WORK_DRIFT, vector_sum(drift, scaled_vector(2.0, cross(spin, joint_velocity))))
        else:
            put_vector(b, i, WORK_SPIN, vector_sum(spin, joint_velocity))
            put_vector(b, i, WORK_SPEED, speed)
            put_vector(b, i, WORK_SPIN_DRIFT, cross(spin, joint_velocity))
            put_vector(b, i, WORK_DRIFT, drift)


@compiled
def _load_body(tree: BodyTree, i: int, work: Work) -> None:
    """Write the inertia and bias force of one rigid body about its joint."""
    b = work.bodies
    mass = tree.bodies[i, BODY_MASS]
    c = rotated(b, i, WORK_ROTATION, vector_at(tree.bodies, i, BODY_CENTRE))
    s = rotated_symmetric(b, i, WORK_ROTATION, symmetric_at(tree.bodies, i, BODY_INERTIA))
    cc = mass * dot(c, c)
    t = outer_product(-mass, c)  # Steiner's term, with cc
    a = s[0] + t[0] + cc, s[1] + t[1] + cc, s[2] + t[2] + cc, s[3] + t[3], s[4] + t[4], s[5] + t[5]
    for k in range(6):
        b[i, WORK_COUPLES + k] = a[k]
        b[i, WORK_FORCES + k] = mass if k < 3 else 0.0
    x, y, z = scaled_vector(mass, c)
    put_vector(b, i, WORK_CROSSED, (0.0, -z, y))
    put_vector(b, i, WORK_CROSSED + 3, (z, 0.0, -x))
    put_vector(b, i, WORK_CROSSED + 6, (-y, x, 0.0))
    spin = vector_at(b, i, WORK_SPIN)
    couple, force = cross(spin, apply_symmetric(a, spin)), cross(spin, cross(spin, (x, y, z)))
    put_vector(b, i, WORK_BIAS_COUPLE, vector_difference(couple, vector_at(b, i, WORK_PULL_COUPLE)))
    put_vector(b, i, WORK_BIAS_FORCE, vector_difference(force, vector_at(b, i, WORK_PULL_FORCE)))


@compiled
def _load_rows(tree: BodyTree, work: Work) -> None:
    """Write the unit forces of the closure rows on the bodies on which they act."""
    slots = work.slots
    for slot in range(len(slots)):
        for k in range(6):
            slots[slot, k] = 0.0
    for r in range(len(tree.rows)):
        direction = vector_at(work.row_lines, r, WAY_DIRECTION)
        is_gap = tree.rows[r, ROW_KIND] >= 3
        for side in range(2):
            slot = tree.rows[r, ROW_SLOT_B if side else ROW_SLOT_A]
            if slot < 0:
                continue
            sign = 1.0 if side else -1.0
            if is_gap:
                force = scaled_vector(sign / tree.size, direction)
                arm = vector_at(work.row_lines, r, WAY_ARM_B if side else WAY_ARM_A)
                add_vector(slots, slot, WORK_SLOT_COUPLE, cross(arm, force))
                add_vector(slots, slot, WORK_SLOT_FORCE, force)
            else:
                add_vector(slots, slot, WORK_SLOT_COUPLE, scaled_vector(sign, direction))


@compiled
def _add_to_parent(i: int, p: int, work: Work) -> None:
    """Add the articulated inertia of body i to that of its parent, about the parent's joint."""
    b = work.bodies
    r = vector_at(b, i, WORK_ARM)
    d = symmetric_at(b, i, WORK_FORCES)
    u, v, w = cross(r, (d[0], d[3], d[4])), cross(r, (d[3], d[1], d[5])), cross(r, (d[4], d[5], d[2]))
    x, y, z = vector_at(b, i, WORK_CROSSED), vector_at(b, i, WORK_CROSSED + 3), vector_at(b, i, WORK_CROSSED + 6)
    x2 = vector_sum(x, (u[0], v[0], w[0]))
    y2 = vector_sum(y, (u[1], v[1], w[1]))
    z2 = vector_sum(z, (u[2], v[2], w[2]))
    add_vector(b, p, WORK_CROSSED, x2)
    add_vector(b, p, WORK_CROSSED + 3, y2)
    add_vector(b, p, WORK_CROSSED + 6, z2)
    add_symmetric(b, p, WORK_FORCES, d)
    x, y, z = cross(r, x), cross(r, y), cross(r, z)
    u, v, w = cross(r, x2), cross(r, y2), cross(r, z2)
    a0, a1, a2, a3, a4, a5 = symmetric_at(b, i, WORK_COUPLES)
    s = a0 + x[0] + u[0], a1 + y[1] + v[1], a2 + z[2] + w[2], a3 + x[1] + v[0], a4 + x[2] + w[0], a5 + y[2] + w[1]
    add_symmetric(b, p, WORK_COUPLES, s)


@compiled
def gather_inertias(tree: BodyTree, held: Signs, work: Work) -> None:
    """Write articulated inertias, joint components of closure rows, and the Delassus matrix; after `move_bodies`.

    held : (n,), not 0 where the joint is held.
    """
    n = len(tree.links)
    b = work.bodies
    slots = work.slots
    for i in range(n):
        _load_body(tree, i, work)
    _load_rows(tree, work)
    for r in range(len(tree.rows)):
        for s in range(r + 1):
            work.delassus[r, s] = 0.0
    for i in range(n - 1, -1, -1):
        p = tree.links[i, LINK_PARENT]
        slides = tree.links[i, LINK_SLIDES]
        w = vector_at(b, i, WORK_LINE)
        if slides:
            couple, force = rotated(b, i, WORK_CROSSED, w), apply_symmetric(symmetric_at(b, i, WORK_FORCES), w)
            along = dot(w, force) + work.added_inertia[i]
        else:
            couple, force = apply_symmetric(symmetric_at(b, i, WORK_COUPLES), w), rotated_back(b, i, WORK_CROSSED, w)
            along = dot(w, couple) + work.added_inertia[i]
        put_vector(b, i, WORK_HEAD_COUPLE, couple)
        put_vector(b, i, WORK_HEAD_FORCE, force)
        b[i, WORK_ALONG] = along
        first, last = tree.links[i, LINK_FIRST_SLOT], tree.links[i, LINK_LAST_SLOT]
        for slot in range(first, last):
            part = vector_at(slots, slot, WORK_SLOT_FORCE if slides else WORK_SLOT_COUPLE)
            slots[slot, WORK_SLOT_POWER] = dot(w, part)
        if not held[i]:
            _release_joint(i, couple, force, along, work)
            for slot in range(first, last):
                share = slots[slot, WORK_SLOT_POWER] / along
                r = tree.slots[slot, SLOT_ROW]
                for other_slot in range(first, slot + 1):
                    work.delassus[r, tree.slots[other_slot, SLOT_ROW]] += share * slots[other_slot, WORK_SLOT_POWER]
                add_vector(slots, slot, WORK_SLOT_COUPLE, scaled_vector(-share, couple))
                add_vector(slots, slot, WORK_SLOT_FORCE, scaled_vector(-share, force))
        if p >= 0:
            _add_to_parent(i, p, work)
            for slot in range(first, last):
                above = tree.slots[slot, SLOT_ABOVE]
                f, c = vector_at(slots, slot, WORK_SLOT_FORCE), vector_at(slots, slot, WORK_SLOT_COUPLE)
                add_vector(slots, above, WORK_SLOT_COUPLE, vector_sum(c, cross(vector_at(b, i, WORK_ARM), f)))
                add_vector(slots, above, WORK_SLOT_FORCE, f)
    # the slots of a body are in the order of their rows, so only one triangle is written
    for r in range(len(tree.rows)):
        for s in range(r):
            work.delassus[s, r] = work.delassus[r, s]


@compiled
def _release_joint(i: int, couple: Vector3, force: Vector3, along: float, work: Work) -> None:
    """Remove the part that a free joint accelerates from its articulated inertia."""
    b = work.bodies
    s = -1.0 / along
    add_symmetric(b, i, WORK_COUPLES, outer_product(s, couple))
    add_symmetric(b, i, WORK_FORCES, outer_product(s, force))
    add_vector(b, i, WORK_CROSSED, scaled_vector(s * couple[0], force))
    add_vector(b, i, WORK_CROSSED + 3, scaled_vector(s * couple[1], force))
    add_vector(b, i, WORK_CROSSED + 6, scaled_vector(s * couple[2], force))


@compiled
def load_joints(tree: BodyTree, held: Signs, torques: Reals, moving: bool, work: Work) -> None:
    """Write net joint forces, and the row accelerations that they cause; call `gather_inertias` first.

    `work.rates` receives the relative accelerations of the welds without constraint forces.

    moving : whether velocities, gravity and external forces count, which allows one call only; else `torques` are
        impulses at rest, and calls may be repeated.
    """
    b, slots = work.bodies, work.slots
    work.rates[:] = 0.0
    if not moving:
        for i in range(len(tree.links)):
            put_vector(b, i, WORK_BIAS_COUPLE, (0.0, 0.0, 0.0))
            put_vector(b, i, WORK_BIAS_FORCE, (0.0, 0.0, 0.0))
    for i in range(len(tree.links) - 1, -1, -1):
        p = tree.links[i, LINK_PARENT]
        couple, force = vector_at(b, i, WORK_BIAS_COUPLE), vector_at(b, i, WORK_BIAS_FORCE)
        drive = torques[i] - dot(vector_at(b, i, WORK_LINE), force if tree.links[i, LINK_SLIDES] else couple)
        b[i, WORK_DRIVE] = drive
        share = 0.0 if held[i] else drive / b[i, WORK_ALONG]
        first, last = tree.links[i, LINK_FIRST_SLOT], tree.links[i, LINK_LAST_SLOT]
        for slot in range(first, last):
            work.rates[tree.slots[slot, SLOT_ROW]] += work.slots[slot, WORK_SLOT_POWER] * share
        if moving:
            turn, shift = vector_at(b, i, WORK_SPIN_DRIFT), vector_at(b, i, WORK_DRIFT)
            for slot in range(first, last):  # `gather_inertias` left in them the part that the joint transmits
                c, f = vector_at(slots, slot, WORK_SLOT_COUPLE), vector_at(slots, slot, WORK_SLOT_FORCE)
                work.rates[tree.slots[slot, SLOT_ROW]] += dot(c, turn) + dot(f, shift)
            of_turn = apply_symmetric(symmetric_at(b, i, WORK_COUPLES), turn)
            couple = vector_sum(couple, vector_sum(of_turn, rotated(b, i, WORK_CROSSED, shift)))
            of_shift = apply_symmetric(symmetric_at(b, i, WORK_FORCES), shift)
            force = vector_sum(force, vector_sum(rotated_back(b, i, WORK_CROSSED, turn), of_shift))
        couple = vector_sum(couple, scaled_vector(share, vector_at(b, i, WORK_HEAD_COUPLE)))
        force = vector_sum(force, scaled_vector(share, vector_at(b, i, WORK_HEAD_FORCE)))
        if p >= 0:
            add_vector(b, p, WORK_BIAS_COUPLE, vector_sum(couple, cross(vector_at(b, i, WORK_ARM), force)))
            add_vector(b, p, WORK_BIAS_FORCE, force)
        elif moving:
            for slot in range(first, last):
                f = vector_at(slots, slot, WORK_SLOT_FORCE)
                fall = f[0] * tree.gravity[0] + f[1] * tree.gravity[1] + f[2] * tree.gravity[2]
                work.rates[tree.slots[slot, SLOT_ROW]] -= fall
    if moving:
        _add_velocity_rates(tree, work)


@compiled
def _add_velocity_rates(tree: BodyTree, work: Work) -> None:
    """Add centripetal terms of welded bodies, and those of rotating row directions, to the row accelerations."""
    b = work.bodies
    for r in range(len(tree.rows)):
        direction = vector_at(work.row_lines, r, WAY_DIRECTION)
        first, second = tree.welds[tree.rows[r, ROW_WELD], WELD_BODY_A], tree.welds[tree.rows[r, ROW_WELD], WELD_BODY_B]
        if first >= 0:
            first_spin, second_spin = vector_at(b, first, WORK_SPIN), vector_at(b, second, WORK_SPIN)
            if tree.rows[r, ROW_KIND] < 3:
                work.rates[r] -= dot(direction, cross(first_spin, vector_difference(second_spin, first_spin)))
            else:
                first_arm, second_arm = vector_at(work.row_lines, r, WAY_ARM_A), vector_at(work.row_lines, r, WAY_ARM_B)
                first_velocity = vector_sum(vector_at(b, first, WORK_SPEED), cross(first_spin, first_arm))
                second_velocity = vector_sum(vector_at(b, second, WORK_SPEED), cross(second_spin, second_arm))
                relative_velocity = vector_difference(second_velocity, first_velocity)
                work.rates[r] -= 2.0 * dot(direction, cross(first_spin, relative_velocity)) / tree.size
        if tree.rows[r, ROW_KIND] < 3:
            continue
        for side in range(2):
            body = tree.welds[tree.rows[r, ROW_WELD], side]
            if body >= 0:
                spin = vector_at(work.bodies, body, WORK_SPIN)
                arm = vector_at(work.row_lines, r, WAY_ARM_B if side else WAY_ARM_A)
                inward = dot(direction, cross(spin, cross(spin, arm)))
                work.rates[r] += (inward if side else -inward) / tree.size
            else:  # the ground, too, rises against gravity
                fall = direction[0] * tree.gravity[0] + direction[1] * tree.gravity[1] + direction[2] * tree.gravity[2]
                work.rates[r] += fall / tree.size


@compiled
def release_joints(tree: BodyTree, held: Signs, moving: bool, work: Work, rates: Reals) -> None:
    """Write joint accelerations (or velocities, from impulses) under the constraint forces; after `load_joints`."""
    b, ground = work.bodies, (0.0, 0.0, 0.0)
    if moving:
        ground = (-tree.gravity[0], -tree.gravity[1], -tree.gravity[2])
    for i in range(len(tree.links)):
        turn, shift = carried_motion(tree, i, ground, work)
        if moving:
            turn = vector_sum(turn, vector_at(b, i, WORK_SPIN_DRIFT))
            shift = vector_sum(shift, vector_at(b, i, WORK_DRIFT))
        drive = b[i, WORK_DRIVE]
        for slot in range(tree.links[i, LINK_FIRST_SLOT], tree.links[i, LINK_LAST_SLOT]):
            drive += work.slots[slot, WORK_SLOT_POWER] * work.forces[tree.slots[slot, SLOT_ROW]]
        drive -= dot(vector_at(b, i, WORK_HEAD_COUPLE), turn) + dot(vector_at(b, i, WORK_HEAD_FORCE), shift)
        rate = 0.0 if held[i] else drive / b[i, WORK_ALONG]
        rates[i] = -drive if held[i] else rate
        carry_body(tree, i, rate, turn, shift, work)


@compiled
def carried_motion(tree: BodyTree, i: int, ground: Vector3, work: Work) -> tuple[Vector3, Vector3]:
    """Return the acceleration (turn, shift) of a body's parent, or of the ground, at the joint; after `carry_body`."""
    p, turn, shift = tree.links[i, LINK_PARENT], (0.0, 0.0, 0.0), ground
    if p >= 0:
        turn, shift = vector_at(work.bodies, p, WORK_TURNING), vector_at(work.bodies, p, WORK_SHIFTING)
    return turn, vector_sum(shift, cross(turn, vector_at(work.bodies, i, WORK_ARM)))


@compiled
def carry_body(tree: BodyTree, i: int, rate: float, turn: Vector3, shift: Vector3, work: Work) -> None:
    """Write the acceleration of a body: that of its parent at the joint (turn, shift) plus the rate of the joint."""
    joint_part = scaled_vector(rate, vector_at(work.bodies, i, WORK_LINE))
    if tree.links[i, LINK_SLIDES]:
        shift = vector_sum(shift, joint_part)
    else:
        turn = vector_sum(turn, joint_part)
    put_vector(work.bodies, i, WORK_TURNING, turn)
    put_vector(work.bodies, i, WORK_SHIFTING, shift)
