"""Verdicts of the stages `motion` and `deployment` that nobody ran, recorded as these record them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcsearch.designs.records import (
    DeploymentBatch,
    FlightNumbers,
    MotionBatch,
    StageResult,
    Trial,
    VerdictBatch,
    WorkKey,
)
from hcsearch.store import Database, record_scene, record_verdicts, start_run

WORK = WorkKey("hex", 12, "", "all")
Judged = tuple[str, int, str, float | None, float | None]
"""Circuit, crease, status, smallest gap (mm) and time (s) of a folding."""


def verdicts_of(judged: Sequence[Judged], trials: Sequence[Trial] = ()) -> VerdictBatch:
    """A batch of verdicts; the first folding of a circuit is its best one."""
    circuits = list(dict.fromkeys(circuit for circuit, *_ in judged))
    best = {circuit: (crease, status) for circuit, crease, status, *_ in reversed(judged)}
    statuses = [status for _, _, status, _, _ in judged]
    moves = [status in ("deploys", "movable") for status in statuses]
    margin = np.where(moves, 1e-5, math.nan)
    hinges = [max(2, len(circuit.partition(":")[2]) - 2) for circuit, *_ in judged]
    paths = tuple(np.outer([math.pi, 0.0], np.ones(k)) if move else None for k, move in zip(hinges, moves, strict=True))
    reasons = [None if status == "locked" else f"a reason for {status}" for status in statuses]
    ways = ["rigid" if move else None for move in moves]
    motion = MotionBatch(ways, margin, -0.5 * margin, 1e-3 * margin, paths, reasons)
    deployments = DeploymentBatch(
        np.array([math.nan if gap is None else 1e-3 * gap for *_, gap, _ in judged]),
        np.array([math.nan if time is None else time for *_, time in judged]),
        np.where([status == "deploys" for status in statuses], 1e-5, math.nan),
        np.where([status == "deploys" for status in statuses], -5e-6, math.nan),
        tuple(trials),
    )
    return VerdictBatch(
        circuits,
        [best[circuit][0] for circuit in circuits],
        [best[circuit][1] for circuit in circuits],
        np.array([circuits.index(circuit) for circuit, *_ in judged], int),
        np.array([crease for _, crease, *_ in judged], int),
        statuses,
        of_foldings={"motion": motion, "deployment": deployments},
    )


def judge(
    database: Database,
    judged: Sequence[Judged],
    scene: str = "default",
    trials: Sequence[Trial] = (),
    flight: Sequence[FlightNumbers | None] | None = None,
    *,
    work: WorkKey = WORK,
    key: str = "p#0/1",
) -> None:
    """Record verdicts in a scene as a run of its own."""
    record_scene(database, scene, "" if scene == "default" else f'name = "{scene}"\n')
    run_id = start_run(database, work=work, until="deployment", panel=None, arguments={"scene": scene}, versions={})
    verdicts = verdicts_of(judged, trials)
    if flight is not None:
        verdicts = verdicts.with_folding_results(flight=tuple(flight))
    deploying = verdicts.status.count("deploys")
    passed = {"motion": deploying + verdicts.status.count("movable"), "deployment": deploying}
    results = [StageResult(stage, 1, count, count, 0.5) for stage, count in passed.items()]
    record_verdicts(database, run_id, replace(work, scene=scene), key, verdicts, results)
