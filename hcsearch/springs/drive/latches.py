"""Latches: deployments by springs alone, with hinges that are held at first and released one after the other.

On a path some hinges leave the packed state later than others. Each of these is latched, and released by one other
hinge: the one that has turned furthest on the path by then, at its angle at that place. Latches are modelled as stops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.springs.deployment.simulated_deployment import Deployment, deployment_of_motion
from hcsearch.springs.dynamics.system import System
from hcsearch.springs.dynamics.time_integration import Motion, joined_motion, simulate_system

DEPARTURE_ANGLE = 0.05
"""Turn (rad) from which on a hinge has left the packed state."""
LATCH_DELAY_SHARE = 0.05
"""Delay after the first hinge, as a share of the path, beyond which a hinge is latched."""
LATCH_CHECK_INTERVAL = 0.002
"""Interval at which the release of latches is checked (s)."""


@dataclass(frozen=True)
class Latch:
    """A hinge that is held until another one has unfolded to an angle (rad)."""

    hinge: int
    waits_for: int
    angle: float


def latches_on(linkage: Linkage, angles: Reals) -> tuple[Latch, ...]:
    """Return the latches that follow from a path, (k, n_hinges), from packed to flat; in the order of their release.

    Hinges that are flat in both states are not latched.
    """
    closing = np.flatnonzero(linkage.folded > 0.0)
    turns = linkage.folded - angles
    departures = np.array([int((np.abs(turns[:, hinge]) > DEPARTURE_ANGLE).argmax()) for hinge in closing])
    first = int(departures.min(initial=len(angles)))
    latches = []
    for departure, hinge in sorted(zip(departures.tolist(), closing.tolist(), strict=True)):
        if departure - first <= LATCH_DELAY_SHARE * len(angles):
            continue
        ahead = closing[departures < departure]
        releasing = int(ahead[turns[departure, ahead].argmax()])
        latches.append(Latch(hinge, releasing, float(angles[departure, releasing])))
    return tuple(latches)


def simulate_latched(compiled: CompiledScene, latches: tuple[Latch, ...], *, tolerance: float = 1e-6) -> Deployment:
    """Simulate a deployment by springs with latches, from the start of a scene compiled by `compile_driven`."""
    q, v, waiting = compiled.start.copy(), np.zeros(len(compiled.start)), set(latches)
    motions: list[Motion] = []
    starts: list[float] = []
    now = 0.0
    while now < compiled.seconds:
        motion = simulate_system(
            _latched(compiled, waiting),
            q,
            v,
            end=LATCH_CHECK_INTERVAL if waiting else compiled.seconds - now,
            tolerance=tolerance,
            restitution=compiled.setup.restitution,
            flat=FLAT_FOLD_ANGLE,
            watched=compiled.hinged,
        )
        motions.append(motion)
        starts.append(now)
        q, v, now = motion.q[-1].copy(), motion.v[-1].copy(), now + float(motion.times[-1])
        if motion.ending != "time":
            break
        angles = q[compiled.joint_of]
        waiting = {latch for latch in waiting if angles[latch.waits_for] > latch.angle}
    return deployment_of_motion(compiled, joined_motion(motions, starts))


def _latched(compiled: CompiledScene, waiting: set[Latch]) -> System:
    """Return the system with stops at the latched hinges."""
    drives = list(compiled.system.drives)
    for latch in waiting:
        joint = int(compiled.joint_of[latch.hinge])
        drives[joint] = replace(drives[joint], lower=float(compiled.start[joint]), upper=math.inf)
    return compiled.system.driven(tuple(drives))
