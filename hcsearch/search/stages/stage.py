"""Stages of the search: pure functions from designs to the same designs with additional columns."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from hcsearch.basics.array_values import Flags
from hcsearch.basics.vocabulary import Keep
from hcsearch.designs.records import StagedDesigns, StageResult
from hcsearch.scenes import Scene
from hcsearch.system.work_steps import work_step


@dataclass(frozen=True)
class Stage:
    """One stage.

    version : raised when its results change. base_stage : stage on whose results it depends, so that a newer version of
        that stage makes its own results outdated, too.
    run : (designs with the columns of earlier stages, scene) -> designs with its columns added.
    passed : (the same designs, scene) -> which designs pass, shape (n_circuits,).
    depends_on_scene : whether results depend on the scene. keep : value of `--keep` for designs that pass.
    funnel_column : column of the funnel with the count that pass.
    """

    name: str
    version: int
    run: Callable[[StagedDesigns, Scene], StagedDesigns]
    passed: Callable[[StagedDesigns, Scene], Flags]
    base_stage: Stage | None = None
    depends_on_scene: bool = False
    keep: Keep | None = None
    funnel_column: str = ""

    @property
    def stored_version(self) -> int:
        """The version combined with the versions of its base stages, under which finished work is stored."""
        return (
            self.version
            if self.base_stage is None
            else self.version * self.base_stage._scale + self.base_stage.stored_version
        )

    @property
    def _scale(self) -> int:
        return 100 if self.base_stage is None else 100 * self.base_stage._scale


def run_stages(
    designs: StagedDesigns, stages: Iterable[Stage], scene: Scene, keep: str = "all", start_time: float | None = None
) -> tuple[StagedDesigns, tuple[StageResult, ...]]:
    """Run stages in sequence, and drop designs that do not pass the stage of `keep`.

    start_time : of the first stage, by `time.perf_counter`; now unless given.
    """
    clock = time.perf_counter() if start_time is None else start_time
    results = []
    for stage in stages:
        with work_step(stage.name) as step:
            designs = stage.run(designs, scene)
            if stage.depends_on_scene:
                step.advance(len(designs.folded) - step.done)
        passed = stage.passed(designs, scene)
        now = time.perf_counter()
        results.append((stage, _result(stage, designs, passed, now - clock)))
        clock = now
        if stage.keep == keep and not passed.all():
            designs = designs.take(passed)
    # a later stage may show that more designs pass an earlier one in the scene: a folding that deploys moves
    counted = [
        _result(stage, designs, stage.passed(designs, scene), result.seconds) if stage.depends_on_scene else result
        for stage, result in results
    ]
    return designs, tuple(counted)


def _result(stage: Stage, designs: StagedDesigns, passed: Flags, seconds: float) -> StageResult:
    return StageResult(stage.name, stage.stored_version, int(passed.sum()), int(designs.n_fixed[passed].sum()), seconds)
