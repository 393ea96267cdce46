"""Stage `flight`: the figures for a review of space mechanisms, for each folding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.records import StagedDesigns
from hcsearch.scenes import Scene
from hcsearch.search.stages import deployment
from hcsearch.search.stages.stage import Stage
from hcsearch.search.stages.statuses import folding_statuses


def _run(designs: StagedDesigns, scene: Scene) -> StagedDesigns:
    from hcsearch.springs.flight.flight_figures import flight_of_foldings  # noqa: PLC0415 - loads slowly

    assert designs.motion is not None
    assert designs.deployment is not None
    movable = np.array([status != "locked" for status in folding_statuses(designs, scene)], bool)
    numbers = flight_of_foldings(designs.circuits, designs.folded, movable, designs.motion, designs.deployment, scene)
    return designs.with_folding_results(flight=numbers)


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Return which designs have a folding that moves, as its figures are about its travel."""
    assert designs.motion is not None
    assert designs.deployment is not None
    return designs.with_folding(designs.motion.moves | designs.deployment.deploys)


STAGE = Stage("flight", 3, _run, _passed, base_stage=deployment.STAGE, depends_on_scene=True)
