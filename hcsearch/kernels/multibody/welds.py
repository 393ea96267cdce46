"""Closure of loops: exact, by welds; or by springs, across the welds or at hinges cut open (thesis 4.2.2).

Exact closure: overconstrained loops have redundant rows, which agree with the others while the loops are closed but
contradict them as soon as rounding opens the loops; solved with all rows, the linkage locks. So at the start of each
step independent rows are chosen by pivoted Cholesky of the Delassus matrix, and kept for the step; the projection
afterwards closes all rows.

Springs across the welds act on every row, so that no rows have to be chosen: states that are singular for exact closure
are regular for springs. The springs are stiff, and meant for linearly implicit steps, whose equations are those of
exact closure with slightly compliant rows.

At cut hinges, springs and dampers of zero length join the two panels at both ends M and N of the hinge line: along
three directions at M, and along the two across the hinge at N. The hinge's law, damper and stops act about the line.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, Signs, WholeNumbers
from hcsearch.kernels.algebra import (
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
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.hinges import Hinges, joint_torques, law_moment
from hcsearch.kernels.multibody.tree import (
    ROW_FREE_TURN,
    ROW_KIND,
    ROW_WELD,
    WAY_ARM_A,
    WAY_ARM_B,
    WAY_DIRECTION,
    WELD_BODY_A,
    WELD_BODY_B,
    WELD_FRAME,
    WELD_POINT_A,
    WORK_PLACE,
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    WORK_SPEED,
    WORK_SPIN,
    BodyTree,
    Work,
)

MIN_ROW_PIVOT_SHARE = 1e-11
"""A row is chosen when its pivot is above this share of the largest Delassus entry with all joints free."""


@compiled
def weld_errors(tree: BodyTree, work: Work, errors: Reals) -> float:
    """Write closure residuals, rotations (rad) and gaps over size; return the largest; call `place_bodies` first."""
    largest = 0.0
    b = work.bodies
    for r in range(len(tree.rows)):
        weld, kind = tree.rows[r, ROW_WELD], tree.rows[r, ROW_KIND]
        first, second = tree.welds[weld, WELD_BODY_A], tree.welds[weld, WELD_BODY_B]
        direction = vector_at(work.row_lines, r, WAY_DIRECTION)
        if kind < 3:
            # half the sum of a_k x b_k over the axes of both bodies is the axis times the sine of the angle between;
            # where b may turn about one axis, that axis alone says how it tilts, however far b has turned
            free = tree.rows[r, ROW_FREE_TURN]
            turn = (0.0, 0.0, 0.0)
            for k in range(3):
                if free < 0 or free == k:
                    fixed = vector_at(tree.weld_places, weld, WELD_FRAME + 3 * k)
                    rotated_axis = rotated(b, first, WORK_ROTATION, fixed) if first >= 0 else fixed
                    turn = vector_sum(turn, cross(rotated_axis, rotated(b, second, WORK_ROTATION, fixed)))
            value = (0.5 if free < 0 else 1.0) * dot(direction, turn)
        else:
            fixed = vector_at(tree.weld_places, weld, WELD_POINT_A)
            # from the joint of body a to the point of body b, less to its own
            gap = (
                vector_difference(vector_at(work.row_lines, r, WAY_ARM_A), rotated(b, first, WORK_ROTATION, fixed))
                if first >= 0
                else vector_difference(
                    vector_sum(vector_at(b, second, WORK_PLACE), vector_at(work.row_lines, r, WAY_ARM_B)), fixed
                )
            )
            value = dot(direction, gap) / tree.size
        errors[r] = value
        largest = max(largest, abs(value))
    return largest


@compiled
def weld_rates(tree: BodyTree, work: Work, rates: Reals) -> float:
    """Write relative velocities of welded bodies along the rows; return the largest; call `move_bodies` first."""
    largest = 0.0
    b = work.bodies
    for r in range(len(tree.rows)):
        weld = tree.rows[r, ROW_WELD]
        direction = vector_at(work.row_lines, r, WAY_DIRECTION)
        value = 0.0
        for side in range(2):
            body = tree.welds[weld, side]
            if body < 0:
                continue
            body_part = dot(direction, vector_at(b, body, WORK_SPIN))
            if tree.rows[r, ROW_KIND] >= 3:
                arm = vector_at(work.row_lines, r, WAY_ARM_B if side else WAY_ARM_A)
                velocity = vector_sum(vector_at(b, body, WORK_SPEED), cross(vector_at(b, body, WORK_SPIN), arm))
                body_part = dot(direction, velocity) / tree.size
            value += body_part if side else -body_part
        rates[r] = value
        largest = max(largest, abs(value))
    return largest


@compiled
def choose_rows(work: Work, scale: float) -> None:
    """Choose independent rows by pivoted Cholesky of the Delassus matrix, the largest pivots first.

    scale : largest diagonal entry of the Delassus matrix with all joints free.
    """
    m = len(work.chosen)
    pivots = work.pivots  # -inf once chosen
    for r in range(m):
        pivots[r] = work.delassus[r, r]
    count = 0
    factor = work.factor
    for k in range(m):
        best = -1
        for r in range(m):
            if pivots[r] > -np.inf and (best < 0 or pivots[r] > pivots[best]):
                best = r
        if pivots[best] <= MIN_ROW_PIVOT_SHARE * scale:
            break
        work.chosen[k] = best
        count += 1
        pivot = math.sqrt(pivots[best])
        pivots[best] = -np.inf
        for r in range(m):  # column k of the factor, by row of the Delassus matrix
            if pivots[r] > -np.inf:
                value = work.delassus[r, best]
                for j in range(k):
                    value -= factor[r, j] * factor[best, j]
                factor[r, k] = value / pivot
                pivots[r] -= factor[r, k] ** 2
        factor[best, k] = pivot
    work.chosen_count[0] = count


@compiled
def factor_chosen_rows(work: Work, scale: float) -> bool:
    """Factor the Delassus matrix on the chosen rows (Cholesky); return whether they are still independent."""
    count = work.chosen_count[0]
    factor, chosen = work.factor, work.chosen
    min_pivot = 1e-3 * MIN_ROW_PIVOT_SHARE * scale
    independent = True
    for k in range(count):
        r = chosen[k]
        for j in range(k + 1):
            value = work.delassus[r, chosen[j]]
            for i in range(j):
                value -= factor[r, i] * factor[chosen[j], i]
            if j < k:
                factor[r, j] = value / factor[chosen[j], j]
            else:
                if value < min_pivot:
                    value, independent = min_pivot, False
                factor[r, k] = math.sqrt(value)
    return independent


@compiled
def close_rows(work: Work, residual: Reals) -> None:
    """Write the row forces that cancel a residual on the chosen rows, 0 on others; call `factor_chosen_rows` first."""
    count = work.chosen_count[0]
    factor, chosen, forces = work.factor, work.chosen, work.forces
    forces[:] = 0.0
    for k in range(count):
        r = chosen[k]
        value = -residual[r]
        for j in range(k):
            value -= factor[r, j] * forces[chosen[j]]
        forces[r] = value / factor[r, k]
    for k in range(count - 1, -1, -1):
        r = chosen[k]
        value = forces[r]
        for j in range(k + 1, count):
            value -= factor[chosen[j], k] * forces[chosen[j]]
        forces[r] = value / factor[r, k]


@compiled
def spring_forces(tree: BodyTree, stiffness: float, damping: float, work: Work) -> None:
    """Write the spring forces of the rows, -k g - c g'; call `place_bodies` and `move_bodies` first."""
    weld_errors(tree, work, work.errors)
    weld_rates(tree, work, work.residual_rates)
    for r in range(len(work.forces)):
        work.forces[r] = -stiffness * work.errors[r] - damping * work.residual_rates[r]


