"""Numerical evidence that a union of elements is a unit: its folded package, rank, and motion from folded to flat.

Everything is computed in floating point at sampled states: ranks by gaps in singular values, contact at states of the
motion and between them. Unlike the clearance proofs of `motion.collision`, nothing here is proved over all of a motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import PatternError
from hcsearch.basics.vocabulary import counted
from hcsearch.library.assemblies.packages import folded_package
from hcsearch.motion.collision.distances import cuts_through
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.motion.kinematics.local import local_at
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from hcsearch.motion.locks.end_locks import contact_rows, lock_at
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.paths.descent import find_descent
from hcsearch.motion.paths.following import PathLimits, follow_path
from hcsearch.motion.paths.motions import MotionPath
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

SAME_FOLDED_FACET_SHARE = 1e-3
"""Folded facets are in one place if their centres are nearer than this share of the thickness; layers are a thickness
apart."""
CONTACT_SAMPLE_SHARES = (1 / 3, 2 / 3)
"""Positions of contact tests between two states of a motion, as shares of the step."""


@dataclass(frozen=True)
class UnitProof:
    """The kinematics of one pattern.

    dof, dof_folded, dof_flat : nullity at a generic state of the motion and at its ends; None if undecided.
    rank_gap : ratio of the least nonzero singular value to the noise, at the generic state.
    deployment_ratio : flat area over footprint of the folded package; overlap : volume that panels fill twice (m^3).
    path_count : number of finite motions from the folded state, within the stops, that the search reports.
    path : `flat` where one smooth motion leads from folded to flat; `stopped` where all motions from the folded state
        end at stops, from which others may continue; `stepwise` where springs find a path that is not a smooth motion;
        `none` where the search finds no motion; `has_locked_end` where no motion is possible.
    path_dof : distinct nullities between its ends. closure_error : greatest residual on it (rad, or gap over size).
    contact : whether panels penetrate each other at a state of it; None without such a motion.
    """

    dof: int | None
    dof_folded: int | None
    dof_flat: int | None
    rank_gap: float
    deployment_ratio: float
    overlap: float
    path_count: int = 0
    path: str = "none"
    path_dof: tuple[int, ...] = ()
    closure_error: float | None = None
    contact: bool | None = None

    @property
    def verdict(self) -> str:
        """`unit` where it moves from folded to flat with one degree of freedom throughout, else the reason against it.

        `no motion found` proves nothing; `stopped` and `several motions` are conclusive unless a motion was missed.
        """
        if self.dof != 1:
            return "undecided" if self.dof is None else f"{counted(self.dof, 'degree')} of freedom"
        if self.overlap:
            return "overlaps folded"
        if self.path != "flat":
            return {"stepwise": "several motions", "none": "no motion found"}.get(self.path, self.path)
        return "unit" if self.path_dof == (1,) else "freer on the way"

    @property
    def holds(self) -> bool:
        """Whether it is a unit."""
        return self.verdict == "unit"


@dataclass(frozen=True, eq=False)
class _Motion(ByValue):
    """A motion from folded to flat, or the outcome of the search for one."""

    path_count: int
    path: str
    nullities: tuple[int, ...] = ()
    residual: float | None = None
    states: Reals | None = None


def generic_freedom(pattern: Pattern) -> int | None:
    """Return the degrees of freedom at a generic state; None where undecided or without a folded state."""
    linkage = Linkage(pattern)
    if not closes_when_folded(linkage):
        return None
    return generic_rank(linkage).nullity


def closes_when_folded(linkage: Linkage) -> bool:
    """Whether the loops close in the folded state."""
    residual, _ = linkage.closure(linkage.folded)
    return float(np.abs(residual).max(initial=0.0)) <= CLOSED_LOOP_RESIDUAL


def has_shared_places(linkage: Linkage) -> bool:
    """Whether two facets coincide in the folded state: a quick test for overlaps measured by `package`.

    It misses partial overlaps, which regular grids exclude.
    """
    middles = (
        np.array([solid.mean(axis=(0, 1)) for solid in linkage.solids(linkage.folded)]) / linkage.pattern.thickness
    )
    apart = np.linalg.norm(middles[:, None] - middles, axis=2) + np.eye(len(middles))
    return bool(apart.min() < SAME_FOLDED_FACET_SHARE)


def has_locked_end(linkage: Linkage) -> bool:
    """Whether the flat or the folded state is proved locked, by hinges at stops and panels in contact."""
    return lock_at(linkage, linkage.flat).locked or lock_at(linkage, linkage.folded, contact_rows(linkage)).locked


def prove_unit(pattern: Pattern) -> UnitProof:
    """Compute rank, package and motion of a pattern; PatternError where it has no folded state.

    The motion is searched for only with one degree of freedom at a generic state and without overlaps when folded.
    """
    linkage = Linkage(pattern)
    if not closes_when_folded(linkage):
        raise PatternError("this pattern has no folded state: its loops stay open with every hinge closed")
    generic = generic_rank(linkage)
    folded = folded_package(pattern)
    overlap = 0.0 if folded.overlap_volume < 1e-9 * pattern.thickness * pattern.area else folded.overlap_volume
    end_nullities = [rank_at(linkage, state).nullity for state in (linkage.folded, linkage.flat)]
    proof = UnitProof(generic.nullity, end_nullities[0], end_nullities[1], generic.gap, folded.ratio, overlap)
    if generic.nullity != 1 or overlap:
        return proof
    motion = _motion(linkage)
    contact = None if motion.states is None else cuts_through(linkage, _denser(linkage, motion.states))
    proof = replace(proof, path_count=motion.path_count, path=motion.path, path_dof=motion.nullities)
    return replace(proof, closure_error=motion.residual, contact=contact)


def _motion(linkage: Linkage) -> _Motion:
    """Search for a motion from the folded state; where no branch reaches the flat state, for one driven by springs."""
    if has_locked_end(linkage):
        return _Motion(0, "locked")
    limits = PathLimits(goal="flat")
    paths = [follow_path(linkage, linkage.folded, velocity, limits=limits) for velocity in _velocities(linkage)]
    for path in paths:
        if path.outcome == "flat":
            return _followed(len(paths), "flat", path)
    by_springs = _searched(linkage, len(paths))
    # the search for branches may have missed one, so springs are tried even where all come to a stop
    stopped = bool(paths) and all(path.outcome == "stopped" for path in paths)
    if stopped and by_springs.path != "flat":
        return replace(by_springs, path="stopped", residual=None, states=None)
    return by_springs


def _velocities(linkage: Linkage) -> list[Reals]:
    """Return the velocities of motions from the folded state, within the stops."""
    local = local_at(linkage, linkage.folded)
    if local.nullity == 1:  # the only motion, in either sense
        only = local.null_space()[:, 0]
        opening = np.where(linkage.folded > 0.0, -only, only)
        senses = ((only, opening), (-only, -opening))
        return [velocity for velocity, opens in senses if opens.min() > -1e-9]
    finite = find_branches(linkage, linkage.folded, stops=True).finite
    return [branch.direction for branch in finite if branch.within_stops]


def _searched(linkage: Linkage, path_count: int) -> _Motion:
    """Search for a motion by springs, and follow it in both directions from its middle where it is a single motion."""
    springs = find_descent(linkage).path
    if springs.outcome != "flat":
        return _Motion(path_count, "none", _between(springs))
    middle = springs.angles[len(springs.angles) // 2]
    to_flat = follow_path(linkage, middle, linkage.flat - middle, limits=PathLimits(goal="flat"))
    to_folded = follow_path(linkage, middle, linkage.folded - middle, limits=PathLimits(goal="folded"))
    if (to_flat.outcome, to_folded.outcome) != ("flat", "folded"):
        return _followed(path_count, "stepwise", springs)
    return _followed(path_count, "flat", to_folded, to_flat)


def _denser(linkage: Linkage, states: Reals) -> Reals:
    """Insert closed states between the states of a motion."""
    denser = [states[-1]]
    for first, second in pairwise(states):
        denser.append(first)
        denser += [close_linkage(linkage, first + share * (second - first)).angles for share in CONTACT_SAMPLE_SHARES]
    return np.array(denser)


def _followed(path_count: int, outcome: str, *paths: MotionPath) -> _Motion:
    """Return the motion along one path, or along the first of two reversed and then the second."""
    nullities = sorted({nullity for path in paths for nullity in _between(path)})
    residual = max(float(path.residuals.max()) for path in paths)
    states = np.vstack([*(path.angles[::-1] for path in paths[:-1]), paths[-1].angles])
    return _Motion(path_count, outcome, tuple(nullities), residual, states)


def _between(path: MotionPath) -> tuple[int, ...]:
    return tuple(sorted({int(nullity) for nullity in path.nullities[1:-1]}))
