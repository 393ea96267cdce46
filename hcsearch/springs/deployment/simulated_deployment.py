"""Simulations of the deployment of a linkage in a scene, by springs or drives, with clearance and arrivals."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Ending, Formulation, Verdict
from hcsearch.kernels.multibody.events import StateSeries
from hcsearch.motion.collision.clearance import Clearance, certify_clearance
from hcsearch.motion.collision.panel_prisms import reaches, resolution_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import labels_of, named_hinges
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.drives import DrivenMotion, Drives, simulate_driven
from hcsearch.springs.deployment.outcomes import (
    FLAT_FOLD_ANGLE,
    MAX_DEPLOYMENT_STEPS,
    DeploymentCheck,
    flat_time_of,
    methods_of,
    outcome_of,
    reason_of_motion,
    reason_with_clearance,
)
from hcsearch.springs.deployment.play import Play, course_of_deployment, play_of_deployment
from hcsearch.springs.deployment.released_hinges import held_at_end, simulate_releases
from hcsearch.springs.dynamics.integration_methods import interpolate_motion
from hcsearch.springs.dynamics.time_integration import (
    Motion,
    closed_states,
    greatest_opening,
    loose_states,
)
from hcsearch.system.work_steps import work_step

DRIVEN_STEP_TOLERANCE = 1e-5
"""Error tolerance of a step under control, relative and absolute."""
MIN_BALANCE_ENERGY = 1e-300
"""Least energy (J) by which the error of the balance is divided."""
STEEP_BASE_ANGLE = 1.4
"""Turn of a floating base about its second axis (rad) beyond which it is near the singularity of its angles."""


@dataclass(frozen=True, eq=False)
class Deployment(ByValue):
    """One deployment, with its states.

    outcome : as in `DeploymentCheck`. reason : a sentence on the outcome, with a remedy where one may lead to another
    verdict.
    angles, rates : (k, n_hinges), fold angles (rad) and their rates at `motion.times`.
    clearance : whether panels collide, certified for all times of the motion; None if not checked.
    seconds : computing time, without compilation of the kernels; equal deployments may differ in it.
    driven : the motion with its drives, if there are any.
    """

    compiled: CompiledScene
    motion: Motion
    outcome: Ending
    reason: str
    angles: Reals
    rates: Reals
    clearance: Clearance | None
    seconds: float = field(compare=False)
    driven: DrivenMotion | None = None

    @cached_property
    def check(self) -> DeploymentCheck:
        """The result without the states, as `check_deployments` reports it."""
        motion, clearance, size = self.motion, self.clearance, math.pi * max(1, self.angles.shape[1])
        end, gap = self.angles[-1], None if clearance is None else clearance.gap
        clear = None if clearance is None else {"clear": True, "collides": False}.get(clearance.kind)
        collision, angles = None, end
        if clearance is not None and clearance.time is not None and clearance.panels is not None:
            collision = (clearance.time, clearance.panels) if clear is False else None
            angles = self.angles_at(np.array([clearance.time]))[0]
        return DeploymentCheck(
            outcome=self.outcome,
            end_time=float(motion.times[-1]),
            clear=clear,
            collision=collision,
            gap=gap,
            speed=0.0 if clearance is None else clearance.speed,
            remaining=float(np.abs(angles).sum()) / size,
            end_remaining=float(np.abs(end).sum()) / size,
            widest=float(np.abs(end).max(initial=0.0)),
            drift=motion.drift / max(motion.largest_energy, MIN_BALANCE_ENERGY),
            opening=self.opening,
            steps=len(motion.times) - 1,
            evaluations=motion.evaluations,
            looks=0 if clearance is None else clearance.bound_count,
            loose_share=loose_states(self.compiled.system, motion),
            stiff_time=motion.stiff_time,
        )

    def angles_at(self, times: Reals) -> Reals:
        """Interpolate the fold angles at times, shape (len(times), n_hinges), with closed loops between the states."""
        nodes, q, v, a = self._closed_states
        at_times = interpolate_motion(nodes, q, v, None if self.motion.cubic else a, times)
        return self.compiled.of_hinges(at_times, np.zeros_like(at_times))[0]

    @cached_property
    def _closed_states(self) -> StateSeries:
        """The states, with others inserted that keep the loops closed."""
        return closed_states(self.compiled.system, self.motion)

    @cached_property
    def opening(self) -> float:
        """The greatest closure residual at and between states, rad, or gap over size."""
        return greatest_opening(self.compiled.system, self._closed_states, self.motion.cubic)

    @property
    def sentence(self) -> str:
        """The reason, after the sentence on the certain or possible collision if there is one."""
        return reason_with_clearance(self.reason, self.outcome, self.clearance, labels_of(self.compiled.linkage))

    @property
    def verdict(self) -> Verdict:
        """The verdict: `deploys` (flat and certified clear), `collides`, or `undecided`."""
        return self.check.verdict

    @property
    def deploys(self) -> bool:
        """Whether the array becomes flat and is certified clear."""
        return self.check.deploys

    @cached_property
    def play(self) -> Play | None:
        """The play between panels that the deployment needs, and their least gap as built; None unless it deploys."""
        if not self.deploys:
            return None
        # no stop holds driven hinges, whose panels overlap by as much as they pass them
        overlap = 0.0 if self.driven is None else float(_overlaps(self.compiled, self.angles).max(initial=0.0))
        return play_of_deployment(self.compiled, self.motion, overlap)

    @property
    def flat_time(self) -> float | None:
        """The time at which the array is flat, s; None if it never is."""
        return flat_time_of(self.outcome, float(self.motion.times[-1]))


def simulate_deployment(
    linkage: Linkage,
    scene: Scene | Setup,
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

    keep : omissions that are not to be made. certified : whether collisions are checked. drives : of hinges; the motion
    then starts at their start, with the tolerance of `simulate_driven_scene`.
    """
    if drives is not None:
        return simulate_driven_scene(compile_driven(linkage, scene, drives, formulation), drives, method=method)
    compiled = compile_scene(linkage, scene, formulation, keep=keep)
    return simulate_compiled(compiled, method=method, tolerance=tolerance, certified=certified, max_steps=max_steps)


