"""Motions under position control: in driven joints a torque that is known beforehand, and what pulls towards a course.

The controller is sampled, as those of machines are: in each period torque, angle and rate that are asked for stay what
they are in its middle, so that a drive is a linear law with a damper, in the tables of laws that the kernels read. No
kernel knows of drives; periods are simulated one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.dynamics.methods import method_named
from hcsearch.dynamics.simulation import Motion, joined, motion_of, plan_for, record_for
from hcsearch.dynamics.system import System
from hcsearch.kernels.multibody import simulation as kernel
from hcsearch.kernels.multibody.hinges import Hinges
from hcsearch.kernels.multibody.motion import Mechanism, hold_for
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.typing import Reals, Whole

ROOM = 3000
"""Steps of a period that there is room for."""


@dataclass(frozen=True)
class Demand:
    """What drives are asked for.

    times : (k,), s, from 0. angles, torques : (k, n_driven), rad and N m: splines through the angles,
    at rest at both ends, straight lines between the torques; the last ones hold from then on.
    stiffness, damping : (n_driven,), torque for an angle (N m/rad) and for a rate (N m s/rad) that is missed.
    period : of the controller, s.
    """

    times: Reals
    angles: Reals
    torques: Reals
    stiffness: Reals
    damping: Reals
    period: float

    @cached_property
    def _course(self) -> Any:
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - loads slowly

        return CubicSpline(self.times, self.angles, bc_type="clamped")

    def at(self, times: Reals) -> tuple[Reals, Reals, Reals]:
        """Angles, rates and torques that are asked for at times, each (len(times), n_driven)."""
        over = times >= self.times[-1]
        own = np.clip(times, self.times[0], self.times[-1])
        angles, rates = np.asarray(self._course(own), float), np.asarray(self._course(own, 1), float)
        rates[over] = 0.0
        torques = np.array([np.interp(own, self.times, column) for column in self.torques.T]).T
        return angles, rates, torques.reshape(angles.shape)


@dataclass(frozen=True)
class Commands(Demand):
    """What driven joints are asked for; joints : their numbers."""

    joints: tuple[int, ...]


@dataclass(frozen=True)
class Driven:
    """A motion under control.

    motion : its energies are those of the system without its drives, and `work` (k,) is what these have done (J).
    torques : (k, n_driven), of the drives at its states, N m. missed : (k, n_driven), angles less those asked for.
    """

    motion: Motion
    work: Reals
    torques: Reals
    missed: Reals

    @property
    def drift(self) -> float:
        """Greatest error of the energy balance, J."""
        own = self.motion
        total = own.kinetic + own.stored + own.height + own.in_stops + own.damped + own.lost - self.work
        return float(np.abs(total - total[0]).max())


class _Piece(NamedTuple):
    """What one period left: its motion, beginning at time 0, and the constant part of the drives' laws in it."""

    began: float
    motion: Motion
    constants: Reals


def simulate_driven(
    system: System,
    commands: Commands,
    q: Reals,
    *,
    end: float,
    method: str = "dormand-prince",
    tolerance: float = 1e-6,
    restitution: float = 0.0,
    flat: float | None = None,
    watched: NDArray[np.bool_] | None = None,
    max_steps: int = 200_000,
) -> Driven:
    """Follow a system under control from a closed state at rest to a time (s); as `simulation.simulate`."""
    control = _Control(system, commands)
    plan = plan_for(
        system, end=commands.period, tolerance=tolerance, restitution=restitution, flat=flat, watched=watched
    )
    coordinates, speeds = np.array(q, float), np.zeros(system.n_joints)
    mechanism = control.mechanism
    hold, work, record = hold_for(mechanism, coordinates), work_for(mechanism.tree), record_for(system.n_joints, ROOM)
    pieces: list[_Piece] = []
    steps = 0
    for number in range(max(1, int(np.ceil(end / commands.period - 1e-9)))):
        constants = control.ask(number)
        kernel.simulate(mechanism, hold, method_named(method), plan, coordinates, speeds, work, record)
        pieces.append(_Piece(number * commands.period, motion_of(record, system), constants))
        steps += pieces[-1].motion.steps
        if pieces[-1].motion.ending != "time" or steps > max_steps:
            break
    return control.joined(pieces, too_many=steps > max_steps)


