"""Impacts at stops, and which stops go on holding afterwards."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals, Signs
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.multibody.contact import push_apart
from hcsearch.kernels.multibody.events import NEAR_STOP_ANGLE
from hcsearch.kernels.multibody.hinges import joint_momenta, kinetic_energy
from hcsearch.kernels.multibody.motion import DiscreteState, Mechanism, accelerate, project_state
from hcsearch.kernels.multibody.sweeps import gather_inertias, load_joints, move_bodies, place_bodies, release_joints
from hcsearch.kernels.multibody.tree import Work
from hcsearch.kernels.multibody.welds import choose_rows, close_rows, factor_chosen_rows


@lean
def _touching(mechanism: Mechanism, q: Reals, touching: Signs) -> bool:
    """Write which joints are at their lower (-1) and upper (1) stops; whether any is."""
    hinges = mechanism.hinges
    some = False
    for i in range(len(q)):
        touching[i] = 0
        if hinges.stop_stiffness == 0.0:
            if q[i] <= hinges.lower[i] + NEAR_STOP_ANGLE:
                touching[i] = -1
            elif q[i] >= hinges.upper[i] - NEAR_STOP_ANGLE:
                touching[i] = 1
        some = some or touching[i] != 0
    return some


@compiled
def update_held_joints(
    mechanism: Mechanism, hold: DiscreteState, slow: float, q: Reals, v: Reals, scale: float, work: Work, a: Reals
) -> bool:
    """Find which of the joints at rest at their stops are held there; whether that has changed. Writes accelerations.

    slow : speed (rad/s) below which a joint at its stop is at rest.
    """
    n = len(q)
    touching = np.empty(n, np.int8)
    some = _touching(mechanism, q, touching)
    before = hold.held.copy()
    hold.held[:] = 0
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    if not some:
        return bool(before.any())
    wanted = np.zeros(n)
    largest = 0.0
    for i in range(n):
        if abs(v[i]) > slow:
            touching[i] = 0
        wanted[i] = touching[i] * a[i]
        largest = max(largest, abs(a[i]))
    pushed, change = np.empty(n), np.empty(n)
    solved = push_apart(mechanism.tree, touching, wanted, scale, work, pushed, change)
    changed, creeping = False, False
    for i in range(n):
        # a joint at rest that neither pushes nor leaves stays held, so that rounding does not decide
        rests = abs(a[i] + change[i]) <= 1e-9 * largest
        if touching[i] and (not solved or pushed[i] > 0.0 or rests):
            hold.held[i] = touching[i]
            creeping = creeping or v[i] != 0.0
            q[i] = mechanism.hinges.lower[i] if touching[i] < 0 else mechanism.hinges.upper[i]
        changed = changed or hold.held[i] != before[i]
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
    """Velocities after impacts of all joints at their stops that move against them (Newton's law, as Moreau has it).

    restitution : 0 to 1. slow : speed (rad/s) below which nothing bounces: joints that knock each other off their
    stops, ever more slowly, come to rest together.
    """
    n = len(q)
    touching = np.empty(n, np.int8)
    if not _touching(mechanism, q, touching):
        return
    wanted, before = np.zeros(n), v.copy()
    fastest = 0.0
    for i in range(n):
        if touching[i]:
            q[i] = mechanism.hinges.lower[i] if touching[i] < 0 else mechanism.hinges.upper[i]
            speed = touching[i] * v[i]  # against the stop
            fastest = max(fastest, speed)
            wanted[i] = (1.0 + restitution) * speed if speed > slow else speed
    hold.held[:] = 0
    place_bodies(mechanism.tree, q, work)
    if fastest > slow:
        pushed, change = np.empty(n), np.empty(n)
        gather_inertias(mechanism.tree, hold.held, work)
        solved = push_apart(mechanism.tree, touching, wanted, scale, work, pushed, change)
        for i in range(n):
            v[i] += change[i]
            if touching[i] and abs(v[i]) <= 1e-9 * fastest:
                v[i] = 0.0
        # half the change and the mean velocity are orthogonal at most: no impact adds energy
        if solved and _norm(mechanism, change, work) <= 4.0 * _norm(mechanism, before, work) * (1.0 + 1e-6):
            return
        v[:] = before
    for i in range(n):
        if touching[i] and touching[i] * v[i] >= -slow:
            hold.held[i] = touching[i]
    arrest_joints(mechanism, hold, v, scale, work)
    project_state(mechanism.tree, hold.held, q, v, closed, work)


@compiled
def arrest_joints(mechanism: Mechanism, hold: DiscreteState, v: Reals, scale: float, work: Work) -> None:
    """The velocities nearest to some, by kinetic energy, with held joints at rest and loops closed; after `place`."""
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


@lean
def _norm(mechanism: Mechanism, v: Reals, work: Work) -> float:
    """Twice the kinetic energy of joint velocities; after `place`."""
    move_bodies(mechanism.tree, v, work)
    return 2.0 * kinetic_energy(mechanism.tree, work)
