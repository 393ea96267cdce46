"""Fits of moment-angle laws of springs to measured pairs (thesis 4.5.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import lstsq
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import Law, linear_law, quadratic_law, tabulated_law
from hcsearch.scenes.spring_files import MAX_FOLD_ANGLE

MIN_FIT_ANGLES = 5
MAX_CURVE_COEFFICIENTS = 8
"""Coefficients of the curve with which laws are compared: a cubic spline of five pieces."""
LAW_TABLE_POINTS = 9
LAW_REFUSAL_CONFIDENCE = 0.99
"""A law is rejected where a curve fits better with at least this probability."""
LAW_MISFIT_SHARE = 0.005
"""Systematic error of a law that measurements of springs cannot show: share of the greatest moment, rms."""
UNLOADING_ANGLE_SHARE = 0.05
"""Share of its range by which the angle must decrease to count as unloading: less is noise."""
DOUBTED_FALL_SHARE = 0.05
"""Share of the greatest moment by which a law may fall over the measured angles before a doubt is reported."""
ESTIMATE_CONFIDENCE = 0.95

_TERMS: dict[str, tuple[str, ...]] = {
    "linear": ("stiffness",),
    "linear, preloaded": ("stiffness", "preload"),
    "quadratic": ("stiffness", "growth"),
    "quadratic, preloaded": ("stiffness", "growth", "preload"),
}
_POWERS = {"stiffness": 1, "growth": 2, "preload": 0}


@dataclass(frozen=True)
class SpringEstimate:
    """A fitted number with its standard error and the ends of its 95 % confidence interval."""

    value: float
    error: float
    low: float
    high: float


@dataclass(frozen=True)
class SpringFit:
    """A law fitted to all pairs by least squares.

    law : its numbers have six digits, as has its text. size : number of fitted coefficients. estimates : `stiffness`
    (N m/rad), `growth` (N m/rad^2), `preload` and `hysteresis` (N m) as far as fitted; of a table only the hysteresis,
    the mean difference of the moments of growing and of decreasing angles.
    residual : rms residual, N m. misfit : systematic error, rms, as a share of the greatest moment.
    sureness : probability that a curve fits better, and not by chance.
    """

    kind: str
    law: Law
    size: int
    estimates: dict[str, SpringEstimate]
    residual: float
    misfit: float
    sureness: float

    @property
    def sufficient(self) -> bool:
        """Whether the data do not require another law."""
        return self.sureness < LAW_REFUSAL_CONFIDENCE or self.misfit < LAW_MISFIT_SHARE


@dataclass(frozen=True)
class IdentifiedSpring:
    """The laws of a spring fitted to moment-angle data.

    fits : simplest first, the table last. loading, unloading : numbers of pairs with growing and with decreasing
    angles. span : least and greatest angle, rad.
    """

    fits: tuple[SpringFit, ...]
    loading: int
    unloading: int
    span: tuple[float, float]

    @property
    def chosen(self) -> SpringFit:
        """The sufficient law with the fewest coefficients; of two with as many, the one with the smaller residual."""
        return min((fit for fit in self.fits if fit.sufficient), key=lambda fit: (fit.size, fit.residual))

    @property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on implausible results for the spring of a hinge, and on possible errors of the measurement."""
        doubts, (low, high) = [], self.span
        if max(-low, high) > MAX_FOLD_ANGLE:
            doubts.append(
                f"angles go from {low:.4g} to {high:.4g} rad, and hinges turn from 0 (flat) to pi: leave out what is "
                "beyond, or change the unit in the name of the column"
            )
        start, end = (self.chosen.law.straight.moment(angle) for angle in self.span)
        if start - end > DOUBTED_FALL_SHARE * max(abs(start), abs(end)):
            doubts.append(
                f"the moment falls from {start:.3g} to {end:.3g} N m as the angle grows from {low:.3g} to {high:.3g} "
                "rad; a hinge turns from 0 (flat) to pi (folded): write pi or 180 degrees minus an angle that counts "
                "from the folded state"
            )
        hysteresis = self.chosen.estimates.get("hysteresis")
        if hysteresis is not None and hysteresis.high < 0.0:
            doubts.append(
                "an angle that goes back returns more moment than a growing one takes, which no spring does: give the "
                "rows in the order of the measurement, and moments the sign of the angle"
            )
        if 0.0 < high <= math.radians(math.pi):
            doubts.append(
                f"angles reach {math.degrees(high):.3g} degrees alone: name the column angle_rad if they are in rad"
            )
        return tuple(doubts)


