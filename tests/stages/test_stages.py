"""The stages and their order: what runs, what passes, and under which numbers finished work is stored."""

import numpy as np
import pytest

from hcsearch.basics.errors import StageError
from hcsearch.basics.vocabulary import KEEPS
from hcsearch.designs.grid import GRIDS
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline.shards import run_shard
from hcsearch.search.stages.circuits import list_shard_circuits
from hcsearch.search.stages.order import STAGES, check_keep, stage_keeping, stage_numbers, stages_until
from hcsearch.search.stages.stage import Stage, run_stages

SCENE = SCENES[DEFAULT_SCENE_NAME]


def test_a_number_holds_the_versions_of_the_stages_below():
    low = Stage("low", 4, lambda designs, _: designs, lambda designs, _: np.ones(len(designs), bool))
    middle = Stage("middle", 3, low.run, low.passed, base_stage=low)
    assert (
        low.stored_version,
        middle.stored_version,
        Stage("high", 2, low.run, low.passed, base_stage=middle).stored_version,
    ) == (
        4,
        304,
        20304,
    )
    known = stage_numbers(stages_until("deployment"))
    assert list(known) == ["circuits", "foldings", "twist", "mobility", "motion", "deployment"]
    assert known["motion"] == 100 * STAGES["motion"].version + known["mobility"]
    assert known["deployment"] == 10_000 * STAGES["deployment"].version + known["motion"]


def test_each_word_of_keep_names_a_stage_that_depends_on_no_scene():
    for keep in KEEPS:
        stage = stage_keeping(keep)
        assert not stage.depends_on_scene
        check_keep(keep, stage.name)
    with pytest.raises(StageError, match="use --until twist"):
        check_keep("untwisted", "foldings")
    with pytest.raises(StageError, match="stage 'flights' is unknown"):
        stages_until("flights")


@pytest.mark.parametrize("keep", KEEPS)
def test_what_is_dropped_on_the_way_changes_nothing_for_the_rest(keep):
    search = PolygonSearch(GRIDS["hex"], 10)
    (prefix,) = search.prefixes
    stages = stages_until("mobility")
    every, whole = run_stages(list_shard_circuits(search, prefix), stages, SCENE)
    kept, results = run_shard(search, prefix, stages, keep)
    assert [(one.stage, one.passed, one.n_fixed) for one in results] == [
        (one.stage, one.passed, one.n_fixed) for one in whole
    ]
    passes = stage_keeping(keep).passed(every, SCENE)
    again = every.take(passes)
    for column in ("words", "symmetry"):
        assert (getattr(kept.circuits, column) == getattr(again.circuits, column)).all()
    assert (kept.foldings.row == again.foldings.row).all()
    assert (kept.foldings.crease == again.foldings.crease).all()
    assert (kept.twists == again.twists).all()
    for column in ("dof", "locked", "locked_hinged", "merged_panels"):
        assert (getattr(kept.mobility, column) == getattr(again.mobility, column)).all()
