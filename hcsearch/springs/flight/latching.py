"""Torque and impulse at hinges that arrive at the flat state, bounded by the energy of the springs.

No motion has more kinetic energy than the springs have lost, whatever the order in which hinges arrive. Proofs:
docs/explanation/flight.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.motion.collision.panel_reaches import longest_way
from hcsearch.motion.kinematics.local import local_at
from hcsearch.scenes.laws import Law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.mass_matrix import mass_matrix


@dataclass(frozen=True)
class LatchBounds:
    """Upper bounds at the arrival of hinges.

    torque : N m, of any latch, at any order of arrivals; None where no hinge has a latch. torque_hinge : where it is
    greatest. impulse : N m s, of a stiff stop at which a hinge arrives while no other hinge is held; None without a
    motion. impulse_hinge : likewise. energy : J, of which springs, and gravity, can lose no more.
    """

    torque: float | None
    torque_hinge: int | None
    impulse: float | None
    impulse_hinge: int | None
    energy: float


def available_energy(linkage: Linkage, setup: Setup, start: Reals) -> float:
    """Return a bound of the kinetic energy of any motion from rest, J; start : fold angles, (n_hinges,), rad.

    Springs lose no more than their energy at the start less the least between the stops; no panel falls by more than
    twice the longest way through the array.
    """
    at_start = sum(law.energy(float(angle)) for law, angle in zip(setup.laws, start, strict=True))
    least = sum(min(0.0, law.least_energy) for law in setup.laws)
    mass = setup.density * linkage.pattern.area * linkage.pattern.thickness
    fallen = mass * math.hypot(*setup.gravity) * 2.0 * longest_way(linkage) if any(setup.gravity) else 0.0
    return max(0.0, at_start - least + fallen)


def latch_bounds(
    linkage: Linkage, setup: Setup, latch_stiffness: Reals, start: Reals, before: Reals | None
) -> LatchBounds:
    """Bound torques and impulses at the arrival of hinges.

    latch_stiffness : (n_hinges,), N m/rad, 0 without a latch. start : fold angles at rest. before : a regular state of
    the motion next to the flat one, for the inertia that a hinge has there; None without a motion.
    """
    energy = available_energy(linkage, setup, start)
    torques = latch_torques(setup.laws, latch_stiffness, energy)
    impulses = np.zeros(0) if before is None else _impulses(linkage, setup, energy, before)
    torque = int(torques.argmax()) if (latch_stiffness > 0.0).any() else None
    impulse = int(impulses.argmax()) if len(impulses) else None
    return LatchBounds(
        None if torque is None else float(torques[torque]),
        torque,
        None if impulse is None else float(impulses[impulse]),
        impulse,
        energy,
    )


def latch_torques(laws: Sequence[Law], latch_stiffness: Reals, energy: float) -> Reals:
    """Return bounds of the torque of each latch, (n_hinges,), N m; 0 without a latch.

    A latch that is turned by x beyond flat stores k x^2 / 2, while the spring of its hinge gives p x, with its torque p
    when flat; each other latch gives p^2 / 2k at most. So k x^2 / 2 - p x is at most the energy and what others give.
    """
    preloads = np.array([max(0.0, law.straight.moment(0.0)) for law in laws])
    has_latch = latch_stiffness > 0.0
    stiffness = np.where(has_latch, latch_stiffness, 1.0)
    given = np.where(has_latch, preloads**2 / (2.0 * stiffness), 0.0)
    available = energy + given.sum() - given
    return np.where(has_latch, preloads + np.sqrt(preloads**2 + 2.0 * stiffness * available), 0.0)


def _impulses(linkage: Linkage, setup: Setup, energy: float, state: Reals) -> Reals:
    """Return (1 + e) sqrt(2 E J) of each hinge, (n_hinges,), N m s, with the inertia J that it has at a state."""
    basis = local_at(linkage, state).null_space()
    if not basis.shape[1]:
        return np.zeros(linkage.n_hinges)
    root = None if setup.free else setup.held
    masses = basis.T @ mass_matrix(linkage, state, setup.density, root) @ basis
    mobility = np.einsum("im,mk,ik->i", basis, np.linalg.inv(masses), basis)
    moves = mobility > MIN_MOBILITY_SHARE * mobility.max()
    inertia = np.where(moves, 1.0 / np.where(moves, mobility, 1.0), 0.0)
    impulses: Reals = (1.0 + setup.restitution) * np.sqrt(2.0 * energy * inertia)
    return impulses


MIN_MOBILITY_SHARE = 1e-6
"""Share of the greatest mobility below which a hinge hardly moves, and does not arrive."""
