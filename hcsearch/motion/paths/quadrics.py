"""Second-order closure equations: a cover of their common zeros on the unit sphere, and the zeros themselves.

Cells that the cover leaves out are proved to hold no zero, so that Newton's method from every remaining cell misses
none for want of a start, and does not depend on the coordinates (Hansen and Walster 2004, Global Optimization Using
Interval Analysis, chapter 11).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.motion.kinematics.local import LocalState, bilinear_products

MIN_CELL_RADIUS = 0.05
"""Radius down to which cells are halved."""
MAX_HALVED_CELLS, MAX_COVER_CELLS = 4000, 1000
"""Halving ends above `MAX_HALVED_CELLS`; the cover is the last set of at most `MAX_COVER_CELLS` cells."""


@dataclass(frozen=True, eq=False)
class Cover(ByValue):
    """Unit vectors (n, m), one within `radius` of every common zero (up to sign where z and -z are one)."""

    centres: Reals
    radius: float


@dataclass(frozen=True, eq=False)
class _Cells(ByValue):
    """Boxes on the faces of a cube about the origin: axis and sense of the face, middle and half widths on it."""

    axis: WholeNumbers
    sense: Reals
    middle: Reals
    half: Reals

    def select(self, flags: Flags) -> _Cells:
        return _Cells(self.axis[flags], self.sense[flags], self.middle[flags], self.half[flags])

    def halves(self) -> _Cells:
        """All cells, bisected across their longest side."""
        rows, side = np.arange(len(self.axis)), self.half.argmax(axis=1)
        half = self.half.copy()
        half[rows, side] *= 0.5
        shift = np.zeros_like(half)
        shift[rows, side] = half[rows, side]
        middle = np.concatenate([self.middle - shift, self.middle + shift])
        return _Cells(np.tile(self.axis, 2), np.tile(self.sense, 2), middle, np.tile(half, (2, 1)))

    def balls(self) -> tuple[Reals, Reals]:
        """Centres on the unit sphere and radii of balls that enclose the projections of the cells."""
        n, m = len(self.axis), self.middle.shape[1] + 1
        rows = np.arange(n)
        corner = np.empty((n, m))
        corner[np.arange(m) != self.axis[:, None]] = self.middle.ravel()
        corner[rows, self.axis] = self.sense
        # radial projection onto a sphere of points outside it does not increase their distance
        nearest = np.sqrt(1.0 + (np.maximum(np.abs(self.middle) - self.half, 0.0) ** 2).sum(axis=1))
        centres = corner / np.linalg.norm(corner, axis=1, keepdims=True)
        # reflect to arbitrary axes: centres on a plane of symmetry of the quadrics would be bad starts
        normal = 1.0 + (np.arange(m) * 0.6180339887498949) % 1.0
        reflected = centres - np.outer(centres @ normal, 2.0 * normal / (normal @ normal))
        return reflected, np.minimum(np.linalg.norm(self.half, axis=1) / nearest, 2.0)


def cover_directions(forms: Reals, cone: Reals | None, *, both: bool, slack: float) -> Cover:
    """Cover the unit vectors z with z' Q z = 0 for all forms Q (k, m, m) and, with a cone A, A z >= 0.

    both : whether z and -z are one. slack : tolerance of the equations.
    """
    m = forms.shape[1]
    senses = (1.0,) if both else (1.0, -1.0)
    axis, sense = np.tile(np.arange(m), len(senses)), np.repeat(senses, m)
    cells = _Cells(axis, sense, np.zeros((len(axis), m - 1)), np.ones((len(axis), m - 1)))
    cover = Cover(np.zeros((0, m)), 2.0)
    while True:
        centres, radii = cells.balls()
        possible = _may_hold_zero(forms, cone, centres, radii, slack)
        cells, centres, radius = cells.select(possible), centres[possible], float(radii[possible].max(initial=0.0))
        if len(centres) <= MAX_COVER_CELLS:
            cover = Cover(centres, radius)
        if radius <= MIN_CELL_RADIUS or len(centres) > MAX_HALVED_CELLS:
            return cover
        cells = cells.halves()


def _may_hold_zero(forms: Reals, cone: Reals | None, centres: Reals, radii: Reals, slack: float) -> Flags:
    """Flag the balls that may hold a common zero.

    Within r of a unit vector c a form is its value at c plus a linear term, up to (|F| + L) r^2, with L the norm of all
    forms together. That holds for each orthonormal combination of the forms, so also for the combinations with the
    least linear terms: a value that these terms cannot cancel proves that the ball holds no common zero.
    """
    possible = np.ones(len(centres), bool)
    if cone is not None:
        possible &= (centres @ cone.T >= -np.linalg.norm(cone, axis=1) * radii[:, None] - slack).all(axis=1)
    candidates = np.flatnonzero(possible)
    if not len(forms) or not len(candidates):
        return possible
    products = np.einsum("kij,lij->kl", forms, forms)
    c, r = centres[candidates], radii[candidates, None]
    turned = np.einsum("kij,nj->nki", forms, c)
    values = np.einsum("nki,ni->nk", turned, c)
    slopes = 2.0 * (turned - values[:, :, None] * c[:, None, :])
    sums = np.linalg.eigh(np.einsum("nki,nli->nkl", slopes, slopes))[1]
    summed = np.abs(np.einsum("nkl,nk->nl", sums, values))
    linear = np.linalg.norm(np.einsum("nkl,nki->nli", sums, slopes), axis=2)
    curved = summed + np.sqrt(np.einsum("nkl,kj,njl->nl", sums, products, sums, optimize=True))
    possible[candidates] = (summed <= linear * r + curved * r * r + slack).all(axis=1)
    return possible


ZERO_FORM_SIZE = 1e-10
"""Forms of screws of unit size that are smaller than this are due to rounding."""
SOLVED_RESIDUAL = 1e-11
"""Tolerance of the residual of a solved equation."""
LOCATED_STATE_RESIDUAL = 1e-5
"""The same tolerance at a singular state that was located approximately."""
SAME_SOLUTION_DISTANCE = 1e-3
"""Solutions nearer than this are one: the error of a double one is the square root of its residual."""
MAX_QUADRIC_STEPS, ZERO_QUADRIC_SIZE = 200, 1e-15
"""Maximum number of steps of Newton's method, and the size below which an equation or a step counts as zero."""
FAMILY_NEIGHBOUR_DISTANCE, CROSSING_NEIGHBOUR_DISTANCE = 0.05, 0.015
"""Distances (rad) of neighbouring solutions: neighbours at the first distinguish a family from a double point; where
families cross, their neighbours at the second give the dimension."""
SPREAD_VALUE_SHARE = 0.2
"""Directions count as spread in a dimension where their singular value there has this share of the greatest."""
FLAT_DIRECTION_SLOPE = 1e-5
"""Directions in which the slope of the equations is below this are candidates for families."""
FAMILY_MEMBER_DISTANCE = 0.25
"""Members of one family are listed no nearer to each other than this."""


