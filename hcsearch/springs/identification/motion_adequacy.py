"""Whether a model explains films, and how well they determine its parameters.

What it leaves is tested against noise that is estimated without it. Parameters have standard errors and intervals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import norm
from scipy.stats import t as t_distribution

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.springs.identification.law_fitting import ESTIMATE_CONFIDENCE, LAW_REFUSAL_CONFIDENCE
from hcsearch.springs.identification.measured_films import Film, film_noise
from hcsearch.springs.identification.motion_fitting import FilmProblem, FittedFilms
from hcsearch.springs.identification.motion_parameters import Parameter

FILM_MISFIT_ANGLE = math.radians(0.5)
"""Systematic error of a model that a film cannot show, rms, rad: it comes from lenses, marks and panels that bend."""
NOISE_FREEDOM_SHARE = 0.15
"""Degrees of freedom of the noise estimate for each frame: the median uses 0.37 of them, and neighbours overlap."""
WINDOW_SHARE = 0.05
"""Share of the frames of a film over which residuals are averaged to find where they are greatest."""


@dataclass(frozen=True)
class LeftOver:
    """What a model leaves of films.

    residual : rms, rad. noise : standard deviation estimated from neighbouring frames, rad; 0 if unknown.
    misfit : systematic part of the residuals, rms, rad. excess_sureness, order_sureness : probabilities that residuals
    exceed the noise, and that they follow each other, not by chance.
    film, hinge, time, error : where the residuals, averaged over neighbouring frames, are greatest: the numbers of film
    and hinge, the time on the film's clock (s), and this mean (rad).
    """

    residual: float
    noise: float
    misfit: float
    excess_sureness: float
    order_sureness: float
    film: int
    hinge: int
    time: float
    error: float

    @property
    def explained(self) -> bool:
        """Whether only noise is left, or less than films show."""
        sure = max(self.excess_sureness, self.order_sureness) >= LAW_REFUSAL_CONFIDENCE
        return not (sure and self.misfit > FILM_MISFIT_ANGLE)


def left_over(films: Sequence[Film], residuals: Reals, freedom: int) -> LeftOver:
    """Test the residuals of a model (model minus film, rad, film by film and frame by frame).

    Lack of fit: an F test of the residuals against the noise of neighbouring frames. Order: the covariance of residuals
    of successive frames, which is 0 for noise and the mean square of what is systematic and slower than a frame.
    """
    noise, frames = film_noise(films)
    squares = float(residuals @ residuals)
    variance = squares / freedom
    excess_sureness = excess = 0.0
    if frames and noise > 0.0:
        ratio, noise_freedom = variance / noise**2, max(1.0, NOISE_FREEDOM_SHARE * frames)
        excess_sureness = float(f_distribution.cdf(ratio, freedom, noise_freedom))
        excess = math.sqrt(max(0.0, variance - noise**2))
    series = _series(films, residuals)
    products = np.concatenate([left[1:] * left[:-1] for _, _, _, left in series])
    deviation = math.sqrt(float((products**2).sum()))
    order_sureness = float(norm.cdf(products.sum() / deviation)) if deviation > 0.0 else 0.0
    ordered = math.sqrt(max(0.0, float(products.mean()))) if len(products) else 0.0
    misfit = max(ordered, excess if excess_sureness >= LAW_REFUSAL_CONFIDENCE else 0.0)
    rms = math.sqrt(squares / len(residuals))
    return LeftOver(rms, noise, misfit, excess_sureness, order_sureness, *_greatest(series))


def _series(films: Sequence[Film], residuals: Reals) -> list[tuple[int, int, Reals, Reals]]:
    """Return film, hinge, times and residuals of each measured hinge of each film."""
    series, begin = [], 0
    for number, film in enumerate(films):
        known = np.isfinite(film.angles)
        table = np.full(film.angles.shape, math.nan)
        table[known] = residuals[begin : begin + film.n_angles]
        begin += film.n_angles
        for hinge in np.flatnonzero(known.any(axis=0)):
            own = known[:, hinge]
            series.append((number, int(hinge), film.times[own], table[own, hinge]))
    return series


def _greatest(series: Sequence[tuple[int, int, Reals, Reals]]) -> tuple[int, int, float, float]:
    """Return film, hinge, time and mean residual where the mean over a window is greatest."""
    best = (0, 0, 0.0, 0.0)
    for film, hinge, times, left in series:
        window = min(len(left), max(3, round(WINDOW_SHARE * len(left))))
        means = np.convolve(left, np.full(window, 1.0 / window), mode="valid")
        k = int(np.abs(means).argmax())
        if abs(means[k]) > abs(best[3]):
            best = (film, hinge, float(times[k + window // 2]), float(means[k]))
    return best


SINGULAR_SHARE = 1e-10
"""A combination is not identified if its eigenvalue of the information matrix, scaled to a diagonal of 1, is at most
this."""
UNIDENTIFIED_PART = 0.1
"""A parameter with at least this part in such a combination is not identified, either."""
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

    Intervals follow from the covariance at the optimum, for a factor on a logarithmic scale. Where the interval of an
    amount would reach below 0, its ends are found by profile likelihood: the squares grow by as much, with all else
    fitted. Where gravity in other directions fits as well, intervals reach over all these minima.
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
    """Return the standard errors of the coordinates, and whether films determine them: their information is regular."""
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
    """Return the ends between which the squares stay within the confidence limit; None without an upper end."""
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
