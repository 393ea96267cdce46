"""Stage `flight`: the figures of a batch of foldings in a scene, each of the motion that decides its status."""

from __future__ import annotations

from dataclasses import replace

from hcsearch.basics.array_values import Flags
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.records import CircuitBatch, DeploymentBatch, FlightNumbers, FoldingBatch, MotionBatch, Trial
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import read_scene_text, scene_in
from hcsearch.springs.flight.figures import figures_of
from hcsearch.springs.flight.travel import Travel, still_travel, travel_along_path, travel_by_springs


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
    if trial is not None:
        tried = scene_in(read_scene_text(trial.values, f"the scene {trial.scene!r}"), grid=folding.circuit.grid.name)
        return travel_by_springs(folding, replace(tried, name=trial.scene), trial.pairs)
    way, states = motion.flat_pairs[i], motion.paths[i]
    if way is not None and states is not None and motion.moves[i]:
        return travel_along_path(folding, scene, way, states)  # type: ignore[arg-type]
    return still_travel(folding, scene, scene.flat_pairs[0])
