"""The deployment of a linkage in a scene, from its start to flat, and what became of it."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.collision.clearance import Clearance, certify
from hcsearch.collision.margins import resolution_of
from hcsearch.collision.reaches import reaches, slack_of
from hcsearch.deployment.compiling import Compiled, compile_scene
from hcsearch.deployment.driving import Drives
from hcsearch.deployment.outcomes import FLAT, STEPS, STILL, method_of, outcome_of, verdict_of
from hcsearch.deployment.reasons import reason_of_motion
from hcsearch.dynamics.driving import Driven, simulate_driven
from hcsearch.dynamics.simulation import Motion, closed_between, simulate
from hcsearch.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.linkage import Linkage
from hcsearch.scenes import Scene
from hcsearch.typing import Reals
from hcsearch.vocabulary import Formulation, Outcome, Verdict

DRIVEN = 1e-3
"""Error of a step under control, relative and absolute."""
STEEP = 1.4
"""A floating base that turns about its second axis by more than this (rad) nears the singularity of its angles."""


@dataclass(frozen=True)
class Deployment:
    """What became of a deployment.

    outcome : `flat`; `moving` when the time was over; `at rest` elsewhere; `jammed`, stops and loops together let
        nothing move on; `diverged`; `out of steps`. reason : in a sentence, with the remedy where there is one.
    angles, rates : (k, n_hinges), fold angles (rad) and their rates at `motion.times`.
    clearance : whether panels collide, certified for all times of the motion; None where nobody asked.
    seconds : computing time, without compilation of the kernels. driven : what drives did, where there are any.
    """

    compiled: Compiled
    motion: Motion
    outcome: Outcome
    reason: str
    angles: Reals
    rates: Reals
    clearance: Clearance | None
    seconds: float
    driven: Driven | None = None

    @property
    def verdict(self) -> Verdict:
        """Whether it comes flat, certified clear; collides; or neither is certain."""
        kind = None if self.clearance is None else self.clearance.kind
        return verdict_of(self.outcome, {"clear": True, "collides": False}.get(kind or ""))

    @property
    def deploys(self) -> bool:
        """Whether it comes flat, certified clear."""
        return self.verdict == "deploys"

    @property
    def flat_time(self) -> float | None:
        """When it was flat, s."""
        return float(self.motion.times[-1]) if self.outcome == "flat" else None


def deploy(
    linkage: Linkage,
    scene: Scene,
    formulation: Formulation = "constrained",
    *,
    method: str | None = None,
    tolerance: float = 1e-6,
    keep: frozenset[str] = frozenset(),
    certified: bool = True,
    max_steps: int | None = None,
    drives: Drives | None = None,
) -> Deployment:
    """Simulate a deployment until the array is flat, at rest, or the scene's time is over.

    keep : what is not to be left out. certified : whether collisions are looked for. drives : of hinges, with which the
    motion starts where they say; its tolerance is that of `run_driven`.
    """
    if drives is not None:
        return run_driven(compile_driven(linkage, scene, drives, formulation), drives, method=method)
    compiled = compile_scene(linkage, scene, formulation, keep=keep)
    return run(compiled, method=method, tolerance=tolerance, certified=certified, max_steps=max_steps)


def run(
    compiled: Compiled,
    *,
    method: str | None = None,
    tolerance: float = 1e-6,
    certified: bool = True,
    max_steps: int | None = None,
) -> Deployment:
    """Simulate a compiled scene; as `deploy`."""
    if not 1e-13 <= tolerance <= 1e-1:
        raise HcsearchError(f"a tolerance of {tolerance:g} is none: give one from 1e-13 to 0.1")
    scene = compiled.scene
    began = time.perf_counter()
    motion = simulate(
        compiled.system,
        compiled.start,
        end=compiled.seconds,
        method=method or method_of(compiled.formulation),
        tolerance=tolerance,
        restitution=scene.restitution,
        flat=FLAT,
        watched=compiled.hinged,
        rest=STILL,
        max_steps=max_steps or STEPS[compiled.formulation],
    )
    seconds = time.perf_counter() - began
    outcome = outcome_of(motion.ending)
    reason = reason_of_motion(compiled, motion)
    if scene.held == "free" and len(motion.q) and _steep(compiled, motion):
        outcome, reason = "diverged", "the floating base turns too far for its three angles: give it more inertia"
    angles, rates = compiled.of_hinges(motion.q, motion.v)
    clearance = _clearance(compiled, motion) if certified else None
    return Deployment(compiled, motion, outcome, reason, angles, rates, clearance, seconds)


def compile_driven(
    linkage: Linkage, scene: Scene, drives: Drives | None, formulation: Formulation = "constrained"
) -> Compiled:
    """Compile a scene for drives, of which nothing is left out that they may break: its mirror half, folded stops."""
    if formulation != "constrained":
        raise HcsearchError(
            f"drives are simulated with exact closure, not in the {formulation} formulation: leave it out"
        )
    if scene.held == "free":
        raise HcsearchError("drives are for an array that is held: hold a panel, such as --held bottom")
    compiled = compile_scene(linkage, scene, keep=frozenset({"half", "stops"}))
    if drives is None:
        return compiled
    drives.check(linkage)
    return replace(compiled, start=drives.start_in(compiled))


def run_driven(
    compiled: Compiled, drives: Drives, *, method: str | None = None, tolerance: float = DRIVEN, certified: bool = True
) -> Deployment:
    """Simulate a scene that `compile_driven` compiled, under position control, until flat or the scene's time is over.

    tolerance : of a step; what is missed by it control takes back. Stops are left out, as a course along them would
    hit them in every period: the motion is certified clear only where no hinge passes one by more than the margin.
    """
    began = time.perf_counter()
    system = compiled.system
    driven = simulate_driven(
        system.driven(tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in system.drives)),
        drives.commands(compiled),
        compiled.start,
        end=compiled.seconds,
        method=method or "implicit",
        tolerance=tolerance,
        restitution=compiled.scene.restitution,
        flat=FLAT,
        watched=compiled.hinged,
    )
    seconds = time.perf_counter() - began
    motion = driven.motion
    angles, rates = compiled.of_hinges(motion.q, motion.v)
    clearance = _within_stops(compiled, motion.times, angles, _clearance(compiled, motion)) if certified else None
    outcome, reason = (
        outcome_of(motion.ending),
        reason_of_motion(compiled, motion, "drive it more slowly, or more firmly"),
    )
    return Deployment(compiled, motion, outcome, reason, angles, rates, clearance, seconds, driven)


def judged(compiled: Compiled, motion: Motion, seconds: float = 0.0) -> Deployment:
    """A motion of a compiled scene as a deployment, certified; seconds : computing time."""
    angles, rates = compiled.of_hinges(motion.q, motion.v)
    outcome, reason = outcome_of(motion.ending), reason_of_motion(compiled, motion)
    return Deployment(compiled, motion, outcome, reason, angles, rates, _clearance(compiled, motion), seconds)


def _within_stops(compiled: Compiled, times: Reals, angles: Reals, clearance: Clearance) -> Clearance:
    """The verdict, `undecided` where panels of a hinge overlap by more than the margin, as no stop keeps them apart."""
    beyond = np.maximum(np.maximum(-angles, angles - math.pi), 0.0) * reaches(compiled.linkage)
    if clearance.kind != "clear" or beyond.max(initial=0.0) <= compiled.margin:
        return clearance
    state, hinge = np.unravel_index(beyond.argmax(), beyond.shape)
    own = compiled.linkage.pattern.hinges[int(hinge)]
    panels = (min(own.first, own.second), max(own.first, own.second))
    return replace(clearance, kind="undecided", time=float(times[state]), panels=panels)


def _steep(compiled: Compiled, motion: Motion) -> bool:
    """Whether the base has come near a state that its angles do not describe."""
    base = np.flatnonzero(~compiled.hinged)
    turns = [k for k in base if not compiled.system.joints[k].slides]
    return len(turns) == 3 and bool(np.abs(motion.q[:, turns[1]]).max() > STEEP)


def _clearance(compiled: Compiled, motion: Motion) -> Clearance:
    """The certified verdict on the motion."""
    linkage = compiled.linkage
    (times, q, v, a), gaps = closed_between(compiled.system, motion)
    angles, rates = compiled.of_hinges(q, v)
    cubic = motion.cubic or bool((compiled.joint_of < 0).any())  # accelerations of cut hinges are not known
    accelerations = np.zeros_like(angles) if cubic else a[:, compiled.joint_of]
    angles, rates, accelerations = map(np.ascontiguousarray, (angles, rates, accelerations))
    course = Course(times, angles, rates, accelerations, cubic)
    if (compiled.joint_of < 0).any():  # what the springs of cut hinges give way opens the loops
        gaps = np.maximum(gaps, motion.gap)
    # springs that close loops give way at impacts, for moments; exact loops hardly open at all
    slack = slack_of(linkage, 1.0) * (gaps if motion.cubic else gaps.max(initial=0.0))
    measured = motion.ending == "flat"
    return certify(
        linkage,
        course,
        margin=compiled.margin,
        resolution=resolution_of(linkage),
        slack=slack,
        apart=compiled.apart,
        measured=measured,
    )
