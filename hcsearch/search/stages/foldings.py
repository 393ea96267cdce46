"""Stage `foldings`: the two-stack foldings of each circuit (thesis 3.2.1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.folding import fold
from hcsearch.designs.records import StagedDesigns
from hcsearch.scenes import Scene
from hcsearch.search.stages.stage import Stage


def _run(designs: StagedDesigns, _scene: Scene) -> StagedDesigns:
    return replace(designs, foldings=fold(designs.circuits))


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Return which circuits fold."""
    return designs.with_folding(np.ones(len(designs.folded), bool))


STAGE = Stage("foldings", 1, _run, _passed, keep="two-stack", funnel_column="two_stack")