@compiled
def forces_ahead(tree: BodyTree, stiffness: float, damping: float, g: float, moves: bool, work: Work) -> None:
    """Write the spring forces of the rows in an implicit stage; call `gather_inertias` and `load_joints` first.

    They are those at the state of the last iteration, plus what the change of a row's acceleration since then adds: g^2
    of it to the gap, and g to its rate. As the acceleration is linear in the forces, each row has a compliance of
    1 / (g^2 k + g c). `work.row_accelerations` are brought up to date.

    g : the step times the diagonal coefficient, s. moves : whether the state is that at the start of the step, so that
        its rates add to the gap, too.
    """
    m, resisting = len(work.forces), g * stiffness + damping if moves else damping
    stiff = g * (g * stiffness + damping)
    weld_errors(tree, work, work.errors)
    weld_rates(tree, work, work.residual_rates)
    for r in range(m):
        work.chosen[r] = r
        work.delassus[r, r] += 1.0 / stiff
        work.row_accelerations[r] -= (stiffness * work.errors[r] + resisting * work.residual_rates[r]) / stiff
        work.rates[r] -= work.row_accelerations[r]
    work.chosen_count[0] = m
    factor_chosen_rows(work, 0.0)
    close_rows(work, work.rates)
    for r in range(m):
        work.row_accelerations[r] -= work.forces[r] / stiff


