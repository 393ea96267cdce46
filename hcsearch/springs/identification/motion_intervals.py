"""Standard errors and 95 % intervals of fitted parameters, and which of them the films do not tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as t_distribution

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.springs.identification.law_fitting import ESTIMATE_CONFIDENCE
from hcsearch.springs.identification.motion_fitting import FilmProblem, FittedFilms
from hcsearch.springs.identification.motion_parameters import Parameter

SINGULAR_SHARE = 1e-10
"""Eigenvalue of the information matrix, scaled to a diagonal of 1, up to which a combination is not identified."""
UNIDENTIFIED_PART = 0.1
"""Part that a parameter has in such a combination, from which on it is not identified, either."""
MAX_TOLD_ERRORS = {"factor": 1.0, "tilt": 0.3}
"""Greatest standard error of a coordinate of an identified parameter: a factor e of a spring, 17 degrees of a tilt."""
MAX_AMOUNT = 1e4
"""Coordinate up to which the upper end of an amount is searched."""
PROFILE_STEPS = 12


@dataclass(frozen=True)
class MotionEstimate:
    """A fitted number with its standard error and the ends of its 95 % confidence interval.

    identified : whether the films determine it; if not, error and ends are None.
    """

    name: str
    unit: str
    value: float
    error: float | None
    low: float | None
    high: float | None

    @property
    def identified(self) -> bool:
        """Whether the films determine the number."""
        return self.high is not None


def estimates_of(problem: FilmProblem, fit: FittedFilms) -> tuple[MotionEstimate, ...]:
    """Return the estimates of all parameters of a fit.

    Intervals follow from the covariance at the optimum, of a factor on a logarithmic scale. Where that of an amount
    would reach below 0, the ends are found by profile likelihood: the squares grow by as much, with all else fitted.
    Where gravity in other directions fits as well, intervals reach over all these minima.
    """
    errors, identified = coordinate_errors(fit)
    half = float(t_distribution.ppf(0.5 + ESTIMATE_CONFIDENCE / 2.0, fit.freedom))
    estimates = []
    for k, parameter in enumerate(fit.parameters.parameters):
        x, error = float(fit.x[k]), float(errors[k])
        minima = [x, *(float(rival[k]) for rival in fit.rivals)]
        ends: tuple[float, float] | None = None
        if identified[k]:
            ends = min(minima) - half * error, max(minima) + half * error
        if parameter.kind == "amount" and (ends is None or ends[0] < 0.0):
            ends = _profile_ends(problem, fit, k, half)
        elif ends is not None and parameter.kind != "amount":
            ends = ends if ends[1] - ends[0] <= 2.0 * half * MAX_TOLD_ERRORS[parameter.kind] else None
        estimates.append(_estimate(parameter, x, error, ends))
    return tuple(estimates)


def coordinate_errors(fit: FittedFilms) -> tuple[Reals, Flags]:
    """Return the standard errors of the coordinates, and whether the films tell them: their information is regular."""
    scales = np.linalg.norm(fit.slopes, axis=0)
    blind = scales <= 1e-12 * max(float(scales.max(initial=0.0)), 1e-300)
    columns = fit.slopes / np.where(blind, 1.0, scales)
    values, vectors = np.linalg.eigh(columns.T @ columns)
    singular = values <= SINGULAR_SHARE
    identified = ~blind & ~(np.abs(vectors[:, singular]) > UNIDENTIFIED_PART).any(axis=1)
    inverse = (vectors[:, ~singular] ** 2 / values[~singular]).sum(axis=1)
    errors = np.sqrt(inverse * fit.squares / fit.freedom) / np.where(blind, 1.0, scales)
    count = len(fit.x)
    return errors[:count], identified[:count]


def _estimate(parameter: Parameter, x: float, error: float, ends: tuple[float, float] | None) -> MotionEstimate:
    value = parameter.value(x)
    if ends is None:
        return MotionEstimate(parameter.name, parameter.unit, value, None, None, None)
    size = value if parameter.kind == "factor" else parameter.scale
    low, high = (parameter.value(end) for end in ends)
    return MotionEstimate(parameter.name, parameter.unit, value, size * error, low, high)


def _profile_ends(problem: FilmProblem, fit: FittedFilms, k: int, half: float) -> tuple[float, float] | None:
    """Return the ends between which the squares stay within those of the confidence; None where there is no upper."""
    allowed = fit.squares * (1.0 + half * half / fit.freedom)

    def excess(x: float) -> float:
        start = fit.x.copy()
        start[k] = x
        return problem.solve(start, fit.releases, fixed=k, evaluations=8).squares - allowed

    at = float(fit.x[k])
    high = max(2.0 * at, 1e-3)
    while excess(high) < 0.0:
        high *= 2.0
        if high > MAX_AMOUNT:
            return None
    low = 0.0 if excess(0.0) <= 0.0 else _crossing(excess, 0.0, at)
    return low, _crossing(excess, high, at)


def _crossing(excess: Callable[[float], float], outside: float, inside: float) -> float:
    """Return where the excess changes its sign between two coordinates, to a thousandth of their distance."""
    tolerance = 1e-3 * abs(outside - inside)
    for _ in range(PROFILE_STEPS):
        middle = 0.5 * (outside + inside)
        if excess(middle) > 0.0:
            outside = middle
        else:
            inside = middle
        if abs(outside - inside) <= tolerance:
            break
    return outside
