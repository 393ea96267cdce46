"""Latch and release: springs alone, with hinges that are held at first and let go one after the other.

On a path some hinges leave the packed state later than others. Each of these is latched, and let go by one other hinge:
the one that has turned furthest on the path when it leaves, at the angle that it has then. Latches are stops.
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
"""A hinge has left the packed state when it has turned by this (rad)."""
LATCH_DELAY_SHARE = 0.05
"""A hinge is latched that leaves later than the first by more than this share of the path."""
LATCH_CHECK_INTERVAL = 0.002
"""Latches are looked at in these intervals (s)."""


@dataclass(frozen=True)
class Latch:
    """A hinge that waits for another one: until that has come down to an angle (rad)."""

    hinge: int
    waits_for: int
    angle: float


def latches_on(linkage: Linkage, angles: Reals) -> tuple[Latch, ...]:
    """Which hinges wait for which on a path, (k, n_hinges), from packed to flat; in the order in which they are let go.

    Hinges that stay flat in both states wait for none.
    """
    closing = np.flatnonzero(linkage.folded > 0.0)
    turned = linkage.folded - angles
    left = np.array([int((np.abs(turned[:, hinge]) > DEPARTURE_ANGLE).argmax()) for hinge in closing])
    first = int(left.min(initial=len(angles)))
    latches = []
    for place, hinge in sorted(zip(left.tolist(), closing.tolist(), strict=True)):
        if place - first <= LATCH_DELAY_SHARE * len(angles):
            continue
        ahead = closing[left < place]
        other = int(ahead[turned[place, ahead].argmax()])
        latches.append(Latch(hinge, other, float(angles[place, other])))
    return tuple(latches)


def simulate_latched(compiled: CompiledScene, latches: tuple[Latch, ...], *, tolerance: float = 1e-6) -> Deployment:
    """Simulate springs with latches, in a scene that `compile_driven` compiled, from its start."""
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
    """The system with stops where latches hold hinges."""
    drives = list(compiled.system.drives)
    for latch in waiting:
        joint = int(compiled.joint_of[latch.hinge])
        drives[joint] = replace(drives[joint], lower=float(compiled.start[joint]), upper=math.inf)
    return compiled.system.driven(tuple(drives))
