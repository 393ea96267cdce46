"""Coefficients of integrators by name, and polynomial interpolation between their states."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import INTEGRATORS
from hcsearch.kernels.multibody.integrators import IntegrationMethod

SCIPY_SOLVERS = {
    "bogacki-shampine": "RK23",
    "dormand-prince": "RK45",
    "dormand-prince-8": "DOP853",
}
"""Explicit integrators by the names of SciPy's solvers."""
IMPLICIT_METHOD = "implicit"
"""ESDIRK4(3)6L[2]SA (Kennedy and Carpenter, Appl. Numer. Math. 44, 2003): order 4(3), L-stable, stiffly accurate."""
EXTRAPOLATED_METHOD, EXTRAPOLATION_ORDER = "linearly-implicit", 4
"""Extrapolated linearly implicit Euler, and its order."""

_IMPLICIT_DIAGONAL, _IMPLICIT_ORDER = 1 / 4, 4
_IMPLICIT_TIMES = (0.0, 1 / 2, 83 / 250, 31 / 50, 17 / 20, 1.0)
_IMPLICIT = (
    (),
    (1 / 4,),
    (8611 / 62500, -1743 / 31250),
    (5012029 / 34652500, -654441 / 2922500, 174375 / 388108),
    (15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912),
    (82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211),
)
_IMPLICIT_THIRD_ORDER = (
    4586570599 / 29645900160,
    0.0,
    178811875 / 945068544,
    814220225 / 1159782912,
    -3700637 / 11593932,
    61727 / 225920,
)
_PREDICTING_STAGES = 4
"""Greatest number of earlier stages whose derivatives are extrapolated to the first guess of an implicit stage."""

_DORMAND_PRINCE = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
_DORMAND_PRINCE_ERRORS = (-71 / 57600, 0.0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40)


@cache
def method_named(name: str) -> IntegrationMethod:
    """Return the coefficients of a method.

    They are SciPy's. As SciPy takes longer to load than many deployments to compute, the coefficients of Dormand and
    Prince (1980), which nearly all motions use, are given here.
    """
    if name == IMPLICIT_METHOD:
        return _implicit()
    if name == EXTRAPOLATED_METHOD:
        return _extrapolated()
    if name == "dormand-prince":
        return _dormand_prince()
    if name not in SCIPY_SOLVERS:
        raise HcsearchError(f"there is no method {name!r}: choose one of {', '.join(INTEGRATORS)}")
    from scipy import integrate  # noqa: PLC0415 - see above

    solver = getattr(integrate, SCIPY_SOLVERS[name])
    stages = solver.n_stages
    a = np.zeros((stages, stages))
    a[:, : solver.A.shape[1]] = solver.A[:stages, :stages]
    if name == "dormand-prince-8":
        errors, order = np.array([solver.E5, solver.E3]), 8
    else:
        errors, order = np.array([solver.E, np.zeros(stages + 1)]), solver.error_estimator_order + 1
    return _explicit(a, np.array(solver.B, float), np.ascontiguousarray(errors, float), order)


def methods_text(methods: tuple[str, str], stiff_time: float) -> str:
    """Return the names of the integrators before and from a time (s), which is infinite where there is one alone."""
    first, second = methods
    if first == second or stiff_time == 0.0:
        return second
    return first if math.isinf(stiff_time) else f"{first}, {second} from {stiff_time:.3g} s"


def _dormand_prince() -> IntegrationMethod:
    stages = len(_DORMAND_PRINCE)
    a = np.zeros((stages, stages))
    for row, weights in enumerate(_DORMAND_PRINCE[:-1], 1):
        a[row, :row] = weights
    errors = np.array([_DORMAND_PRINCE_ERRORS, np.zeros(stages + 1)])
    return _explicit(a, np.array(_DORMAND_PRINCE[-1]), errors, 5)


def _explicit(a: Reals, b: Reals, errors: Reals, order: int) -> IntegrationMethod:
    return IntegrationMethod(a, b, errors, order, 0.0, np.zeros((0, 0)), 0)


def _implicit() -> IntegrationMethod:
    stages = len(_IMPLICIT)
    a, predictors = np.zeros((stages, stages)), np.zeros((stages, stages))
    for row, weights in enumerate(_IMPLICIT[1:], 1):
        a[row, :row], a[row, row] = weights, _IMPLICIT_DIAGONAL
        near = sorted(range(row), key=lambda k: abs(_IMPLICIT_TIMES[k] - _IMPLICIT_TIMES[row]))[:_PREDICTING_STAGES]
        for k in near:  # Lagrange's polynomials
            others = [_IMPLICIT_TIMES[j] for j in near if j != k]
            factors = [(_IMPLICIT_TIMES[row] - time) / (_IMPLICIT_TIMES[k] - time) for time in others]
            predictors[row, k] = math.prod(factors)
    errors = np.zeros((2, stages + 1))
    errors[0, :stages] = a[-1] - _IMPLICIT_THIRD_ORDER
    return IntegrationMethod(a, a[-1].copy(), errors, _IMPLICIT_ORDER, _IMPLICIT_DIAGONAL, predictors, 0)


def _extrapolated() -> IntegrationMethod:
    s = EXTRAPOLATION_ORDER
    return IntegrationMethod(np.zeros((s, s)), np.zeros(s), np.zeros((2, s + 1)), s, 0.0, np.zeros((0, 0)), s)


def interpolate_motion(nodes: Reals, q: Reals, v: Reals, a: Reals | None, times: Reals) -> Reals:
    """Interpolate the coordinates of a motion with states at `nodes`, (k,), s, at times; shape (len(times), n).

    q, v, a : (k, n), coordinates, velocities, accelerations. Quintic Hermite interpolation, with an error of O(h^6) for
    a step h; cubic, O(h^4), where accelerations are None.
    """
    times = np.asarray(times, float)
    k = np.clip(np.searchsorted(nodes, times, side="right") - 1, 0, len(nodes) - 2)
    h = (nodes[k + 1] - nodes[k])[:, None]
    x = np.divide(times[:, None] - nodes[k][:, None], h, out=np.zeros_like(h), where=h > 0.0)
    q0, rise = q[k], q[k + 1] - q[k]
    v0, v1 = h * v[k], h * v[k + 1]
    if a is None:
        cubic: Reals = q0 + x * (v0 + x * (3 * rise - 2 * v0 - v1 + x * (v0 + v1 - 2 * rise)))
        return cubic
    a0, a1 = h * h * a[k], h * h * a[k + 1]
    c3 = 10 * rise - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15 * rise + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    c5 = 6 * rise - 3 * (v0 + v1) - 0.5 * (a0 - a1)
    quintic: Reals = q0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
    return quintic
