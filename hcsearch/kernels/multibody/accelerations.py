"""Joint accelerations of a mechanism with closed loops, and the projection of states onto closed loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, Signs, WholeNumbers
from hcsearch.kernels.algebra import cross, put_vector, rotated, vector_at
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.drag import Drag, pull_drag
from hcsearch.kernels.multibody.hinges import (
    Hinges,
    Struts,
    Targets,
    add_drive_torques,
    add_friction,
    joint_torques,
    pull_struts,
    set_factors,
    write_drive_targets,
)
from hcsearch.kernels.multibody.sweeps import gather_inertias, load_joints, move_bodies, place_bodies, release_joints
from hcsearch.kernels.multibody.tree import (
    BODY_CENTRE,
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    BodyTree,
    Work,
)
from hcsearch.kernels.multibody.welds import (
    CutHinges,
    choose_rows,
    close_rows,
    factor_chosen_rows,
    forces_ahead,
    pull_cuts,
    spring_energy,
    spring_forces,
    weld_errors,
    weld_rates,
)


class Mechanism(NamedTuple):
    """A mechanism: bodies, joints, loops and the forces on them.

    loads : (n, 3), constant forces at the centres of mass, N; or no rows.
    closure_stiffness, closure_damping : of springs in place of exact closure, N m and N m s per rad, or per gap over
        size; 0 where closure is exact.
    overdamped : whether bodies have no inertia, so that only dampers resist; masses are then 0 and weights are loads.
    targets : of the drives, as functions of time. drag : of facets, none in a vacuum.
    """

    tree: BodyTree
    hinges: Hinges
    struts: Struts
    cuts: CutHinges
    loads: Reals
    closure_stiffness: float
    closure_damping: float
    overdamped: bool
    targets: Targets
    drag: Drag


HELD_BY_FRICTION = 2
"""Entry of `DiscreteState.held` of a joint that friction holds, away from its stops."""


class DiscreteState(NamedTuple):
    """The discrete part of a state.

    held : (n,), -1 at the lower stop, 1 at the upper, `HELD_BY_FRICTION`, 0 free. branches : (n,), 0 straight, 1 bent,
        of laws that snap; cut_branches : the same of cut hinges. slides : (n,), sign of the rates of sliding joints
        with friction, 0 of others; no entries where no joint has friction.
    """

    held: Signs
    branches: Signs
    cut_branches: Signs
    slides: Signs


class Stepper(NamedTuple):
    """The mechanism, tolerances and work tables that each integration step needs.

    scale : `largest_pivot`, which other pivots are compared to. relative_tolerance,
        absolute_tolerance : of the error of a step.
    stages : (s + 1, 2 n + 2), derivatives of the state (q, v, energy lost, time) in a step, the last one at its end.
    start, end : (2 n + 2,), states at both ends of the step. counts : of the record.
    """

    mechanism: Mechanism
    hold: DiscreteState
    scale: float
    relative_tolerance: float
    absolute_tolerance: float
    work: Work
    stages: Reals
    start: Reals
    end: Reals
    counts: WholeNumbers


def discrete_state_for(mechanism: Mechanism, q: Reals) -> DiscreteState:
    """Return the discrete state at given coordinates: no joint held, laws bent beyond `snaps_up`."""
    hinges, n = mechanism.hinges, len(mechanism.tree.links)
    return DiscreteState(
        np.zeros(n, np.int8),
        (q > hinges.snaps_up).astype(np.int8),
        np.zeros(len(mechanism.cuts.bodies), np.int8),
        np.zeros(len(hinges.friction), np.int8),
    )


@compiled
def update_bodies(mechanism: Mechanism, hold: DiscreteState, q: Reals, v: Reals, work: Work) -> None:
    """Write positions and velocities of all bodies, and the forces of loads, struts, cut hinges and drag on them."""
    tree = mechanism.tree
    place_bodies(tree, q, work)
    move_bodies(tree, v, work)
    is_pulled = len(mechanism.struts.stiffness) or len(mechanism.cuts.bodies) or len(mechanism.loads)
    if is_pulled or len(mechanism.drag.bodies):
        for i in range(len(q)):
            put_vector(work.bodies, i, WORK_PULL_COUPLE, (0.0, 0.0, 0.0))
            put_vector(work.bodies, i, WORK_PULL_FORCE, (0.0, 0.0, 0.0))
        for i in range(len(mechanism.loads)):
            force = vector_at(mechanism.loads, i, 0)
            arm = rotated(work.bodies, i, WORK_ROTATION, vector_at(tree.bodies, i, BODY_CENTRE))
            put_vector(work.bodies, i, WORK_PULL_COUPLE, cross(arm, force))
            put_vector(work.bodies, i, WORK_PULL_FORCE, force)
        pull_struts(mechanism.struts, work)
        pull_cuts(mechanism.cuts, hold.cut_branches, work)
        pull_drag(mechanism.drag, work)


@compiled
def solve_accelerations(
    mechanism: Mechanism, hold: DiscreteState, scale: float, fresh: bool, work: Work, a: Reals
) -> bool:
    """Write joint accelerations under the forces in `work.torques`; call `update_bodies` first. See `accelerate`."""
    tree = mechanism.tree
    gather_inertias(tree, hold.held, work)
    load_joints(tree, hold.held, work.torques, True, work)
    independent = True
    if mechanism.closure_stiffness > 0.0:
        spring_forces(tree, mechanism.closure_stiffness, mechanism.closure_damping, work)
    else:
        if fresh:
            choose_rows(work, scale)
        independent = factor_chosen_rows(work, scale)
        close_rows(work, work.rates)
    release_joints(tree, hold.held, True, work, a)
    return independent


@compiled
def solve_accelerations_ahead(
    mechanism: Mechanism, hold: DiscreteState, g: float, moves: bool, work: Work, a: Reals
) -> None:
    """Write joint accelerations with closure springs as of `forces_ahead`; call `update_bodies` first."""
    tree = mechanism.tree
    gather_inertias(tree, hold.held, work)
    load_joints(tree, hold.held, work.torques, True, work)
    forces_ahead(tree, mechanism.closure_stiffness, mechanism.closure_damping, g, moves, work)
    release_joints(tree, hold.held, True, work, a)


@compiled
def closure_energy(mechanism: Mechanism, work: Work) -> tuple[float, float]:
    """Return energy of the closure springs and power lost in their dampers; call `update_bodies` first."""
    return spring_energy(mechanism.tree, mechanism.closure_stiffness, mechanism.closure_damping, work)


@compiled
def accelerate(
    mechanism: Mechanism, hold: DiscreteState, q: Reals, v: Reals, scale: float, fresh: bool, work: Work, a: Reals
) -> bool:
    """Write joint accelerations (holding forces at held joints); return whether the chosen rows were independent.

    In overdamped motion the results are velocities, and `v` is 0. Drives are evaluated at the time `work.time`. The
    constraint forces of the rows are left in `work.forces`.

    scale : as of `choose_rows`. fresh : whether to choose independent rows anew.
    """
    update_bodies(mechanism, hold, q, v, work)
    set_factors(mechanism.hinges, work.time[0])
    joint_torques(mechanism.hinges, hold.branches, q, v, work.torques)
    add_friction(mechanism.hinges, hold.slides, work.torques)
    write_drive_targets(mechanism.targets, work.time[0], work)
    add_drive_torques(mechanism.targets, q, v, work, work.torques)
    if mechanism.overdamped:
        for i in range(len(work.added_inertia)):
            work.added_inertia[i] = mechanism.hinges.damping[i]
    return solve_accelerations(mechanism, hold, scale, fresh, work, a)


@compiled
def largest_pivot(mechanism: Mechanism, q: Reals, work: Work) -> float:
    """Return the largest diagonal entry of the Delassus matrix with all joints free: the scale of pivots."""
    tree, n = mechanism.tree, len(q)
    if mechanism.overdamped:
        for i in range(len(work.added_inertia)):
            work.added_inertia[i] = mechanism.hinges.damping[i]
    place_bodies(tree, q, work)
    move_bodies(tree, np.zeros(n), work)
    gather_inertias(tree, np.zeros(n, np.int8), work)
    largest = 0.0
    for r in range(len(tree.rows)):
        largest = max(largest, work.delassus[r, r])
    return largest


@compiled
def project_state(tree: BodyTree, held: Signs, q: Reals, v: Reals, closed: float, work: Work) -> tuple[float, float]:
    """Project a state onto closed loops in the mass metric; return the remaining residual and its rate.

    Newton iteration with the factor stored in `work`, hence only near the state at which that was computed. The
    iteration that closes linkages (`linkage.loops.weigh_rows`) differs: it minimises the change of the angles, and
    recomputes the Jacobian.

    closed : residual (and rate) at which to stop; three steps at most.
    """
    residual = rate = 0.0
    for k in range(4):
        place_bodies(tree, q, work)
        residual = weld_errors(tree, work, work.errors)
        if residual <= closed or k == 3:
            break
        _correct(tree, held, q, work)
    for k in range(3):
        move_bodies(tree, v, work)
        rate = weld_rates(tree, work, work.errors)
        if rate <= closed or k == 2:
            break
        _correct(tree, held, v, work)
    return residual, rate


@compiled
def _correct(tree: BodyTree, held: Signs, state: Reals, work: Work) -> None:
    """Correct joint coordinates or velocities by the closure errors in `work.errors`."""
    load_joints(tree, held, work.zeros, False, work)
    close_rows(work, work.errors)
    release_joints(tree, held, False, work, work.projection_change)
    for i in range(len(state)):
        if not held[i]:
            state[i] += work.projection_change[i]
