"""The stages in a scene, `motion` and `deployment`, in pieces of seconds: little is lost when a run is killed."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcsearch import deployment, planning
from hcsearch.collision.clearance import check_margin, margin_of
from hcsearch.grid import grid_named
from hcsearch.linkage import Linkage
from hcsearch.mobility import locks_of
from hcsearch.pattern import Pattern
from hcsearch.pipeline.designs import circuit_texts
from hcsearch.pipeline.stages import BUILT
from hcsearch.records import NONE, Candidates, DeploymentBatch, MotionBatch, StageResult, VerdictBatch
from hcsearch.scenes import Scene, check_verdicts, panel_of
from hcsearch.store.columns import VERDICTS

FOLDING_SECONDS = 0.4
"""Core seconds that a folding of `_PANELS` panels takes, with its second looks; they grow as the square of their number
(measured: 0.4 s of 12 hexagons, 2.5 s of the 30 squares of 6x5)."""
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
    """What a piece gives: verdicts for the store, and the results of the stages."""

    key: str
    verdicts: VerdictBatch
    results: tuple[StageResult, ...]
    foldings: int


@dataclass(frozen=True)
class Judge:
    """Verdicts on pieces in a scene.

    deploys : whether deployments are simulated, and not only paths looked for.
    """

    scene: Scene
    deploys: bool

    def __call__(self, piece: Piece) -> Verdict:
        """Judge one piece."""
        from hcsearch.planning.stage import motions  # noqa: PLC0415 - its kernels take seconds to load

        begun = time.perf_counter()
        own = piece.candidates
        locks = own.locked, own.locked_hinged
        locked, locked_hinged = locks_of(own.circuits, own.foldings, locks, panel_of(self.scene, own.circuits.grid))
        own = replace(own, locked=locked, locked_hinged=locked_hinged)
        motion = motions(own.circuits, own.foldings, (locked, locked_hinged), self.scene)
        moving = np.zeros(len(own.circuits), bool)
        moving[own.foldings.row[motion.moves]] = True
        results = [_result(planning.STAGE, moving, own, begun)]
        found = None
        if self.deploys:
            from hcsearch.deployment.verdicts import verdicts  # noqa: PLC0415

            begun = time.perf_counter()
            found = verdicts(own.circuits, own.foldings, own.locked, motion.met, self.scene)
        words = _words(own, motion, found, self.scene)
        best, status = _best(own, words, motion)
        if self.deploys:
            deploys = np.array([word == "deploys" for word in status], bool)
            results.append(_result(deployment.STAGE, deploys, own, begun))
        texts = circuit_texts(grid_named(own.circuits.grid), own.circuits.words)
        batch = VerdictBatch(texts, best, status, own.foldings.row, own.foldings.crease, words, motion, found)
        return Verdict(piece.key, batch, tuple(results), len(own.foldings))


def check_scene(scene: Scene, grid: str, n: int) -> None:
    """Refuse a scene that the foldings of n panels of a grid cannot be judged in."""
    check_verdicts(scene, grid, n)
    length, width, thickness = panel_of(scene, grid)
    tiling = grid_named(grid)
    facet = tuple((length * x, width * y) for x, y in tiling.corners(tiling.cell((1, 1))))
    panel = Linkage(Pattern((facet,), {}, thickness))
    check_margin(panel, margin_of(panel) if scene.margin is None else scene.margin)


def _result(stage: str, passed: NDArray[np.bool_], own: Candidates, begun: float) -> StageResult:
    seconds = time.perf_counter() - begun
    return StageResult(stage, BUILT[stage], int(passed.sum()), int(own.n_fixed[passed].sum()), seconds)


def _words(own: Candidates, motion: MotionBatch, found: DeploymentBatch | None, scene: Scene) -> list[str]:
    """The status of each folding in a scene."""
    locked = own.locked if scene.flat_pairs == "rigid" or scene.merge is True else own.locked_hinged
    words = []
    for i, moves in enumerate(motion.moves.tolist()):
        if found is not None and found.deploys[i]:
            words.append("deploys")
        else:
            words.append("movable" if moves else "locked" if locked[i] else "undecided")
    return words


def seconds_of(foldings: float, n: int) -> float:
    """About how many core seconds the verdicts on foldings of n panels take."""
    return foldings * FOLDING_SECONDS * (n / _PANELS) ** 2


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


def _best(own: Candidates, words: list[str], motion: MotionBatch) -> tuple[list[int], list[str]]:
    """Crease and status of the best folding of each design: by status, least play, lowest dof, lowest crease."""
    rank = {word: place for place, word in enumerate(VERDICTS)}
    places = np.array([rank[word] for word in words], int)
    dof = np.where(own.dof == NONE, np.iinfo(np.int32).max, own.dof)
    order = np.lexsort((own.foldings.crease, dof, np.nan_to_num(motion.margin, nan=np.inf), places, own.foldings.row))
    _, firsts = np.unique(own.foldings.row[order], return_index=True)
    best = order[firsts]
    return own.foldings.crease[best].tolist(), [words[k] for k in best.tolist()]
