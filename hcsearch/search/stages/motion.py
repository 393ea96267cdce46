"""Stage `motion`: certified paths of untwisted foldings from packed to flat, in a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.records import StagedDesigns
from hcsearch.scenes import Scene, panel_of
from hcsearch.search.stages import mobility
from hcsearch.search.stages.stage import Stage


def _run(designs: StagedDesigns, scene: Scene) -> StagedDesigns:
    """Locks of the scene's panels, and the motions of what these leave free."""
    from hcsearch.search.stages.motion_batches import motions  # noqa: PLC0415 - its kernels take seconds to load

    circuits, foldings, known = designs.circuits, designs.folded, designs.mobility
    assert known is not None
    locks = known.locked, known.locked_hinged
    locks = mobility.locks_of(circuits, foldings, locks, panel_of(scene, circuits.grid))
    return replace(
        designs,
        mobility=replace(known, locked=locks[0], locked_hinged=locks[1]),
        motion=motions(circuits, foldings, locks, scene, budget=designs.budget, searched=designs.searched),
    )


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Designs of which a folding has a proved path, or deploys: what springs bring flat moves."""
    assert designs.motion is not None
    moves = designs.motion.moves
    return designs.with_folding(moves if designs.deployment is None else moves | designs.deployment.deploys)


STAGE = Stage("motion", 6, _run, _passed, below=mobility.STAGE, in_a_scene=True, counts="movable", they="move")