@compiled
def spring_loss(damping: float, work: Work) -> float:
    """Return the power lost in the dampers of closure springs, from the rates in `work.residual_rates`."""
    lost = 0.0
    for r in range(len(work.residual_rates)):
        lost += damping * work.residual_rates[r] ** 2
    return lost


@compiled
def spring_energy(tree: BodyTree, stiffness: float, damping: float, work: Work) -> tuple[float, float]:
    """Return energy of the closure springs and power lost in their dampers; after `place_bodies` and `move_bodies`."""
    stored = lost = 0.0
    if stiffness > 0.0:
        weld_errors(tree, work, work.errors)
        weld_rates(tree, work, work.residual_rates)
        for r in range(len(work.forces)):
            stored += 0.5 * stiffness * work.errors[r] ** 2
        lost = spring_loss(damping, work)
    return stored, lost


class CutHinges(NamedTuple):
    """Hinges cut open and closed by springs, c of them.

    bodies : (c, 2), first and second, -1 the ground. points : (c, 12), M and N from the joint of the first body, then
        from that of the second. frames : (c, 9), the hinge's direction and two across it, fixed to the first body.
    hinges : laws, dampers and stops about the lines. stiffness, damping : of each of the five springs, N/m and Ns/m.
    """

    bodies: WholeNumbers
    points: Reals
    frames: Reals
    hinges: Hinges
    stiffness: float
    damping: float


@compiled
def _turned(work: Work, body: int, v: Vector3) -> Vector3:
    return rotated(work.bodies, body, WORK_ROTATION, v) if body >= 0 else v


@compiled
def _spin(work: Work, body: int) -> Vector3:
    return vector_at(work.bodies, body, WORK_SPIN) if body >= 0 else (0.0, 0.0, 0.0)


@compiled
def _point(work: Work, body: int, arm: Vector3) -> tuple[Vector3, Vector3]:
    """Return position and velocity of a point of a body, or of the ground."""
    if body < 0:
        return arm, (0.0, 0.0, 0.0)
    b = work.bodies
    return vector_sum(vector_at(b, body, WORK_PLACE), arm), vector_sum(
        vector_at(b, body, WORK_SPEED), cross(vector_at(b, body, WORK_SPIN), arm)
    )


@compiled
def cut_angles(cuts: CutHinges, work: Work, angles: Reals, speeds: Reals) -> None:
    """Write fold angles of cut hinges, from -pi/2 to 3 pi/2, and their rates; call `move_bodies` first."""
    for c in range(len(cuts.bodies)):
        first, second = cuts.bodies[c, 0], cuts.bodies[c, 1]
        line = _turned(work, first, vector_at(cuts.frames, c, 0))
        across = vector_at(cuts.frames, c, 3)
        first_across, second_across = _turned(work, first, across), _turned(work, second, across)
        angle = math.atan2(dot(line, cross(first_across, second_across)), dot(first_across, second_across))
        angles[c] = angle + 2.0 * math.pi if angle < -0.5 * math.pi else angle
        speeds[c] = dot(line, vector_difference(_spin(work, second), _spin(work, first)))