@dataclass(frozen=True, eq=False)
class QuadricSolution(ByValue):
    """A unit vector at which all forms vanish, and the dimension of the family of such vectors around it."""

    vector: Reals
    dimension: int
    residual: float


def second_order_forms(local: LocalState, basis: Reals) -> Reals:
    """Quadratic forms of the second-order equations, shape (n_stresses, m, m): z' Q z = 0 for velocities basis z."""
    rows, m = local.jacobian.shape[0], basis.shape[1]
    stresses = np.linalg.svd(local.left)[0][:, local.kept_rank :] if local.kept_rank else np.eye(rows)

    def bend(velocity: Reals) -> Reals:
        return local.linkage.bend(local.jacobian, np.ascontiguousarray(velocity))

    if not m:
        return np.zeros((stresses.shape[1], 0, 0))
    forms: Reals = np.einsum("rk,ijr->kij", stresses, bilinear_products(basis.T, bend))
    return forms


def solve_quadrics(
    forms: Reals, cone: Reals | None = None, *, both: bool = True, solved: float = SOLVED_RESIDUAL
) -> tuple[list[QuadricSolution], float]:
    """Solve z' Q z = 0 on the unit sphere for all forms Q (k, m, m), with A z >= 0 for a cone A; also return a radius.

    Isolated solutions are listed once each (up to sign when `both`), families by some members, no two nearer than a
    quarter. Newton's method starts in every cell of a cover, so every solution is within the radius of a start.
    solved : tolerance of the equations; greater where forms are less accurate.
    """
    if not forms.shape[1]:
        return [], 0.0
    forms = _independent(forms)
    cone = None if cone is None or not len(cone) else cone
    cover = cover_directions(forms, cone, both=both, slack=solved)
    ends, residuals = _newton(forms, cone, cover.centres)
    ends, residuals = ends[residuals < solved], residuals[residuals < solved]
    kernels = _kernels(forms, ends)
    sizes = np.array([len(kernel) for kernel in kernels], int)
    solutions: list[QuadricSolution] = []
    listed = np.zeros(len(ends), bool)
    for i, end in enumerate(ends):
        if listed[i]:
            continue
        dimension = _dimension(forms, end, kernels[i], solved)
        solutions.append(QuadricSolution(end, dimension, float(residuals[i])))
        cosines = ends @ end
        distances = np.sqrt(np.maximum(2.0 - 2.0 * (np.abs(cosines) if both else cosines), 0.0))
        listed |= distances < max(SAME_SOLUTION_DISTANCE, 10 * solved**0.5)
        if dimension:
            listed |= (distances < FAMILY_MEMBER_DISTANCE) & (sizes == sizes[i])
    return solutions, cover.radius


