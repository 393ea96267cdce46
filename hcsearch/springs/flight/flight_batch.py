"""Stage `flight`: the figures of a batch of foldings in a scene, each of the motion that decides its status."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from hcsearch.basics.array_values import Flags
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.records import CircuitBatch, DeploymentBatch, FlightNumbers, FoldingBatch, MotionBatch, Trial
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.scene_file import read_scene_text, scene_in
from hcsearch.springs.flight.flight_figures import figures_of
from hcsearch.springs.flight.travel import Travel, travel_along, travel_by_springs


def flight_of_foldings(
    circuits: CircuitBatch,
    foldings: FoldingBatch,
    chosen: Flags,
    motion: MotionBatch,
    deployment: DeploymentBatch,
    scene: Scene,
) -> tuple[FlightNumbers | None, ...]:
    """Return the figures of the chosen foldings of a batch in a scene, None for the others.

    The motion of a folding is its deployment where springs open it, with the springs and joints that do, else its
    proved path.
    """
    batch = [folding_at(circuits, foldings, i) for i in range(len(foldings))]
    deploying = {trial.folding: trial for trial in reversed(deployment.trials) if trial.status == "deploys"}
    return tuple(
        figures_of(_travel(folding, scene, motion, i, deploying.get(i))) if chosen[i] else None
        for i, folding in enumerate(batch)
    )


def _travel(folding: Folding, scene: Scene, motion: MotionBatch, i: int, trial: Trial | None) -> Travel:
    """Return the travel of a folding of the batch by the motion that decides its status."""
    panel = panel_of(scene, folding.circuit.grid.name)
    if trial is not None:
        tried = scene_in(read_scene_text(trial.values, f"the scene {trial.scene!r}"), grid=folding.circuit.grid.name)
        return travel_by_springs(folding.linkage(panel, flat_pairs=trial.pairs), replace(tried, name=trial.scene))
    way = motion.flat_pairs[i]
    if way is None:
        return travel_along(folding.linkage(panel, flat_pairs=scene.flat_pairs[0]), scene)
    return travel_along(folding.linkage(panel, flat_pairs=cast("Way", way)), scene, motion.paths[i])
