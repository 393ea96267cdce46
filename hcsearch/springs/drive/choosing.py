"""Which hinges to drive: as many as there are freedoms, so that they hold the linkage firmly all along a path.

At each state the rates that keep the loops closed form a space of as many dimensions as there are freedoms. With B an
orthonormal basis of it, by columns, the rows of B at the driven hinges are the reduced Jacobian: its least singular
value is how fast the driven hinges turn at least, together, where all hinges together turn at 1 rad/s. At 0 the others
could move while the driven ones stand still: a dead point. Where every set of as many hinges as freedoms comes near
one on the way, more hinges are driven.
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
"""States along a path at which sets are judged while they are searched, and how often that is done again with the
states at which the set that was chosen does worse."""
MAX_ENUMERATED_HINGE_SETS = 3000
"""Up to so many sets, all are tried; else sets grow from pivots and hinges are exchanged while that helps."""
MAX_EXCHANGE_SWEEPS = 12
MONOTONE_VALUE_SHARE = 0.5
"""Share of the best least singular value that is kept where monotone hinges take the place of others."""
MONOTONE_ANGLE_TOLERANCE = 0.01
"""A hinge that turns back by no more than this (rad) is monotone."""
FIRM_SINGULAR_VALUE = 0.1
"""Hinges are added, those that help most, until the least singular value is this at least."""
CLOSURE_RANK_TOLERANCE = 1e-7
"""Singular values of closure below this share of the greatest, at the state where the most count, are none."""


@dataclass(frozen=True)
class DrivenHinges:
    """Driven hinges.

    hinges : their numbers. monotone : of these. freedoms : of the linkage along the path.
    least : least singular value of the reduced Jacobian along the path; place : where, as a share of its length.
    closure : least singular value of closure itself along the path, and place : what ends and singular states near the
    path make small whatever is driven. tried : sets.
    """

    hinges: tuple[int, ...]
    monotone: tuple[int, ...]
    freedoms: int
    least: float
    place: float
    closure: float
    closure_place: float
    tried: int


def frames_at(linkage: Linkage, angles: Reals, rank: int | None = None) -> tuple[Reals, Reals]:
    """Orthonormal frames (k, n_hinges, n_hinges) at states, and singular values of closure there, (k, rank).

    The first `rank` columns span what closure asks of the rates, the others the closed rates. rank : of closure; what
    it is at most along the path unless given.
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
    """Whether each hinge turns monotonically along a path, (n_hinges,), to `MONOTONE_ANGLE_TOLERANCE`."""
    fallen = np.maximum.accumulate(angles, axis=0) - angles
    risen = angles - np.minimum.accumulate(angles, axis=0)
    monotone: NDArray[np.bool_] = np.minimum(fallen.max(axis=0), risen.max(axis=0)) <= MONOTONE_ANGLE_TOLERANCE
    return monotone


def choose_driven_hinges(linkage: Linkage, angles: Reals, firm: float = FIRM_SINGULAR_VALUE) -> DrivenHinges:
    """The hinges to drive for a path through closed states, (k, n_hinges), evenly along it.

    First the set whose least singular value is greatest; then monotone hinges in the place of others, while half of
    that is kept; then more hinges, where the least singular value is below `firm`.
    """
    frames, values = frames_at(linkage, angles)
    freedoms = linkage.n_hinges - values.shape[1]
    steady = monotone_hinges(angles)
    looked, tried = np.unique(np.linspace(0, len(angles) - 1, CHOICE_STATE_COUNT).astype(int)), 0
    for _ in range(MAX_CHOICE_REPEATS):
        search = _Search(frames[looked], freedoms, steady)
        driven = search.made_firm(search.run(), firm)
        tried += search.tried
        least = least_singular_values(frames, freedoms, np.array([driven], int))[0] if driven else np.ones(len(angles))
        if least.min() >= min(firm, 0.5 * least[looked].min()):
            break
        looked = np.union1d(looked, np.argsort(least)[:5])  # states that were left out, at which the set does worst
    return judge_driven_hinges(linkage, angles, driven, tried)


def judge_driven_hinges(linkage: Linkage, angles: Reals, driven: tuple[int, ...], tried: int = 1) -> DrivenHinges:
    """The choice of given hinges, judged along a path."""
    frames, values = frames_at(linkage, angles)
    freedoms, steady = linkage.n_hinges - values.shape[1], monotone_hinges(angles)
    if len(driven) < freedoms:
        raise HcsearchError(f"{len(driven)} hinges cannot drive {freedoms} freedoms: name {freedoms} at least")
    if not all(0 <= hinge < linkage.n_hinges for hinge in driven):
        raise HcsearchError(f"there is no hinge {max(driven)}: name hinges from 0 to {linkage.n_hinges - 1}")
    least = least_singular_values(frames, freedoms, np.array([driven], int))[0] if driven else np.ones(len(angles))
    closure = values[:, -1] if values.shape[1] else np.ones(len(angles))
    last = max(len(angles) - 1, 1)
    return DrivenHinges(
        driven,
        tuple(hinge for hinge in driven if steady[hinge]),
        freedoms,
        float(least.min()),
        float(least.argmin() / last),
        float(closure.min()),
        float(closure.argmin() / last),
        tried,
    )


