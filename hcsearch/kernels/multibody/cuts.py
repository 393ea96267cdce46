"""Hinges cut open and held together by springs: the penalty formulation of the thesis (4.2.2, eq. 4.23).

At both ends M and N of the hinge line springs and dampers of no length join the two panels: along three directions at
M, and along the two across the hinge at N. The hinge's own law, damper and stops act about the line.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals, Signs, WholeNumbers
from hcsearch.kernels.algebra.vectors import (
    Vector3,
    add_vector,
    cross,
    dot,
    rotated,
    scaled_vector,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.multibody.hinges import Hinges, joint_torques, law_moment
from hcsearch.kernels.multibody.tree import (
    WORK_PLACE,
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    WORK_SPEED,
    WORK_SPIN,
    Work,
)


class CutHinges(NamedTuple):
    """Cut hinges, c of them.

    bodies : (c, 2), first and second, -1 the ground. points : (c, 12), M and N from the joint of the first body, then
        from that of the second. frames : (c, 9), the hinge's direction and two across it, fixed to the first body.
    hinges : what acts about the lines. stiffness, damping : of each of the five springs, N/m and Ns/m.
    """

    bodies: WholeNumbers
    points: Reals
    frames: Reals
    hinges: Hinges
    stiffness: float
    damping: float


@lean
def _turned(work: Work, body: int, v: Vector3) -> Vector3:
    return rotated(work.bodies, body, WORK_ROTATION, v) if body >= 0 else v


@lean
def _spin(work: Work, body: int) -> Vector3:
    return vector_at(work.bodies, body, WORK_SPIN) if body >= 0 else (0.0, 0.0, 0.0)


@lean
def _point(work: Work, body: int, arm: Vector3) -> tuple[Vector3, Vector3]:
    """Position and velocity of a point of a body, or of the ground."""
    if body < 0:
        return arm, (0.0, 0.0, 0.0)
    b = work.bodies
    return vector_sum(vector_at(b, body, WORK_PLACE), arm), vector_sum(
        vector_at(b, body, WORK_SPEED), cross(vector_at(b, body, WORK_SPIN), arm)
    )


@lean
def cut_angles(cuts: CutHinges, work: Work, angles: Reals, speeds: Reals) -> None:
    """Fold angles of cut hinges, from -pi/2 to 3 pi/2, and their rates; after `move`."""
    for c in range(len(cuts.bodies)):
        first, second = cuts.bodies[c, 0], cuts.bodies[c, 1]
        line = _turned(work, first, vector_at(cuts.frames, c, 0))
        across = vector_at(cuts.frames, c, 3)
        here, there = _turned(work, first, across), _turned(work, second, across)
        angle = math.atan2(dot(line, cross(here, there)), dot(here, there))
        angles[c] = angle + 2.0 * math.pi if angle < -0.5 * math.pi else angle
        speeds[c] = dot(line, vector_difference(_spin(work, second), _spin(work, first)))


@compiled
def pull_cuts(cuts: CutHinges, branches: Signs, work: Work) -> None:
    """Add the forces of cut hinges to the pulls on bodies; after `move`."""
    count = len(cuts.bodies)
    angles, speeds, torques = np.empty(count), np.empty(count), np.empty(count)
    cut_angles(cuts, work, angles, speeds)
    joint_torques(cuts.hinges, branches, angles, speeds, torques)
    for c in range(count):
        first, second = cuts.bodies[c, 0], cuts.bodies[c, 1]
        line = _turned(work, first, vector_at(cuts.frames, c, 0))
        _push(work, first, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), scaled_vector(-torques[c], line))
        _push(work, second, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), scaled_vector(torques[c], line))
        for end in range(2):
            one = _turned(work, first, vector_at(cuts.points, c, 3 * end))
            two = _turned(work, second, vector_at(cuts.points, c, 6 + 3 * end))
            gap, speed = _gap(cuts, c, end, one, two, work)
            force = vector_sum(scaled_vector(-cuts.stiffness, gap), scaled_vector(-cuts.damping, speed))
            _push(work, second, two, force, (0.0, 0.0, 0.0))
            _push(work, first, one, scaled_vector(-1.0, force), (0.0, 0.0, 0.0))


@lean
def _gap(cuts: CutHinges, c: int, end: int, one: Vector3, two: Vector3, work: Work) -> tuple[Vector3, Vector3]:
    """What a spring feels between the two points, and its rate: at N nothing along the hinge."""
    first, second = cuts.bodies[c, 0], cuts.bodies[c, 1]
    here, slow = _point(work, first, one)
    there, fast = _point(work, second, two)
    gap, speed = vector_difference(there, here), vector_difference(fast, slow)
    if end == 1:
        line = _turned(work, first, vector_at(cuts.frames, c, 0))
        gap = vector_difference(gap, scaled_vector(dot(line, gap), line))
        speed = vector_difference(speed, scaled_vector(dot(line, speed), line))
    return gap, speed


@lean
def _push(work: Work, body: int, arm: Vector3, force: Vector3, couple: Vector3) -> None:
    if body >= 0:
        add_vector(work.bodies, body, WORK_PULL_COUPLE, vector_sum(couple, cross(arm, force)))
        add_vector(work.bodies, body, WORK_PULL_FORCE, force)


@lean
def cut_gap(cuts: CutHinges, work: Work) -> float:
    """The greatest gap that a spring feels, m; after `move`."""
    worst = 0.0
    for c in range(len(cuts.bodies)):
        for end in range(2):
            one = _turned(work, cuts.bodies[c, 0], vector_at(cuts.points, c, 3 * end))
            two = _turned(work, cuts.bodies[c, 1], vector_at(cuts.points, c, 6 + 3 * end))
            gap, _ = _gap(cuts, c, end, one, two, work)
            worst = max(worst, math.sqrt(dot(gap, gap)))
    return worst


@compiled
def cut_energy(cuts: CutHinges, branches: Signs, work: Work) -> tuple[float, float, float, float]:
    """Energy of the laws, of the stops, of the springs across, and power lost in all dampers; after `move`."""
    count = len(cuts.bodies)
    angles, speeds = np.empty(count), np.empty(count)
    cut_angles(cuts, work, angles, speeds)
    hinges = cuts.hinges
    stored = stops = open_ = lost = 0.0
    for c in range(count):
        _, energy = law_moment(hinges, c, branches[c], angles[c])
        stored += energy
        lost += hinges.damping[c] * speeds[c] ** 2
        beyond = min(angles[c] - hinges.lower[c], 0.0) + max(angles[c] - hinges.upper[c], 0.0)
        if beyond != 0.0 and hinges.stop_stiffness > 0.0:
            stops += 0.5 * hinges.stop_stiffness * beyond**2
            lost += hinges.stop_damping * speeds[c] ** 2
        for end in range(2):
            one = _turned(work, cuts.bodies[c, 0], vector_at(cuts.points, c, 3 * end))
            two = _turned(work, cuts.bodies[c, 1], vector_at(cuts.points, c, 6 + 3 * end))
            gap, speed = _gap(cuts, c, end, one, two, work)
            open_ += 0.5 * cuts.stiffness * dot(gap, gap)
            lost += cuts.damping * dot(speed, speed)
    return stored, stops, open_, lost
