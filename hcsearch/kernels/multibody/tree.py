"""Tables of a tree of rigid bodies with closed loops, and work tables of the recursions.

Joint i joins body i to a body of a lower number, or to the ground (-1), and turns about or slides along a line.
In the reference state all joint coordinates are 0; axes, points and inertias are those of that state, in world axes.
A loop is closed by a weld: two bodies, halves of one panel as a rule, that must move as one. A row is one equation of
a weld; a slot is a row at a body that its force passes through on the way to the ground.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled

BODY_AXIS, BODY_OFFSET, BODY_CENTRE, BODY_INERTIA, BODY_MASS = 0, 3, 6, 9, 15
"""Columns of `BodyTree.bodies`: unit vector of the joint axis, offset from the parent's joint (on the ground: from the
origin) to this joint, offset from the joint to the centre of mass, inertia about that (xx, yy, zz, xy, xz, yz),
mass."""

LINK_PARENT, LINK_SLIDES, LINK_FIRST_SLOT, LINK_LAST_SLOT = 0, 1, 2, 3
"""Columns of `BodyTree.links`: parent or -1, whether the joint slides, its slots (the last exclusive)."""

WELD_BODY_A, WELD_BODY_B = 0, 1
WELD_POINT_A, WELD_POINT_B, WELD_FRAME = 0, 3, 6
"""Columns of `BodyTree.welds` (-1 the ground) and of `BodyTree.weld_places`: the common point, from the joints of both
bodies, and three directions fixed to body a, by rows."""

ROW_WELD, ROW_KIND, ROW_SLOT_A, ROW_SLOT_B, ROW_FREE_TURN = 0, 1, 2, 3, 4
"""Columns of `BodyTree.rows`: weld; kind, 0 to 2 for rotations about, 3 to 5 for gaps along a direction of the weld's
frame; slots where the row acts on bodies a and b, -1 on the ground; for rotations, the direction about which the weld
lets b turn freely, or -1."""

SLOT_ROW, SLOT_ABOVE = 0, 1
"""Columns of `BodyTree.slots`: the row, and the slot of the same row at the parent or -1."""

WORK_ROTATION, WORK_PLACE, WORK_LINE, WORK_ARM, WORK_SPIN, WORK_SPEED, WORK_SPIN_DRIFT, WORK_DRIFT = (
    0,
    9,
    12,
    15,
    18,
    21,
    24,
    27,
)
"""Columns of `Work.bodies`: rotation from the reference state, position of the joint, joint axis, offset from the
parent's joint, angular velocity, velocity at the joint, and velocity-dependent angular acceleration and acceleration
there."""

WORK_COUPLES, WORK_CROSSED, WORK_FORCES = 30, 36, 45
"""Articulated inertia about the joint: couple per angular acceleration (symmetric), couple per acceleration (3 x 3, by
rows; its transpose is force per angular acceleration), force per acceleration (symmetric)."""

WORK_BIAS_COUPLE, WORK_BIAS_FORCE, WORK_PULL_COUPLE, WORK_PULL_FORCE = 51, 54, 57, 60
"""Bias couple and force of the body (without accelerations), and the external ones about its joint."""

WORK_HEAD_COUPLE, WORK_HEAD_FORCE, WORK_ALONG, WORK_DRIVE, WORK_TURNING, WORK_SHIFTING = 63, 66, 69, 70, 71, 74
"""Couple and force that a unit acceleration of the joint requires, their component along the joint, the net joint force
for acceleration, angular acceleration, acceleration at the joint."""

WORK_BODY_COLUMNS = 77

WAY_DIRECTION, WAY_ARM_A, WAY_ARM_B = 0, 3, 6
"""Columns of `Work.row_lines`: direction of the row, and the point of body b from the joints of both bodies."""

WORK_SLOT_COUPLE, WORK_SLOT_FORCE, WORK_SLOT_POWER = 0, 3, 6
"""Columns of `Work.slots`: the row's unit force transmitted to this body (couple, force), and its joint component."""


class BodyTree(NamedTuple):
    """Bodies, joints and welds; n bodies, w welds, m rows, s slots. Lengths in m, masses in kg.

    bodies : (n, 16). links : (n, 4). welds : (w, 2). weld_places : (w, 15). rows : (m, 5). slots : (s, 2), those of a
    body in the order of their rows. gravity : (3,), m/s^2. size : length that gaps are divided by.
    """

    bodies: Reals
    links: WholeNumbers
    welds: WholeNumbers
    weld_places: Reals
    rows: WholeNumbers
    slots: WholeNumbers
    gravity: Reals
    size: float


class Work(NamedTuple):
    """Work tables that the recursions write.

    bodies : (n, 77). slots : (s, 7). row_lines : (m, 9).
    errors, rates, forces : (m,), closure residuals, their rates (or accelerations), and forces of the rows.
    residual_rates, row_accelerations : (m,), of closure springs; the latter in the last iteration of an implicit stage.
    delassus : (m, m), accelerations of the rows per force. factor : (m, m), its Cholesky factor on the chosen rows.
    chosen : (m,), the independent rows. chosen_count : (1,), their number. pivots : (m,), used while rows are chosen.
    torques, added_inertia : (n,), joint forces, and the inertia that implicit steps add to the joints.
    accelerations, projection_change, zeros : (n,), of a stage, by a projection, and 0. trial : (2, n), a trial state.
    time : (1,), s, at which accelerations are computed. drive_targets : (n, 3), of the drives at that time.
    """

    bodies: Reals
    slots: Reals
    row_lines: Reals
    errors: Reals
    rates: Reals
    forces: Reals
    residual_rates: Reals
    row_accelerations: Reals
    delassus: Reals
    factor: Reals
    chosen: WholeNumbers
    chosen_count: WholeNumbers
    pivots: Reals
    torques: Reals
    added_inertia: Reals
    accelerations: Reals
    projection_change: Reals
    zeros: Reals
    trial: Reals
    time: Reals
    drive_targets: Reals


@compiled
def work_for(tree: BodyTree) -> Work:
    """Return work tables for the recursions on a tree."""
    n, m, slots = len(tree.links), len(tree.rows), len(tree.slots)
    return Work(
        bodies=np.zeros((n, WORK_BODY_COLUMNS)),
        slots=np.zeros((slots, 7)),
        row_lines=np.zeros((m, 9)),
        errors=np.zeros(m),
        rates=np.zeros(m),
        forces=np.zeros(m),
        residual_rates=np.zeros(m),
        row_accelerations=np.zeros(m),
        delassus=np.zeros((m, m)),
        factor=np.zeros((m, m)),
        chosen=np.zeros(m, np.int64),
        chosen_count=np.zeros(1, np.int64),
        pivots=np.zeros(m),
        torques=np.zeros(n),
        added_inertia=np.zeros(n),
        accelerations=np.zeros(n),
        projection_change=np.zeros(n),
        zeros=np.zeros(n),
        trial=np.zeros((2, n)),
        time=np.zeros(1),
        drive_targets=np.zeros((n, 3)),
    )
