"""Deployments in stages: hold-downs release hinges at given times or after others, and laws act from a time on.

A hinge that is held down cannot open beyond its angle at the start: its hold-down is a stop there. Its spring is
stressed all the time and does no work before the release. A law that acts from a time on has no energy before; what it
has then, and what it gets as it rises, is a negative loss. Each stage is simulated alone and ends exactly at the next
release, or where a law begins or ends to rise, whatever the method, so that no step spans one. Other scenes are one
stage.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.scenes.laws import Law, timed_law
from hcsearch.scenes.setup import HoldDown
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE, REST_ANGLE_TOLERANCE
from hcsearch.springs.dynamics.system import System
from hcsearch.springs.dynamics.time_integration import (
    Event,
    Motion,
    SimulationOptions,
    joined_motion,
    simulate_system,
)

_STILL = frozenset({"rest", "stuck"})
"""Ends of stages after which nothing moves until the next release at a given time."""


def simulate_releases(
    compiled: CompiledScene,
    *,
    methods: tuple[str, str],
    tolerance: float,
    max_steps: int,
    longest_step: float = math.inf,
) -> Motion:
    """Simulate a compiled scene with its hold-downs until the array is flat, at rest, or the scene's time is over.

    methods : as in `Motion`. longest_step : s.
    """
    run = _Run(compiled, methods, tolerance, max_steps, longest_step)
    if not (compiled.setup.hold_downs or compiled.setup.law_times):
        return run.stage(compiled.start, None, compiled.seconds, ()).motion
    return run.motion()


_Reached = tuple[int, float]
"""The joint whose angle (rad) releases others."""


class _Stage(NamedTuple):
    """The motion of one stage, and the joint that ends it by its angle, if one does."""

    motion: Motion
    reached: _Reached | None


@dataclass
class _Run:
    """The stages of one deployment; now : s, the end of the last one."""

    compiled: CompiledScene
    methods: tuple[str, str]
    tolerance: float
    max_steps: int
    longest_step: float
    now: float = 0.0
    motions: list[Motion] = field(default_factory=list)
    starts: list[float] = field(default_factory=list)

    def motion(self) -> Motion:
        """Simulate all stages and join them."""
        q, v, seconds = self.compiled.start, None, self.compiled.seconds
        waiting = {
            held for held in self.compiled.setup.hold_downs if not _is_released(self.compiled, held, 0.0, q[None])
        }
        while True:
            times = {*self.compiled.setup.law_times, *(held.time for held in waiting if held.after < 0)}
            due = min((time for time in times if time > self.now), default=seconds)
            stage = self.stage(q, v, min(due, seconds), tuple(sorted(waiting)))
            motion, reached = stage.motion, stage.reached
            if motion.ending in _STILL and due < seconds:
                motion = _stilled(motion, due - self.now)
            self.starts.append(self.now)
            self.now = min(due, seconds) if motion.ending == "time" else self.now + float(motion.times[-1])
            released = {held for held in waiting if self._releases(held, reached)}
            self.motions.append(self._with_releases(motion, released))
            goes_on = released or (motion.ending == "time" and self.now < seconds)
            if not goes_on or self.now >= seconds:
                return _with_balance(joined_motion(self.motions, self.starts), self.motions)
            q, v = motion.q[-1].copy(), motion.v[-1].copy()
            waiting -= released

    def stage(self, q: Reals, v: Reals | None, end: float, waiting: Sequence[HoldDown]) -> _Stage:
        """Simulate one stage from a state; end : latest end of the stage, s. waiting : hinges that are held down."""
        compiled = self.compiled
        system = _system_of_stage(compiled, waiting, self.now, end)
        options: SimulationOptions = {
            "end": end - self.now,
            "tolerance": self.tolerance,
            "restitution": compiled.setup.restitution,
            "longest_step": self.longest_step,
        }
        last_change = max(compiled.setup.law_times, default=0.0)
        if end >= compiled.seconds and last_change <= self.now:  # else an array at rest waits for what comes
            options["rest"] = REST_ANGLE_TOLERANCE
        watched: list[tuple[Flags, float, _Reached | None]] = [
            (np.arange(system.n_joints) == joint, angle, (joint, angle))
            for joint, angle in sorted({(self._joint(held.after), held.angle) for held in waiting if held.after >= 0})
        ]
        if all(q[self._joint(held.hinge)] <= FLAT_FOLD_ANGLE for held in waiting):
            watched.append((compiled.hinged, FLAT_FOLD_ANGLE, None))
        method, stiff_method = self.methods
        simulated = partial(simulate_system, system, q, v, method=method, stiff_method=stiff_method)
        run = partial(simulated, max_steps=self.max_steps, **options)
        if not watched:
            return _Stage(run(), None)
        # all are the same motion, and end where the angle that they watch is reached
        ended = [(run(flat=angle, watched=joints), reached) for joints, angle, reached in watched]
        motion, reached = min(ended, key=lambda one: (one[0].times[-1], one[0].ending != "flat"))
        return _Stage(motion, reached if motion.ending == "flat" else None)

    def _releases(self, held: HoldDown, reached: _Reached | None) -> bool:
        """Return whether a hold-down releases its hinge now; reached : the hinge that has reached its angle."""
        return self.now >= held.time if held.after < 0 else (self._joint(held.after), held.angle) == reached

    def _joint(self, hinge: int) -> int:
        return int(self.compiled.joint_of[hinge])

    def _with_releases(self, motion: Motion, released: set[HoldDown]) -> Motion:
        """Add releases at the end of a stage to its events."""
        joints = sorted({self._joint(held.hinge) for held in released})
        events = tuple(Event(float(motion.times[-1]), joint, "released", 0.0) for joint in joints)
        return replace(motion, events=motion.events + events)


RELEASE_ANGLE_TOLERANCE = 1e-6
"""Distance (rad) within which a hinge has reached the angle at which it releases another."""


def _is_released(compiled: CompiledScene, held: HoldDown, now: float, q: Reals) -> bool:
    """Return whether a hinge was released at a time (s) or before, in states (k, n_joints) up to then."""
    if held.after < 0:
        return now >= held.time
    reached = q[:, int(compiled.joint_of[held.after])] <= held.angle + RELEASE_ANGLE_TOLERANCE
    return bool(reached.any())


def held_at_end(compiled: CompiledScene, motion: Motion) -> tuple[int, ...]:
    """Return the hinges that are still held down at the end of a motion."""
    end = float(motion.times[-1])
    held = (one for one in compiled.setup.hold_downs if not _is_released(compiled, one, end, motion.q))
    return tuple(sorted(one.hinge for one in held))


def _system_of_stage(compiled: CompiledScene, waiting: Sequence[HoldDown], start: float, end: float) -> System:
    """Return the system of a stage: with stops at hinges that are held down, and the laws from its start on (s)."""
    if not (waiting or compiled.setup.law_times):
        return compiled.system
    drives = [replace(drive, law=_law_of_stage(drive.law, start, end)) for drive in compiled.system.drives]
    for held in waiting:
        joint = int(compiled.joint_of[held.hinge])
        drives[joint] = replace(drives[joint], lower=float(compiled.start[joint]))
    return compiled.system.driven(tuple(drives))


def _law_of_stage(law: Law, start: float, end: float) -> Law:
    """Return a law with times counted from the start of a stage, in which its moment begins or ends no rise."""
    if law.full <= start:
        return timed_law(law, 0.0, 0.0) if law.full else law
    if law.begin >= end:  # at its end, too, it does not act
        return replace(law, begin=math.inf, full=math.inf)
    return replace(law, begin=law.begin - start, full=law.full - start)


def _stilled(motion: Motion, seconds: float) -> Motion:
    """Return a motion that stays in its last state until a time (s)."""
    names = ("q", "kinetic", "stored", "height", "in_stops", "damped", "lost")
    states: dict[str, Any] = {
        name: np.concatenate([getattr(motion, name), getattr(motion, name)[-1:]]) for name in names
    }
    states |= {name: np.concatenate([getattr(motion, name), np.zeros_like(motion.v[-1:])]) for name in ("v", "a")}
    return replace(motion, ending="time", times=np.append(motion.times, seconds), **states)


def _with_balance(joined: Motion, motions: Sequence[Motion]) -> Motion:
    """Add to the energy lost what compliant stops of hold-downs had taken up, less the energy of laws that begin."""
    lost, state = joined.lost.copy(), 0
    for before, after in pairwise(motions):
        state += len(before.times)
        kept, left = (_energy(motion, k) for motion, k in ((before, -1), (after, 0)))
        lost[state:] += kept - left
    return replace(joined, lost=lost)


def _energy(motion: Motion, state: int) -> float:
    """Return the energy of a state, J."""
    return float(motion.kinetic[state] + motion.stored[state] + motion.height[state] + motion.in_stops[state])
