"""All stages for a single circuit, with a verdict on each of its foldings in a scene."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from hcsearch.basics.vocabulary import Status, counted, millimetres, play_sentence
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, no_folding_reason, representatives
from hcsearch.designs.panel_sizes import panel_text
from hcsearch.designs.records import CircuitBatch, StagedDesigns, play_of_batch
from hcsearch.motion.planning.problems import check_memory
from hcsearch.scenes import Scene, check_verdicts, panel_of
from hcsearch.search.own_patterns.checked import Checked, through_stages
from hcsearch.search.stages.order import STAGES
from hcsearch.search.stages.stage import run_stages
from hcsearch.search.stages.statuses import folding_statuses
from hcsearch.system.work_steps import Progress


@dataclass(frozen=True)
class FoldingVerdict:
    """The verdict on one folding.

    twist : |Lk|. dof, kutzbach : freedoms with hinged flat pairs; dof is None where it is undecided or the folding is
    twisted. status : None where it is twisted. reason : a sentence. scene : name of a scene in which springs deploy it,
    for `hcsearch deploy`; None without one. needed_margin, least_gap : m, of the motion behind the status, as in
    `records.play_of_batch`; None without one.
    """

    folding: Folding
    twist: int
    dof: int | None
    kutzbach: int
    status: Status | None
    reason: str
    scene: str | None = None
    needed_margin: float | None = None
    least_gap: float | None = None

    @property
    def status_word(self) -> str:
        """The status, or that the folding is twisted."""
        return self.status or "twisted"

    @property
    def heading(self) -> str:
        """The folding, its status and its freedoms."""
        freedoms = "" if self.dof is None else f", {counted(self.dof, 'degree')} of freedom (Kutzbach {self.kutzbach})"
        return f"{self.folding.notation}: {self.status_word}{freedoms}"

    @property
    def reasons(self) -> list[str]:
        """The reason for the status."""
        return [self.reason]

    @property
    def play(self) -> str | None:
        """The play that the motion needs, as a sentence."""
        return play_sentence(millimetres(self.needed_margin))

    @property
    def deployed_in(self) -> list[tuple[str, str]]:
        """The folding and the scene in which springs deploy it."""
        return [] if self.scene is None else [(self.folding.notation, self.scene)]

    def facts(self) -> dict[str, Any]:
        """All results as plain data; keys name their units."""
        return {
            "folding": self.folding.notation,
            "status": self.status_word,
            "twist": self.twist,
            "dof": self.dof,
            "kutzbach": self.kutzbach,
            "reason": self.reason,
            "needed_margin_mm": millimetres(self.needed_margin),
            "least_gap_mm": millimetres(self.least_gap),
            "play": self.play,
            "deploys_in": self.scene,
        }


def check_circuit(
    circuit: Circuit,
    scene: Scene,
    creases: Collection[int] | None = None,
    progress: Progress = lambda _done, _total, _stage: None,
) -> Checked:
    """Take a circuit through every stage in a scene.

    circuit : in any position, order and direction. creases : of the foldings to check, in its canonical order; all
    unless given. progress : called with the numbers of untwisted foldings done and in all, and the stage of the next
    one. SceneError where the grid's designs cannot be judged in the scene, SizeError where that would take more memory
    than `check_memory` allows.
    """
    check_memory(circuit.n)
    circuit = circuit.canonical()
    check_verdicts(scene, circuit.grid.name, circuit.n)
    word = np.array([circuit.word], np.int8)
    batch = CircuitBatch(circuit.grid.name, word, np.array([circuit.symmetry], np.int16))
    designs = StagedDesigns(batch, np.array([circuit.n_fixed]))
    first = [STAGES[name] for name in ("circuits", "foldings")]
    designs, _ = run_stages(designs, first, scene)
    two_stack = len(designs.folded)
    if creases is not None:
        chosen = np.isin(designs.folded.crease, sorted(creases))
        designs = designs.take(np.ones(1, bool), chosen)
    designs, _ = run_stages(designs, [STAGES["twist"]], scene)
    assert designs.twists is not None
    untwisted = designs.twists == 0
    verdicts = {
        int(crease): _twisted(Folding(circuit, int(crease)), int(linking_number))
        for crease, linking_number in zip(designs.folded.crease, designs.twists, strict=True)
        if linking_number
    }
    untwisted_rows = np.flatnonzero(untwisted)
    known = [Folding(circuit, int(designs.folded.crease[place])) for place in untwisted_rows]
    representative_of = np.array(representatives(known, [0] * len(known), panel_of(scene, circuit.grid.name)), int)
    done = 0
    for first in np.unique(representative_of):  # congruent foldings are judged together
        congruent = untwisted_rows[representative_of == first]
        class_designs = through_stages(
            designs.take(np.ones(1, bool), np.isin(np.arange(len(untwisted)), congruent)),
            lambda name, judged: run_stages(judged, [STAGES[name]], scene)[0],
            partial(progress, done, len(untwisted_rows)),
        )
        verdicts |= {verdict.folding.crease: verdict for verdict in _judged(circuit, class_designs, scene)}
        done += len(congruent)
    return _checked(circuit, scene, two_stack, tuple(verdicts[crease] for crease in sorted(verdicts)))


def _checked(circuit: Circuit, scene: Scene, two_stack: int, verdicts: tuple[FoldingVerdict, ...]) -> Checked:
    """Return the verdicts on foldings of a circuit, with how many foldings pass each stage."""
    statuses = [verdict.status for verdict in verdicts]
    funnel = {
        "two-stack foldings": two_stack,
        "checked": len(statuses),
        "untwisted": sum(status is not None for status in statuses),
        "not locked": sum(status not in (None, "locked") for status in statuses),
        "movable": sum(status in ("deploys", "movable") for status in statuses),
        "deployed by springs": statuses.count("deploys"),
    }
    array, panel = circuit.array.canonical().notation, panel_text(panel_of(scene, circuit.grid.name))
    facts = {
        "circuit": circuit.notation,
        "array": array,
        "panels": circuit.n,
        "panel_mm": panel,
        "scene": scene.name,
        "funnel": funnel,
        "foldings": [verdict.facts() for verdict in verdicts],
    }
    heads = [
        f"{circuit.notation}, array {array}",
        f"  {circuit.n} panels of {panel} mm, scene {scene.name}",
        *(f"  {label:24}{count:>6}" for label, count in funnel.items()),
    ]
    fault = "" if two_stack else f"nothing folds: {no_folding_reason(circuit.n)}"
    return Checked(scene, facts, heads, verdicts, funnel, fault)


def _twisted(folding: Folding, linking_number: int) -> FoldingVerdict:
    """Return the verdict on a twisted folding, which later stages skip."""
    n = folding.circuit.n
    reason = f"twisted, with linking number {linking_number}: no motion leads from packed to flat"
    return FoldingVerdict(folding, linking_number, dof=None, kutzbach=6 * (n - 1) - 5 * n, status=None, reason=reason)


def _judged(circuit: Circuit, designs: StagedDesigns, scene: Scene) -> list[FoldingVerdict]:
    """Return the verdicts on untwisted foldings after all stages."""
    mobility, motion, deployment = designs.mobility, designs.motion, designs.deployment
    assert mobility is not None
    assert motion is not None
    assert deployment is not None
    trials = {trial.folding: trial for trial in deployment.trials if trial.status == "deploys"}
    first = {trial.folding: trial for trial in reversed(deployment.trials)}
    margins, gaps = (column.tolist() for column in play_of_batch(motion, deployment))
    verdicts = []
    for i, status in enumerate(folding_statuses(designs, scene)):
        assert status is not None
        dof = int(mobility.dof[i])
        reason, path = "", motion.reason[i]
        if status == "deploys":
            reason = trials[i].reason
        elif status == "locked":
            at_end = "one-sided hinges hold an end of the motion, however flat pairs may be joined: see hcsearch show"
            reason = path or at_end
        else:
            # no scene with rigid pairs is tried where these are locked
            hinged = "no set that was tried with hinged flat pairs brings it flat" if motion.met[i] else ""
            tried = first[i].reason if i in first else hinged
            reason = f"{path}; springs: {tried}" if tried else f"{path}"
        verdicts.append(
            FoldingVerdict(
                Folding(circuit, int(designs.folded.crease[i])),
                0,
                dof if dof >= 0 else None,
                mobility.kutzbach,
                status,
                reason,
                trials[i].scene if status == "deploys" else None,
                None if math.isnan(margins[i]) else margins[i],
                None if math.isnan(gaps[i]) else gaps[i],
            )
        )
    return verdicts
