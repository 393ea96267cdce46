"""The second-order equations of closure, and the directions that solve them: common points of quadrics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.kinematics.local import Local

Reals = NDArray[np.float64]

NOTHING = 1e-10
"""Forms of screws of unit size that are smaller than this are rounding."""
SOLVED = 1e-11
"""What may be left of an equation."""
ROUGHLY = 1e-5
"""The same at a state that is singular only as far as it has been located."""
SAME = 1e-3
"""Solutions nearer than this are one: a double one is known to the root of what it is solved to."""
TRIED = 0.05
"""A family is told from a double point by steps of this length in it."""


@dataclass(frozen=True)
class Solution:
    """A unit vector on which all forms vanish, and the dimension of the family of such vectors around it."""

    vector: Reals
    dimension: int
    residual: float


def second_order(local: Local, basis: Reals) -> Reals:
    """Quadratic forms of the second-order equations, shape (n_stresses, m, m): z' Q z = 0 for velocities basis z."""
    rows, m = local.jacobian.shape[0], basis.shape[1]
    stresses = np.linalg.svd(local.left)[0][:, local.kept :] if local.kept else np.eye(rows)

    def bend(velocity: Reals) -> Reals:
        return local.linkage.bend(local.jacobian, np.ascontiguousarray(velocity))

    single = [bend(basis[:, i]) for i in range(m)]
    forms = np.zeros((rows, m, m))
    for i in range(m):
        forms[:, i, i] = single[i]
        for j in range(i):
            both = 0.5 * (bend(basis[:, i] + basis[:, j]) - single[i] - single[j])
            forms[:, i, j] = forms[:, j, i] = both
    found: Reals = np.einsum("rk,rij->kij", stresses, forms)
    return found


def solve_quadrics(
    forms: Reals,
    cone: Reals | None = None,
    *,
    starts: int = 100,
    seed: int = 1,
    both: bool = True,
    solved: float = SOLVED,
) -> list[Solution]:
    """Unit vectors z with z' Q z = 0 for all forms Q (k, m, m) and, with a cone A, A z >= 0; by many starts.

    Isolated ones once each (up to sign when `both`); of families those found, no two nearer than a quarter.
    solved : what may be left of an equation, more where forms are known less well.
    """
    m = forms.shape[1]
    if not m:
        return []
    sizes = np.abs(forms).max(axis=(1, 2), initial=0.0)
    forms = forms[sizes > NOTHING] / sizes.max(initial=NOTHING)
    rng = np.random.default_rng(seed)
    found: list[Solution] = []
    for z in rng.standard_normal((starts, m)):
        solution = _newton(forms, cone, z / np.linalg.norm(z), solved)
        if solution is None:
            continue
        vector, residual = solution
        dimension = _dimension(forms, vector, solved)
        apart = 0.25 if dimension else max(SAME, 10 * solved**0.5)
        if not any(_distance(vector, old.vector, both) < apart for old in found if old.dimension == dimension):
            found.append(Solution(vector, dimension, residual))
    return found


def _distance(one: Reals, two: Reals, both: bool) -> float:
    apart = float(np.linalg.norm(one - two))
    return min(apart, float(np.linalg.norm(one + two))) if both else apart


def _newton(forms: Reals, cone: Reals | None, z: Reals, solved: float) -> tuple[Reals, float] | None:
    """From a start to a solution nearby (Levenberg and Marquardt); None where the way ends elsewhere."""
    damping = 1e-3
    value, slope = _system(forms, cone, z)
    for _ in range(200):
        size = float(np.abs(value).max(initial=0.0))
        if size < 1e-15:
            break
        step = np.linalg.lstsq(
            np.vstack([slope, np.sqrt(damping) * np.eye(len(z))]), -np.r_[value, np.zeros(len(z))], rcond=None
        )[0]
        trial = z + step
        trial /= np.linalg.norm(trial)
        new_value, new_slope = _system(forms, cone, trial)
        if new_value @ new_value < value @ value:
            moved = float(np.linalg.norm(trial - z))
            z, value, slope = trial, new_value, new_slope
            damping = max(0.1 * damping, 1e-30)
            if moved < 1e-15:
                break
        else:
            damping = max(10 * damping, 1e-20)
            if damping > 1e6:
                break
    residual = float(np.abs(value).max(initial=0.0))
    return (z, residual) if residual < solved else None


def _system(forms: Reals, cone: Reals | None, z: Reals) -> tuple[Reals, Reals]:
    """What must vanish, and its derivative: the forms, and what sticks out of the cone."""
    turned = forms @ z
    value, slope = turned @ z, 2.0 * turned
    if cone is not None and len(cone):
        out = cone @ z
        value = np.r_[value, np.minimum(out, 0.0)]
        slope = np.vstack([slope, np.where(out < 0.0, 1.0, 0.0)[:, None] * cone])
    return value, slope


def _dimension(forms: Reals, z: Reals, solved: float) -> int:
    """Dimension of the solutions around one, on the sphere: of the kernel directions those that lead to others."""
    slope = np.vstack([2.0 * forms @ z, z])
    _, s, vt = np.linalg.svd(slope)
    kernel = vt[int(np.count_nonzero(s > 1e-5)) :]
    count = 0
    for direction in kernel:
        other = _newton(forms, None, (z + TRIED * direction) / np.hypot(1.0, TRIED), solved)
        if other is not None:
            away = other[0] - z
            count += bool(abs(away @ direction) > 0.5 * TRIED and np.linalg.norm(away) < 2 * TRIED)
    return count
