"""Numerical continuation of motions of one parameter by prediction and correction (thesis appendix A1 and A2).

The thesis adds a fixed increment along the tangent and corrects it. Here the motion is followed by its arc length in
the space of fold angles, with predictors of higher order and error control of the step. It ends at the flat or the
folded state, both of them singular, or where a hinge reaches its stop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import counted
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL
from hcsearch.motion.paths.motions import (
    STOP_TOLERANCE,
    MotionPath,
    PathEnding,
    SingularEvent,
    first_stop,
    motion_path_of,
    singular_states,
    stop_margins,
)
from hcsearch.motion.paths.stepping import PREDICTORS, Advance, PathStep, Walker, miss_distance
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.labels import named_hinges
from hcsearch.shape.linkage import Linkage

PathGoal = Literal["flat", "folded", "end", "none"]
PathEnd = Literal["flat", "folded"]

MIN_PATH_STEP = 1e-10
"""Minimum step (rad)."""
LANDING_DISTANCE, SURE_LANDING_DISTANCE, MAX_LANDING_MISS = 0.1, 1e-4, 1e-8
"""The last step to an end is made from less than `SURE_LANDING_DISTANCE` (rad a hinge) if the path would miss the end
by no more than `MAX_LANDING_MISS` (rad), and from less than `LANDING_DISTANCE` where states in between cannot be
trusted."""
CLOSURE_ROUNDING, BLURRED_STATE_SHARE = 1e-14, 1e-6
"""Rounding error of the closure, and the error that is allowed for a state as a share of its distance from a singular
one."""
LOST_CLOSURE_RESIDUAL = 0.1
"""Closure is lost where the residual is greater than this."""


@dataclass(frozen=True)
class Stepping:
    """Step control of a path.

    method : `increment` (fixed increments of the fastest hinge, as in the thesis), `euler`, `taylor` (second order),
        `runge-kutta` (fourth), `hermite` (fifth, from two states).
    step : first step (rad of arc length; `increment`: rad of the fastest hinge), and every step if not adaptive.
    max_step : greatest step (rad of arc length); None for a tenth of a half turn of every hinge.
    tolerance : distance (rad) from the predicted to the corrected state at which adaptive steps aim.
    corrections : Newton corrections in each step; None for as many as closure needs. A number serves to compare
        methods, with fixed steps.
    """

    method: str = "hermite"
    step: float | None = None
    max_step: float | None = None
    tolerance: float = 1e-3
    adaptive: bool = True
    corrections: int | None = None

    def __post_init__(self) -> None:
        if self.method not in PREDICTORS:
            raise HcsearchError(f"there is no method {self.method!r}: choose one of {', '.join(PREDICTORS)}")
        if self.adapts and self.corrections is not None:
            raise HcsearchError("steps cannot adapt to unfinished corrections: give adaptive=False, or leave them out")

    @property
    def adapts(self) -> bool:
        """Whether steps adapt; the thesis's increments are fixed."""
        return self.adaptive and self.method != "increment"

    def first(self, n_hinges: int) -> float:
        """The first step: short, as it usually leaves a singular state; later steps grow by error control."""
        if self.step is not None:
            return self.step
        if self.method == "increment":
            return 0.01
        return (SURE_LANDING_DISTANCE if self.adapts else 0.02) * math.sqrt(n_hinges)


@dataclass(frozen=True)
class PathLimits:
    """Conditions that end a path.

    goal : the state that ends it: `flat`, `folded`, `end` for either, `none` for neither. stops : whether hinges stop
        at 0 and pi; else they turn on. events : whether to search for singular states between the states.
    at_bifurcation : whether to pass bifurcations straight on, or to stop at the first. at_event : the same for all
        singular states.
    length : arc length (rad) at which to end.
    """

    goal: PathGoal = "end"
    stops: bool = True
    events: bool = True
    at_bifurcation: Literal["pass", "stop"] = "pass"
    at_event: Literal["pass", "stop"] = "pass"
    max_steps: int = 2000
    length: float = math.inf


