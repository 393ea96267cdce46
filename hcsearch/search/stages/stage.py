"""What a stage of the search is: a pure function from designs to the same designs with its own columns."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from hcsearch.basics.array_values import Flags
from hcsearch.basics.vocabulary import Keep
from hcsearch.designs.records import StagedDesigns, StageResult
from hcsearch.scenes import Scene


@dataclass(frozen=True)
class Stage:
    """One stage.

    version : raised when its results change. below : the stage whose results it rests on, where a newer one of these
        makes its own older, too.
    run : designs with the columns of the stages before, and a scene -> designs with its columns as well.
    passed : the same -> which designs pass, shape (n_circuits,).
    in_a_scene : whether results depend on the scene. keep : the word of `--keep` for what passes.
    counts : the column of the funnel that holds how many pass; they : what those do, in words.
    """

    name: str
    version: int
    run: Callable[[StagedDesigns, Scene], StagedDesigns]
    passed: Callable[[StagedDesigns, Scene], Flags]
    below: Stage | None = None
    in_a_scene: bool = False
    keep: Keep | None = None
    counts: str = ""
    they: str = ""

    @property
    def number(self) -> int:
        """The version with those of the stages below, as finished work is stored under it."""
        return self.version if self.below is None else self.version * self.below._scale + self.below.number

    @property
    def _scale(self) -> int:
        return 100 if self.below is None else 100 * self.below._scale


def run_stages(
    designs: StagedDesigns, stages: Iterable[Stage], scene: Scene, keep: str = "all", begun: float | None = None
) -> tuple[StagedDesigns, tuple[StageResult, ...]]:
    """Run stages one after the other; after the one that `keep` names only designs that pass it are kept.

    begun : when the work of the first one began, by `time.perf_counter`; now unless it is given.
    """
    clock = time.perf_counter() if begun is None else begun
    results = []
    for stage in stages:
        designs = stage.run(designs, scene)
        passed = stage.passed(designs, scene)
        now = time.perf_counter()
        results.append((stage, _result(stage, designs, passed, now - clock)))
        clock = now
        if stage.keep == keep and not passed.all():
            designs = designs.take(passed)
    # in a scene a later stage may show that more pass an earlier one: what deploys moves
    counted = [
        _result(stage, designs, stage.passed(designs, scene), result.seconds) if stage.in_a_scene else result
        for stage, result in results
    ]
    return designs, tuple(counted)


def _result(stage: Stage, designs: StagedDesigns, passed: Flags, seconds: float) -> StageResult:
    return StageResult(stage.name, stage.number, int(passed.sum()), int(designs.n_fixed[passed].sum()), seconds)