def solution_near(forms: Reals, cone: Reals | None, vector: Reals) -> tuple[Reals, float]:
    """Return the vector that Newton's method reaches from a vector (m,), and its residual."""
    ends, residuals = _newton(_independent(forms), cone if cone is not None and len(cone) else None, vector[None])
    return ends[0], float(residuals[0])


def _independent(forms: Reals) -> Reals:
    """Equivalent forms that are orthogonal to each other, the largest of norm 1, without those due to rounding.

    Sums of squares of the forms do not depend on the basis of self-stresses.
    """
    _, s, vt = np.linalg.svd(forms.reshape(len(forms), forms.shape[1] ** 2), full_matrices=False)
    significant = s > ZERO_FORM_SIZE
    orthogonal: Reals = (s[significant, None] * vt[significant] / s.max(initial=ZERO_FORM_SIZE)).reshape(
        -1, *forms.shape[1:]
    )
    return orthogonal


def _newton(forms: Reals, cone: Reals | None, starts: Reals, linear: Reals | None = None) -> tuple[Reals, Reals]:
    """Minimise the residuals on the sphere from all starts (n, m); return the end points and their residual norms.

    Levenberg and Marquardt's method, with one call of LAPACK for a step of all starts.
    linear : terms (k, m) that are added to the forms.
    """
    z = starts / np.linalg.norm(starts, axis=1, keepdims=True)
    value, slope = _system(forms, cone, z, linear)
    damping = np.full(len(z), 1e-3)
    unconverged = np.abs(value).max(axis=1, initial=0.0) >= ZERO_QUADRIC_SIZE
    for _ in range(MAX_QUADRIC_STEPS):
        active = np.flatnonzero(unconverged)
        if not len(active):
            break
        trial = z[active] + _damped_step(value[active], slope[active], damping[active])
        trial /= np.linalg.norm(trial, axis=1, keepdims=True)
        new_value, new_slope = _system(forms, cone, trial, linear)
        better = (new_value**2).sum(axis=1) < (value[active] ** 2).sum(axis=1)
        moved = np.linalg.norm(trial - z[active], axis=1)
        accepted = active[better]
        z[accepted], value[accepted], slope[accepted] = trial[better], new_value[better], new_slope[better]
        damping[active] = np.where(
            better, np.maximum(0.1 * damping[active], 1e-30), np.maximum(10 * damping[active], 1e-20)
        )
        errors = np.abs(value[active]).max(axis=1, initial=0.0)
        unconverged[active] = (errors >= ZERO_QUADRIC_SIZE) & np.where(
            better, moved >= ZERO_QUADRIC_SIZE, damping[active] <= 1e6
        )
    return z, np.linalg.norm(value, axis=1)


