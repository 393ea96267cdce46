"""Certificates of foldings and patterns: the proof of a path or of a lock, which independent checkers can repeat."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import WAYS, Way, counted
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize, panel_text, read_panel
from hcsearch.designs.twisting import twist
from hcsearch.motion.certificates import collision_checker, lock_checker, path_checker
from hcsearch.motion.certificates.certificate_data import array_data, certificate, lock_claim, path_claim
from hcsearch.motion.certificates.certificate_grammar import (
    MAX_BYTES,
    ArrayData,
    Clock,
    NoCertificateError,
    NotProvedError,
    claims_of,
    parsed,
    printable,
)
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_linkage_motion, plan_motion, proof_margins
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.planning.problems import group_of, loops_of
from hcsearch.motion.planning.schedule import LOOSE_SEARCH_ROUNDS
from hcsearch.motion.planning.stretches import SAME_STATE_DISTANCE
from hcsearch.motion.searching import Budget
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import components, sides_of
from hcsearch.system.reading import read_binary_file
from hcsearch.system.work_steps import Progress, work_step

DEFAULT_PROOF_BUDGET = 5
"""The default budget of the search for a proof."""
MAX_PATH_SEEDS = 12
"""Number of paths that are tried until the checker proves one: some come closer to singular states than others."""
CheckedClaim = tuple[dict[str, Any], str]
"""A claim, and its checker's statement of the proved fact."""
CLAIM_CHECKERS = {"path": path_checker.checked, "lock": lock_checker.checked, "collision": collision_checker.checked}
"""The checkers, by kind of claim."""


class CertificateError(HcsearchError):
    """The data are no certificate, or it does not prove what it claims."""


class UnprovedCertificateError(CertificateError):
    """A certificate does not prove what it claims, or not in the given time."""


def prove_folding(
    folding: Folding, panel: PanelSize, ways: Sequence[Way], margin: float | None, budget: int = DEFAULT_PROOF_BUDGET
) -> tuple[dict[str, Any], list[str]]:
    """Prove a path or a lock of a folding; return its certificate as plain data, and the proved facts as sentences.

    panel : size of its panels, m. ways : the ways of joining flat pairs that are tried. margin : as in `plan_motion`.

    The checkers have proved the certificate. Its circuit is canonical, in whichever form the folding is given.
    budget : efforts of the search. HcsearchError where nothing is proved by these.
    """
    folding = Folding.from_notation(folding.notation)
    turns = twist(folding)
    if turns:
        raise HcsearchError(
            f"{folding.notation} is twisted, with linking number {turns}: that no motion opens it is a theorem, and "
            "needs no certificate; name a folding without twist"
        )
    allowed = [way for way in ways if folding.can_join(way)]
    motion = plan_motion(folding, panel, allowed, margin, budget=budget)
    linkages = {way: folding.linkage(panel, flat_pairs=way) for way in allowed}
    return _certified(linkages, motion, margin, budget, folding.notation, panel_text(panel))


def prove_pattern(
    linkage: Linkage,
    name: str,
    margin: float | None,
    budget: int = DEFAULT_PROOF_BUDGET,
    progress: Progress | None = None,
) -> tuple[dict[str, Any], list[str]]:
    """Prove a path or a lock of a pattern that is no design, as `prove_folding`; name : of the file.

    progress : called with the number of efforts done and the number of all efforts.

    HcsearchError also where its points lie on no lattice of a tiling, in whose whole numbers certificates are written,
    where these numbers are too large for the checkers, where hinges are between their stops in the packed state, or
    where a path is found along which the equations of closed loops depend on each other: no proof of closed states is
    known there, and there is no lock.
    """
    if not linkage.folds_flat:
        raise HcsearchError(
            f"{name} states a packed state with hinges between 0 and 180 degrees, and certificates begin at states in "
            "whole numbers: see what hcsearch check says of it, or give the pattern without this state"
        )
    array_data(linkage)  # before the search: it refuses arrays that no certificate holds
    motion = PlannedMotion(None, None, None, ())
    for done in range(budget):
        if progress is not None:
            progress(done, budget, "efforts to prove a path or a lock")
        motion = plan_linkage_motion(linkage, margin, budget=done + 1, done=done)
        if motion.locked or motion.margin is not None:
            break
        if motion.states is not None:
            _refuse_dependent_closure(linkage, motion.states, name)
    return _certified({"hinged": linkage}, motion, margin, budget, name, None)


