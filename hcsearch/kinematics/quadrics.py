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
STEPS, NIL = 200, 1e-15
"""Steps of a search, and what of an equation or a step is nothing."""
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
    for vector, residual in zip(*_newton(forms, cone, rng.standard_normal((starts, m))), strict=True):
        if residual >= solved:
            continue
        dimension = _dimension(forms, vector, solved)
        apart = 0.25 if dimension else max(SAME, 10 * solved**0.5)
        if not any(_distance(vector, old.vector, both) < apart for old in found if old.dimension == dimension):
            found.append(Solution(vector, dimension, residual))
    return found


def _distance(one: Reals, two: Reals, both: bool) -> float:
    apart = float(np.linalg.norm(one - two))
    return min(apart, float(np.linalg.norm(one + two))) if both else apart


def _newton(forms: Reals, cone: Reals | None, starts: Reals) -> tuple[Reals, list[float]]:
    """Where the ways from all starts (n, m) end, each on the sphere, and what is left of the equations there.

    Levenberg and Marquardt, all starts together: one call of LAPACK for a step of each.
    """
    z = starts / np.linalg.norm(starts, axis=1, keepdims=True)
    value, slope = _system(forms, cone, z)
    damping = np.full(len(z), 1e-3)
    going = np.abs(value).max(axis=1, initial=0.0) >= NIL
    for _ in range(STEPS):
        at = np.flatnonzero(going)
        if not len(at):
            break
        trial = z[at] + _damped_step(value[at], slope[at], damping[at])
        trial /= np.linalg.norm(trial, axis=1, keepdims=True)
        new_value, new_slope = _system(forms, cone, trial)
        better = (new_value**2).sum(axis=1) < (value[at] ** 2).sum(axis=1)
        moved = np.linalg.norm(trial - z[at], axis=1)
        taken = at[better]
        z[taken], value[taken], slope[taken] = trial[better], new_value[better], new_slope[better]
        damping[at] = np.where(better, np.maximum(0.1 * damping[at], 1e-30), np.maximum(10 * damping[at], 1e-20))
        left = np.abs(value[at]).max(axis=1, initial=0.0)
        going[at] = (left >= NIL) & np.where(better, moved >= NIL, damping[at] <= 1e6)
    return z, np.abs(value).max(axis=1, initial=0.0).tolist()


def _damped_step(value: Reals, slope: Reals, damping: Reals) -> Reals:
    """Steps (n, m) of least value + slope step, squared, and damping times step, squared."""
    u, s, vt = np.linalg.svd(slope, full_matrices=False)
    nothing = s <= max(slope.shape[1:]) * np.finfo(float).eps * s[:, :1]
    gain = np.where(nothing, 0.0, s / (s * s + damping[:, None]))
    step: Reals = -np.einsum("nji,nj->ni", vt, gain * np.einsum("nkj,nk->nj", u, value))
    return step


def _system(forms: Reals, cone: Reals | None, z: Reals) -> tuple[Reals, Reals]:
    """What must vanish at vectors z (n, m), and its derivative: the forms, and what sticks out of the cone."""
    turned = np.einsum("kij,nj->nki", forms, z)
    value, slope = np.einsum("nki,ni->nk", turned, z), 2.0 * turned
    if cone is not None and len(cone):
        out = z @ cone.T
        value = np.hstack([value, np.minimum(out, 0.0)])
        slope = np.concatenate([slope, np.where(out < 0.0, 1.0, 0.0)[:, :, None] * cone], axis=1)
    return value, slope


def _dimension(forms: Reals, z: Reals, solved: float) -> int:
    """Dimension of the solutions around one, on the sphere: of the kernel directions those that lead to others."""
    slope = np.vstack([2.0 * forms @ z, z])
    _, s, vt = np.linalg.svd(slope)
    kernel = vt[int(np.count_nonzero(s > 1e-5)) :]
    if not len(kernel):
        return 0
    ends, residuals = _newton(forms, None, z + TRIED * kernel)
    away = ends - z
    along = np.abs(np.einsum("ij,ij->i", away, kernel)) > 0.5 * TRIED
    near = np.linalg.norm(away, axis=1) < 2 * TRIED
    return int(np.count_nonzero((np.array(residuals) < solved) & along & near))