@work_step("simulating the motion")
def simulate_compiled(
    compiled: CompiledScene,
    *,
    method: str | None = None,
    tolerance: float = 1e-6,
    certified: bool = True,
    max_steps: int | None = None,
    longest_step: float = math.inf,
) -> Deployment:
    """Simulate a compiled scene, with the options of `simulate_deployment`; longest_step : s."""
    if not 1e-13 <= tolerance <= 1e-1:
        raise HcsearchError(f"a tolerance of {tolerance:g} is out of range: give one from 1e-13 to 0.1")
    began = time.perf_counter()
    motion = simulate_releases(
        compiled,
        methods=methods_of(compiled.formulation, method),
        tolerance=tolerance,
        max_steps=max_steps or MAX_DEPLOYMENT_STEPS[compiled.formulation],
        longest_step=longest_step,
    )
    return deployment_of_motion(compiled, motion, time.perf_counter() - began, certified=certified)


def compile_driven(
    linkage: Linkage, scene: Scene | Setup, drives: Drives | None, formulation: Formulation = "constrained"
) -> CompiledScene:
    """Compile a scene for drives, without the omissions that they may invalidate: mirror half and folded stops."""
    if formulation != "constrained":
        raise HcsearchError(
            f"drives are simulated with exact closure, not in the {formulation} formulation: leave it out"
        )
    setup = setup_of_scene(scene, linkage)
    if setup.hold_downs or setup.law_times:
        raise HcsearchError("drives are simulated without hold-downs and laws in time: leave them out")
    if setup.free:
        raise HcsearchError("drives are for an array that is held: hold a panel, such as --held bottom")
    compiled = compile_scene(linkage, setup, keep=frozenset({"half", "stops"}))
    if drives is None:
        return compiled
    drives.check(linkage)
    return replace(compiled, start=drives.start_in(compiled))


@work_step("simulating the drives")
def simulate_driven_scene(
    compiled: CompiledScene,
    drives: Drives,
    *,
    method: str | None = None,
    tolerance: float = DRIVEN_STEP_TOLERANCE,
    certified: bool = True,
) -> Deployment:
    """Simulate a scene compiled by `compile_driven` under position control, until flat or the end of the scene's time.

    tolerance : of a step; control corrects its errors. Stops are omitted, as a course along them would hit them again
    and again: the motion is certified clear only where no hinge passes one by more than the margin.
    """
    began = time.perf_counter()
    system, commands = compiled.system, drives.commands(compiled)
    free = system.driven(tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in system.drives))

    def follow(end: float, flat: float | None) -> DrivenMotion:
        return simulate_driven(
            free,
            commands,
            compiled.start,
            end=end,
            method=method or "linearly-implicit",
            tolerance=tolerance,
            restitution=compiled.setup.restitution,
            flat=flat,
            watched=compiled.hinged,
        )

    driven = follow(compiled.seconds, FLAT_FOLD_ANGLE)
    if driven.motion.ending == "flat" and driven.motion.times[-1] < drives.times[-1]:
        # drives continue to the end of their course, where torques may be greatest
        driven = replace(driven, greatest_torques=follow(float(drives.times[-1]), None).greatest_torques)
    # states inserted between others move under the drives, too
    compiled = replace(compiled, system=system.under_control(commands.targets))
    seconds = time.perf_counter() - began
    return deployment_of_motion(compiled, driven.motion, seconds, certified=certified, driven=driven)


