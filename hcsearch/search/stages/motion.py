"""Stage `motion`: the untwisted foldings with a proved path from packed to flat, and the play that it needs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

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
from hcsearch.motion.planning.schedule import DEFAULT_EFFORT_BUDGET
from hcsearch.scenes import Scene, panel_of
from hcsearch.search.stages import mobility
from hcsearch.search.stages.stage import Stage
from hcsearch.system.work_steps import step_of_thread

if TYPE_CHECKING:
    from hcsearch.motion.planning.motion_search import PlannedMotion


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
    """Search for motions of a batch of untwisted foldings in a scene.

    locked : (n_foldings,) each, which are proved locked with rigid and with hinged flat pairs; no path is searched for
        with locked pairs.
    budget : efforts for each folding, None for the default. searched : (n_foldings,), efforts already made.
    Only one of several congruent foldings is searched, and its motion is transferred to the others.
    """
    from hcsearch.motion.planning.motion_search import motion_from_twin, plan_motion  # noqa: PLC0415 - loads slowly

    efforts = DEFAULT_EFFORT_BUDGET if budget is None else budget
    panel, allowed = panel_of(scene, circuits.grid), scene.flat_pairs
    batch_foldings = [folding_at(circuits, foldings, i) for i in range(len(foldings))]
    representative_of = representatives(batch_foldings, foldings.row.tolist(), panel)

    step, members = step_of_thread(), Counter(representative_of)

    def run(i: int) -> PlannedMotion | None:
        unlocked = [flat_pairs for flat_pairs in allowed if not locked[flat_pairs == "hinged"][i]]
        done = 0 if searched is None else int(searched[i])
        planned = (
            plan_motion(batch_foldings[i], panel, unlocked, scene.margin, budget=efforts, done=done)
            if unlocked
            else None
        )
        step.advance(members[i])
        return planned

    searched_foldings = sorted(set(representative_of))
    with ThreadPoolExecutor(threads) as pool:  # kernels release the GIL
        motion_of = dict(zip(searched_foldings, pool.map(run, searched_foldings), strict=True))
    planned = [
        motion if motion is None or i == first else motion_from_twin(motion, batch_foldings[i], panel)
        for i, first in enumerate(representative_of)
        for motion in (motion_of[first],)
    ]
    return _batch(
        planned, [None if i == first else batch_foldings[first].crease for i, first in enumerate(representative_of)]
    )


def _batch(planned: Sequence[PlannedMotion | None], congruent_crease: list[int | None]) -> MotionBatch:
    """Convert planned motions to a struct of arrays."""
    from hcsearch.motion.planning.motion_search import reason_of  # noqa: PLC0415 - loads slowly

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
        congruent_crease,
        [None if motion is None else _evidence(motion) for motion in planned],
    )


def _evidence(motion: PlannedMotion) -> Evidence:
    """Return the results of a search for a motion other than its path."""
    critical, lock = motion.critical, None
    if motion.lock is not None:
        flat_pairs, enclosure = motion.lock
        assert enclosure.end is not None
        lock = StoredLock(flat_pairs, motion.locked, enclosure.end, enclosure.cubes, enclosure.faces, enclosure.margin)
    if critical is None:
        return Evidence(motion.efforts, lock, motion.margin)
    least = critical.least_proved if motion.margin is None else motion.margin
    return Evidence(motion.efforts, lock, least, critical.greatest_unmet)


def _run(designs: StagedDesigns, scene: Scene) -> StagedDesigns:
    """Check locks with the scene's panels, and search for motions of the foldings that are not locked."""
    circuits, foldings, known = designs.circuits, designs.folded, designs.mobility
    assert known is not None
    locks = known.locked, known.locked_hinged
    locks = mobility.locks_with_panel(circuits, foldings, locks, panel_of(scene, circuits.grid))
    return designs.with_folding_results(
        mobility=replace(known, locked=locks[0], locked_hinged=locks[1]),
        motion=motions_of_batch(circuits, foldings, locks, scene, budget=designs.budget, searched=designs.searched),
    )


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Return which designs have a folding with a proved path, or one that deploys and therefore moves."""
    assert designs.motion is not None
    moves = designs.motion.moves
    return designs.with_folding(moves if designs.deployment is None else moves | designs.deployment.deploys)


STAGE = Stage(
    "motion",
    6,
    _run,
    _passed,
    base_stage=mobility.STAGE,
    depends_on_scene=True,
    funnel_column="movable",
)
