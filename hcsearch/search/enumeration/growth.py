"""The growth constant of a sequence of counts: a least-squares fit of C mu^n n^g to their logarithms.

Counts of polygons on a lattice are asymptotic to C mu^n n^g, where g is believed to be -5/2 on every lattice (Nienhuis,
Phys. Rev. Lett. 49 (1982) 1062). The fit with that exponent, biased in the words of Guttmann (Phase Transitions and
Critical Phenomena 13 (1989) 1), has a term in 1/n for the remainder. Counts of small n, and lattices on which they rise
and fall with n, make fits differ: the error covers the changes between fits to neighbouring windows of n.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

POLYGON_EXPONENT = -2.5
_LEAST_COUNTS = 6  # three parameters, and three more counts to judge the fit
_SHARE = 2 / 3  # the share of the counts that is fitted: the last ones
_LARGEST_ERROR = 0.5  # greatest error of ln mu: beyond it the number says nothing


@dataclass(frozen=True)
class Growth:
    """The growth of counts as C mu^n n^exponent.

    mu : the growth constant, per panel. mu_error : its estimated error. exponent : fitted, or as given; exponent_error
    : its estimated error, 0 where it was given.
    """

    mu: float
    mu_error: float
    exponent: float
    exponent_error: float


def fit_growth(counts: Mapping[int, int], exponent: float | None = None) -> Growth | None:
    """Fit the growth of counts by n; None where fewer than six are positive, or where they do not determine it.

    counts : count by n, in any spacing; zeros are left out. exponent : the known exponent; by default it is fitted.

    The last two thirds of the counts are fitted. The error is twice the greatest of: the standard error; the change
    when the window moves back by one or two counts, or has one more or fewer; and the change by the next term in
    1/n, where this term is significant.
    """
    sizes = [n for n in sorted(counts) if counts[n] > 0]
    if len(sizes) < _LEAST_COUNTS:
        return None
    n = np.array(sizes, float)
    logs = np.array([math.log(counts[size]) for size in sizes])  # also works for integers beyond the range of floats
    width = max(_LEAST_COUNTS, math.ceil(_SHARE * len(sizes)))
    best, standard_error = _fit(n[-width:], logs[-width:], exponent)
    others = [
        _fit(n[end - wide : end], logs[end - wide : end], exponent)[0]
        for end in range(len(sizes) - 2, len(sizes) + 1)
        for wide in (width - 1, width, width + 1)
        if _LEAST_COUNTS - 1 <= wide <= end
    ]
    longer, longer_error = _fit(n[-width:], logs[-width:], exponent, further_terms=1)
    if (np.abs(longer - best) > 2 * longer_error).all():
        others.append(longer)
    errors = 2 * np.maximum(standard_error, np.abs(np.array(others) - best).max(axis=0))
    if errors[0] > _LARGEST_ERROR:
        return None
    mu = math.exp(best[0])
    if exponent is not None:
        return Growth(mu, mu * float(errors[0]), exponent, 0.0)
    return Growth(mu, mu * float(errors[0]), float(best[1]), float(errors[1]))


def _fit(
    n: NDArray[np.float64], logs: NDArray[np.float64], exponent: float | None, further_terms: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit logarithms of counts; ln mu and the exponent (or the factor of 1/n), and their standard errors."""
    middle = n.mean()  # about the mean, the columns are nearly independent
    x = n / middle
    columns = [np.ones_like(n), n - middle]
    columns += [np.log(x)] if exponent is None else [1 / x]
    columns += [x ** -(k + (exponent is not None)) for k in range(1, further_terms + 1)]
    matrix = np.stack(columns, axis=1)
    wanted = logs if exponent is None else logs - exponent * np.log(n)
    inverse = np.linalg.pinv(matrix)
    values = inverse @ wanted
    residual = wanted - matrix @ values
    variance = residual @ residual / (len(n) - matrix.shape[1])
    return values[1:3], np.sqrt(variance * (inverse**2).sum(axis=1))[1:3]
