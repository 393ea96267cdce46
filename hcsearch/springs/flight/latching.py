"""Loads of hinges that arrive at the flat state and latch: bounds by the energy of the springs, and simulated arrivals.

A hinge that arrives turns a little beyond flat, against the stiffness of its latch, until that has taken the energy of
the motion. Energy bounds the torque and what the root feels, whichever hinges arrive first. The impulse at one hinge
has no bound by energy, as loops may move it slowly while everything else moves fast: it is computed for simulated
arrivals. Proofs: docs/explanation/flight_modes.md, 5 to 8. Requirements: ECSS-E-ST-33-01C, 4.7.5.4.3 and 4.7.5.4.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import Law, LawBranch
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.springs.deployment.compiled_scene import AT_STOP_ANGLE
from hcsearch.springs.deployment.simulated_deployment import Deployment, hinge_arrivals
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.flight.deployed_modes import FloatingBase, PanelRates, panel_rates
from hcsearch.springs.flight.torque_margin import closed_rates

RESTING_RATE_SHARE = 1e-6
"""Share of the greatest rate below which a hinge at a stop is taken to rest there."""
INERTIA_TOLERANCE = 1e-9
"""Inverse inertias of hinges that arrive together are zero below this share of the greatest."""


@dataclass(frozen=True, eq=False)
class LatchBounds(ByValue):
    """Bounds of the loads of latching, never below what can happen from the start of the deployment.

    energy : J, that springs and gravity can give from the start. torques : (n_hinges,), of each latch, N m; NaN for a
    hinge without a latch. base_impulse, base_moment : what the root takes at one arrival, N s, and N m s about its
    centre of mass.
    """

    energy: float
    torques: Reals
    base_impulse: float
    base_moment: float

    @property
    def torque(self) -> float | None:
        """The greatest torque of a latch, N m; None without any."""
        latched = self.torques[~np.isnan(self.torques)]
        return float(latched.max()) if len(latched) else None


@dataclass(frozen=True, eq=False)
class ArrivalLoads(ByValue):
    """Loads of hinges that arrive together in a simulation.

    time : s. hinges : those that arrive. speeds : of each, rad/s. energy : J, kinetic, that these stops can take.
    impulses : at each of these hinges, N m s. torques : (n_hinges,), upper bounds for their latches, N m; NaN for other
    hinges. base_impulse, base_moment : as in `LatchBounds`.
    """

    time: float
    hinges: tuple[int, ...]
    speeds: Reals
    energy: float
    impulses: Reals
    torques: Reals
    base_impulse: float
    base_moment: float

    @property
    def impulse(self) -> float:
        """The greatest impulse at a hinge, N m s."""
        return float(np.abs(self.impulses).max(initial=0.0))


def latch_bounds(
    linkage: Linkage,
    laws: Sequence[Law],
    latch_stiffness: Reals,
    density: float,
    root: int,
    start: Reals,
    *,
    gravity: Sequence[float] = (0.0, 0.0, 0.0),
    restitution: float = 0.0,
    base: FloatingBase | None = None,
) -> LatchBounds:
    """Bound the loads of latching without a simulation, for springs that push no harder beyond flat than at flat.

    laws : of the hinges. latch_stiffness : (n_hinges,), N m/rad, 0 where there is no latch. start : (n_hinges,), fold
    angles at which the array is at rest, rad. gravity : m/s^2, in the axes of the root. restitution : of the stops.
    Others as in `deployed_modes`. HcsearchError for numbers of hinges that differ.
    """
    latches = np.asarray(latch_stiffness, float)
    if not len(laws) == linkage.n_hinges or latches.shape != (linkage.n_hinges,) or not (latches >= 0.0).all():
        raise HcsearchError(
            f"laws and stiffnesses of latches are one for each hinge: give {linkage.n_hinges}, and 0 for no latch"
        )
    bodies = panel_bodies(linkage, density)
    reach = panel_reach(linkage, root, np.array([body.centre for body in bodies]))
    masses = np.array([body.mass for body in bodies])
    spins = np.array([np.linalg.eigvalsh(body.inertia)[-1] for body in bodies])
    masses[root] = spins[root] = 0.0  # the root does not move, or is what takes the load
    energy = released_energy(laws, start)
    if base is None and any(gravity):
        centres = panel_rates(linkage, density, root, start).centres
        # gravity is given in the axes of the root, places in the axes of the base of the linkage
        arms = (centres - centres[root]) @ linkage.poses(start)[root, :, :3]
        energy += float((masses * (np.linalg.norm(gravity) * reach - arms @ np.array(gravity, float))).sum())
    preloads = np.array([max(0.0, law.straight.moment(0.0)) for law in laws])
    yielding = latches > 0.0
    pressed = np.where(yielding, 0.5 * preloads**2 / np.where(yielding, latches, 1.0), 0.0)
    torques = preloads + np.sqrt(preloads**2 + 2.0 * latches * (energy + pressed.sum() - pressed))
    momentum = (1.0 + restitution) * math.sqrt(2.0 * (energy + pressed.sum()))
    return LatchBounds(
        energy=float(energy),
        torques=np.where(yielding, torques, np.nan),
        base_impulse=momentum * math.sqrt(masses.sum()),
        base_moment=momentum * math.sqrt(float((masses * reach**2 + spins).sum())),
    )


def released_energy(laws: Sequence[Law], start: Reals) -> float:
    """Return the greatest energy that springs can give from the start, J: the stored one less the least one."""
    least = {law: _least_energy(law) for law in set(laws)}
    return math.fsum(law.energy(float(angle)) - least[law] for law, angle in zip(laws, start, strict=True))


def _least_energy(law: Law) -> float:
    """Return the least energy of a law between the stops, J, on both of its branches."""
    branches = [branch for branch in (law.straight, law.bent) if branch is not None]
    return min(branch.energy(angle) for branch in branches for angle in _turning_angles(branch))


def _turning_angles(branch: LawBranch) -> list[float]:
    """Return the angles from 0 to pi at which the energy of a branch may be least: ends, and zeros of its moment."""
    angles = [0.0, math.pi]
    for start, cubic in zip(branch.breaks, branch.cubics, strict=True):
        angles.append(start)
        angles += [start + float(root.real) for root in np.roots(cubic[::-1]) if np.isfinite(root)]
    return [angle for angle in angles if 0.0 <= angle <= math.pi]


def panel_reach(linkage: Linkage, root: int, centres: Reals) -> Reals:
    """Return the greatest distance of each panel's centre from the root's, however hinges are folded, (n_panels,), m.

    centres : (n_panels, 3), of the flat array. The way leads through the middles of hinges, whose distances no panel
    changes.
    """
    tree = hinge_tree(linkage.pattern, root)
    ways, reach = np.zeros(linkage.n_panels), np.zeros(linkage.n_panels)
    for panel in tree.order.tolist():
        parent = int(tree.parents[panel])
        if parent < 0:
            continue
        point = linkage.points[tree.hinges[panel]]
        before = centres[root] if parent == root else linkage.points[tree.hinges[parent]]
        ways[panel] = ways[parent] + float(np.linalg.norm(point - before))
        reach[panel] = ways[panel] + float(np.linalg.norm(centres[panel] - point))
    return reach


def arrival_loads(deployment: Deployment, latch_stiffness: Reals) -> tuple[ArrivalLoads, ...]:
    """Return the loads of hinges that arrive at flat in a simulated deployment.

    latch_stiffness : (n_hinges,), N m/rad, 0 where there is no latch. Hinges that rest at stops are taken to be held
    there. A deployment ends a little before all hinges are flat: each of those left is taken to arrive as the next.
    Hinges that the others bring to their stops without a rate of their own are left out.
    """
    hits = _flat_hits(deployment)
    if deployment.outcome == "flat":
        end = len(deployment.angles) - 1
        hits += [(end, (hinge,)) for hinge in np.flatnonzero(~_resting(deployment, end)).tolist()]
    loads: list[ArrivalLoads] = []
    for state in sorted({state for state, _ in hits}):
        stopped = _Stopping.of(deployment, state)
        loads += [stopped.loads(hinges, latch_stiffness) for at, hinges in hits if at == state]
    return tuple(loads)


def _flat_hits(deployment: Deployment) -> list[tuple[int, tuple[int, ...]]]:
    """Return the states just before hinges arrive at flat, and the hinges of each: one, or two mirror images."""
    times, hits = deployment.motion.times, []
    for arrival in hinge_arrivals(deployment):
        waiting = set(arrival.hinges) if arrival.stop == "flat" else set()
        for event in deployment.motion.events:
            hinges = deployment.compiled.hinges_of(event.joint)
            if event.kind != "hit" or event.time < arrival.time or not waiting.issuperset(hinges):
                continue
            waiting -= set(hinges)
            states = np.flatnonzero(times == event.time)  # before and after each of the events at this time
            state = int(states[np.abs(deployment.rates[states, hinges[0]] + abs(event.speed)).argmin()])
            if not _resting(deployment, state)[hinges].any():
                hits.append((state, tuple(hinges)))
    return hits


def _resting(deployment: Deployment, state: int) -> Flags:
    """Return which hinges rest at a stop, (n_hinges,)."""
    angles, speeds = deployment.angles[state], np.abs(deployment.rates[state])
    at_stop = (angles <= AT_STOP_ANGLE) | (angles >= math.pi - AT_STOP_ANGLE)
    resting: Flags = at_stop & (speeds <= RESTING_RATE_SHARE * speeds.max())
    return resting


@dataclass(frozen=True, eq=False)
class _Stopping(ByValue):
    """A state of a deployment at which hinges are stopped.

    motions : of panels. basis : (n_hinges, m), of the closed rates at which resting hinges stay. inertia : (m, m), in
    this basis. closed : (m,), the rates of the state in this basis.
    """

    deployment: Deployment
    state: int
    motions: PanelRates
    basis: Reals
    inertia: Reals
    closed: Reals

    @staticmethod
    def of(deployment: Deployment, state: int) -> _Stopping:
        """Return the state with its inertia."""
        linkage, setup = deployment.compiled.linkage, deployment.compiled.setup
        angles = deployment.angles[state]
        base = FloatingBase(setup.base_mass, setup.base_inertia) if setup.free else None
        motions = panel_rates(linkage, setup.density, setup.held, angles, base)
        held = np.eye(linkage.n_hinges)[_resting(deployment, state)]
        rates = closed_rates(np.vstack([linkage.closure(angles)[1], held])[None])
        basis = rates.bases(np.array([0]), int(rates.ranks[0]))[0]
        closed = basis.T @ deployment.rates[state]
        return _Stopping(deployment, state, motions, basis, basis.T @ motions.mass_matrix @ basis, closed)

    def loads(self, hinges: tuple[int, ...], latches: Reals) -> ArrivalLoads:
        """Return the loads when hinges are stopped together."""
        setup, rates = self.deployment.compiled.setup, self.deployment.rates[self.state]
        arriving, bounce = self.basis[list(hinges)], 1.0 + setup.restitution
        yielding = np.linalg.solve(self.inertia, arriving.T)
        speeds = arriving @ self.closed
        impulses = np.linalg.pinv(arriving @ yielding, rcond=INERTIA_TOLERANCE, hermitian=True) @ speeds
        energy = max(0.0, 0.5 * float(impulses @ speeds))
        given = bounce * self.motions.root_momenta(self.basis @ (yielding @ impulses))
        torques = np.full(len(rates), np.nan)
        for hinge in hinges:
            if latches[hinge] > 0.0:
                preload = max(0.0, setup.laws[hinge].straight.moment(0.0))
                torques[hinge] = preload + math.sqrt(preload**2 + 2.0 * latches[hinge] * energy)
        return ArrivalLoads(
            time=float(self.deployment.motion.times[self.state]),
            hinges=hinges,
            speeds=np.abs(speeds),
            energy=energy,
            impulses=bounce * impulses,
            torques=torques,
            base_impulse=float(np.linalg.norm(given[3:])),
            base_moment=float(np.linalg.norm(given[:3])),
        )
