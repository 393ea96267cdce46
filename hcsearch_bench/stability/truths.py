"""How far off a simulation is: closed forms, a strip of panels by its own equations, limits, and finer simulations."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation
from hcsearch.scenes import Scene
from hcsearch.springs.accuracy.stability_points import judged_states
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.springs.dynamics.time_integration import Motion, simulate_system
from hcsearch_bench.stability.strips import StabilitySubject

FINE = 1_000
"""Least steps of a simulation that others are compared to, so that little is lost between its states."""
MANY = 200
"""A strip of so many panels costs seconds a time step: it is solved to 1e-10, others to 1e-12."""
SLOW = 1e-2
"""Impacts slower than this do not bounce (rad/s), by the model of stops."""


@dataclass(frozen=True)
class Truth:
    """What a simulation is compared with.

    name : what it is. error : of a deployment; rad, or a share of the largest energy. HcsearchError where it is not
        known.
    """

    name: str
    error: Callable[[Deployment], float]


@dataclass(frozen=True)
class Oscillator:
    """One hinge between two panels, of which one is held: inertia (kg m^2), damping (N m s/rad), stiffness (N m/rad).

    rest : angle without moment, rad; start : at rest there, rad.
    """

    inertia: float
    damping: float
    stiffness: float
    rest: float
    start: float

    def angles(self, times: Reals) -> Reals:
        """Fold angles, rad: the sum of two exponentials."""
        half, square = 0.5 * self.damping / self.inertia, self.stiffness / self.inertia
        root = cmath.sqrt(half * half - square)
        if abs(root) < 1e-9 * math.sqrt(square):
            return self.rest + (self.start - self.rest) * (1.0 + half * times) * np.exp(-half * times)
        fast = -half - root
        slow = square / fast  # not -half + root, of which nothing is left where damping is great
        away = (fast * np.exp(slow * times) - slow * np.exp(fast * times)) / (fast - slow)
        angles: Reals = self.rest + (self.start - self.rest) * away.real
        return angles

    def bounces(self, stop: float, restitution: float, times: Reals) -> Reals:
        """Fold angles where the rest lies beyond a stop from which it bounces; without damping, times rising."""
        rate = math.sqrt(self.stiffness / self.inertia)
        first, at_stop = self.start - self.rest, stop - self.rest
        angles = np.full(len(times), stop)
        begin, end = 0.0, math.acos(at_stop / first) / rate
        inside = times <= end
        angles[inside] = self.rest + first * np.cos(rate * times[inside])
        speed = rate * math.sqrt(first**2 - at_stop**2)
        while speed > SLOW and end < times[-1]:
            speed *= restitution
            begin, end = end, end + 2.0 * math.atan2(speed, rate * abs(at_stop)) / rate
            inside = (times > begin) & (times <= end)
            phase = rate * (times[inside] - begin)
            away = math.copysign(speed / rate, first)
            angles[inside] = self.rest + at_stop * np.cos(phase) + away * np.sin(phase)
        return angles


@dataclass(frozen=True)
class Strip:
    """Panels in a row on alternating faces, the first one held or with a base that floats: plane motion.

    side, thickness : m; density : kg/m^3. stiffness, rest, damping : (panels - 1,), of each hinge, N m/rad, rad,
    N m s/rad. base : mass (kg) and inertia (kg m^2) of what carries the first panel; None where it is held.
    rigid : a hinge that does not turn. Equations in the absolute angles of the panels, without joints or recursion;
    SciPy solves them.
    """

    panels: int
    side: float
    thickness: float
    density: float
    stiffness: Reals
    rest: Reals
    damping: Reals
    base: tuple[float, float] | None = None
    rigid: int | None = None

    @property
    def _arms(self) -> Reals:
        """(panels, panels), complex numbers: entry k, i is the way to the centre of panel k that turns with panel i."""
        n = self.panels
        sheet = np.array([0.0, self.thickness])
        out = sheet[(np.arange(n) + 1) % 2]  # the hinge after panel k: on top where k is even
        into = np.roll(out, 1)
        arms = np.tril(np.tile(self.side + 1j * (out - into), (n, 1)), -1)
        np.fill_diagonal(arms, 0.5 * self.side + 1j * (0.5 * self.thickness - into))
        arms[:, 0] = 0.5 * self.side + 1j * (out[0] - 0.5 * self.thickness)  # from the centre of the first panel
        arms[0, 0] = 0.0
        matrix: Reals = arms
        return matrix

    def angles(self, start: Reals, times: Reals) -> Reals:
        """Fold angles (k, panels - 1) at times that rise from 0, from rest."""
        return self.motion(start, float(times[-1]))(times)

    def motion(self, start: Reals, end: float) -> Callable[[Reals], Reals]:
        """Fold angles (k, panels - 1) by times up to the end, from rest."""
        tolerance = 1e-12 if self.panels < MANY else 1e-10
        n = self.panels
        turns = np.append(0.0, np.cumsum(self._senses * start))
        solution = solve_ivp(
            self._rates,
            (0.0, end),
            np.append(turns, np.zeros(n)),
            method="DOP853",
            dense_output=True,
            rtol=tolerance,
            atol=tolerance,
        )
        if not solution.success:
            raise HcsearchError(f"SciPy does not solve the strip: {solution.message}")

        def angles(times: Reals) -> Reals:
            result: Reals = self._senses * np.diff(solution.sol(times)[:n].T, axis=1)
            return result

        return angles

    @cached_property
    def _senses(self) -> Reals:
        """(panels - 1,), 1 for hinges on top, -1 for others."""
        return np.where(np.arange(self.panels - 1) % 2 == 0, 1.0, -1.0)

    @cached_property
    def _inertia(self) -> tuple[NDArray[np.complex128], Reals]:
        """Sums over the panels of mass times the product of two arms, and the panels' own inertias as a matrix."""
        n, mass = self.panels, self.density * self.side**2 * self.thickness
        masses, inertias = np.full(n, mass), np.full(n, mass * (self.side**2 + self.thickness**2) / 12)
        arms = self._arms
        if self.base is not None:
            masses[0] += self.base[0]
            inertias[0] += self.base[1]
        pairs = (arms.conj().T * masses) @ arms
        if self.base is not None:  # about the common centre of mass, which stays where it is
            way = masses @ arms
            pairs = pairs - np.outer(way.conj(), way) / masses.sum()
        return pairs, np.diag(inertias)

    def _rates(self, _: float, state: Reals) -> Reals:
        """Speeds and accelerations of the angles of the panels."""
        n, senses = self.panels, self._senses
        first = 0 if self.base is not None else 1
        pairs, own = self._inertia
        turns, speeds = state[:n], state[n:]
        moments = senses * (
            self.stiffness * (senses * (turns[1:] - turns[:-1]) - self.rest)
            + self.damping * senses * (speeds[1:] - speeds[:-1])
        )
        way = np.exp(1j * turns)
        both = pairs * (way.conj()[:, None] * way)
        matrix = both.real + own
        forces = both.imag @ speeds**2
        forces[:-1] += moments
        forces[1:] -= moments
        if (k := self.rigid) is not None:  # two panels turn as one: rows and columns of both are added
            matrix[k] += matrix[k + 1]
            matrix[:, k] += matrix[:, k + 1]
            matrix[k + 1] = 0.0
            matrix[:, k + 1] = 0.0
            matrix[k + 1, k], matrix[k + 1, k + 1] = -1.0, 1.0
            forces[k], forces[k + 1] = forces[k] + forces[k + 1], 0.0
        rates = np.zeros(2 * n)
        rates[:n] = speeds
        rates[n + first :] = np.linalg.solve(matrix[first:, first:], forces[first:])
        return rates


