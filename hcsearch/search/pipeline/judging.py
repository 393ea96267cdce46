"""Verdicts in a scene, in pieces of a few seconds, and continued search for undecided foldings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

import numpy as np

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import grid_named
from hcsearch.designs.records import CircuitBatch, StagedDesigns, StageResult, Undecided, VerdictBatch
from hcsearch.motion.collision.panel_prisms import check_margin, margin_of
from hcsearch.scenes import Scene, check_verdicts, panel_of
from hcsearch.search.pipeline.shards import verdict_rows
from hcsearch.search.stages.order import stages_until
from hcsearch.search.stages.stage import Stage, run_stages
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

FOLDING_CORE_SECONDS = 0.4
"""Core seconds for the verdict on a folding of `_PANELS` panels, retries included; proportional to the square of the
number of panels (measured: 0.4 s for 12 hexagons, 2.5 s for the 30 squares of 6x5)."""
PIECE_CORE_SECONDS = 4.0
"""Approximate core seconds of a piece."""
_PANELS = 12
_MARK = "#"
_KEY = re.compile(rf"(.*){_MARK}[0-9]{{1,9}}/([0-9]{{1,9}})", re.DOTALL)


@dataclass(frozen=True)
class CandidatePiece:
    """Some candidates of a shard of the search; key : identifies the piece among finished work."""

    key: str
    candidates: StagedDesigns


@dataclass(frozen=True)
class JudgedPiece:
    """The result of a piece: verdicts for the store, and results of the stages."""

    key: str
    verdicts: VerdictBatch
    results: tuple[StageResult, ...]
    foldings: int


@dataclass(frozen=True)
class Judge:
    """Task that judges pieces in a scene by the stages that depend on it; budget : None for the default."""

    scene: Scene
    stages: tuple[Stage, ...]
    budget: int | None = None

    def __call__(self, piece: CandidatePiece) -> JudgedPiece:
        """Judge one piece."""
        candidates = replace(piece.candidates, budget=self.budget)
        designs, results = run_stages(candidates, self.stages, self.scene)
        return JudgedPiece(piece.key, verdict_rows(designs, self.scene), results, len(designs.folded))


def check_scene_of_run(scene: Scene, grid: str, n: int) -> None:
    """Refuse a scene in which foldings of n panels of a grid cannot be judged."""
    check_verdicts(scene, grid, n)
    length, width, thickness = panel_of(scene, grid)
    facet = tuple((length * x, width * y) for x, y in grid_named(grid).corners((0, 0, 0)))
    panel = Linkage(Pattern.from_polygons((facet,), {}, thickness))
    check_margin(panel, margin_of(panel) if scene.margin is None else scene.margin)


def judging_seconds(foldings: float, n: int) -> float:
    """Estimate the core seconds of verdicts on foldings of n panels."""
    return foldings * FOLDING_CORE_SECONDS * (n / _PANELS) ** 2


def candidate_pieces(shard: str, candidates: StagedDesigns) -> Iterator[CandidatePiece]:
    """Divide the candidates of a shard into pieces, which depend on the candidates alone."""
    n, designs = candidates.circuits.words.shape[1], len(candidates.circuits)
    max_foldings = max(1, round(PIECE_CORE_SECONDS / judging_seconds(1.0, n)))
    counts = np.bincount(candidates.folded.row, minlength=designs)
    numbers = np.arange(designs)
    ends: list[int] = []
    pending = 0
    for design, count in enumerate(counts.tolist()):
        if pending and pending + count > max_foldings:
            ends.append(design)
            pending = 0
        pending += count
    bounds = [0, *ends, designs] if designs else []
    for k, (begin, end) in enumerate(pairwise(bounds)):
        yield CandidatePiece(
            f"{shard}{_MARK}{k}/{len(bounds) - 1}", candidates.take((numbers >= begin) & (numbers < end))
        )
    if not designs:
        yield CandidatePiece(f"{shard}{_MARK}0/1", candidates)


def unfinished_shards(shards: Sequence[str], keys: Sequence[str]) -> list[str]:
    """Return the shards with an unfinished piece; keys : the keys of finished work, other keys are ignored."""
    piece_counts: dict[str, tuple[int, int]] = {}
    for key in keys:
        if (piece := _KEY.fullmatch(key)) is not None:
            shard, finished_pieces = piece[1], piece_counts.get(piece[1], (0, 0))[0]
            piece_counts[shard] = (finished_pieces + 1, int(piece[2]))
    return [shard for shard in shards if shard not in piece_counts or piece_counts[shard][0] < piece_counts[shard][1]]


@dataclass(frozen=True)
class SettlingTask:
    """The undecided foldings of one design; key : identifies the task among finished work."""

    key: str
    foldings: tuple[Undecided, ...]


@dataclass(frozen=True)
class Settler:
    """Task that continues the search for undecided foldings in a scene, with a budget."""

    scene: Scene
    stages: tuple[Stage, ...]
    budget: int

    def __call__(self, task: SettlingTask) -> JudgedPiece:
        """Continue the search for the foldings of one design."""
        designs, results = run_stages(self._designs(task.foldings), self.stages, self.scene)
        return JudgedPiece(task.key, verdict_rows(designs, self.scene), results, len(designs.folded))

    def _designs(self, foldings: tuple[Undecided, ...]) -> StagedDesigns:
        """Return the design with these foldings alone, and the efforts already spent on them."""
        circuit = Circuit.from_notation(foldings[0].circuit)
        words, symmetry = np.array([circuit.word], np.int8), np.array([circuit.symmetry], np.int16)
        batch = CircuitBatch(circuit.grid.name, words, symmetry)
        unjudged = StagedDesigns(batch, np.array([circuit.n_fixed]))
        designs, _ = run_stages(unjudged, stages_until("mobility"), self.scene)
        efforts = {folding.crease: folding.efforts for folding in foldings}
        designs = designs.take(np.ones(1, bool), np.isin(designs.folded.crease, sorted(efforts)))
        searched = np.array([efforts[crease] for crease in designs.folded.crease.tolist()])
        return replace(designs, budget=self.budget, searched=searched)


def settling_tasks(foldings: Iterable[Undecided], budget: int) -> Iterator[SettlingTask]:
    """Group undecided foldings, sorted by design, into tasks."""
    for design_id, design_foldings in groupby(foldings, key=lambda folding: folding.design_id):
        yield SettlingTask(f"budget {budget}, design {design_id}", tuple(design_foldings))
