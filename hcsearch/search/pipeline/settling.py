"""Foldings that are undecided are searched on with a larger budget, design by design, from where they were left."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.records import CircuitBatch, StagedDesigns, Undecided
from hcsearch.scenes import Scene
from hcsearch.search.pipeline.judging import JudgedPiece
from hcsearch.search.pipeline.rows import verdict_rows
from hcsearch.search.stages.order import stages_until
from hcsearch.search.stages.stage import Stage, run_stages


@dataclass(frozen=True)
class Task:
    """The undecided foldings of one design; key : its own name among finished work."""

    key: str
    foldings: tuple[Undecided, ...]


@dataclass(frozen=True)
class Settler:
    """Verdicts on undecided foldings in a scene, with a budget."""

    scene: Scene
    stages: tuple[Stage, ...]
    budget: int

    def __call__(self, task: Task) -> JudgedPiece:
        """Search on for the foldings of one design."""
        designs, results = run_stages(self._designs(task.foldings), self.stages, self.scene)
        return JudgedPiece(task.key, verdict_rows(designs, self.scene), results, len(designs.folded))

    def _designs(self, foldings: tuple[Undecided, ...]) -> StagedDesigns:
        """The design with these foldings alone, and what was done for them."""
        circuit = Circuit.from_notation(foldings[0].circuit)
        words, symmetry = np.array([circuit.word], np.int8), np.array([circuit.symmetry], np.int16)
        batch = CircuitBatch(circuit.grid.name, words, symmetry)
        begun = StagedDesigns(batch, np.array([circuit.n_fixed]))
        designs, _ = run_stages(begun, stages_until("mobility"), self.scene)
        efforts = {one.crease: one.efforts for one in foldings}
        designs = designs.take(np.ones(1, bool), np.isin(designs.folded.crease, sorted(efforts)))
        searched = np.array([efforts[crease] for crease in designs.folded.crease.tolist()])
        return replace(designs, budget=self.budget, searched=searched)


def tasks(foldings: Iterable[Undecided], budget: int) -> Iterator[Task]:
    """The tasks of some foldings, which come design by design."""
    for number, own in groupby(foldings, key=lambda one: one.design_id):
        yield Task(f"budget {budget}, design {number}", tuple(own))
