"""Integrators by name: explicit Runge-Kutta methods with the coefficients that SciPy holds, and an implicit one."""

from __future__ import annotations

from functools import cache

import numpy as np

from hcsearch.errors import HcsearchError
from hcsearch.kernels.multibody.explicit import Method

METHODS = {
    "bogacki-shampine": "RK23",
    "dormand-prince": "RK45",
    "dormand-prince-8": "DOP853",
}
"""Orders 3(2) (the thesis's), 5(4) and 8(5,3), by the names of SciPy's solvers."""
IMPLICIT, ORDER = "implicit", 4
"""Extrapolated linearly implicit Euler, and its order."""


@cache
def method_named(name: str) -> Method:
    """Coefficients of a method."""
    from scipy import integrate  # noqa: PLC0415 - takes longer to load than a deployment to compute

    if name == IMPLICIT:
        return Method(np.zeros((ORDER, ORDER)), np.zeros(ORDER), np.zeros((2, ORDER + 1)), ORDER, ORDER)
    if name not in METHODS:
        raise HcsearchError(f"there is no method {name!r}: choose one of {', '.join((*METHODS, IMPLICIT))}")
    solver = getattr(integrate, METHODS[name])
    stages = solver.n_stages
    a = np.zeros((stages, stages))
    a[:, : solver.A.shape[1]] = solver.A[:stages, :stages]
    if name == "dormand-prince-8":
        errors, order = np.array([solver.E5, solver.E3]), 8
    else:
        errors, order = np.array([solver.E, np.zeros(stages + 1)]), solver.error_estimator_order + 1
    return Method(a, np.array(solver.B, float), np.ascontiguousarray(errors, float), order, 0)