class _Control:
    """Drives as laws of the joints, whose constant part is written anew in each period."""

    def __init__(self, system: System, commands: Commands) -> None:
        self.system, self.commands = system, commands
        self.driven = np.array(commands.joints, int)
        count = max(1, int(np.ceil(commands.times[-1] / commands.period)))
        angles, rates, torques = commands.at((np.arange(count + 1, dtype=float) + 0.5) * float(commands.period))
        self.constants = -commands.stiffness * angles - commands.damping * rates - torques
        base = system.mechanism
        hinges, self.rows, self.owners = _own_pieces(base.hinges, self.driven)
        damping = hinges.damping.copy()
        damping[self.driven] += commands.damping
        self.hinges = hinges._replace(damping=damping)
        breaks, stiffness = hinges.breaks[self.rows], commands.stiffness[self.owners]
        self.hinges.cubics[self.rows, 0] += stiffness * breaks
        self.hinges.cubics[self.rows, 1] += stiffness
        self.hinges.energies[self.rows] += 0.5 * stiffness * breaks**2
        self.moments = self.hinges.cubics[self.rows, 0].copy()
        self.energies = self.hinges.energies[self.rows].copy()
        self.mechanism: Mechanism = base._replace(hinges=self.hinges)

    def ask(self, number: int) -> Reals:
        """Write the laws of a period; the constant parts of the drives."""
        own = min(number, len(self.constants) - 1)
        constants = self.constants[own]
        added = constants[self.owners]
        self.hinges.cubics[self.rows, 0] = self.moments + added
        self.hinges.energies[self.rows] = self.energies + added * self.hinges.breaks[self.rows]
        return np.asarray(constants)

    def joined(self, pieces: list[_Piece], *, too_many: bool) -> Driven:
        """The pieces as one motion; where one ends and the next begins, velocities agree and accelerations jump."""
        parts = [self._without(piece) for piece in pieces]
        own, motions = self.commands, [part[0] for part in parts]
        motion = joined(motions, [piece.began for piece in pieces])
        if too_many:
            motion = replace(motion, ending="steps")
        done = np.cumsum([0.0, *(part[1][-1] for part in parts)])
        work = np.concatenate([part[1] + before for part, before in zip(parts, done, strict=False)])
        constants = np.concatenate([np.tile(p.constants, (len(p.motion.times), 1)) for p in pieces])
        angles, rates = motion.q[:, self.driven], motion.v[:, self.driven]
        torques = -(constants + own.stiffness * angles + own.damping * rates)
        return Driven(motion, work, torques, angles - own.at(motion.times)[0])

    def _without(self, piece: _Piece) -> tuple[Motion, Reals]:
        """A piece with the energies of the system without its drives, and the work of these, (k,)."""
        motion, own = piece.motion, self.commands
        angles, rates, pushes = (part[:, self.driven] for part in (motion.q, motion.v, motion.a))
        held = (piece.constants * angles + 0.5 * own.stiffness * angles**2).sum(axis=1)
        step = np.diff(motion.times)[:, None]
        middle = 0.5 * (rates[1:] + rates[:-1]) + step * (pushes[:-1] - pushes[1:]) / 8.0
        taken = own.damping * step * (rates[1:] ** 2 + rates[:-1] ** 2 + 4.0 * middle**2) / 6.0
        taken = np.r_[0.0, np.cumsum(taken.sum(axis=1))]
        return replace(motion, damped=motion.damped - taken, stored=motion.stored - held), held[0] - held - taken


def _own_pieces(hinges: Hinges, driven: Whole) -> tuple[Hinges, Whole, Whole]:
    """The tables with pieces of laws that driven joints share with none; rows of these, and whose they are."""
    pieces = hinges.pieces.copy()
    breaks, cubics, energies = [hinges.breaks], [hinges.cubics], [hinges.energies]
    rows: list[int] = []
    owners: list[int] = []
    size = len(hinges.breaks)
    for number, joint in enumerate(driven):
        for branch in range(2):
            first, last = hinges.pieces[joint, branch]
            breaks.append(hinges.breaks[first:last])
            cubics.append(hinges.cubics[first:last])
            energies.append(hinges.energies[first:last])
            pieces[joint, branch] = size, size + last - first
            rows += range(size, size + last - first)
            owners += [number] * int(last - first)
            size += int(last - first)
    tables = hinges._replace(
        pieces=pieces, breaks=np.concatenate(breaks), cubics=np.concatenate(cubics), energies=np.concatenate(energies)
    )
    return tables, np.array(rows, int), np.array(owners, int)
