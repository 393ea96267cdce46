"""Local analysis of a linkage at a state: tangent space, curvature, and distance from singularity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.motion.kinematics.numerical_rank import Rank, decide_rank
from hcsearch.shape.linkage import Linkage

MIN_PIVOT_SHARE = 0.618
"""Hinges whose squared residual projection exceeds this share of the greatest are candidates for the next basis vector;
the first one is taken, as by symmetry many are equal but for rounding."""


@dataclass(frozen=True, eq=False)
class LocalState(ByValue):
    """Fold angles (rad) and the closure Jacobian at them, split into row space and null space by its singular values.

    jacobian : shape (n_rows, n_hinges).
    rank : decided or not; `kept_rank` is the number of singular values that count as non-zero.
    left, values, right : the singular vectors and values that are kept, shapes
        (n_rows, kept_rank), (kept_rank,), (kept_rank, n_hinges).
    """

    linkage: Linkage
    angles: Reals
    residual: float
    jacobian: Reals
    rank: Rank
    left: Reals
    values: Reals
    right: Reals

    @property
    def kept_rank(self) -> int:
        """Number of singular values that count as non-zero."""
        return len(self.values)

    @property
    def least_singular_value(self) -> float:
        """Least singular value that counts as non-zero; infinite in an open chain."""
        return float(self.values[-1]) if self.kept_rank else np.inf

    @property
    def nullity(self) -> int:
        """First-order degrees of freedom; -1 where the rank is not decided."""
        return -1 if self.rank.nullity is None else self.rank.nullity

    def tangent(self, vector: Reals) -> Reals:
        """Project a velocity onto the null space, where the loops stay closed to first order."""
        tangential: Reals = vector - self.right.T @ (self.right @ vector)
        return tangential

    def geodesic_acceleration(self, velocity: Reals) -> Reals:
        """The shortest acceleration that keeps the loops closed to second order, for a tangent velocity.

        A motion with this acceleration is a geodesic of the closed states. With one degree of freedom it is the motion
        itself, parametrised by arc length.
        """
        if not self.kept_rank:
            return np.zeros_like(velocity)
        bend = self.linkage.bend(self.jacobian, velocity)
        acceleration: Reals = -self.right.T @ ((self.left.T @ bend) / self.values)
        return acceleration

    def null_space(self) -> Reals:
        """An orthonormal basis of the null space of the Jacobian, shape (n_hinges, m).

        The singular vectors of zero are an arbitrary basis, which differs between processors. This one is built from
        projections of unit velocities of single hinges, pivoted as in Gram-Schmidt, so it depends on the space alone.
        """
        n = len(self.angles)
        remainder = np.eye(n) - self.right.T @ self.right
        basis = np.empty((n, n - self.kept_rank))
        for k in range(basis.shape[1]):
            sizes = remainder.diagonal()
            column = remainder[:, int(np.argmax(sizes > MIN_PIVOT_SHARE * sizes.max()))]
            column = self.tangent(column - basis[:, :k] @ (basis[:, :k].T @ column))
            basis[:, k] = column / np.linalg.norm(column)
            remainder = remainder - np.outer(basis[:, k], basis[:, k])
        return basis


def local_at(
    linkage: Linkage, angles: Reals, *, kept_rank: int | None = None, closure: tuple[Reals, Reals] | None = None
) -> LocalState:
    """Analyse a linkage at given fold angles.

    kept_rank : number of singular values that count as non-zero, if the caller knows it, as between two closed states;
    else all values above the noise count.
    closure : residual and Jacobian at these angles, if already evaluated.
    """
    residual, jacobian = linkage.closure(angles) if closure is None else closure
    if not len(residual):
        empty = np.zeros((0, linkage.n_hinges))
        rank = decide_rank(np.zeros(0), linkage.n_hinges)
        return LocalState(linkage, angles, 0.0, jacobian, rank, np.zeros((0, 0)), np.zeros(0), empty)
    u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    worst = float(np.abs(residual).max())
    rank = decide_rank(s, linkage.n_hinges, worst)
    if kept_rank is None:
        kept_rank = int(np.count_nonzero(s > rank.noise))
    return LocalState(linkage, angles, worst, jacobian, rank, u[:, :kept_rank], s[:kept_rank], vt[:kept_rank])


def same_orientation(before: LocalState, after: LocalState) -> bool:
    """Whether an even number of the kept singular values change sign between two near states.

    Singular values that are continued as smooth functions change sign where they vanish, and the singular vectors show
    it: det(U1' U2) det(V1' V2) < 0 if an odd number did (the thesis appendix asks only for the rank).
    """
    if before.kept_rank != after.kept_rank or not before.kept_rank:
        return True
    ranges = np.linalg.slogdet(before.left.T @ after.left)[0]
    rows = np.linalg.slogdet(before.right @ after.right.T)[0]
    return bool(ranges * rows >= 0)


def bilinear_products(vectors: Reals, bend: Callable[[Reals], Reals]) -> Reals:
    """Values of the symmetric bilinear form of the quadratic form `bend`, for all pairs of vectors, (n, n, n_rows).

    vectors : (n, n_hinges), velocities. bend : second-order closure error of moving with one velocity, (n_rows,).
    """
    squares = np.array([bend(vector) for vector in vectors])
    values = np.empty((len(vectors), len(vectors), squares.shape[1]))
    for i, j in combinations_with_replacement(range(len(vectors)), 2):
        values[i, j] = values[j, i] = (
            squares[i] if i == j else 0.5 * (bend(vectors[i] + vectors[j]) - squares[i] - squares[j])
        )
    return values
