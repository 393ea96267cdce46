"""Articulated-body recursions: outward for positions and velocities, inward for inertias, outward for accelerations.

Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 7 and 8, in world axes about the joints, so that bodies
far from the origin lose no accuracy. The forces that close loops are carried inward beside the inertias; what a row's
unit force does along each joint gives the Delassus matrix as a sum over joints (Rodriguez, Jain and Kreutz-Delgado
1992). A held joint is left out of all three: its bodies move as one.
"""

from __future__ import annotations

from hcsearch.basics.arrays import Reals, Signs
from hcsearch.kernels.algebra.vectors import (
    Vector,
    add,
    add_symmetric,
    applied,
    at,
    conjugated,
    cross,
    dot,
    minus,
    plus,
    product,
    put,
    rotation,
    symmetric,
    times,
    turn_row,
    turned,
    turned_back,
)
from hcsearch.kernels.compiling.compiled import inlined, lean
from hcsearch.kernels.multibody.tree import (
    ABOVE,
    ALONG,
    ARM,
    ARM_A,
    ARM_B,
    AXIS,
    BIAS_COUPLE,
    BIAS_FORCE,
    BODY_A,
    BODY_B,
    CENTRE,
    COUPLES,
    CROSSED,
    DRIFT,
    DRIVE,
    FIRST,
    FORCES,
    FRAME,
    HEAD_COUPLE,
    HEAD_FORCE,
    INERTIA,
    KIND,
    LAST,
    LINE,
    MASS,
    OFFSET,
    PARENT,
    PLACE,
    POINT_B,
    POWER,
    PULL_COUPLE,
    PULL_FORCE,
    ROW,
    ROW_COUPLE,
    ROW_FORCE,
    SHIFTING,
    SLIDES,
    SLOT_A,
    SLOT_B,
    SPEED,
    SPIN,
    SPIN_DRIFT,
    TURN,
    TURNING,
    WAY,
    WELD,
    Tree,
    Work,
)


@lean
def place(tree: Tree, q: Reals, work: Work) -> None:
    """Positions of all bodies and of the closure rows."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, PARENT]
        own = at(tree.bodies, i, AXIS)
        arm = at(tree.bodies, i, OFFSET)
        x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
        line, origin = own, (0.0, 0.0, 0.0)
        if p >= 0:
            arm, line = turned(b, p, TURN, arm), turned(b, p, TURN, own)
            x, y, z = at(b, p, TURN), at(b, p, TURN + 3), at(b, p, TURN + 6)
            origin = at(b, p, PLACE)
        if tree.links[i, SLIDES]:
            arm = plus(arm, times(q[i], line))
        else:
            columns = rotation(own, q[i])
            x, y, z = turn_row(x, columns), turn_row(y, columns), turn_row(z, columns)
        put(b, i, TURN, x)
        put(b, i, TURN + 3, y)
        put(b, i, TURN + 6, z)
        put(b, i, LINE, line)
        put(b, i, ARM, arm)
        put(b, i, PLACE, plus(origin, arm))
    for r in range(len(tree.rows)):
        weld, kind = tree.rows[r, WELD], tree.rows[r, KIND]
        first, second = tree.welds[weld, BODY_A], tree.welds[weld, BODY_B]
        way = at(tree.weld_places, weld, FRAME + 3 * (kind if kind < 3 else kind - 3))
        arm = turned(b, second, TURN, at(tree.weld_places, weld, POINT_B))
        put(work.ways, r, ARM_B, arm)
        if first >= 0:
            way = turned(b, first, TURN, way)
            # body a carries the row where body b is, which may be elsewhere along directions that are not closed
            arm = minus(plus(at(b, second, PLACE), arm), at(b, first, PLACE))
        put(work.ways, r, WAY, way)
        put(work.ways, r, ARM_A, arm)


@lean
def move(tree: Tree, v: Reals, work: Work) -> None:
    """Velocities of all bodies, and the accelerations that they cause; after `place`."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, PARENT]
        spin, speed = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if p >= 0:
            spin, speed = at(b, p, SPIN), at(b, p, SPEED)
        arm = at(b, i, ARM)
        own = times(v[i], at(b, i, LINE))
        flow = cross(spin, arm)
        speed = plus(speed, flow)
        drift = cross(spin, flow)
        if tree.links[i, SLIDES]:
            put(b, i, SPIN, spin)
            put(b, i, SPEED, plus(speed, own))
            put(b, i, SPIN_DRIFT, (0.0, 0.0, 0.0))
            put(b, i, DRIFT, plus(drift, times(2.0, cross(spin, own))))
        else:
            put(b, i, SPIN, plus(spin, own))
            put(b, i, SPEED, speed)
            put(b, i, SPIN_DRIFT, cross(spin, own))
            put(b, i, DRIFT, drift)


