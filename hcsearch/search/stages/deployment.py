"""Stage `deployment`: the foldings that springs deploy in a scene without a collision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.records import StagedDesigns
from hcsearch.scenes import Scene
from hcsearch.search.stages import motion
from hcsearch.search.stages.stage import Stage
from hcsearch.springs.deployment import DEPLOYMENT_VERSION


def _run(designs: StagedDesigns, scene: Scene) -> StagedDesigns:
    from hcsearch.springs.deployment.deployment_verdicts import deploy_foldings  # noqa: PLC0415 - its kernels take seconds to load

    assert designs.mobility is not None
    assert designs.motion is not None
    deployments = deploy_foldings(designs.circuits, designs.folded, designs.mobility.locked, designs.motion.met, scene)
    return designs.with_folding_results(deployment=deployments)


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    """Return which designs have a folding that deploys."""
    assert designs.deployment is not None
    return designs.with_folding(designs.deployment.deploys)


STAGE = Stage(
    "deployment",
    DEPLOYMENT_VERSION,
    _run,
    _passed,
    base_stage=motion.STAGE,
    depends_on_scene=True,
    funnel_column="deploys",
)
