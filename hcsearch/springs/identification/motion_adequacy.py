"""Whether a model explains films: tests of what it leaves against noise that is estimated without it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import norm

from hcsearch.basics.array_values import Reals
from hcsearch.springs.identification.film_course import film_noise
from hcsearch.springs.identification.law_fitting import LAW_REFUSAL_CONFIDENCE
from hcsearch.springs.identification.measured_films import Film

FILM_MISFIT_ANGLE = math.radians(0.5)
"""Systematic error of a model that a film cannot show, rms, rad: that of lenses, marks and panels that bend."""
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