def fit_spring(angles: Reals, moments: Reals) -> IdentifiedSpring:
    """Fit laws of a spring to fold angles (rad) and the moments (N m) that hold them, in the order measured.

    Linear and quadratic laws, each through the origin or preloaded, are compared with a cubic spline of five pieces
    fitted to the same pairs: a law is sufficient unless the spline fits better, significantly (F test) and by more than
    such measurements show. If no law is sufficient, a table of nine points on the spline is chosen. Where the angle
    also decreases, a constant hysteresis between loading and unloading is fitted along with each law, which then lies
    midway. The thesis fits one line to all pairs (4.5.2) and says that its springs stiffen at large angles: that is a
    quadratic law.

    Standard errors assume independent residuals; where they are not (densely read gauges), the errors are too small.
    Errors: HcsearchError for fewer than five angles, numbers that are not finite, moments that are all the same.
    """
    angles, moments = _checked(angles, moments)
    unloading = _unloading(angles)
    has_hysteresis = unloading.any() and not unloading.all()
    hysteresis = np.where(unloading, -0.5, 0.5)[:, None][:, : int(has_hysteresis)]
    knots, degree = _knots(angles)
    spline = _least_squares(np.hstack([BSpline.design_matrix(angles, knots, degree).toarray(), hysteresis]), moments)
    fits = []
    for kind, terms in _TERMS.items():
        solution = _least_squares(np.column_stack([*(angles ** _POWERS[term] for term in terms), hysteresis]), moments)
        names = (*terms, "hysteresis")[: len(solution.values)]
        fits.append(_described(kind, names, _law(dict(zip(terms, solution.values, strict=False))), solution, spline))
    curve = BSpline(knots, spline.values[: len(knots) - degree - 1], degree)
    nodes = np.linspace(angles.min(), angles.max(), LAW_TABLE_POINTS)
    law = tabulated_law(map(_six_digits, nodes), map(_six_digits, curve(nodes)))
    fits.append(_described("table", ("hysteresis",)[: int(has_hysteresis)], law, spline, spline))
    span = (float(angles.min()), float(angles.max()))
    return IdentifiedSpring(tuple(fits), int((~unloading).sum()), int(unloading.sum()), span)


def _checked(angles: Reals, moments: Reals) -> tuple[Reals, Reals]:
    angles, moments = np.asarray(angles, float), np.asarray(moments, float)
    if not (np.isfinite(angles).all() and np.isfinite(moments).all()):
        raise HcsearchError("angles or moments hold values that are not numbers: leave those rows out")
    distinct = len(np.unique(angles))
    if distinct < MIN_FIT_ANGLES:
        raise HcsearchError(f"{distinct} different angles do not determine a law: measure at {MIN_FIT_ANGLES} or more")
    if np.ptp(moments) == 0.0:
        raise HcsearchError(f"the moment is {moments[0]:g} N m at every angle: is the gauge connected?")
    return angles, moments


def _unloading(angles: Reals) -> Flags:
    """Mark the angles of unloading: after a peak and before a trough, where the decrease exceeds the noise."""
    threshold = UNLOADING_ANGLE_SHARE * float(np.ptp(angles))
    unloading = np.zeros(len(angles), bool)
    direction = top = bottom = 0
    for k, angle in enumerate(angles):
        top = k if angle > angles[top] else top
        bottom = k if angle < angles[bottom] else bottom
        if direction <= 0 and angle - angles[bottom] > threshold:
            unloading[bottom + 1 : k] = False
            direction, top = 1, k
        elif direction >= 0 and angles[top] - angle > threshold:
            unloading[top + (top > 0) : k] = True
            direction, bottom = -1, k
        unloading[k] = direction < 0
    return unloading


def _knots(angles: Reals) -> tuple[Reals, int]:
    """Return knots and degree of the spline: at most five pieces, with equal numbers of distinct angles."""
    distinct = np.unique(angles)
    size = min(MAX_CURVE_COEFFICIENTS, len(distinct) // 2)
    degree = min(3, size - 1)
    breaks = np.quantile(distinct, np.linspace(0.0, 1.0, size - degree + 1))
    return np.concatenate([[breaks[0]] * degree, breaks, [breaks[-1]] * degree]), degree


@dataclass(frozen=True, eq=False)
class _Solution(ByValue):
    """A least-squares solution: values, standard errors, sum of squared residuals, degrees of freedom, moments."""

    values: Reals
    errors: Reals
    squares: float
    freedom: int
    moments: Reals


def _least_squares(columns: Reals, moments: Reals) -> _Solution:
    values = lstsq(columns, moments)[0]
    squares = float(((moments - columns @ values) ** 2).sum())
    freedom = len(moments) - columns.shape[1]
    errors = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) * squares / freedom)
    return _Solution(values, errors, squares, freedom, moments)


def _described(kind: str, names: tuple[str, ...], law: Law, solution: _Solution, spline: _Solution) -> SpringFit:
    """Return a fit with the last of its values by name, compared with the spline."""
    rows = len(solution.moments)
    half = t_distribution.ppf(0.5 + ESTIMATE_CONFIDENCE / 2.0, solution.freedom)
    values, errors = solution.values[-len(names) :], solution.errors[-len(names) :]
    estimates = {
        name: SpringEstimate(float(value), float(error), float(value - half * error), float(value + half * error))
        for name, value, error in zip(names, values, errors, strict=False)
    }
    excess, unknowns = max(0.0, solution.squares - spline.squares), solution.freedom - spline.freedom
    sureness = 0.0
    if unknowns > 0 and excess > 0.0:
        ratio = excess / unknowns / (spline.squares / spline.freedom) if spline.squares > 0.0 else np.inf
        sureness = float(f_distribution.cdf(ratio, unknowns, spline.freedom))
    return SpringFit(
        kind=kind,
        law=law,
        size=rows - solution.freedom,
        estimates=estimates,
        residual=float(np.sqrt(solution.squares / rows)),
        misfit=float(np.sqrt(excess / rows) / abs(solution.moments).max()),
        sureness=sureness,
    )


def _law(values: dict[str, float]) -> Law:
    rounded = {name: _six_digits(value) for name, value in values.items()}
    return (quadratic_law if "growth" in rounded else linear_law)(**rounded)


def _six_digits(value: float) -> float:
    """Round a number to the six digits of a notation; no gauge has more."""
    return float(f"{value:.6g}")
