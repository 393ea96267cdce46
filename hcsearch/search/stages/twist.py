"""Stage `twist`: the linking number of each folding, which must be 0 to reach the two stacks (thesis 3.3.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.records import StagedDesigns
from hcsearch.designs.twisting import twist_batch
from hcsearch.scenes import Scene
from hcsearch.search.stages.stage import Stage


def _run(designs: StagedDesigns, _scene: Scene) -> StagedDesigns:
    return designs.with_folding_results(twist=twist_batch(designs.circuits, designs.folded))


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Return which designs have an untwisted folding."""
    assert designs.twists is not None
    return designs.with_folding(designs.twists == 0)


STAGE = Stage("twist", 1, _run, _passed, keep="untwisted", funnel_column="untwisted")