@compiled
def pull_cuts(cuts: CutHinges, branches: Signs, work: Work) -> None:
    """Add the forces of cut hinges to the external forces on bodies; call `move_bodies` first."""
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
            first_arm = _turned(work, first, vector_at(cuts.points, c, 3 * end))
            second_arm = _turned(work, second, vector_at(cuts.points, c, 6 + 3 * end))
            gap, speed = _gap(cuts, c, end, first_arm, second_arm, work)
            force = vector_sum(scaled_vector(-cuts.stiffness, gap), scaled_vector(-cuts.damping, speed))
            _push(work, second, second_arm, force, (0.0, 0.0, 0.0))
            _push(work, first, first_arm, scaled_vector(-1.0, force), (0.0, 0.0, 0.0))


@compiled
def _gap(
    cuts: CutHinges, c: int, end: int, first_arm: Vector3, second_arm: Vector3, work: Work
) -> tuple[Vector3, Vector3]:
    """Return the gap of a spring between its two points, and its rate; at N without the component along the hinge."""
    first, second = cuts.bodies[c, 0], cuts.bodies[c, 1]
    first_point, first_velocity = _point(work, first, first_arm)
    second_point, second_velocity = _point(work, second, second_arm)
    gap, speed = vector_difference(second_point, first_point), vector_difference(second_velocity, first_velocity)
    if end == 1:
        line = _turned(work, first, vector_at(cuts.frames, c, 0))
        gap = vector_difference(gap, scaled_vector(dot(line, gap), line))
        speed = vector_difference(speed, scaled_vector(dot(line, speed), line))
    return gap, speed


@compiled
def _push(work: Work, body: int, arm: Vector3, force: Vector3, couple: Vector3) -> None:
    if body >= 0:
        add_vector(work.bodies, body, WORK_PULL_COUPLE, vector_sum(couple, cross(arm, force)))
        add_vector(work.bodies, body, WORK_PULL_FORCE, force)


@compiled
def cut_gap(cuts: CutHinges, work: Work) -> float:
    """Return the greatest gap of a spring at cut hinges, m; call `move_bodies` first."""
    largest = 0.0
    for c in range(len(cuts.bodies)):
        for end in range(2):
            first_arm = _turned(work, cuts.bodies[c, 0], vector_at(cuts.points, c, 3 * end))
            second_arm = _turned(work, cuts.bodies[c, 1], vector_at(cuts.points, c, 6 + 3 * end))
            gap, _ = _gap(cuts, c, end, first_arm, second_arm, work)
            largest = max(largest, math.sqrt(dot(gap, gap)))
    return largest


@compiled
def cut_energy(cuts: CutHinges, branches: Signs, work: Work) -> tuple[float, float, float, float]:
    """Return energies of laws, stops and springs of cut hinges, and power lost in dampers; after `move_bodies`."""
    count = len(cuts.bodies)
    angles, speeds = np.empty(count), np.empty(count)
    cut_angles(cuts, work, angles, speeds)
    hinges = cuts.hinges
    stored = stops = across = lost = 0.0
    for c in range(count):
        _, energy = law_moment(hinges, c, branches[c], angles[c])
        stored += energy
        lost += hinges.damping[c] * speeds[c] ** 2
        beyond = min(angles[c] - hinges.lower[c], 0.0) + max(angles[c] - hinges.upper[c], 0.0)
        if beyond != 0.0 and hinges.stop_stiffness > 0.0:
            stops += 0.5 * hinges.stop_stiffness * beyond**2
            lost += hinges.stop_damping * speeds[c] ** 2
        for end in range(2):
            first_arm = _turned(work, cuts.bodies[c, 0], vector_at(cuts.points, c, 3 * end))
            second_arm = _turned(work, cuts.bodies[c, 1], vector_at(cuts.points, c, 6 + 3 * end))
            gap, speed = _gap(cuts, c, end, first_arm, second_arm, work)
            across += 0.5 * cuts.stiffness * dot(gap, gap)
            lost += cuts.damping * dot(speed, speed)
    return stored, stops, across, lost