def analytic(name: str, way: Callable[[Reals], Reals]) -> Truth:
    """A truth by fold angles, (k,) or (k, n_hinges), that are known at all times."""

    def error(deployment: Deployment) -> float:
        times, angles = judged_states(deployment)
        return float(np.abs(angles - np.reshape(way(times), angles.shape)).max())

    return Truth(name, error)


@cache
def fine(subject: StabilitySubject, scene: Scene, formulation: Formulation, method: str, tolerance: float) -> Fine:
    """A simulation of the whole array in many steps; HcsearchError where it does not come to its end."""
    compiled = compile_scene(subject.linkage, scene, formulation, keep=frozenset(OMISSIONS))
    motion = simulate_system(
        compiled.system,
        subject.start_of(compiled),
        end=compiled.seconds,
        method=method,
        tolerance=tolerance,
        restitution=scene.restitution,
        flat=None if subject.flat else FLAT_FOLD_ANGLE,
        watched=compiled.hinged,
        longest_step=compiled.seconds / FINE,
        max_steps=20 * FINE,
    )
    if motion.ending not in {"time", "flat"}:
        raise HcsearchError(f"{method} at {tolerance:g} ends with {motion.ending}")
    return Fine(compiled, motion)


@dataclass(frozen=True)
class Fine:
    """A simulation to compare to."""

    compiled: CompiledScene
    motion: Motion

    def distance(self, deployment: Deployment) -> float:
        """Greatest distance of fold angles; of compliant stops up to the first impact."""
        hits = [event.time for event in self.motion.events if event.kind == "hit"]
        last = float(self.motion.times[-1])
        times, angles = judged_states(deployment, min([last, *hits]) if deployment.compiled.system.cuts else last)
        q = self.motion.at(times)
        return float(np.abs(angles - self.compiled.of_hinges(q, np.zeros_like(q))[0]).max())


def finer(
    subject: StabilitySubject,
    scene: Scene,
    *ways: tuple[str, float],
    formulation: Formulation = "constrained",
    name: str = "",
) -> Truth:
    """The first of several finer simulations, by method and tolerance, that comes to its end."""

    def error(deployment: Deployment) -> float:
        refusals = []
        for method, tolerance in ways:
            try:
                return fine(subject, scene, formulation, method, tolerance).distance(deployment)
            except HcsearchError as unable:
                refusals.append(str(unable))
        raise HcsearchError(f"no truth: {'; '.join(refusals)}")

    return Truth(name or " or ".join(f"{method} at {tolerance:g}" for method, tolerance in ways), error)


def energy_of_impacts(deployment: Deployment) -> float:
    """Greatest gain at an event, or error of the whole balance, as a share of the largest energy."""
    motion = deployment.motion
    gain = float(np.max(-np.diff(motion.lost), initial=0.0))
    return max(gain, motion.drift) / largest_energy(motion)


def largest_energy(motion: Motion) -> float:
    """The greatest of the energies of a motion, J."""
    return max(float(np.abs(part).max()) for part in (motion.kinetic, motion.stored, motion.height)) or 1.0