@lean
def _load_body(tree: Tree, i: int, work: Work) -> None:
    """Inertia and bias of one body on its own, about its joint."""
    b = work.bodies
    mass = tree.bodies[i, MASS]
    c = turned(b, i, TURN, at(tree.bodies, i, CENTRE))
    s = conjugated(b, i, TURN, symmetric(tree.bodies, i, INERTIA))
    cc = mass * dot(c, c)
    own = product(-mass, c)
    a = (s[0] + own[0] + cc, s[1] + own[1] + cc, s[2] + own[2] + cc, s[3] + own[3], s[4] + own[4], s[5] + own[5])
    for k in range(6):
        b[i, COUPLES + k] = a[k]
        b[i, FORCES + k] = mass if k < 3 else 0.0
    x, y, z = times(mass, c)
    put(b, i, CROSSED, (0.0, -z, y))
    put(b, i, CROSSED + 3, (z, 0.0, -x))
    put(b, i, CROSSED + 6, (-y, x, 0.0))
    spin = at(b, i, SPIN)
    put(b, i, BIAS_COUPLE, minus(cross(spin, applied(a, spin)), at(b, i, PULL_COUPLE)))
    put(b, i, BIAS_FORCE, minus(cross(spin, cross(spin, (x, y, z))), at(b, i, PULL_FORCE)))


@lean
def _load_rows(tree: Tree, work: Work) -> None:
    """The unit forces of the closure rows on the bodies where they act."""
    slots = work.slots
    for slot in range(len(slots)):
        for k in range(6):
            slots[slot, k] = 0.0
    for r in range(len(tree.rows)):
        way = at(work.ways, r, WAY)
        gap = tree.rows[r, KIND] >= 3
        for side in range(2):
            slot = tree.rows[r, SLOT_B if side else SLOT_A]
            if slot < 0:
                continue
            sign = 1.0 if side else -1.0
            if gap:
                force = times(sign / tree.size, way)
                add(slots, slot, ROW_COUPLE, cross(at(work.ways, r, ARM_B if side else ARM_A), force))
                add(slots, slot, ROW_FORCE, force)
            else:
                add(slots, slot, ROW_COUPLE, times(sign, way))


@lean
def _pass_on(i: int, p: int, work: Work) -> None:
    """Add the inertia left at joint i to that of its parent, about the parent's joint."""
    b = work.bodies
    r = at(b, i, ARM)
    d = symmetric(b, i, FORCES)
    u, v, w = cross(r, (d[0], d[3], d[4])), cross(r, (d[3], d[1], d[5])), cross(r, (d[4], d[5], d[2]))
    x, y, z = at(b, i, CROSSED), at(b, i, CROSSED + 3), at(b, i, CROSSED + 6)
    x2 = plus(x, (u[0], v[0], w[0]))
    y2 = plus(y, (u[1], v[1], w[1]))
    z2 = plus(z, (u[2], v[2], w[2]))
    add(b, p, CROSSED, x2)
    add(b, p, CROSSED + 3, y2)
    add(b, p, CROSSED + 6, z2)
    add_symmetric(b, p, FORCES, d)
    x, y, z = cross(r, x), cross(r, y), cross(r, z)
    u, v, w = cross(r, x2), cross(r, y2), cross(r, z2)
    a = symmetric(b, i, COUPLES)
    add_symmetric(
        b,
        p,
        COUPLES,
        (
            a[0] + x[0] + u[0],
            a[1] + y[1] + v[1],
            a[2] + z[2] + w[2],
            a[3] + x[1] + v[0],
            a[4] + x[2] + w[0],
            a[5] + y[2] + w[1],
        ),
    )


