"""Steps along a motion: prediction by one of several predictors, then correction onto the closed states.

All follow the geodesic of the closed states in the space of fold angles, parametrised by its arc length; with one
degree of freedom that is the motion. The order of a predictor is the highest power of the step to which it is exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, correction
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.shape.linkage import Linkage

DISTINCT_STATE_DISTANCE = 1e-12
"""States nearer than this (rad) are the same: no difference quotient is computed between them."""


@dataclass(frozen=True, eq=False)
class PathStep(ByValue):
    """A state on a path with its unit tangent and its arc length from the start."""

    local: LocalState
    tangent: Reals
    length: float

    @cached_property
    def acceleration(self) -> Reals:
        """Acceleration of the geodesic."""
        return self.local.geodesic_acceleration(self.tangent)

    @cached_property
    def slopes(self) -> Reals:
        """Derivatives of the kept singular values with respect to arc length."""
        local, small = self.local, 1e-6
        jacobian = local.linkage.closure(local.angles + small * self.tangent)[1]
        rates: Reals = np.einsum("rk,kr->k", local.left, local.right @ (jacobian - local.jacobian).T) / small
        return rates

    @property
    def angles(self) -> Reals:
        """Fold angles of the state."""
        return self.local.angles


PredictedState = tuple[Reals, Reals, int]
"""Predicted fold angles and velocity, and the order of the prediction."""


@dataclass(frozen=True)
class Predictor:
    """A named predictor of the state at a distance from the last one, given also the one before it (or None).

    evaluations : number of evaluations of the closure in each prediction.
    """

    name: str
    predict: Callable[[PathStep | None, PathStep, float], PredictedState]
    evaluations: int = 0


def _euler(before: PathStep | None, last: PathStep, distance: float) -> PredictedState:
    """Predict along the tangent (thesis appendix A1)."""
    return last.angles + distance * last.tangent, last.tangent, 1


def _taylor(before: PathStep | None, last: PathStep, distance: float) -> PredictedState:
    """Predict along the osculating parabola: the second-order closure equations cost one pass around the loops.

    The velocity follows the trapezoidal rule: the other half of it is normal to the closed states at the next one, and
    vanishes by projection there.
    """
    velocity = last.tangent + 0.5 * distance * last.acceleration
    return last.angles + distance * velocity, velocity, 2


def _adams(before: PathStep | None, last: PathStep, distance: float) -> PredictedState:
    """Predict along the parabola corrected by the change of the acceleration (Adams, Bashforth and Moulton).

    The velocity is the integral of the quadratic through three accelerations; the next one vanishes by projection. The
    first step, and one from a singular state, where part of the acceleration is unknown, is a parabola.
    """
    if not _comparable(before, last):
        return _taylor(before, last, distance)
    assert before is not None
    h, k = distance, last.length - before.length
    bend = 0.5 * last.acceleration + h / (6 * k) * (last.acceleration - before.acceleration)
    angles = last.angles + h * last.tangent + h * h * bend
    velocity = last.tangent + h / (6 * k) * ((3 * k + h) * last.acceleration - h * h / (h + k) * before.acceleration)
    return angles, velocity, 3


def _runge_kutta(before: PathStep | None, last: PathStep, distance: float) -> PredictedState:
    """Predict by the classical fourth-order Runge-Kutta method on angles and velocity of the geodesic."""
    linkage, kept_rank, h = last.local.linkage, last.local.kept_rank, distance

    def slopes(angles: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        local = local_at(linkage, angles, kept_rank=kept_rank)
        tangent = local.tangent(velocity)
        return tangent, local.geodesic_acceleration(tangent)

    q, v = last.angles, last.tangent
    q1, v1 = last.tangent, last.acceleration
    q2, v2 = slopes(q + 0.5 * h * q1, v + 0.5 * h * v1)
    q3, v3 = slopes(q + 0.5 * h * q2, v + 0.5 * h * v2)
    q4, v4 = slopes(q + h * q3, v + h * v3)
    return q + h / 6 * (q1 + 2 * q2 + 2 * q3 + q4), v + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4), 4


def _hermite(before: PathStep | None, last: PathStep, distance: float) -> PredictedState:
    """Predict by the quintic through the last two states, their tangents and accelerations.

    Only with one degree of freedom, where the correction removes the errors that extrapolation amplifies; else Adams.
    """
    if not _comparable(before, last) or len(last.angles) - last.local.kept_rank != 1:
        return _adams(before, last, distance)
    assert before is not None
    h = last.length - before.length
    x = distance / h
    # the parabola of the last state is exact to x^2 at x = 0; three more terms match the state before, at x = -1
    rest = before.angles - (last.angles - h * last.tangent + 0.5 * h * h * last.acceleration)
    slope = h * (before.tangent - last.tangent + h * last.acceleration)
    bend = h * h * (before.acceleration - last.acceleration)
    # rest = -a + b - c, slope = 3 a - 4 b + 5 c, bend = -6 a + 12 b - 20 c
    c = -6 * rest - 3 * slope - 0.5 * bend
    b = -15 * rest - 7 * slope - bend
    a = b - c - rest
    angles, velocity, _ = _taylor(before, last, distance)
    return angles + x**3 * (a + x * (b + x * c)), velocity, 5


def _comparable(before: PathStep | None, last: PathStep) -> bool:
    """Whether two states have comparable accelerations."""
    if before is None or before.local.kept_rank != last.local.kept_rank:
        return False
    return last.length - before.length > DISTINCT_STATE_DISTANCE


PREDICTORS = {
    p.name: p
    for p in (
        Predictor("increment", _euler),
        Predictor("euler", _euler),
        Predictor("taylor", _taylor),
        Predictor("adams", _adams),
        Predictor("runge-kutta", _runge_kutta, evaluations=3),
        Predictor("hermite", _hermite),
    )
}


def arc_length(first: PathStep, second: PathStep) -> float:
    """Arc length between two states, exact to fourth order, by end points, tangents and accelerations.

    The two-point formula q1 - q0 = s/2 (t0 + t1) + s^2/12 (w0 - w1), solved for s along the mean tangent. It is no less
    than their distance along that tangent: near a singular state accelerations are inaccurate.
    """
    mean = 0.5 * (first.tangent + second.tangent)
    along = float(mean @ mean)
    chord = float((second.angles - first.angles) @ mean) / along
    curve = float((first.acceleration - second.acceleration) @ mean) / along / 12
    s = chord
    for _ in range(3):
        s = chord - s * s * curve
    return max(s, chord * math.sqrt(along))


def miss_distance(before: PathStep | None, last: PathStep, state: Reals) -> float:
    """Distance (rad) at which the extrapolated motion passes a state ahead, by the predictor of highest order."""
    distance = float(np.linalg.norm(state - last.angles))
    for _ in range(3):
        point = _hermite(before, last, distance)[0]
        slope = (point - _hermite(before, last, 0.999 * distance)[0]) / (0.001 * distance)
        distance += float((state - point) @ slope / (slope @ slope))
    return float(np.linalg.norm(state - _hermite(before, last, distance)[0]))


MAX_CORRECTIONS = 12
MIN_TANGENT_COSINE = 0.7
"""Minimum scalar product of the unit tangents at both ends of a step."""


class Advance(NamedTuple):
    """The result of a step: the new state, the error of its prediction (rad), and the order of the prediction."""

    step: PathStep
    error: float
    order: int


@dataclass
class Walker:
    """Makes steps with one predictor, and counts evaluations of the closure.

    corrections : Newton corrections in each step; None for as many as closure needs.
    zero_share : singular values below this share of the greatest count as zeros at a start, and from there on as long
        as they stay below it; elsewhere rounding alone decides, so that singular states on the way are found.
    """

    linkage: Linkage
    predictor: Predictor
    corrections: int | None = None
    zero_share: float = 0.0
    evaluations: int = field(default=0, init=False)

    def state_at(self, angles: Reals) -> LocalState:
        """Analyse the linkage at given fold angles."""
        self.evaluations += 1
        return local_at(self.linkage, angles)

    def start_at(self, angles: Reals) -> LocalState:
        """Analyse the linkage at the start of a motion."""
        return self._without_zeros(self.state_at(angles))

    def _without_zeros(self, local: LocalState) -> LocalState:
        kept = int(np.count_nonzero(local.values > self.zero_share * local.values.max(initial=0.0)))
        return replace(local, left=local.left[:, :kept], values=local.values[:kept], right=local.right[:kept])

    def advance(self, before: PathStep | None, last: PathStep, distance: float) -> Advance | None:
        """Make a step of a given length; None if no trustworthy state results."""
        predicted, velocity, order = self.predictor.predict(before, last, distance)
        self.evaluations += self.predictor.evaluations
        local = (
            self._closed(predicted) if self.corrections is None else self._corrected(predicted, last.local.kept_rank)
        )
        if local is None:
            return None
        if last.local.kept_rank < local.kept_rank:
            reduced = self._without_zeros(local)
            local = reduced if reduced.kept_rank == last.local.kept_rank else local
        tangent = local.tangent(velocity)
        size = float(np.linalg.norm(tangent))
        if size < MIN_TANGENT_COSINE or tangent @ last.tangent < MIN_TANGENT_COSINE * size:
            return None
        step = PathStep(local, tangent / size, 0.0)
        # where the rank changes, the acceleration on one side is unknown
        length = arc_length(last, step) if local.kept_rank == last.local.kept_rank else distance
        if not 0.5 * distance < length < 2.0 * distance:  # much shorter or longer: on another branch
            return None
        error = float(np.linalg.norm(local.angles - predicted))
        return Advance(PathStep(local, step.tangent, last.length + length), error, order)

    def _closed(self, angles: Reals) -> LocalState | None:
        """The closed state nearest to a prediction; None where Newton's method does not converge.

        One more correction is made than closure needs: near a singular state the error of the angles is the residual
        over the least singular value.
        """
        tolerance = 50 * np.finfo(float).eps * math.sqrt(self.linkage.n_hinges)
        polished = False
        for _ in range(MAX_CORRECTIONS):
            residual, jacobian = self._closure(angles)
            worst = float(np.abs(residual).max(initial=0.0))
            if worst <= tolerance or (polished and worst <= CLOSED_LOOP_RESIDUAL):
                return local_at(self.linkage, angles, closure=(residual, jacobian))
            if not math.isfinite(worst):
                return None
            polished = worst <= CLOSED_LOOP_RESIDUAL
            angles = angles + correction(jacobian, residual)
        return None

    def _corrected(self, angles: Reals, kept_rank: int) -> LocalState | None:
        """Correct a prediction a fixed number of times, closed or not; None where the residual is not finite."""
        for _ in range(self.corrections or 0):
            residual, jacobian = self._closure(angles)
            angles = angles + correction(jacobian, residual)
        residual, jacobian = self._closure(angles)
        if not np.isfinite(residual).all():
            return None
        return local_at(self.linkage, angles, kept_rank=kept_rank, closure=(residual, jacobian))

    def _closure(self, angles: Reals) -> tuple[Reals, Reals]:
        self.evaluations += 1
        return self.linkage.closure(angles)