@work_step("certifying the clearance")
def deployment_of_motion(
    compiled: CompiledScene,
    motion: Motion,
    seconds: float = 0.0,
    *,
    certified: bool = True,
    driven: DrivenMotion | None = None,
) -> Deployment:
    """Convert a motion of a compiled scene to a deployment.

    seconds : computing time. certified : whether collisions are checked. driven : the motion with its drives, if any.
    """
    angles, rates = compiled.of_hinges(motion.q, motion.v)
    outcome = outcome_of(motion.ending)
    clearance = _clearance(compiled, motion) if certified else None
    if clearance is not None and driven is not None:
        clearance = _within_stops(compiled, motion.times, angles, clearance)
    if driven is None and compiled.setup.free and len(motion.q) and _steep(compiled, motion):
        outcome, reason = "diverged", "the floating base turns too far for its three angles: give it more inertia"
    else:
        reason = reason_of_motion(compiled, motion, clearance, driven=driven is not None)
        if held := held_at_end(compiled, motion):
            reason += f"; still held down: hinges {named_hinges(compiled.linkage, held)}"
    return Deployment(compiled, motion, outcome, reason, angles, rates, clearance, seconds, driven)


def _within_stops(compiled: CompiledScene, times: Reals, angles: Reals, clearance: Clearance) -> Clearance:
    """Change a clear verdict to `undecided` where panels of a hinge without stops overlap by more than the margin."""
    overlaps = _overlaps(compiled, angles)
    if clearance.kind != "clear" or overlaps.max(initial=0.0) <= compiled.margin:
        return clearance
    state, hinge = np.unravel_index(overlaps.argmax(), overlaps.shape)
    ends = compiled.linkage.pattern.hinges[int(hinge)]
    panels = (min(ends.first, ends.second), max(ends.first, ends.second))
    return replace(clearance, kind="undecided", time=float(times[state]), panels=panels)


def _overlaps(compiled: CompiledScene, angles: Reals) -> Reals:
    """Return bounds of the overlap of panels whose hinges pass a stop (m), shape (k, n_hinges)."""
    beyond: Reals = np.maximum(np.maximum(-angles, angles - math.pi), 0.0) * reaches(compiled.linkage)
    return beyond


def _steep(compiled: CompiledScene, motion: Motion) -> bool:
    """Return whether the floating base comes near the singularity of its angles."""
    base = np.flatnonzero(~compiled.hinged)
    turns = [k for k in base if not compiled.system.joints[k].slides]
    return len(turns) == 3 and bool(np.abs(motion.q[:, turns[1]]).max() > STEEP_BASE_ANGLE)


def _clearance(compiled: CompiledScene, motion: Motion) -> Clearance:
    """Certify the clearance of a motion."""
    linkage, path = compiled.linkage, course_of_deployment(compiled, motion)
    certified = partial(certify_clearance, linkage, slack=path.slacks, apart=compiled.separated_pairs)
    resolution, measured = resolution_of(linkage), motion.ending == "flat"
    return certified(path.course, margin=compiled.margin, resolution=resolution, measured=measured)


ARRIVAL_TIME_TOLERANCE = 1e-4
"""Greatest time (s) between arrivals that count as one: mirror images arrive together up to rounding."""


@dataclass(frozen=True)
class Arrival:
    """Hinges that arrive at their stops together: the first time (s), and the greatest speed (rad/s)."""

    time: float
    stop: Literal["flat", "folded"]
    hinges: tuple[int, ...]
    speed: float


def hinge_arrivals(deployment: Deployment) -> tuple[Arrival, ...]:
    """Return the arrivals of hinges at stops that they had left by more than 0.01 rad since their last hit.

    Bounces are left out, as their number and size depend on the model of the stops.
    """
    arrived: list[Arrival] = []
    for at, stop, hinge, speed in sorted(_hits(deployment)):
        recent = (a for a in arrived[::-1] if a.stop == stop and at - a.time <= ARRIVAL_TIME_TOLERANCE)
        together = next(recent, None)
        if together is None:
            arrived.append(Arrival(at, stop, (hinge,), speed))
        else:
            hinges = tuple(sorted({*together.hinges, hinge}))
            arrived[arrived.index(together)] = Arrival(together.time, stop, hinges, max(together.speed, speed))
    return tuple(arrived)


def _hits(deployment: Deployment) -> list[tuple[float, Literal["flat", "folded"], int, float]]:
    """Return time, stop, hinge and speed of each hit except bounces."""
    times, angles, hits = deployment.motion.times, deployment.angles, []
    last_hits: dict[int, float] = {}
    for event in deployment.motion.events:
        if event.kind != "hit":
            continue
        for hinge in deployment.compiled.hinges_of(event.joint):
            angles_since = angles[
                np.searchsorted(times, last_hits.get(hinge, 0.0)) : np.searchsorted(times, event.time), hinge
            ]
            angle = float(np.interp(event.time, times, angles[:, hinge]))
            stop: Literal["flat", "folded"] = "flat" if angle < 0.5 * math.pi else "folded"
            limit = 0.0 if stop == "flat" else math.pi
            if np.abs(angles_since - limit).max(initial=0.0) > FLAT_FOLD_ANGLE:
                hits.append((event.time, stop, hinge, abs(event.speed)))
            last_hits[hinge] = event.time
    return hits