def least_singular_values(frames: Reals, freedoms: int, sets: NDArray[np.int64]) -> Reals:
    """Least singular value of the reduced Jacobian for sets of driven hinges (s, d), shape (s, k).

    frames : (k, n, n), orthonormal; the last columns are a basis of the closed rates, the others of what closure asks.
    Where few hinges are not driven, the rows of closure at these have the same least singular value.
    """
    n = frames.shape[1]
    others = n - sets.shape[1]
    if not others:
        return np.ones((len(sets), len(frames)))
    if others < freedoms:
        rest = np.array([np.setdiff1d(np.arange(n), own) for own in sets])
        rows = frames[:, rest, : n - freedoms]
    else:
        rows = frames[:, sets, n - freedoms :]
    values = np.linalg.svd(rows, compute_uv=False)[..., -1]
    return np.ascontiguousarray(values.T)


class _Search:
    """The search for a set."""

    def __init__(self, frames: Reals, freedoms: int, steady: NDArray[np.bool_]) -> None:
        self.frames, self.freedoms, self.steady = frames, freedoms, steady
        self.n = frames.shape[1]
        self.tried = 0

    def run(self) -> tuple[int, ...]:
        """The hinges to drive, in order."""
        if self.freedoms == self.n:
            return tuple(range(self.n))
        if not self.freedoms:
            return ()
        if math.comb(self.n, self.freedoms) <= MAX_ENUMERATED_HINGE_SETS:
            return self._all()
        return self._exchanged()

    def made_firm(self, driven: tuple[int, ...], firm: float) -> tuple[int, ...]:
        """A set with hinges added until its least singular value is large enough, or nothing helps."""
        value = float(self._judged([driven])[0]) if driven else firm
        while value < firm and len(driven) < self.n:
            sets = [tuple(sorted((*driven, new))) for new in range(self.n) if new not in driven]
            values = self._judged(sets)
            good = np.flatnonzero(values >= min(firm, values.max()))
            driven = sets[min(good, key=lambda k: (self._turning(sets[k]), -values[k]))]
            value = float(self._judged([driven])[0])
        return driven

    def _judged(self, sets: list[tuple[int, ...]]) -> Reals:
        """The least singular value of sets along the path."""
        self.tried += len(sets)
        least = [
            least_singular_values(self.frames, self.freedoms, np.array(sets[k : k + 200], int)).min(axis=1)
            for k in range(0, len(sets), 200)
        ]
        return np.concatenate(least)

    def _turning(self, driven: tuple[int, ...]) -> int:
        """Driven hinges that turn back on the way."""
        return sum(not self.steady[hinge] for hinge in driven)

    def _all(self) -> tuple[int, ...]:
        sets = list(combinations(range(self.n), self.freedoms))
        values = self._judged(sets)
        kept = np.flatnonzero(values >= MONOTONE_VALUE_SHARE * values.max())
        return sets[min(kept, key=lambda k: (self._turning(sets[k]), -values[k]))]

    def _exchanged(self) -> tuple[int, ...]:
        """Pivots of all bases together, then exchanges of one hinge: for the value, then for monotone hinges."""
        from scipy.linalg import qr  # noqa: PLC0415 - loads slowly

        together = np.concatenate(list(self.frames[:, :, -self.freedoms :].transpose(0, 2, 1)))
        pivots = qr(together, mode="r", pivoting=True)[1]
        driven = tuple(sorted(int(h) for h in pivots[: self.freedoms]))
        value = float(self._judged([driven])[0])
        for _ in range(MAX_EXCHANGE_SWEEPS):
            sets = self._exchanges(driven)
            values = self._judged(sets)
            best = int(values.argmax())
            if values[best] <= value * (1.0 + 1e-9):
                break
            driven, value = sets[best], float(values[best])
        floor = MONOTONE_VALUE_SHARE * value
        for _ in range(self.freedoms):
            sets = [own for own in self._exchanges(driven) if self._turning(own) < self._turning(driven)]
            values = self._judged(sets) if sets else np.zeros(1)
            if values.max() < floor:
                break
            driven = sets[int(values.argmax())]
        return driven

    def _exchanges(self, driven: tuple[int, ...]) -> list[tuple[int, ...]]:
        others = [h for h in range(self.n) if h not in driven]
        return [tuple(sorted({*driven, new} - {old})) for old in driven for new in others]
