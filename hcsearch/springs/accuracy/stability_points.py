"""Numerical stability of a scene: simulations with other values, and of extremes, each judged beside references.

A simulation is accurate, degraded within a bound, refused, or wrong.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple, get_args

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Ending, Formulation
from hcsearch.scenes.setup import Setup
from hcsearch.springs.accuracy.reference_motions import NO_ANSWER, affordable_steps, reference_motion
from hcsearch.springs.accuracy.swept_values import SWEPT_VALUES, ScenePoint, sweep_points
from hcsearch.springs.deployment.compiled_scene import ALL_OMISSIONS, OMISSIONS, compile_scene
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS
from hcsearch.springs.deployment.simulated_deployment import MIN_BALANCE_ENERGY, Deployment, simulate_compiled
from hcsearch.system.terminal import short_number

Judgement = Literal["accurate", "degraded", "refused", "wrong"]
JUDGEMENTS: tuple[Judgement, ...] = get_args(Judgement)
"""`accurate`: the error is at most `ACCURATE_TOLERANCES` tolerances; `degraded`: within a bound by a rougher
simulation; `refused`: the simulation itself says that it has no answer; `wrong`: it claims one, but the error is beyond
the bound or a number is not finite."""
ACCURATE_TOLERANCES, ANGLE_FLOOR = 100.0, 1e-11
"""A simulation is accurate when its error is at most so many tolerances, plus this rounding error (rad)."""
BOUND_FACTOR = 3.0
"""A bound is so many times the closure residual and the distance to a simulation that is ten times rougher."""
MAX_JUDGED_STATES = 200
"""Greatest number of states of a simulation that are compared with a rougher one."""
MAX_CLOSURE_STATES = 50
"""Number of states at which the closure residual is computed, about."""
DeploymentBound = Callable[[], float | None]
"""Computes the distance of a deployment from a rougher one, rad; None where no rougher one comes to an answer."""


class JudgedDeployment(NamedTuple):
    """The judgement on a simulation with its reason; error, bound : rad, as far as they are known and needed."""

    judgement: Judgement
    reason: str
    error: float | None = None
    bound: float | None = None


def judge_deployment(
    deployment: Deployment, tolerance: float, error: float | None, distance: DeploymentBound
) -> JudgedDeployment:
    """Judge a simulation by its error (rad), None where that is not known; distance : from a rougher simulation."""
    if deployment.outcome in NO_ANSWER:
        return JudgedDeployment("refused", f"{deployment.outcome}: {deployment.reason}")
    if not all_finite(deployment):
        return JudgedDeployment("wrong", "a number is not finite")
    allowed = ACCURATE_TOLERANCES * tolerance + ANGLE_FLOOR
    if error is not None and error <= allowed:
        return JudgedDeployment("accurate", "", error)
    rough = distance()
    bound = None if rough is None else allowed + BOUND_FACTOR * rough
    if error is None:  # nothing to compare to: fold angles cannot leave the stops
        bound = math.pi if bound is None else bound
        return JudgedDeployment("degraded", f"within {bound:.1e}; no finer simulation ends", None, bound)
    if bound is None or not error <= bound:
        return JudgedDeployment("wrong", f"off by more than bounded; {deployment.reason}", error, bound)
    return JudgedDeployment("degraded", f"within {bound:.1e}", error, bound)


def all_finite(deployment: Deployment) -> bool:
    """Return whether all numbers of a deployment are finite."""
    motion = deployment.motion
    parts = (deployment.angles, deployment.rates, motion.times, motion.a, motion.kinetic, motion.stored, motion.lost)
    return all(bool(np.isfinite(part).all()) for part in parts) and math.isfinite(motion.drift)


def closure_of_angles(deployment: Deployment) -> float:
    """Return the greatest closure residual of the fold angles: by the linkage, not by the simulation."""
    linkage = deployment.compiled.linkage
    if not linkage.loops:
        return 0.0
    _, angles = judged_states(deployment)
    every = max(1, len(angles) // MAX_CLOSURE_STATES)
    return max(float(np.abs(linkage.closure(state)[0]).max()) for state in angles[::every])


def judged_states(deployment: Deployment, last: float = math.inf) -> tuple[Reals, Reals]:
    """Return times at the ends of steps, up to `last` (s), and the fold angles there."""
    times, angles = deployment.motion.times, deployment.angles
    if deployment.outcome == "at rest":  # it says that nothing moves until the end
        times, angles = np.append(times, deployment.compiled.seconds), np.vstack([angles, angles[-1]])
    count = int(np.searchsorted(times, last, side="right"))
    chosen = np.unique(np.linspace(0, count - 1, min(count, MAX_JUDGED_STATES)).round().astype(int))
    return times[chosen], angles[chosen]


def distance_from(deployment: Deployment, rough: Deployment) -> float:
    """Return the greatest distance of a fold angle from a rougher simulation, plus the closure residual, rad."""
    end = float(rough.motion.times[-1])
    times, angles = judged_states(deployment, end if rough.outcome != "at rest" else math.inf)
    q = rough.motion.at(np.minimum(times, end))
    others, _ = rough.compiled.of_hinges(q, np.zeros_like(q))
    return float(np.abs(angles - others).max()) + closure_of_angles(deployment)


ROUGHER = 10.0
"""Ratio of the tolerance of the simulation that bounds an error to the tolerance of the judged one."""
STRESS_FACTOR = 10.0
"""Factor by which the standard set changes each value, up and down."""
STRESS_SPREADS = (10.0, 1000.0)
"""Spreads of springs in the standard set."""
PACKED_START, STIFF_STOPS, CLASHING_RESTITUTION = 0.999999, 100.0, 0.9
"""Known extremes: a start so near to the packed state, where closure is nearly singular; stops stiffer than the scene's
by this factor; stops from which hinges bounce with this share of their speed, with a tenth of the damping."""
ENOUGH_COMPARED = 0.9
"""Where references agree for less than this share of a motion, the judgement says until when it is compared."""


@dataclass(frozen=True)
class StabilityCase:
    """A scene that is judged.

    values : of the sweep, in its order. own : whether these are the user's. keep : omissions that are not made.
    """

    label: str
    values: tuple[float, ...]
    point: ScenePoint
    formulation: Formulation
    own: bool = False
    keep: frozenset[str] = frozenset()


@dataclass(frozen=True)
class StabilityPoint:
    """The judgement on a scene.

    error : greatest distance of a fold angle from the reference, or closure residual where that is greater, rad.
    bound : of that error, where the simulation is not accurate. drift : error of the energy balance as a share of the
    largest energy.
    until : time (s) up to which references agree; None without them. seconds : processor time of the judged simulation.
    """

    label: str
    values: tuple[float, ...]
    own: bool
    judgement: Judgement
    error: float | None
    bound: float | None
    drift: float | None
    outcome: Ending | None
    until: float | None
    steps: int | None
    seconds: float
    reason: str


def sweep_cases(
    point: ScenePoint, ranges: Mapping[str, tuple[float, float]], formulation: Formulation
) -> list[StabilityCase]:
    """Return the scenes of a sweep of one value or two over ranges; HcsearchError for others."""
    if not 1 <= len(ranges) <= 2:
        raise HcsearchError(f"a sweep is of one value or of two, not of {len(ranges)}: name fewer")
    unknown = [name for name in ranges if name not in SWEPT_VALUES]
    if unknown:
        raise HcsearchError(f"{unknown[0]!r} cannot be swept: choose from {', '.join(SWEPT_VALUES)}")
    owns = [SWEPT_VALUES[name].own(point) for name in ranges]
    most, density = (13, 2.0) if len(ranges) == 1 else (7, 1.0)
    values = [
        sweep_points(*limits, own, per_decade=density, most=most)
        for limits, own in zip(ranges.values(), owns, strict=True)
    ]
    return [_swept(point, tuple(ranges), chosen, tuple(owns), formulation) for chosen in itertools.product(*values)]


def _swept(
    point: ScenePoint,
    names: Sequence[str],
    values: tuple[float, ...],
    owns: tuple[float, ...],
    formulation: Formulation,
) -> StabilityCase:
    for name, value, own in zip(names, values, owns, strict=True):
        if value != own:
            point = SWEPT_VALUES[name].changed(point, value)
    label = ", ".join(f"{name} {short_number(value)}" for name, value in zip(names, values, strict=True))
    return StabilityCase(label, values, point, formulation, values == owns)


def stress_cases(point: ScenePoint, formulation: Formulation) -> Iterator[StabilityCase]:
    """Return the standard set: each value times and over `STRESS_FACTOR`, springs of great spread, known extremes."""
    setup = point.setup
    yield StabilityCase("as it is", (), point, formulation, own=True)
    for name, value in SWEPT_VALUES.items():
        own = value.own(point)
        for factor, words in ((STRESS_FACTOR, f"x {STRESS_FACTOR:g}"), (1.0 / STRESS_FACTOR, f"/ {STRESS_FACTOR:g}")):
            if own > 0.0 and name != "spread":
                yield StabilityCase(f"{name} {words}", (), value.changed(point, factor * own), formulation)
    for spread in STRESS_SPREADS:
        changed = SWEPT_VALUES["spread"].changed(point, spread)
        yield StabilityCase(f"spread {spread:g}", (), changed, formulation)

    def extreme(label: str, changed: Setup, model: Formulation = formulation) -> StabilityCase:
        return StabilityCase(label, (), replace(point, setup=changed), model)

    yield extreme(f"start {PACKED_START}", replace(setup, start=PACKED_START))
    yield replace(extreme("redundant closure", setup), keep=frozenset(ALL_OMISSIONS))
    yield extreme("stiff stops", replace(setup, stop_stiffness=STIFF_STOPS * setup.stop_stiffness), "penalty")
    damping = SWEPT_VALUES["damping"]
    weak = damping.change(point, 0.1 * damping.own(point)).setup
    yield extreme("clashing stops", replace(weak, restitution=CLASHING_RESTITUTION))


def judged_points(
    cases: Sequence[StabilityCase],
    *,
    tolerance: float,
    seconds: float,
    announce: Callable[[str], None] = lambda _words: None,
) -> Iterator[StabilityPoint]:
    """Simulate each scene by its default method and judge it; seconds : greatest time of one reference, s, about."""
    for case in cases:
        announce(case.label)
        yield judged_point(case, tolerance, seconds)


def judged_point(case: StabilityCase, tolerance: float, seconds: float) -> StabilityPoint:
    """Simulate a scene by its default method and judge it beside references."""
    linkage, setup = case.point.linkage, case.point.setup
    blank = StabilityPoint(case.label, case.values, case.own, "refused", *(None,) * 5, None, 0.0, "")
    try:
        compiled = compile_scene(linkage, setup, case.formulation, keep=case.keep)
        run = partial(simulate_compiled, compiled, certified=False)
        affordable, most = affordable_steps(run, seconds), MAX_DEPLOYMENT_STEPS[case.formulation]
        if case.formulation in {"penalty", "compliant"}:  # stiff springs take minutes to come to so many steps
            most = min(most, affordable)
        begin = time.process_time()
        deployment = run(tolerance=tolerance, max_steps=most)
        taken = time.process_time() - begin
    except HcsearchError as refusal:
        return replace(blank, reason=str(refusal))
    if deployment.outcome == "out of steps" and most < MAX_DEPLOYMENT_STEPS[case.formulation]:
        return replace(blank, outcome=deployment.outcome, reason=f"takes more than {seconds:g} s: allow it more time")
    error, until = None, None
    if deployment.outcome not in NO_ANSWER:
        error, until = _error(case, deployment, seconds)
    rough = partial(_distance_from_rougher, case, deployment, min(ROUGHER * tolerance, 0.1))
    judged = judge_deployment(deployment, tolerance, error, rough)
    motion = deployment.motion
    return replace(
        blank,
        judgement=judged.judgement,
        error=judged.error,
        bound=judged.bound,
        drift=motion.drift / max(motion.largest_energy, MIN_BALANCE_ENERGY),
        outcome=deployment.outcome,
        until=until,
        steps=motion.steps,
        seconds=taken,
        reason=_reason(judged, deployment, until),
    )


def _error(case: StabilityCase, deployment: Deployment, seconds: float) -> tuple[float | None, float | None]:
    """Return the error of a deployment beside references, rad, and until when these agree, s; None without them."""
    linkage, setup = case.point.linkage, case.point.setup
    compiled = deployment.compiled
    whole = compile_scene(linkage, setup, case.formulation, keep=frozenset(OMISSIONS) | case.keep)
    end = float(deployment.motion.times[-1])
    try:
        reference = reference_motion(compiled, whole, end=end, seconds=seconds)
    except HcsearchError:
        return None, None
    error = reference.angle_error(deployment)
    if error is None:
        return None, None
    exact_closure = not compiled.system.cuts and not compiled.system.closure_stiffness
    return max(error, closure_of_angles(deployment) if exact_closure else 0.0), reference.until


def _distance_from_rougher(case: StabilityCase, deployment: Deployment, tolerance: float) -> float | None:
    """Return the distance from a simulation at a greater tolerance, rad; None where it has no answer."""
    rough = simulate_compiled(deployment.compiled, tolerance=tolerance, certified=False)
    return None if rough.outcome in NO_ANSWER else distance_from(deployment, rough)


def _reason(judged: JudgedDeployment, deployment: Deployment, until: float | None) -> str:
    """Return the reason of a judgement, with the time until which it holds if that is not the end."""
    end = float(deployment.motion.times[-1])
    early = f"compared until {short_number(until)} of {short_number(end)} s" if until is not None else ""
    shown = until is not None and until < ENOUGH_COMPARED * end
    return "; ".join(filter(None, (judged.reason, early if shown else "")))
