"""Stage `motion`: which foldings have a proved path from packed to flat in a scene, and with how little play."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from hcsearch.flat_pairs import ways
from hcsearch.folding import Folding, folding_at
from hcsearch.planning.motions import Motion, motion_of
from hcsearch.planning.planner import Growth
from hcsearch.planning.proofs import Proof
from hcsearch.records import CircuitBatch, FoldingBatch, MotionBatch
from hcsearch.scenes import Scene, panel_of

Flags = NDArray[np.bool_]
ENDS = ("packed", "flat")


def motions(
    circuits: CircuitBatch,
    foldings: FoldingBatch,
    locked: tuple[Flags, Flags],
    scene: Scene,
    threads: int = 1,
) -> MotionBatch:
    """Motions of a batch of untwisted foldings in a scene.

    locked : (n_foldings,) each, which are proved locked with rigid and with hinged flat pairs: no path is looked for in
        those ways, and none in any where all are locked.
    """
    panel, allowed = panel_of(scene, circuits.grid), ways(scene)

    def run(i: int) -> Motion | None:
        own = [way for way in allowed if not locked[way == "hinged"][i]]
        folding: Folding = folding_at(circuits, foldings, i)
        return motion_of(folding, panel, own, scene.margin) if own else None

    with ThreadPoolExecutor(threads) as pool:  # the kernels leave the interpreter's lock
        found = list(pool.map(run, range(len(foldings))))
    return _batch(found)


def _batch(found: Sequence[Motion | None]) -> MotionBatch:
    """Motions as a struct of arrays."""
    count = len(found)
    margin, gap, slack = np.full(count, np.nan), np.full(count, np.nan), np.full(count, np.nan)
    for i, motion in enumerate(found):
        if motion is not None and motion.proof is not None and motion.margin is not None:
            margin[i], gap[i], slack[i] = motion.margin, -motion.proof.overlap, motion.proof.slack
    return MotionBatch(
        [None if motion is None or motion.margin is None else motion.way for motion in found],
        margin,
        gap,
        slack,
        tuple(None if motion is None else motion.states for motion in found),
        [None if motion is None else reason_of(motion) for motion in found],
    )


def reason_of(motion: Motion) -> str:
    """What is known of a motion, in a sentence."""
    if motion.proof is not None and motion.margin is None:
        return f"the search reached a path with {motion.way} flat pairs that is not proved: {_failed(motion.proof)}"
    if motion.margin is not None:
        play = f"{1e3 * motion.margin:.4g} mm of play on every face"
        return f"a path from packed to flat is proved with {motion.way} flat pairs and {play}"
    if not motion.growths:
        return "no path was searched for: the folding has no mirror pairs of panels to merge"
    return "the search reached no path: " + "; ".join(
        f"{way} flat pairs, {_grown(growth)}" for way, growth in motion.growths
    )


def _failed(proof: Proof) -> str:
    """Why a path is not proved."""
    if proof.motion is None:
        return "no closed states are proved beside all of it, as it passes states that are singular, or nearly so"
    if any(proof.reach):
        away = " and ".join(f"{far:.2g} rad from the {end}" for end, far in zip(ENDS, proof.reach, strict=True) if far)
        return f"its proof ends {away} state"
    if proof.clear is None:
        return "hinges go beyond their stops by more than the play allows"
    one, two = proof.clear.panels or (0, 0)
    return f"panels {one} and {two} come too near with {1e3 * proof.clear.margin:.4g} mm of play on every face"


def _grown(growth: Growth) -> str:
    """What the trees of one search came to."""
    if not all(growth.starts):
        return f"no way out of the {ENDS[growth.starts[0] > 0]} state"
    one, two = growth.sizes
    closed = [end for end, off in zip(ENDS, growth.closed_off, strict=True) if off]
    state = f"closed off at the {' and the '.join(closed)} state" if closed else "still growing"
    return f"trees of {one:,} and {two:,} states {state} after {growth.rounds} rounds, cells {growth.resolution:g} rad"