def _refuse_dependent_closure(linkage: Linkage, states: Reals, name: str) -> None:
    """Refuse a path, (k, n_hinges), if its closure equations depend on each other at each of its states.

    The equations belong to the group in which its hinges turn. A path through flat-folded states is not judged,
    since it is proved in parts, each in a group of its own.
    """
    inner = states[1:-1]
    if (np.minimum(inner, math.pi - inner).max(axis=1) <= SAME_STATE_DISTANCE).any():
        return
    folded = linkage.folded.astype(float)
    end, equations = whole_end(linkage, folded), linkage.n_rows
    if end is not None:
        moving = np.abs(states - folded).max(axis=0) > SAME_STATE_DISTANCE
        equations = len(group_of(linkage, loops_of(linkage), end, moving, linkage.closure(folded)[1]).rows)
    ranks = [rank_at(linkage, state).rank for state in states]
    independent = max(equations if rank is None else rank for rank in ranks)
    if independent < equations:
        raise HcsearchError(
            f"a path of {name} is found, but it cannot be proved: {equations} equations close the loops, of which "
            f"{independent} are independent along it, and a proof needs all of them to be; see hcsearch drive"
        )


def _certified(
    linkages: Mapping[Way, Linkage],
    motion: PlannedMotion,
    margin: float | None,
    budget: int,
    name: str,
    panel_mm: str | None,
) -> tuple[dict[str, Any], list[str]]:
    """Return the certificate of a motion or a lock, and its claims as sentences; HcsearchError without either."""
    if not motion.locked and motion.margin is None:
        raise HcsearchError(
            f"neither a path nor a lock of {name} is proved by {budget} efforts: give --budget {budget + 2}"
        )
    checked = _locks(linkages, motion, name) if motion.locked else [_path(linkages, motion, margin, name)]
    data = certificate([claim for claim, _ in checked], name, panel_mm)
    try:
        claims_of(parsed(json.dumps(data, separators=(",", ":")).encode() + b"\n"))
    except NoCertificateError as refused:
        raise HcsearchError(
            f"the certificate of {name} is beyond what hcsearch verify reads: {refused}; give other panels"
        ) from refused
    return data, [_sentence(data, claim, proved) for claim, proved in checked]


def _locks(linkages: Mapping[Way, Linkage], motion: PlannedMotion, name: str) -> list[CheckedClaim]:
    """Claims that a folding is locked: with hinged pairs, which covers all other ways, or in each way."""
    known = dict(motion.locks)
    ways: list[Way] = ["hinged"] if "hinged" in known else [*known]
    claims = [{**lock_claim(linkages[way], known[way]), "pairs": way} for way in ways]
    try:
        return [(claim, CLAIM_CHECKERS[claim["kind"]](claim)) for claim in claims]
    except NotProvedError as refused:
        raise HcsearchError(
            f"the checker does not confirm the lock of {name}: {refused}; give other panels"
        ) from refused


def _path(linkages: Mapping[Way, Linkage], motion: PlannedMotion, margin: float | None, name: str) -> CheckedClaim:
    """Return a path claim that the checker proves: of the planned path, or of another in the same way."""
    assert motion.way is not None
    linkage = linkages[motion.way]
    prover, margins, refusal = Prover(linkage), proof_margins(linkage, margin), ""
    for states in _candidates(linkage, motion, margins[-1]):
        proof = prover.prove(states, margins)
        if proof.margin is None:
            continue
        try:
            claim = path_claim(linkage, prover.tubes(states, [proof.margin])[0], proof.margin)
            return {**claim, "pairs": motion.way}, path_checker.checked(claim)
        except NotProvedError as refused:
            refusal = str(refused)
    raise HcsearchError(f"the checker confirms no path of {name}: {refusal}; give other panels")


