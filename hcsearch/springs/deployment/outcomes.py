"""Outcomes of a deployment: its ending, the verdict that follows, and the reason in a sentence."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from hcsearch.basics.vocabulary import Ending, Formulation, Integrator, Verdict
from hcsearch.motion.collision.clearance import Clearance
from hcsearch.shape.labels import Labels, named_hinges
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.dynamics.law_torques import holding_friction
from hcsearch.springs.dynamics.time_integration import Motion, SimulationStop
from hcsearch.system.terminal import short_number


def reason_of_motion(
    compiled: CompiledScene, motion: Motion, clearance: Clearance | None = None, *, driven: bool = False
) -> str:
    """Return a sentence on the end of a motion, with a remedy where it may lead to another verdict.

    clearance : None if not checked. Where panels collide or may collide, a motion by springs that ends elsewhere would
    have the same verdict; one by drives may collide as it strays from its course.
    """
    sentence = _sentence_on_end(compiled, motion)
    diverged = outcome_of(motion.ending) == "diverged"
    is_clear = clearance is None or clearance.kind == "clear"
    remedy = _remedy(compiled, motion.ending, motion.methods, driven=driven) if driven or diverged or is_clear else ""
    return f"{sentence}: {remedy}" if remedy else sentence


def _sentence_on_end(compiled: CompiledScene, motion: Motion) -> str:
    """Return a sentence on the end of a motion."""
    end = f"{short_number(motion.times[-1])} s"
    stops = compiled.at_stops(motion.q[-1])
    shut, opened = (named_hinges(compiled.linkage, hinges) for hinges in (stops.closed, stops.open))
    hinges_at_stops = f"closed hinges {shut}, open hinges {opened}"
    widest = float(np.abs(motion.q[-1][compiled.hinged]).max(initial=0.0))
    return {
        "flat": f"flat after {end}",
        "time": f"after {end} the widest fold angle is {widest:.3g} rad",
        "rest": f"at rest from {end} on: {hinges_at_stops}",
        "jammed": f"at {end} stops and loops prevent any motion: {hinges_at_stops}",
        "steps": f"stopped at {end} after {motion.steps} steps",
        "singular": f"branch-singular at {end}: rounding errors limit its steps, so that they decide how it goes on",
        "short": f"no step is short enough at {end}",
        "stuck": f"stuck from {end} on: {_friction_sentence(compiled, motion)}",
        "open": f"the loops open at {end}",
        "diverged": f"numbers overflow at {end}",
        "energy": f"the energy balance is off by {motion.drift:.2g} J at {end}",
    }[motion.ending]


def _remedy(compiled: CompiledScene, ending: SimulationStop, methods: tuple[str, str], *, driven: bool) -> str:
    """Return how a motion may end otherwise; empty where it ends flat, or is held by its stops."""
    tighter, closer = "lower the tolerance", "take the compliant formulation"
    gentler = closer if "implicit" in methods else "take the implicit method"
    easier = f"raise the tolerance, or {gentler}"
    if compiled.formulation == "penalty":
        easier, closer = "raise the tolerance, or lower cut_stiffness and stop_stiffness", "raise cut_stiffness"
    return {
        "time": "drive it more slowly, or more firmly" if driven else "give it more seconds",
        "steps": easier,
        "singular": closer,
        "short": easier,
        "stuck": "give stiffer springs, or less friction or harness",
        "open": closer,
        "diverged": f"{tighter}, or {gentler}",
        "energy": closer if compiled.formulation == "constrained" else tighter,
    }.get(ending, "")


def _friction_sentence(compiled: CompiledScene, motion: Motion) -> str:
    """Return a sentence on the friction and harness, a sum, that hold an array at the end of a motion."""
    torques = np.abs(holding_friction(compiled.system, motion.q[-1]))
    friction = np.array([drive.friction for drive in compiled.system.drives])
    joint = int(np.divide(torques, friction, out=np.zeros_like(torques), where=friction > 0.0).argmax())
    torque, most = (short_number(values[joint] / compiled.shares[joint], 3) for values in (torques, friction))
    hinges = named_hinges(compiled.linkage, compiled.hinges_of(joint))
    return f"friction or harness is used most in hinges {hinges}, {torque} of {most} N m"


def reason_with_clearance(reason: str, outcome: Ending, clearance: Clearance | None, labels: Labels) -> str:
    """Prefix a reason with the collision, if there is a certain or possible one."""
    if outcome == "diverged" or clearance is None or clearance.kind == "clear" or clearance.panels is None:
        return reason
    if clearance.kind == "collides":
        return f"{collision_sentence(clearance.panels, clearance.time, labels)}; {reason}"
    first, second = (labels.panels[panel] for panel in clearance.panels)
    when = "" if clearance.time is None else f" at {short_number(clearance.time)} s"
    return f"panels {first} and {second} come so near{when} that a collision cannot be excluded; {reason}"


def reason_of_check(
    outcome: Ending, end: float, clear: bool | None, collision: tuple[float, tuple[int, int]] | None, labels: Labels
) -> str:
    """Return the reason for the verdict on a deployment without its motion; end : s. clear : None if undecided."""
    if outcome == "diverged":
        return f"diverged at {short_number(end)} s: the results are not valid"
    if collision is not None:
        return collision_sentence(collision[1], collision[0], labels)
    contact = "clear until then" if clear else "a collision is neither certain nor excluded"
    if outcome == "flat":
        return f"flat after about {short_number(end, 1)} s, {contact}"  # more digits may depend on the tolerance
    return f"{outcome} at {short_number(end)} s, {contact}"


def collision_sentence(panels: tuple[int, int], time: float | None, labels: Labels) -> str:
    """Return a sentence with the names of colliding panels, and the time (s)."""
    first, second = (labels.panels[panel] for panel in panels)
    return f"panels {first} and {second} collide" + ("" if time is None else f" at {short_number(time)} s")


FLAT_FOLD_ANGLE = 0.01
"""Greatest fold angle of a flat array (rad): 0.6 degrees."""
REST_ANGLE_TOLERANCE = 1e-4
"""Greatest turn of a hinge of an array at rest, by speeds and accelerations in the remaining time or in 1 s (rad)."""
MAX_DEPLOYMENT_STEPS: dict[Formulation, int] = {
    "constrained": 20_000,
    "compliant": 100_000,
    "penalty": 400_000,
    "quasistatic": 20_000,
}
"""Steps after which a simulation is stopped; the thesis's springs need 140 for a millisecond."""
_OUTCOMES: dict[SimulationStop, Ending] = {
    "flat": "flat",
    "time": "moving",
    "rest": "at rest",
    "jammed": "jammed",
    "stuck": "stuck",
    "steps": "out of steps",
    "singular": "branch-singular",
}


