"""The choice of driven hinges: as many as there are freedoms, so that they control the linkage well all along a path.

At each state the rates that keep the loops closed form the null space of the closure Jacobian, whose dimension is the
number of freedoms. With B an orthonormal basis of it, by columns, the rows of B at the driven hinges are the reduced
Jacobian: its least singular value is the least rate of the driven hinges, in norm, where all hinges together turn at
1 rad/s. At 0 the others could move while the driven ones stand still: a dead point. Where every set of as many hinges
as freedoms comes near one on the path, more hinges are driven.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.linkage import Linkage

CHOICE_STATE_COUNT, MAX_CHOICE_REPEATS = 60, 8
"""Number of states along a path at which the search evaluates sets, and greatest number of searches; each adds the
states at which the chosen set is worst."""
MAX_ENUMERATED_HINGE_SETS = 3000
"""Greatest number of sets that are enumerated; more are searched by exchanges of hinges from a pivoted QR."""
MAX_EXCHANGE_SWEEPS = 12
MONOTONE_VALUE_SHARE = 0.5
"""Share of the best least singular value that must remain when monotone hinges replace others."""
MONOTONE_ANGLE_TOLERANCE = 0.01
"""Greatest turn back (rad) of a monotone hinge."""
FIRM_SINGULAR_VALUE = 0.1
"""Least singular value up to which hinges are added, the most helpful ones first."""
CLOSURE_RANK_TOLERANCE = 1e-7
"""Relative tolerance of the rank of closure, as a share of the greatest singular value."""


@dataclass(frozen=True)
class DrivenHinges:
    """Driven hinges and their evaluation along a path.

    hinges : their numbers. monotone : the monotone ones of these. freedoms : of the linkage along the path.
    least_value : least singular value of the reduced Jacobian along the path; least_place : where, as a share of its
    length. closure_value : least singular value of the closure Jacobian along the path, and closure_place : where; ends
    and singular states near the path make it small for any driven hinges. tried : number of sets evaluated.
    """

    hinges: tuple[int, ...]
    monotone: tuple[int, ...]
    freedoms: int
    least_value: float
    least_place: float
    closure_value: float
    closure_place: float
    tried: int


def frames_at(linkage: Linkage, angles: Reals, rank: int | None = None) -> tuple[Reals, Reals]:
    """Return orthonormal frames (k, n_hinges, n_hinges) at states, and singular values of closure, (k, rank).

    The first `rank` columns span the row space of the closure Jacobian, the others its null space, the closed rates.
    rank : of closure; unless given its greatest value along the path.
    """
    n = linkage.n_hinges
    jacobians = np.array([linkage.closure(state)[1] for state in angles]).reshape(len(angles), -1, n)
    if not jacobians.shape[1]:
        return np.broadcast_to(np.eye(n), (len(angles), n, n)), np.ones((len(angles), 0))
    _, values, right = np.linalg.svd(jacobians)
    if rank is None:
        rank = int((values > CLOSURE_RANK_TOLERANCE * values.max()).sum(axis=1).max())
    return right.transpose(0, 2, 1), values[:, :rank]


def monotone_hinges(angles: Reals) -> NDArray[np.bool_]:
    """Return whether each hinge turns monotonically along a path, (n_hinges,), to `MONOTONE_ANGLE_TOLERANCE`."""
    fallen = np.maximum.accumulate(angles, axis=0) - angles
    risen = angles - np.minimum.accumulate(angles, axis=0)
    monotone: NDArray[np.bool_] = np.minimum(fallen.max(axis=0), risen.max(axis=0)) <= MONOTONE_ANGLE_TOLERANCE
    return monotone


def choose_driven_hinges(linkage: Linkage, angles: Reals, min_value: float = FIRM_SINGULAR_VALUE) -> DrivenHinges:
    """Choose the hinges to drive along a path, from evenly spaced closed states, (k, n_hinges).

    First the set with the greatest least singular value is chosen; then monotone hinges replace others, as long as half
    of that value remains; then hinges are added while it is below `min_value`.
    """
    frames, values = frames_at(linkage, angles)
    freedoms = linkage.n_hinges - values.shape[1]
    monotone = monotone_hinges(angles)
    state_numbers, tried = np.unique(np.linspace(0, len(angles) - 1, CHOICE_STATE_COUNT).astype(int)), 0
    for _ in range(MAX_CHOICE_REPEATS):
        search = _Search(frames[state_numbers], freedoms, monotone)
        driven = search.with_more_hinges(search.run(), min_value)
        tried += search.tried
        least_values = (
            least_singular_values(frames, freedoms, np.array([driven], int))[0] if driven else np.ones(len(angles))
        )
        if least_values.min() >= min(min_value, 0.5 * least_values[state_numbers].min()):
            break
        # add the omitted states at which the set is worst
        state_numbers = np.union1d(state_numbers, np.argsort(least_values)[:5])
    return judge_driven_hinges(linkage, angles, driven, tried)


def judge_driven_hinges(linkage: Linkage, angles: Reals, driven: tuple[int, ...], tried: int = 1) -> DrivenHinges:
    """Evaluate given driven hinges along a path."""
    frames, values = frames_at(linkage, angles)
    freedoms, monotone = linkage.n_hinges - values.shape[1], monotone_hinges(angles)
    if len(driven) < freedoms:
        raise HcsearchError(f"{len(driven)} hinges cannot drive {freedoms} freedoms: name {freedoms} at least")
    if not all(0 <= hinge < linkage.n_hinges for hinge in driven):
        raise HcsearchError(f"there is no hinge {max(driven)}: name hinges from 0 to {linkage.n_hinges - 1}")
    least_values = (
        least_singular_values(frames, freedoms, np.array([driven], int))[0] if driven else np.ones(len(angles))
    )
    closure_values = values[:, -1] if values.shape[1] else np.ones(len(angles))
    last = max(len(angles) - 1, 1)
    return DrivenHinges(
        driven,
        tuple(hinge for hinge in driven if monotone[hinge]),
        freedoms,
        float(least_values.min()),
        float(least_values.argmin() / last),
        float(closure_values.min()),
        float(closure_values.argmin() / last),
        tried,
    )


def least_singular_values(frames: Reals, freedoms: int, sets: NDArray[np.int64]) -> Reals:
    """Return the least singular values of the reduced Jacobian for sets of driven hinges (s, d), shape (s, k).

    frames : (k, n, n), orthonormal; the last columns are a basis of the closed rates, the others of the row space of
    closure. Where few hinges are not driven, the rows of the latter at these have the same least singular value.
    """
    n = frames.shape[1]
    n_passive = n - sets.shape[1]
    if not n_passive:
        return np.ones((len(sets), len(frames)))
    if n_passive < freedoms:
        passive = np.array([np.setdiff1d(np.arange(n), hinges) for hinges in sets])
        rows = frames[:, passive, : n - freedoms]
    else:
        rows = frames[:, sets, n - freedoms :]
    values = np.linalg.svd(rows, compute_uv=False)[..., -1]
    return np.ascontiguousarray(values.T)


class _Search:
    """The search for a set of driven hinges at some states."""

    def __init__(self, frames: Reals, freedoms: int, monotone: NDArray[np.bool_]) -> None:
        self.frames, self.freedoms, self.monotone = frames, freedoms, monotone
        self.n = frames.shape[1]
        self.tried = 0

    def run(self) -> tuple[int, ...]:
        """Return the hinges to drive, in order."""
        if self.freedoms == self.n:
            return tuple(range(self.n))
        if not self.freedoms:
            return ()
        if math.comb(self.n, self.freedoms) <= MAX_ENUMERATED_HINGE_SETS:
            return self._enumerate()
        return self._exchange()

    def with_more_hinges(self, driven: tuple[int, ...], min_value: float) -> tuple[int, ...]:
        """Add hinges to a set until its least singular value reaches `min_value`, or all hinges are driven."""
        value = float(self._least_values([driven])[0]) if driven else min_value
        while value < min_value and len(driven) < self.n:
            sets = [tuple(sorted((*driven, hinge))) for hinge in range(self.n) if hinge not in driven]
            values = self._least_values(sets)
            sufficient = np.flatnonzero(values >= min(min_value, values.max()))
            driven = sets[min(sufficient, key=lambda k: (self._non_monotone(sets[k]), -values[k]))]
            value = float(self._least_values([driven])[0])
        return driven

    def _least_values(self, sets: list[tuple[int, ...]]) -> Reals:
        """Return the least singular value of each set along the path."""
        self.tried += len(sets)
        values = [
            least_singular_values(self.frames, self.freedoms, np.array(sets[k : k + 200], int)).min(axis=1)
            for k in range(0, len(sets), 200)
        ]
        return np.concatenate(values)

    def _non_monotone(self, driven: tuple[int, ...]) -> int:
        """Return the number of driven hinges that are not monotone."""
        return sum(not self.monotone[hinge] for hinge in driven)

    def _enumerate(self) -> tuple[int, ...]:
        sets = list(combinations(range(self.n), self.freedoms))
        values = self._least_values(sets)
        candidates = np.flatnonzero(values >= MONOTONE_VALUE_SHARE * values.max())
        return sets[min(candidates, key=lambda k: (self._non_monotone(sets[k]), -values[k]))]

    def _exchange(self) -> tuple[int, ...]:
        """Start from pivots of all bases together; exchange hinges singly, for the value, then for monotone ones."""
        from scipy.linalg import qr  # noqa: PLC0415 - loads slowly

        stacked = np.concatenate(list(self.frames[:, :, -self.freedoms :].transpose(0, 2, 1)))
        pivots = qr(stacked, mode="r", pivoting=True)[1]
        driven = tuple(sorted(int(h) for h in pivots[: self.freedoms]))
        value = float(self._least_values([driven])[0])
        for _ in range(MAX_EXCHANGE_SWEEPS):
            sets = self._neighbours(driven)
            values = self._least_values(sets)
            best = int(values.argmax())
            if values[best] <= value * (1.0 + 1e-9):
                break
            driven, value = sets[best], float(values[best])
        floor = MONOTONE_VALUE_SHARE * value
        for _ in range(self.freedoms):
            sets = [
                hinges for hinges in self._neighbours(driven) if self._non_monotone(hinges) < self._non_monotone(driven)
            ]
            values = self._least_values(sets) if sets else np.zeros(1)
            if values.max() < floor:
                break
            driven = sets[int(values.argmax())]
        return driven

    def _neighbours(self, driven: tuple[int, ...]) -> list[tuple[int, ...]]:
        passive = [h for h in range(self.n) if h not in driven]
        return [tuple(sorted({*driven, new} - {old})) for old in driven for new in passive]
