"""Reference motions of a compiled scene: two independent simulations, and until when they agree."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Ending, Integrator
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.error_estimates import angle_distances, comparison_times, parting_time
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.system.terminal import tolerance_text

ReferenceSettings = tuple[tuple[Integrator, float], ...]
"""Methods and tolerances of a reference; the first one that comes to an end is taken."""
REFERENCES: tuple[ReferenceSettings, ReferenceSettings] = (
    (("dormand-prince-8", 1e-13), ("dormand-prince-8", 1e-12), ("dormand-prince-8", 1e-11), ("implicit", 1e-11)),
    (("dormand-prince", 1e-12), ("dormand-prince", 1e-11), ("implicit", 1e-10), ("bogacki-shampine", 1e-9)),
)
"""Settings of the reference, and of the second one, whose method is another."""
STIFF_REFERENCES: tuple[ReferenceSettings, ReferenceSettings] = (
    (("implicit", 1e-12), ("implicit", 1e-11), ("implicit", 1e-10), ("implicit", 1e-9)),
    (("linearly-implicit", 1e-9), ("linearly-implicit", 1e-8), ("linearly-implicit", 1e-7)),
)
"""The same where explicit steps are limited by their stability."""
SPRINGY_REFERENCES: tuple[ReferenceSettings, ReferenceSettings] = (
    (("dormand-prince-8", 1e-11), ("linearly-implicit", 1e-8)),
    (("linearly-implicit", 1e-8), ("dormand-prince", 1e-9)),
)
"""The same where stiff springs close the loops, which make steps short."""
REFERENCE_STEPS = 1_000
"""Least number of steps of a reference, so that states between its own are as exact."""
MAX_REFERENCE_STEPS = 200_000
"""Greatest number of steps of a reference; fewer where they take longer than is allowed."""
PROBE_STEPS = 100
"""Number of simulated steps from which the time of a step is estimated."""
USABLE_DOUBT, AGREEING_ANGLE = 1e-3, 1e-6
"""Where two references differ by more than the first angle (rad), errors are measured as long as they agree to the
second."""
NO_ANSWER: frozenset[Ending] = frozenset({"diverged", "out of steps", "jammed", "branch-singular"})
"""Endings by which a simulation says that it did not come to an answer."""


class ReferenceRun(NamedTuple):
    """A simulation that others are compared with."""

    method: Integrator
    tolerance: float
    deployment: Deployment

    @property
    def setting(self) -> str:
        """The method and the tolerance in words."""
        return f"{self.method} at {tolerance_text(self.tolerance)}"


@dataclass(frozen=True, eq=False)
class ReferenceMotion(ByValue):
    """A reference, a second one by another method, and how far they agree.

    until : time (s) up to which others are compared. angle_doubt : greatest distance of a fold angle between both until
    then, rad; None without a second one. time_doubt : distance of the flat times, s; None unless both are flat.
    parting : time (s) from which on they differ by more than `PARTING_ANGLE`; None if they never do.
    """

    first: ReferenceRun
    second: ReferenceRun | None
    until: float
    angle_doubt: float | None
    time_doubt: float | None
    parting: float | None

    @property
    def whole(self) -> bool:
        """Whether the reference comes to an end, and the second one agrees on the motion until then."""
        first = self.first.deployment
        return self.parting is None and first.outcome not in NO_ANSWER

    @property
    def flat_time(self) -> float | None:
        """The flat time of the reference, s; None where it is not flat, or the second one does not confirm it."""
        return self.first.deployment.flat_time if self.whole and self.time_doubt is not None else None

    def angle_error(self, deployment: Deployment) -> float | None:
        """Return the greatest distance of a fold angle (rad) from the reference; None where it ends much earlier.

        Compared at evenly spaced times and inside all steps, until `until` or the end of the deployment.
        """
        motion = deployment.motion
        end = float(motion.times[-1])
        early = deployment.outcome in NO_ANSWER and end < self.until * (1.0 - 1e-9)
        if len(motion.times) < 2 or early or not np.isfinite(motion.q).all():
            return None
        times = comparison_times(motion.times, min(self.until, end))
        return float(angle_distances(deployment, self.first.deployment, times).max(initial=0.0))


def reference_motion(
    compiled: CompiledScene, whole: CompiledScene, *, end: float, seconds: float, independent: bool = True
) -> ReferenceMotion:
    """Simulate the references of a compiled scene.

    whole : the same scene with nothing left out, which the second one simulates. end : s, about the end of the motion,
    by which steps are limited. seconds : greatest time of one simulation, s, about. independent : whether there is a
    second one. HcsearchError where no simulation makes a step.
    """
    firsts, settings = reference_settings(compiled)
    first = reference_run(compiled, firsts, end, seconds)
    if first is None:
        raise HcsearchError("no simulation of this scene gets anywhere: see the reason that hcsearch deploy gives")
    others = tuple(setting for setting in settings if setting[0] != first.method)
    second = reference_run(whole, others, end, seconds) if independent else None
    return compared_references(first, second)


def reference_settings(compiled: CompiledScene) -> tuple[ReferenceSettings, ReferenceSettings]:
    """Return the settings of both references of a compiled scene."""
    if compiled.formulation in {"penalty", "compliant"}:
        return SPRINGY_REFERENCES
    return STIFF_REFERENCES if is_stiff(compiled) else REFERENCES


def is_stiff(compiled: CompiledScene) -> bool:
    """Return whether all steps of a compiled scene are implicit unless a method is given."""
    return simulate_compiled(compiled, certified=False, max_steps=1).motion.stiff_time == 0.0


def affordable_steps(run: Callable[..., Deployment], seconds: float) -> int:
    """Return how many steps a simulation can make in processor time (s); run : simulates up to `max_steps`."""
    run(max_steps=1)  # loads the kernels
    begin = time.process_time()
    probe = run(max_steps=PROBE_STEPS)
    per_step = (time.process_time() - begin) / max(1, probe.motion.steps + probe.motion.rejected)
    return max(1, int(seconds / per_step))


def compared_references(first: ReferenceRun, second: ReferenceRun | None) -> ReferenceMotion:
    """Return a reference with how far a second simulation agrees with it."""
    one = first.deployment
    if second is None:
        return ReferenceMotion(first, None, float(one.motion.times[-1]), None, None, None)
    other = second.deployment
    until = float(min(one.motion.times[-1], other.motion.times[-1]))
    times = comparison_times(other.motion.times, until)
    distances = angle_distances(one, other, times)
    parting = parting_time(times, distances)
    if not distances.max(initial=0.0) <= USABLE_DOUBT:
        until = _agreeing_until(times, distances)
        distances = distances[times <= until]
    time_doubt = abs(one.flat_time - other.flat_time) if one.flat_time and other.flat_time else None
    return ReferenceMotion(first, second, until, float(distances.max(initial=0.0)), time_doubt, parting)


def _agreeing_until(times: Reals, distances: Reals) -> float:
    """Return the last time until which two references agree to `AGREEING_ANGLE`."""
    apart = np.flatnonzero(distances > AGREEING_ANGLE)
    return float(times[-1] if not len(apart) else times[max(0, apart[0] - 1)])


def reference_run(
    compiled: CompiledScene, settings: ReferenceSettings, end: float, seconds: float
) -> ReferenceRun | None:
    """Return the first simulation that comes to an end, else the one that gets farthest; None where none has a step.

    end, seconds : as in `reference_motion`.
    """
    runs: list[ReferenceRun] = []
    for method, tolerance in settings:
        run = partial(simulate_compiled, compiled, method=method, tolerance=tolerance, certified=False)
        steps = min(MAX_REFERENCE_STEPS, max(REFERENCE_STEPS, affordable_steps(run, seconds)))
        deployment = run(max_steps=steps, longest_step=end / REFERENCE_STEPS)
        if len(deployment.motion.times) < 2 or not math.isfinite(deployment.motion.drift):
            continue
        runs.append(ReferenceRun(method, tolerance, deployment))
        if deployment.outcome not in NO_ANSWER:
            return runs[-1]
    return max(runs, key=lambda one: float(one.deployment.motion.times[-1]), default=None)
