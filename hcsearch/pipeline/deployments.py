"""The stage `deployment` in pieces that take seconds, so that little is lost when a run is killed."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hcsearch import deployment
from hcsearch.grid import grid_named
from hcsearch.pipeline.designs import circuit_texts
from hcsearch.pipeline.stages import BUILT
from hcsearch.records import NONE, Candidates, DeploymentBatch, StageResult, VerdictBatch
from hcsearch.scenes import Scene

BEST_FIRST: tuple[str, ...] = ("deploys", "undecided", "collides", "locked")
"""Verdicts on foldings; a design has the best of its foldings."""
FOLDING_SECONDS = 0.4
"""Core seconds that a folding of `_PANELS` panels takes, with its second look; they grow as the cube of their number
(measured: 0.3 to 0.45 s of 12 hexagons, 8 s of the 30 rectangles of 6x5)."""
PIECE_SECONDS = 4.0
"""Core seconds that a piece takes, about."""
_PANELS = 12
_MARK = "#"


@dataclass(frozen=True)
class Piece:
    """Some candidates of a unit of the search; key : its own name among finished work."""

    key: str
    candidates: Candidates


@dataclass(frozen=True)
class Verdict:
    """What a piece gives: verdicts for the store, and the result of the stage."""

    key: str
    verdicts: VerdictBatch
    result: StageResult
    foldings: int


@dataclass(frozen=True)
class Deploy:
    """Verdicts on pieces in a scene."""

    scene: Scene

    def __call__(self, piece: Piece) -> Verdict:
        """Simulate one piece."""
        from hcsearch.deployment.verdicts import verdicts  # noqa: PLC0415 - its kernels take seconds to load

        begun = time.perf_counter()
        own = piece.candidates
        plain = np.zeros(len(own.foldings), np.int16)
        found = verdicts(own.circuits, own.foldings, plain, own.locked, self.scene)
        best, status = _best(own, found)
        passed = np.array([word == "deploys" for word in status], bool)
        result = StageResult(
            deployment.STAGE,
            BUILT[deployment.STAGE],
            int(passed.sum()),
            int(own.n_fixed[passed].sum()),
            time.perf_counter() - begun,
        )
        batch = VerdictBatch(
            circuit_texts(grid_named(own.circuits.grid), own.circuits.words),
            best,
            status,
            own.foldings.row,
            own.foldings.crease,
            found,
        )
        return Verdict(piece.key, batch, result, len(own.foldings))


def seconds_of(foldings: float, n: int) -> float:
    """About how many core seconds the verdicts on foldings of n panels take."""
    return foldings * FOLDING_SECONDS * (n / _PANELS) ** 3


def pieces(unit: str, candidates: Candidates) -> Iterator[Piece]:
    """Pieces of the candidates of a unit; what they are depends on the candidates alone."""
    n, designs = candidates.circuits.words.shape[1], len(candidates.circuits)
    most = max(1, round(PIECE_SECONDS / seconds_of(1.0, n)))
    counts = np.bincount(candidates.foldings.row, minlength=designs)
    ends: list[int] = []
    waiting = 0
    for design, count in enumerate(counts.tolist()):
        if waiting and waiting + count > most:
            ends.append(design)
            waiting = 0
        waiting += count
    bounds = [0, *ends, designs] if designs else []
    for k, (begin, end) in enumerate(pairwise(bounds)):
        yield Piece(f"{unit}{_MARK}{k}/{len(bounds) - 1}", candidates.take(begin, end))
    if not designs:
        yield Piece(f"{unit}{_MARK}0/1", candidates)


def unfinished(units: Sequence[str], keys: Sequence[str]) -> list[str]:
    """Units of which not all pieces are among finished ones."""
    counted: dict[str, tuple[int, int]] = {}
    for key in keys:
        unit, _, place = key.rpartition(_MARK)
        done, _ = counted.get(unit, (0, 0))
        counted[unit] = (done + 1, int(place.partition("/")[2]))
    return [unit for unit in units if unit not in counted or counted[unit][0] < counted[unit][1]]


def _best(own: Candidates, found: DeploymentBatch) -> tuple[list[int], list[str]]:
    """Crease and status of the best folding of each design: by status, then lowest dof, then lowest crease."""
    rank = {word: place for place, word in enumerate(BEST_FIRST)}
    words = np.array([rank[str(word)] for word in found.status], int)
    dof = np.where(own.dof == NONE, np.iinfo(np.int32).max, own.dof)
    order = np.lexsort((own.foldings.crease, dof, words, own.foldings.row))
    _, firsts = np.unique(own.foldings.row[order], return_index=True)
    best = order[firsts]
    return own.foldings.crease[best].tolist(), [BEST_FIRST[words[k]] for k in best.tolist()]