def _candidates(linkage: Linkage, motion: PlannedMotion, margin: float) -> Iterator[Reals]:
    """The states of the proved path, then of other paths planned with a margin (m)."""
    assert motion.states is not None
    yield motion.states
    planner = Planner(linkage, margin)
    for seed in range(1, MAX_PATH_SEEDS):
        states = planner.plan(Budget(LOOSE_SEARCH_ROUNDS, seed=seed)).states
        if states is not None:
            yield states


def read_certificate(path: str) -> Any:
    """Read the data of a certificate; InputFileError as in `read_binary_file`, CertificateError if they are no JSON."""
    try:
        return parsed(read_binary_file(path, "the certificate", max_bytes=MAX_BYTES))
    except NoCertificateError as refused:
        raise CertificateError(f"{refused}; write it by hcsearch prove") from None


@work_step("checking the certificate")
def verify_certificate(data: Any, clock: Clock | None = None) -> list[str]:
    """Verify the claims of a certificate; return the proved facts as sentences.

    clock : the time after which it is not decided, without a limit if none is given. CertificateError for data that
    are no certificate; UnprovedCertificateError where a claim is not proved.
    """
    clock = clock or Clock()
    try:
        return [_verified(data, claim, clock) for claim in claims_of(data)]
    except NoCertificateError as refused:
        raise CertificateError(str(refused)) from refused
    except NotProvedError as refused:
        raise UnprovedCertificateError(str(refused)) from refused


def _verified(data: Mapping[str, Any], claim: Any, clock: Clock) -> str:
    """Check that a claim is about the named array, and prove it; return it as a sentence.

    For a pattern, the certificate's own array counts, as its file is not at hand.
    """
    clock.check()
    array = ArrayData(claim.get("array"))
    if data["panel_mm"] is None:
        for number, panel in enumerate(array.panels):
            if not _is_joined([array.facets[facet] for facet in panel]):
                raise CertificateError(f"panel {number} is in several parts: its facets are not joined by sides")
    else:
        _check_named(data, claim)
    return _sentence(data, claim, CLAIM_CHECKERS[claim["kind"]](claim, clock))


def _check_named(data: Mapping[str, Any], claim: Mapping[str, Any]) -> None:
    """Check that the array of a claim belongs to the named folding, panels and joining of flat pairs."""
    name, panel, way = printable(data["of"]), printable(data["panel_mm"]), claim.get("pairs")
    if way not in WAYS:
        raise CertificateError(f"it names no joining of flat pairs: write {', '.join(WAYS)}")
    try:
        folding, size = Folding.from_notation(name), read_panel(panel)
        named = array_data(folding.linkage(size, flat_pairs=way))
    except (HcsearchError, ValueError) as error:
        raise CertificateError(f"it names no folding, panel or joining of flat pairs ({error})") from error
    if claim["array"] != named:
        raise UnprovedCertificateError(
            f"its array is not that of {name} with {way} flat pairs and panels of {panel} mm"
        )


def _is_joined(facets: Sequence[Sequence[Sequence[int]]]) -> bool:
    """Whether facets, given by their corners, are one polygon: each is joined to others by whole sides."""
    rings = [[tuple(corner) for corner in facet] for facet in facets]
    owners = {side: number for number, ring in enumerate(rings) for side in sides_of(ring)}
    joined = [(number, owners[end, start]) for (start, end), number in owners.items() if (end, start) in owners]
    return len(components(range(len(facets)), joined)) == 1


def _sentence(data: Mapping[str, Any], claim: Mapping[str, Any], proved: str) -> str:
    """The proved claim as a sentence, with its folding and panels, or with the size of its pattern."""
    if data["panel_mm"] is None:
        panels, hinges = (len(claim["array"][key]) for key in ("panels", "hinges"))
        size = f"{counted(panels, 'panel')} and {counted(hinges, 'hinge')}"
        return f"the pattern of {size} in the certificate, named {data['of']!r}: {proved}"
    return f"{printable(data['of'])}, {claim['pairs']} flat pairs, panels of {printable(data['panel_mm'])} mm: {proved}"