ADAPTIVE_STEPPING, DEFAULT_PATH_LIMITS = Stepping(), PathLimits()


def follow_path(
    linkage: Linkage,
    start: Reals,
    direction: Reals | None = None,
    *,
    stepping: Stepping = ADAPTIVE_STEPPING,
    limits: PathLimits = DEFAULT_PATH_LIMITS,
    zero_share: float = 0.0,
) -> MotionPath:
    """Follow the motion that begins at a closed state in a direction.

    direction : velocity of the fold angles, which is projected onto the tangent space; None for the straight direction
        to the goal (flat, where either end will do). A singular state needs one (`branches`).
        With several degrees of freedom the motion is the geodesic: it runs on as straight as closure allows.
    zero_share : as in `Walker`, for a start that is located only approximately, and for motions along singular states.
    """
    begin = np.array(start, float)
    if direction is None:
        direction = (linkage.folded if limits.goal == "folded" else linkage.flat) - begin
    return _Following(linkage, stepping, limits, zero_share, begin, np.asarray(direction, float)).run()


class _Landing(NamedTuple):
    """An end that the path leads to, and its distance (rad)."""

    name: PathEnd
    state: Reals
    distance: float


class _Following(SteppedSearch[MotionPath]):
    """The state of a path that is being followed. ending : why it ends; None while it goes on."""

    def __init__(
        self,
        linkage: Linkage,
        stepping: Stepping,
        limits: PathLimits,
        zero_share: float,
        start: Reals,
        direction: Reals,
    ) -> None:
        self.walker = Walker(linkage, PREDICTORS[stepping.method], stepping.corrections, zero_share)
        self.limits, self.distance = limits, stepping.first(linkage.n_hinges)
        self.adapts_first = stepping.adapts and stepping.step is None
        self.tolerance = stepping.tolerance if stepping.adapts else math.inf
        self.watches_events = limits.events and stepping.corrections is None
        both: dict[PathEnd, Reals] = {"flat": linkage.flat, "folded": linkage.folded}
        self.ends = {
            name: end for name, end in both.items() if limits.goal in {name, "end"} and _is_closed(linkage, end)
        }
        self.size = math.sqrt(linkage.n_hinges)
        self.max_step = stepping.max_step or 0.1 * math.pi * self.size
        self.states: list[PathStep] = []
        self.events: list[SingularEvent] = []
        self.landing: _Landing | None = None
        self.rejected = 0
        self.ending = self._begin(start, direction)

    @property
    def last(self) -> PathStep:
        return self.states[-1]

    @property
    def before(self) -> PathStep | None:
        return self.states[-2] if len(self.states) > 1 else None

    @property
    def done(self) -> bool:
        return self.ending is not None

    def step(self, budget: Budget) -> None:
        self.ending = self._ending() or self._advance()

    @property
    def result(self) -> MotionPath:
        assert self.ending is not None
        states, lengths = [state.local for state in self.states], [state.length for state in self.states]
        effort: dict[str, Any] = {"rejected": self.rejected, "evaluations": self.walker.evaluations}
        return motion_path_of(states, lengths, self.ending, **effort, events=self.events, velocity=self.last.tangent)

    def _begin(self, start: Reals, direction: Reals) -> PathEnding | None:
        local = self.walker.start_at(start)
        tangent = local.tangent(direction)
        tangent_norm, direction_norm = float(np.linalg.norm(tangent)), float(np.linalg.norm(direction))
        moves = tangent_norm > 1e-9 * direction_norm
        self.states.append(PathStep(local, tangent / tangent_norm if moves else tangent, 0.0))
        for name, state in self.ends.items():
            if not direction_norm and not np.abs(start - state).any():
                return PathEnding(name, f"{name} at the start")
        if local.residual > 10 * CLOSED_LOOP_RESIDUAL:
            return PathEnding("lost closure", f"the start is not closed: its residual is {local.residual:.1e}")
        beyond = np.flatnonzero(stop_margins(local.angles) < -STOP_TOLERANCE) if self.limits.stops else ()
        if len(beyond):
            names = named_hinges(self.walker.linkage, beyond)
            return PathEnding("stopped", f"the start is beyond the stops of hinges {names}", tuple(map(int, beyond)))
        if local.rank.rank is None and not self.walker.zero_share:
            return PathEnding("undecided", f"the rank at the start is not decided: a gap of {local.rank.gap:.1e} only")
        if not moves:
            return PathEnding("lost closure", "closure lets nothing move in this direction: take one from `branches`")
        return None

    def _ending(self) -> PathEnding | None:
        """The reason why the path ends at its last state; None if it goes on."""
        last = self.last
        if self.limits.stops:
            # to first order; hinges that turn outward later are detected by later steps
            outward = np.where(last.angles < 0.5 * math.pi, -last.tangent, last.tangent)
            blocked = np.flatnonzero((stop_margins(last.angles) <= STOP_TOLERANCE) & (outward > 1e-6))
            if len(blocked):
                return _stopped(self.walker.linkage, blocked)
        if last.length >= self.limits.length * (1 - 1e-12):
            return PathEnding("length", f"at length {last.length:.6g}")
        if len(self.states) > self.limits.max_steps:
            return PathEnding("out of budget", f"{self.limits.max_steps} steps were not enough: raise max_steps")
        return None

    def _advance(self) -> PathEnding | None:
        distance = self.distance
        if self.walker.predictor.name == "increment":
            distance /= float(np.abs(self.last.tangent).max())
        distance = min(distance, self.limits.length - self.last.length)
        previous = self.landing
        distance, self.landing = self._approach(distance)
        landing = self.landing or previous
        # once the path leads to an end, contrary states beside the end are due to rounding
        if landing is not None and (self.landing is None or _is_near(self.last, landing, self.size)):
            return self._land(landing)
        if self.adapts_first and len(self.states) == 1:
            distance, advance = self._first_step(distance)
        else:
            advance = self.walker.advance(self.before, self.last, distance)
        if landing is not None and (advance is None or advance.step.local.rank.rank is None):
            return self._land(landing)  # its singularity hides the states before it
        if advance is None or advance.error > 4 * self.tolerance:
            return self._shorten_step(distance, lost=advance is None and math.isinf(self.tolerance))
        if advance.step.local.residual > LOST_CLOSURE_RESIDUAL:
            return PathEnding(
                "lost closure", f"uncorrected, the loops have opened by {advance.step.local.residual:.1e}"
            )
        if math.isfinite(self.tolerance):
            factor = 0.9 * (self.tolerance / max(advance.error, 1e-300)) ** (1.0 / (advance.order + 1))
            self.distance = min(self.max_step, distance * min(3.0, max(0.3, factor)))
        return self._add_state(self.before, self.last, advance.step)

    def _approach(self, distance: float) -> tuple[float, _Landing | None]:
        """Shorten a step towards a near end to four fifths of the way; also return that end if the path leads to it."""
        landing = None
        for name, state in self.ends.items():
            offset = state - self.last.angles
            remaining = float(np.linalg.norm(offset))
            if remaining >= 2.0 * distance or offset @ self.last.tangent <= 0.9 * remaining:
                continue
            if self.last.local.nullity > 1:  # one geodesic of many would miss the end: turn towards it
                tangent = self.last.local.tangent(offset)
                self.states[-1] = replace(self.last, tangent=tangent / np.linalg.norm(tangent))
            distance = min(distance, 0.8 * remaining)
            near = remaining < LANDING_DISTANCE * self.size
            if near and miss_distance(self.before, self.last, state) < MAX_LANDING_MISS:
                landing = _Landing(name, state, remaining)
        return distance, landing

    def _first_step(self, distance: float) -> tuple[float, Advance | None]:
        """Make the first step: short, but so long that the distance from a singular state exceeds rounding."""
        best: tuple[float, Advance | None] = (distance, None)
        for power in range(10):
            trial_distance = distance * 2**power
            if power and trial_distance > min(self.max_step, self.limits.length):
                break
            advance = self.walker.advance(None, self.last, trial_distance)
            if advance is not None and advance.error <= 4 * self.tolerance:
                best = (trial_distance, advance)
                if not _blurred(advance.step, trial_distance):
                    break
        return best

    def _shorten_step(self, distance: float, *, lost: bool) -> PathEnding | None:
        """Reject a step and shorten the next one; end the path if steps become too short."""
        self.rejected += 1
        self.distance = 0.4 * distance
        if self.distance >= MIN_PATH_STEP and not lost:
            return None
        sentence = "no closed state follows: the direction is no motion, or the step is too long"
        return PathEnding("lost closure", f"{sentence} (steps down to {distance:.1e})")

    def _land(self, landing: _Landing) -> PathEnding:
        local = self.walker.state_at(landing.state)
        distance = float(np.linalg.norm(landing.state - self.last.angles))
        self.states.append(PathStep(local, self.last.tangent, self.last.length + distance))
        return PathEnding(landing.name, f"{landing.name} after {len(self.states) - 1} steps")

    def _add_state(self, before: PathStep | None, last: PathStep, after: PathStep) -> PathEnding | None:
        """Add a state, with the stop or the singular states between it and the last one."""
        if self.limits.stops and stop_margins(after.angles).min() < -STOP_TOLERANCE:
            stop = first_stop(self.walker, before, last, after)
            if stop is None:
                return self._shorten_step(after.length - last.length, lost=math.isinf(self.tolerance))
            if stop is not last:
                # near a singular state, closing the loops may move the stop on
                chord = float(np.linalg.norm(stop.angles - last.angles))
                self.states.append(replace(stop, length=max(stop.length, last.length + chord)))
            margins, beyond = stop_margins(stop.angles), stop_margins(after.angles) < -STOP_TOLERANCE
            # near a singular state the stop is located less accurately than its tolerance
            reached = beyond & (margins <= max(STOP_TOLERANCE, float(margins[beyond].min())))
            return _stopped(self.walker.linkage, np.flatnonzero(reached))
        if self.watches_events:
            for event in singular_states(self.walker, before, last, after):
                self.events.append(event)
                ending = self._ending_at(event)
                if ending is not None:
                    self.states.append(replace(last, local=self.walker.state_at(event.angles), length=event.length))
                    return ending
        self.states.append(after)
        return None

    def _ending_at(self, event: SingularEvent) -> PathEnding | None:
        """The reason to end the path at a singular state; None where it passes it."""
        if event.kind == "bifurcation" and "stop" in {self.limits.at_bifurcation, self.limits.at_event}:
            return PathEnding("branch", f"a bifurcation: {counted(event.nullity, 'first-order motion')}")
        if self.limits.at_event == "stop":
            motions = counted(event.nullity, "first-order motion")
            return PathEnding("singular", f"a singular state ({event.kind}): {motions}")
        return None


def _is_closed(linkage: Linkage, state: Reals) -> bool:
    return float(np.abs(linkage.closure(state)[0]).max(initial=0.0)) <= CLOSED_LOOP_RESIDUAL


def _is_near(last: PathStep, landing: _Landing, size: float) -> bool:
    return landing.distance < SURE_LANDING_DISTANCE * size or _blurred(last, landing.distance)


def _blurred(step: PathStep, distance: float) -> bool:
    """Whether rounding, over the least singular value, is significant at a distance from a singular state."""
    return BLURRED_STATE_SHARE * step.local.least_singular_value * distance < CLOSURE_ROUNDING


def _stopped(linkage: Linkage, hinges: WholeNumbers) -> PathEnding:
    return PathEnding("stopped", f"hinges at their stops: {named_hinges(linkage, hinges)}", tuple(map(int, hinges)))