def _damped_step(value: Reals, slope: Reals, damping: Reals) -> Reals:
    """Damped steps (n, m), which minimise |value + slope step|^2 + damping |step|^2.

    `kinematics.closing.correction` is such a step for one state. Both are kept: it truncates singular values at another
    level, and its matrix products round differently from the sums over all states here, so that results would change.
    """
    u, s, vt = np.linalg.svd(slope, full_matrices=False)
    negligible = s <= max(slope.shape[1:]) * np.finfo(float).eps * s[:, :1]
    gain = np.where(negligible, 0.0, s / (s * s + damping[:, None]))
    step: Reals = -np.einsum("nji,nj->ni", vt, gain * np.einsum("nkj,nk->nj", u, value))
    return step


def _system(forms: Reals, cone: Reals | None, z: Reals, linear: Reals | None) -> tuple[Reals, Reals]:
    """Residuals at vectors z (n, m) and their derivatives: of the equations, and of violated conditions of the cone."""
    turned = np.einsum("kij,nj->nki", forms, z)
    value, slope = np.einsum("nki,ni->nk", turned, z), 2.0 * turned
    if linear is not None:
        value, slope = value + z @ linear.T, slope + linear
    if cone is not None:
        out = z @ cone.T
        value = np.hstack([value, np.minimum(out, 0.0)])
        slope = np.concatenate([slope, np.where(out < 0.0, 1.0, 0.0)[:, :, None] * cone], axis=1)
    return value, slope


def _kernels(forms: Reals, vectors: Reals) -> list[Reals]:
    """For each vector (n, m) the null space of the equations' slopes within the sphere, as rows."""
    slopes = np.concatenate([2.0 * np.einsum("kij,nj->nki", forms, vectors), vectors[:, None, :]], axis=1)
    _, s, vt = np.linalg.svd(slopes)
    return [rows[int(np.count_nonzero(values > FLAT_DIRECTION_SLOPE)) :] for rows, values in zip(vt, s, strict=True)]


def _dimension(forms: Reals, z: Reals, kernel: Reals, solved: float) -> int:
    """Dimension of the set of solutions around one, on the sphere.

    It is at most the dimension of the space that the directions to neighbours span. Where families cross, this space
    has more dimensions than any of them, so the dimension is computed at the neighbours, each on one family.
    """
    neighbours, max_dimension = _neighbours(forms, z, kernel, solved, FAMILY_NEIGHBOUR_DISTANCE)
    if max_dimension and all(len(other) == max_dimension for other in _kernels(forms, neighbours)):
        return max_dimension
    dimension = 0
    for neighbour, directions in zip(neighbours, _kernels(forms, neighbours), strict=True):
        _, spanned = _neighbours(forms, neighbour, directions, solved, CROSSING_NEIGHBOUR_DISTANCE)
        dimension = max(dimension, min(spanned, max_dimension))
        if dimension == max_dimension:
            break
    return dimension


def _neighbours(forms: Reals, z: Reals, kernel: Reals, solved: float, distance: float) -> tuple[Reals, int]:
    """Solutions at a fixed distance (rad) from another, and the dimension of the space that their directions span.

    The fixed distance keeps the search away from the point where families cross.
    """
    if not len(kernel):
        return np.zeros((0, len(z))), 0
    across = np.linalg.svd(z[None])[2][1:]  # with unit vectors x a neighbour is cos z + sin x across
    cosine, sine = math.cos(distance), math.sin(distance)
    restricted, linear = sine * across @ forms @ across.T, 2.0 * cosine * forms @ z @ across.T
    between = 0.5 * np.roll(kernel, 1, axis=0)
    starts = np.concatenate([kernel, kernel + between, kernel - between]) @ across.T
    directions, residuals = _newton(restricted, None, np.concatenate([starts, -starts]), linear)
    directions = directions[sine * residuals < solved] @ across
    spread = np.linalg.svd(directions @ kernel.T, compute_uv=False)
    return cosine * z + sine * directions, int(np.count_nonzero(spread > SPREAD_VALUE_SHARE * spread.max(initial=0.0)))