def outcome_of(ending: SimulationStop) -> Ending:
    """Return the ending of a deployment from the ending of its simulation."""
    return _OUTCOMES.get(ending, "diverged")


def verdict_of(outcome: Ending, clear: bool | None) -> Verdict:
    """Return the verdict on a deployment; clear : None where collisions are undecided or were not checked.

    A simulation that diverges has no valid results, collisions included.
    """
    if outcome == "diverged" or clear is None:
        return "undecided"
    if not clear:
        return "collides"
    return "deploys" if outcome == "flat" else "undecided"


def flat_time_of(outcome: Ending, end_time: float) -> float | None:
    """Return the time at which an array is flat, s; None if it never is."""
    return end_time if outcome == "flat" else None


METHODS: dict[Formulation, tuple[Integrator, Integrator]] = {
    "constrained": ("dormand-prince", "implicit"),
    "compliant": ("linearly-implicit", "linearly-implicit"),
    "penalty": ("dormand-prince", "dormand-prince"),
    "quasistatic": ("dormand-prince", "implicit"),
}
"""Default integrators of each formulation, for motions that are not stiff and for stiff ones. No method treats the
springs of cut hinges implicitly."""


def methods_of(formulation: Formulation, method: str | None = None) -> tuple[str, str]:
    """Return the integrators for motions that are not stiff and for stiff ones: the default ones, or `method`."""
    return METHODS[formulation] if method is None else (method, method)


@dataclass(frozen=True)
class DeploymentCheck:
    """The result of one deployment without its states, which `Deployment` includes.

    outcome : `flat`; `moving` at the end of the time; `at rest` elsewhere; `stuck`, friction holds what would move
        without it; `jammed`, stops and loops prevent any motion; `diverged`; `out of steps`; `branch-singular`,
        rounding decides how it would go on.
    clear : whether the motion is certified clear until its end; None where undecided or not checked.
    collision : time (s) and panels of the first collision, or None. gap : smallest gap of a deployment that becomes
        flat and clear, m (see `Clearance`). speed : approach speed of panels where it is not clear, m/s, else 0.
        remaining : mean fold angle over pi at the collision, or at the end if it is clear; end_remaining : the same at
        the end. widest : greatest fold angle at the end, rad. drift : greatest error of the energy balance, as a share
        of the largest energy.
    stiff_time : time (s) from which on the method for stiff motions makes the steps; infinite if it never does.
    opening : greatest closure residual, rad or gap over the pattern's size. loose_share : share of the states at which
        loops are open though states are projected (see `docs/explanation/dynamics.md`, singular branches); not stored
        in databases.
    """

    outcome: Ending
    end_time: float
    clear: bool | None
    collision: tuple[float, tuple[int, int]] | None
    gap: float | None
    speed: float
    remaining: float
    end_remaining: float
    widest: float
    drift: float
    opening: float
    steps: int
    evaluations: int
    looks: int
    loose_share: float = field(default=0.0, compare=False)
    stiff_time: float = field(default=math.inf, compare=False)

    @property
    def verdict(self) -> Verdict:
        """The verdict: `deploys` (flat and certified clear), `collides`, or `undecided`."""
        return verdict_of(self.outcome, self.clear)

    @property
    def deploys(self) -> bool:
        """Whether the array becomes flat and is certified clear."""
        return self.verdict == "deploys"

    @property
    def flat_time(self) -> float | None:
        """The time at which the array is flat, s; None if it never is."""
        return flat_time_of(self.outcome, self.end_time)

    def reason(self, labels: Labels) -> str:
        """Return the reason for the verdict in a sentence, with the names of panels."""
        return reason_of_check(self.outcome, self.end_time, self.clear, self.collision, labels)
