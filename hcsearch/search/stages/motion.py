"""Stage `motion`: which untwisted foldings have a proved path from packed to flat, and with how much play."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Flags
from hcsearch.designs.folding import folding_at, representatives
from hcsearch.designs.records import (
    CircuitBatch,
    Evidence,
    FoldingBatch,
    Integers,
    MotionBatch,
    StagedDesigns,
    StoredLock,
)
from hcsearch.motion.planning.motion_search import PlannedMotion, motion_from_twin, plan_motion, reason_of
from hcsearch.motion.planning.schedule import DEFAULT_EFFORT_BUDGET
from hcsearch.scenes import Scene, panel_of
from hcsearch.search.stages import mobility
from hcsearch.search.stages.stage import Stage


def motions_of_batch(
    circuits: CircuitBatch,
    foldings: FoldingBatch,
    locked: tuple[Flags, Flags],
    scene: Scene,
    threads: int = 1,
    *,
    budget: int | None = None,
    searched: Integers | None = None,
) -> MotionBatch:
    """Motions of a batch of untwisted foldings in a scene.

    locked : (n_foldings,) each, which are proved locked with rigid and with hinged flat pairs: no path is searched for
        with those, and none at all where both are.
    budget : efforts for each folding, None for the usual ones; searched : (n_foldings,), how many were made before.
    One of congruent foldings is looked at, and its motion carried over to the others.
    """
    efforts = DEFAULT_EFFORT_BUDGET if budget is None else budget
    panel, allowed = panel_of(scene, circuits.grid), scene.flat_pairs
    own = [folding_at(circuits, foldings, i) for i in range(len(foldings))]
    standing = representatives(own, foldings.row.tolist(), panel)

    def run(i: int) -> PlannedMotion | None:
        free = [way for way in allowed if not locked[way == "hinged"][i]]
        done = 0 if searched is None else int(searched[i])
        return plan_motion(own[i], panel, free, scene.margin, budget=efforts, done=done) if free else None

    judged = sorted(set(standing))
    with ThreadPoolExecutor(threads) as pool:  # the kernels leave the interpreter's lock
        known = dict(zip(judged, pool.map(run, judged), strict=True))
    planned = [
        motion if motion is None or i == first else motion_from_twin(motion, own[i], panel)
        for i, first in enumerate(standing)
        for motion in (known[first],)
    ]
    return _batch(planned, [None if i == first else own[first].crease for i, first in enumerate(standing)])


def _batch(planned: Sequence[PlannedMotion | None], like: list[int | None]) -> MotionBatch:
    """Motions as a struct of arrays."""
    count = len(planned)
    margin, gap, slack = np.full(count, np.nan), np.full(count, np.nan), np.full(count, np.nan)
    for i, motion in enumerate(planned):
        if motion is not None and motion.proof is not None and motion.margin is not None:
            margin[i], gap[i], slack[i] = motion.margin, -motion.proof.overlap, motion.proof.slack
    return MotionBatch(
        [None if motion is None or motion.margin is None else motion.way for motion in planned],
        margin,
        gap,
        slack,
        tuple(None if motion is None else motion.states for motion in planned),
        [None if motion is None else reason_of(motion) for motion in planned],
        like,
        [None if motion is None else _evidence(motion) for motion in planned],
    )


def _evidence(motion: PlannedMotion) -> Evidence:
    """What the search for a motion came to, beside its path."""
    critical, lock = motion.critical, None
    if motion.lock is not None:
        way, enclosure = motion.lock
        assert enclosure.end is not None
        lock = StoredLock(way, motion.locked, enclosure.end, enclosure.cubes, enclosure.faces, enclosure.margin)
    if critical is None:
        return Evidence(motion.efforts, lock, motion.margin)
    least = critical.least_proved if motion.margin is None else motion.margin
    return Evidence(motion.efforts, lock, least, critical.greatest_unmet)


def _run(designs: StagedDesigns, scene: Scene) -> StagedDesigns:
    """Locks of the scene's panels, and the motions of what these leave free."""
    circuits, foldings, known = designs.circuits, designs.folded, designs.mobility
    assert known is not None
    locks = known.locked, known.locked_hinged
    locks = mobility.locks_with_panel(circuits, foldings, locks, panel_of(scene, circuits.grid))
    return replace(
        designs,
        mobility=replace(known, locked=locks[0], locked_hinged=locks[1]),
        motion=motions_of_batch(circuits, foldings, locks, scene, budget=designs.budget, searched=designs.searched),
    )


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Designs of which a folding has a proved path, or deploys: what springs bring flat moves."""
    assert designs.motion is not None
    moves = designs.motion.moves
    return designs.with_folding(moves if designs.deployment is None else moves | designs.deployment.deploys)


STAGE = Stage("motion", 6, _run, _passed, below=mobility.STAGE, in_a_scene=True, counts="movable", they="move")
