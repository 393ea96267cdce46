"""Proofs that a union of elements is a unit: its folded package, its rank, and its motion from flat to folded.

All of it is floating point at sampled states: ranks by gaps in singular values, the motion by its states, contact at
them and between. Nothing here is a proof over all of the motion, as `motion.collision` gives of clearance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import PatternError
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
"""Middles of folded facets nearer than this share of the thickness are in one place; layers are a thickness apart."""
CONTACT_SAMPLE_SHARES = (1 / 3, 2 / 3)
"""Where contact is looked for between two states of a motion, as shares of the step."""


@dataclass(frozen=True)
class UnitProof:
    """The kinematics of one pattern.

    dof, dof_folded, dof_flat : nullity at a generic state of the motion and at its ends; None undecided.
    rank_gap : least singular value that counts over the noise, at the generic state.
    deployment_ratio : flat area over footprint of the folded package; overlap : volume that panels fill twice (m^3).
    ways : number of finite motions out of the folded state, within the stops, that the search reports.
    path : `flat` where one smooth motion leads from folded to flat; `stopped` where those out of the folded state
        come to stops, from where others may go on; `stepwise` where springs find a way that is no smooth motion; `none`
        where the search reports nothing; `has_locked_end` where nothing moves.
    path_dof : nullities between its ends, each once. closure_error : greatest residual on it (rad, or gap over size).
    contact : whether panels cut through each other at a state of it; None without such a motion.
    """

    dof: int | None
    dof_folded: int | None
    dof_flat: int | None
    rank_gap: float
    deployment_ratio: float
    overlap: float
    ways: int = 0
    path: str = "none"
    path_dof: tuple[int, ...] = ()
    closure_error: float | None = None
    contact: bool | None = None

    @property
    def verdict(self) -> str:
        """`unit` where it moves from folded to flat with one degree of freedom all the way, else what is against it.

        `no motion found` proves nothing; `stopped` and `several motions` prove it unless a motion was missed.
        """
        if self.dof != 1:
            return "undecided" if self.dof is None else f"{self.dof} degrees of freedom"
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
    """A motion from folded to flat, or what became of the search for one."""

    ways: int
    path: str
    nullities: tuple[int, ...] = ()
    residual: float | None = None
    states: Reals | None = None


def generic_freedom(pattern: Pattern) -> int | None:
    """Degrees of freedom at a generic state; None where undecided, or where the loops stay open when folded."""
    linkage = Linkage(pattern)
    if not closes_when_folded(linkage):
        return None
    return generic_rank(linkage).nullity


def closes_when_folded(linkage: Linkage) -> bool:
    """Whether the loops are closed with every hinge folded."""
    residual, _ = linkage.closure(linkage.folded)
    return float(np.abs(residual).max(initial=0.0)) <= CLOSED_LOOP_RESIDUAL


def has_shared_places(linkage: Linkage) -> bool:
    """Whether two facets have one place when folded: a quick test of what `package` measures.

    It misses facets that overlap in part, which those of regular grids cannot.
    """
    middles = (
        np.array([solid.mean(axis=(0, 1)) for solid in linkage.solids(linkage.folded)]) / linkage.pattern.thickness
    )
    apart = np.linalg.norm(middles[:, None] - middles, axis=2) + np.eye(len(middles))
    return bool(apart.min() < SAME_FOLDED_FACET_SHARE)


def has_locked_end(linkage: Linkage) -> bool:
    """Whether the flat or the folded state is proved locked, by hinges at stops and panels that lie on each other."""
    return lock_at(linkage, linkage.flat).locked or lock_at(linkage, linkage.folded, contact_rows(linkage)).locked


def prove_unit(pattern: Pattern) -> UnitProof:
    """Rank, package and motion of a pattern; PatternError where it has no folded state.

    The motion is searched only with one degree of freedom at a generic state, and no two panels in one place folded.
    """
    linkage = Linkage(pattern)
    if not closes_when_folded(linkage):
        raise PatternError("this pattern has no folded state: its loops stay open with every hinge closed")
    generic = generic_rank(linkage)
    folded = folded_package(pattern)
    overlap = 0.0 if folded.overlap_volume < 1e-9 * pattern.thickness * pattern.area else folded.overlap_volume
    ends = [rank_at(linkage, state).nullity for state in (linkage.folded, linkage.flat)]
    proof = UnitProof(generic.nullity, ends[0], ends[1], generic.gap, folded.ratio, overlap)
    if generic.nullity != 1 or overlap:
        return proof
    motion = _motion(linkage)
    return replace(
        proof,
        ways=motion.ways,
        path=motion.path,
        path_dof=motion.nullities,
        closure_error=motion.residual,
        contact=None if motion.states is None else cuts_through(linkage, _denser(linkage, motion.states)),
    )


def _motion(linkage: Linkage) -> _Motion:
    """The motion out of the folded state; where no branch leads to the flat state, one that springs find."""
    if has_locked_end(linkage):
        return _Motion(0, "locked")
    paths = [follow_path(linkage, linkage.folded, way, limits=PathLimits(goal="flat")) for way in _ways(linkage)]
    for path in paths:
        if path.outcome == "flat":
            return _followed(len(paths), "flat", path)
    sprung = _searched(linkage, len(paths))
    # the search for branches may have missed one, so springs are tried even where all come to a stop
    stopped = bool(paths) and all(path.outcome == "stopped" for path in paths)
    return replace(sprung, path="stopped", residual=None, states=None) if stopped and sprung.path != "flat" else sprung


def _ways(linkage: Linkage) -> list[Reals]:
    """Velocities of the motions out of the folded state, within the stops."""
    local = local_at(linkage, linkage.folded)
    if local.nullity == 1:  # there can be no other, in one sense or the other
        only = local.null_space()[:, 0]
        opening = np.where(linkage.folded > 0.0, -only, only)
        senses = ((only, opening), (-only, -opening))
        return [velocity for velocity, opens in senses if opens.min() > -1e-9]
    finite = find_branches(linkage, linkage.folded, stops=True).finite
    return [way.direction for way in finite if way.within_stops]


def _searched(linkage: Linkage, ways: int) -> _Motion:
    """A motion that springs make, and followed both ways from its middle where it is one motion and not several."""
    springs = find_descent(linkage).path
    if springs.outcome != "flat":
        return _Motion(ways, "none", _between(springs))
    middle = springs.angles[len(springs.angles) // 2]
    forth = follow_path(linkage, middle, linkage.flat - middle, limits=PathLimits(goal="flat"))
    back = follow_path(linkage, middle, linkage.folded - middle, limits=PathLimits(goal="folded"))
    if (forth.outcome, back.outcome) != ("flat", "folded"):
        return _followed(ways, "stepwise", springs)
    return _followed(ways, "flat", back, forth)


def _denser(linkage: Linkage, states: Reals) -> Reals:
    """The states of a motion with closed ones between them."""
    denser = [states[-1]]
    for one, two in pairwise(states):
        denser.append(one)
        denser += [close_linkage(linkage, one + share * (two - one)).angles for share in CONTACT_SAMPLE_SHARES]
    return np.array(denser)


def _followed(ways: int, outcome: str, *paths: MotionPath) -> _Motion:
    """The motion along one path, or back along the first of two and on along the other."""
    nullities = sorted({nullity for path in paths for nullity in _between(path)})
    residual = max(float(path.residuals.max()) for path in paths)
    states = np.vstack([*(path.angles[::-1] for path in paths[:-1]), paths[-1].angles])
    return _Motion(ways, outcome, tuple(nullities), residual, states)


def _between(path: MotionPath) -> tuple[int, ...]:
    return tuple(sorted({int(nullity) for nullity in path.nullities[1:-1]}))