@lean
def gather(tree: Tree, held: Signs, work: Work) -> None:
    """Articulated inertias, what each closure row does along each joint, and the Delassus matrix; after `move`.

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
        p = tree.links[i, PARENT]
        slides = tree.links[i, SLIDES]
        w = at(b, i, LINE)
        if slides:
            couple, force = turned(b, i, CROSSED, w), applied(symmetric(b, i, FORCES), w)
            along = dot(w, force) + work.soft[i]
        else:
            couple, force = applied(symmetric(b, i, COUPLES), w), turned_back(b, i, CROSSED, w)
            along = dot(w, couple) + work.soft[i]
        put(b, i, HEAD_COUPLE, couple)
        put(b, i, HEAD_FORCE, force)
        b[i, ALONG] = along
        first, last = tree.links[i, FIRST], tree.links[i, LAST]
        for slot in range(first, last):
            slots[slot, POWER] = dot(w, at(slots, slot, ROW_FORCE if slides else ROW_COUPLE))
        if not held[i]:
            _free(i, couple, force, along, work)
            for slot in range(first, last):
                share = slots[slot, POWER] / along
                r = tree.slots[slot, ROW]
                for other in range(first, slot + 1):
                    work.delassus[r, tree.slots[other, ROW]] += share * slots[other, POWER]
                add(slots, slot, ROW_COUPLE, times(-share, couple))
                add(slots, slot, ROW_FORCE, times(-share, force))
        if p >= 0:
            _pass_on(i, p, work)
            for slot in range(first, last):
                above = tree.slots[slot, ABOVE]
                f = at(slots, slot, ROW_FORCE)
                add(slots, above, ROW_COUPLE, plus(at(slots, slot, ROW_COUPLE), cross(at(b, i, ARM), f)))
                add(slots, above, ROW_FORCE, f)
    # the slots of a body are in the order of their rows, so only one triangle is written
    for r in range(len(tree.rows)):
        for s in range(r):
            work.delassus[s, r] = work.delassus[r, s]


@lean
def _free(i: int, couple: Vector, force: Vector, along: float, work: Work) -> None:
    """Take what moves with the joint out of the inertia."""
    b = work.bodies
    s = -1.0 / along
    add_symmetric(b, i, COUPLES, product(s, couple))
    add_symmetric(b, i, FORCES, product(s, force))
    add(b, i, CROSSED, times(s * couple[0], force))
    add(b, i, CROSSED + 3, times(s * couple[1], force))
    add(b, i, CROSSED + 6, times(s * couple[2], force))


@lean
def load(tree: Tree, held: Signs, torques: Reals, moving: bool, work: Work) -> None:
    """Forces left over for acceleration at each joint, and what they do to the rows; after `gather`, once.

    rates : the relative accelerations of the welds without the forces that close them.
    moving : whether velocities, gravity and pulls count; else `torques` are impulses at rest, in one call or several.
    """
    b = work.bodies
    work.rates[:] = 0.0
    if not moving:
        for i in range(len(tree.links)):
            put(b, i, BIAS_COUPLE, (0.0, 0.0, 0.0))
            put(b, i, BIAS_FORCE, (0.0, 0.0, 0.0))
    for i in range(len(tree.links) - 1, -1, -1):
        p = tree.links[i, PARENT]
        couple, force = at(b, i, BIAS_COUPLE), at(b, i, BIAS_FORCE)
        drive = torques[i] - dot(at(b, i, LINE), force if tree.links[i, SLIDES] else couple)
        b[i, DRIVE] = drive
        share = 0.0 if held[i] else drive / b[i, ALONG]
        first, last = tree.links[i, FIRST], tree.links[i, LAST]
        for slot in range(first, last):
            work.rates[tree.slots[slot, ROW]] += work.slots[slot, POWER] * share
        if moving:
            turn, shift = at(b, i, SPIN_DRIFT), at(b, i, DRIFT)
            for slot in range(first, last):  # `gather` left in them the part that the joint carries on
                rate = dot(at(work.slots, slot, ROW_COUPLE), turn) + dot(at(work.slots, slot, ROW_FORCE), shift)
                work.rates[tree.slots[slot, ROW]] += rate
            couple = plus(couple, plus(applied(symmetric(b, i, COUPLES), turn), turned(b, i, CROSSED, shift)))
            force = plus(force, plus(turned_back(b, i, CROSSED, turn), applied(symmetric(b, i, FORCES), shift)))
        couple = plus(couple, times(share, at(b, i, HEAD_COUPLE)))
        force = plus(force, times(share, at(b, i, HEAD_FORCE)))
        if p >= 0:
            add(b, p, BIAS_COUPLE, plus(couple, cross(at(b, i, ARM), force)))
            add(b, p, BIAS_FORCE, force)
        elif moving:
            for slot in range(first, last):
                force = at(work.slots, slot, ROW_FORCE)
                work.rates[tree.slots[slot, ROW]] -= (
                    force[0] * tree.gravity[0] + force[1] * tree.gravity[1] + force[2] * tree.gravity[2]
                )
    if moving:
        _own_rates(tree, work)


@lean
def _own_rates(tree: Tree, work: Work) -> None:
    """Add what the spin of welded bodies does to their common point, and that of body a to the direction of the row."""
    b = work.bodies
    for r in range(len(tree.rows)):
        way = at(work.ways, r, WAY)
        first, second = tree.welds[tree.rows[r, WELD], BODY_A], tree.welds[tree.rows[r, WELD], BODY_B]
        if first >= 0:
            turning = at(b, first, SPIN)
            if tree.rows[r, KIND] < 3:
                work.rates[r] -= dot(way, cross(turning, minus(at(b, second, SPIN), turning)))
            else:
                here = plus(at(b, first, SPEED), cross(turning, at(work.ways, r, ARM_A)))
                there = plus(at(b, second, SPEED), cross(at(b, second, SPIN), at(work.ways, r, ARM_B)))
                work.rates[r] -= 2.0 * dot(way, cross(turning, minus(there, here))) / tree.size
        if tree.rows[r, KIND] < 3:
            continue
        for side in range(2):
            body = tree.welds[tree.rows[r, WELD], side]
            if body >= 0:
                spin = at(work.bodies, body, SPIN)
                inward = dot(way, cross(spin, cross(spin, at(work.ways, r, ARM_B if side else ARM_A))))
                work.rates[r] += (inward if side else -inward) / tree.size
            else:  # the ground, too, rises against gravity
                fall = way[0] * tree.gravity[0] + way[1] * tree.gravity[1] + way[2] * tree.gravity[2]
                work.rates[r] += fall / tree.size


@lean
def release(tree: Tree, held: Signs, moving: bool, work: Work, rates: Reals) -> None:
    """Write joint accelerations, (n,), or velocities from impulses; what holds them at held joints; after `load`."""
    b = work.bodies
    for i in range(len(tree.links)):
        p = tree.links[i, PARENT]
        turn, shift = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if p >= 0:
            turn, shift = at(b, p, TURNING), at(b, p, SHIFTING)
        elif moving:
            shift = (-tree.gravity[0], -tree.gravity[1], -tree.gravity[2])
        shift = plus(shift, cross(turn, at(b, i, ARM)))
        if moving:
            turn, shift = plus(turn, at(b, i, SPIN_DRIFT)), plus(shift, at(b, i, DRIFT))
        drive = b[i, DRIVE]
        for slot in range(tree.links[i, FIRST], tree.links[i, LAST]):
            drive += work.slots[slot, POWER] * work.forces[tree.slots[slot, ROW]]
        drive -= dot(at(b, i, HEAD_COUPLE), turn) + dot(at(b, i, HEAD_FORCE), shift)
        rate = 0.0 if held[i] else drive / b[i, ALONG]
        rates[i] = -drive if held[i] else rate
        carry(tree, i, rate, turn, shift, work)


@inlined
def carry(tree: Tree, i: int, rate: float, turn: Vector, shift: Vector, work: Work) -> None:
    """Write how a body moves that is carried by a turn and a shift, and moved by its joint at a rate."""
    own = times(rate, at(work.bodies, i, LINE))
    if tree.links[i, SLIDES]:
        shift = plus(shift, own)
    else:
        turn = plus(turn, own)
    put(work.bodies, i, TURNING, turn)
    put(work.bodies, i, SHIFTING, shift)
