"""Verdicts of the stage `deployment` in the database: in scenes of their own, kept beside other stages, made anew."""

from dataclasses import replace

import numpy as np
import pytest
from store_samples import begin, record, sample

from hcsearch.errors import DatabaseError, SceneError
from hcsearch.records import NONE, MobilityBatch, StageResult, Trial, Work
from hcsearch.store import (
    find_design,
    find_scene,
    finished_batches,
    open_database,
    record_batches,
    record_scene,
    record_verdicts,
    save_scores,
    scene_names,
    schema,
    select,
)
from tests.judging import judge, verdicts_of

NAMES = ("hex:a", "hex:b", "hex:c")
WORK = Work("hex", 12, "", "all")
RESULT = StageResult("deployment", 1, 1, 1, 0.5)


def mobility(locked=False):
    numbers = {
        name: np.full(4, value)
        for name, value in (("dof", 6), ("dof_folded", 7), ("dof_flat", 6), ("merged_panels", 0))
    }
    none = {name: np.full(4, NONE) for name in ("kutzbach_merged", "dof_merged")}
    return MobilityBatch(kutzbach=6, **numbers, **none, locked=np.array([False] * 3 + [locked]))


def trial(scene, status, clearance=None, time=None, contact=None, folding=0):
    return Trial(folding, scene, "{}", "constrained", status, "so it was", clearance, contact, time, 1e-7, 2e-9)


def list_designs(database, *, locked=False):
    """The sample with the stage `mobility`; the third design has one untwisted folding."""
    word = "locked" if locked else "undecided"
    designs = replace(
        sample(NAMES),
        mobility=mobility(locked),
        best_crease=np.array([-1, -1, 3]),
        folding_status=[None, None, None, word],
        status=[None, None, word],
    )
    record_batches(database, begin(database, WORK), WORK, [("p", designs, [])])


COLLIDES = trial("default", "collides", contact=0.25)
DEPLOYS = trial("hinged", "deploys", clearance=1.5e-3, time=0.5)
FLAT = ("hex:c", 3, "deploys", 1.5, 0.5)
CUT = ("hex:c", 3, "collides", None, None)


def told(database, scene="default"):
    """What both views say of the third design; they must agree."""
    names = "status,deployable,min_clearance,deploy_time"
    (row,) = select(database, "untwisted", columns=names, scene=scene).rows
    assert select(database, "crease=3", columns=names, view="foldings", scene=scene).rows == (row,)
    return list(row)


def everything(database):
    """The rows of all tables, but for those that say who worked when."""
    found = {}
    with database.reading() as connection:
        for name, table in schema.metadata.tables.items():
            columns = [column for column in table.c if column.name != "run_id"]
            if name != "run":
                found[name] = sorted(map(repr, connection.execute(table.select().with_only_columns(*columns))))
    return found


@pytest.fixture
def listed(database):
    list_designs(database)
    return database


def test_a_verdict_is_stored_with_its_deployments(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    assert told(listed) == ["deploys", 1, 1.5, 0.5]
    rows = select(listed, view="deployments", columns="crease,scene,status,clearance,first_contact,deploy_time").rows
    assert rows == ((3, "default", "collides", None, 0.25, None), (3, "hinged", "deploys", 1.5, None, 0.5))
    errors = select(listed, view="deployments", columns="base,energy_error,closure_error", limit=1).rows
    assert errors == (("default", 1e-7, pytest.approx(2e-6)),)
    assert [row["scene"] for row in find_design(listed, "hex:c")["deployments"]] == ["default", "hinged"]
    shown = select(listed, columns="circuit,status,deployable").rows
    assert shown == (("hex:a", "no_folding", 0), ("hex:b", "twisted", 0), ("hex:c", "deploys", 1))


@pytest.mark.parametrize("status", ["deploys", "collides"])
def test_a_later_run_of_earlier_stages_leaves_the_verdicts(listed, status):
    judge(listed, [FLAT if status == "deploys" else CUT], trials=[COLLIDES])
    judge(listed, [CUT], "solar", [trial("solar", "collides")])
    before = everything(listed), told(listed), told(listed, "solar")
    list_designs(listed)
    assert (everything(listed), told(listed), told(listed, "solar")) == before


def test_a_proof_of_a_lock_takes_the_place_of_a_verdict_with_the_next_one(listed):
    """A newer stage `mobility` makes the batches of the stage `deployment` older, so that the next run does both."""
    judge(listed, [CUT], trials=[COLLIDES])
    list_designs(listed, locked=True)
    assert told(listed)[:2] == [CUT[2], None]
    judge(listed, [(*CUT[:2], "locked", None, None)])
    assert told(listed)[:2] == ["locked", 0]


def test_what_deploys_with_hinged_pairs_may_be_locked_with_rigid_ones(database):
    list_designs(database, locked=True)
    assert told(database) == ["locked", 0, None, None]
    judge(database, [FLAT], trials=[DEPLOYS])
    assert told(database) == ["deploys", 1, 1.5, 0.5]


def test_newer_deployments_take_the_place_of_older_ones_of_their_scene_alone(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [FLAT], "solar", [trial("solar", "collides"), replace(DEPLOYS, scene="solar, hinged")])
    judge(listed, [("hex:c", 3, "undecided", None, None)], trials=[replace(COLLIDES, status="undecided")])
    assert told(listed) == ["undecided", None, None, None]
    assert told(listed, "solar") == ["deploys", 1, 1.5, 0.5]
    rows = select(listed, view="deployments", columns="base,scene,status").rows
    assert rows == (
        ("default", "default", "undecided"),
        ("solar", "solar", "collides"),
        ("solar", "solar, hinged", "deploys"),
    )


def test_the_same_piece_twice_changes_nothing(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    before = everything(listed)
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    assert everything(listed) == before


def test_a_verdict_comes_after_mobility(listed):
    assert told(listed) == ["undecided", None, None, None]
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    assert told(listed) == ["deploys", 1, 1.5, 0.5]


def test_verdicts_of_two_scenes_live_beside_each_other(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "solar", [trial("solar", "collides", contact=0.125)])
    assert told(listed) == ["deploys", 1, 1.5, 0.5]
    assert told(listed, "solar") == ["collides", None, None, None]
    assert select(listed, "deployable", columns="circuit").rows == (("hex:c",),)
    assert select(listed, "deployable", columns="circuit", scene="solar").rows == ()
    assert select(listed, "status=collides", columns="circuit", scene="solar").rows == (("hex:c",),)
    rows = select(listed, "base=solar", view="deployments", columns="scene,first_contact").rows
    assert rows == (("solar", 0.125),)
    # what needs no scene is the same in all of them
    plain = "id,circuit,n_foldings,untwisted,dof,orbit_size"
    assert select(listed, columns=plain, scene="solar").rows == select(listed, columns=plain).rows
    assert scene_names(listed) == ["default", "solar"]
    assert (find_scene(listed, "solar"), find_scene(listed, "none")) == ('name = "solar"\n', None)


def test_scenes_that_are_simulated_under_one_name_do_not_meet(listed):
    """A scene may be called as a look in another scene is."""
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "hinged", [trial("hinged", "collides")])
    rows = select(listed, "scene=hinged", view="deployments", columns="base,status").rows
    assert rows == (("default", "deploys"), ("hinged", "collides"))


def test_each_scene_has_its_own_finished_work(listed):
    judge(listed, [FLAT])
    stage = {"deployment": 1}
    assert list(finished_batches(listed, replace(WORK, scene="default"), stage)) == ["p#0/1"]
    assert finished_batches(listed, replace(WORK, scene="solar"), stage) == {}
    assert finished_batches(listed, WORK, stage) == {}


def test_the_best_folding_of_a_design_differs_between_scenes(database):
    record(database, ["hex:d"], creases=[[1, 4]], twists=[[0, 0]])
    with database.writing() as connection:
        connection.execute(schema.design.update().values(best_crease=1, status="undecided"))
        connection.execute(schema.folding.update().values(dof=schema.folding.c.crease, status="undecided"))
    shown = [select(database, columns="status,dof,min_clearance").rows]
    judge(database, [("hex:d", 4, "deploys", 0.25, 1.0), ("hex:d", 1, "collides", None, None)])
    judge(database, [("hex:d", 1, "deploys", 0.75, 2.0), ("hex:d", 4, "undecided", None, None)], "solar")
    shown += [select(database, columns="status,dof,min_clearance", scene=scene).rows for scene in ("default", "solar")]
    assert shown == [(("undecided", 1, None),), (("deploys", 4, 0.25),), (("deploys", 1, 0.75),)]
    statuses = select(database, view="foldings", columns="crease,status,deploy_time", scene="solar").rows
    assert statuses == ((1, "deploys", 2.0), (4, "undecided", None))


def test_a_scene_that_was_never_run_is_refused(listed):
    for view in ("designs", "foldings", "deployments"):
        with pytest.raises(SceneError, match=r"'solar' in .*: none yet; run `hcsearch enumerate --scene solar`"):
            select(listed, view=view, scene="solar")
    judge(listed, [FLAT])
    judge(listed, [CUT], "moon")
    judge(listed, [CUT], "moon, 300x300x4")
    known = "its scenes are: default, moon, 'moon, 300x300x4'; run `hcsearch enumerate --scene 'low moon'`"
    with pytest.raises(SceneError, match=known):
        select(listed, scene="low moon")


def test_the_default_scene_may_be_asked_about_before_it_was_run(listed):
    assert scene_names(listed) == []
    assert len(select(listed, scene="default").rows) == 3


@pytest.mark.parametrize("name", ["o'brien", "a :b", "%s", "100%", '"', "\\", "'; DROP TABLE design; --"])
def test_any_name_of_a_scene_is_a_value(listed, name):
    judge(listed, [FLAT], name)
    assert told(listed, name) == ["deploys", 1, 1.5, 0.5]
    assert told(listed) == ["undecided", None, None, None]


def test_another_scene_under_a_taken_name_is_refused(listed):
    judge(listed, [FLAT], "solar")
    before = everything(listed)
    with pytest.raises(SceneError, match="has another scene 'solar', with verdicts of its own: give this one another"):
        record_scene(listed, "solar", "density = 600.0\n")
    record_scene(listed, "solar", 'name = "solar"\n')
    assert everything(listed) == before


def test_a_design_that_is_missing_is_damage(listed, path):
    judge(listed, [FLAT])
    before = everything(listed)
    with pytest.raises(DatabaseError, match=f"{path} is damaged, it lacks 1 designs that were stored: restore a copy"):
        judge(listed, [CUT, ("hex:z", 3, "deploys", 1.0, 1.0)])
    assert everything(listed) == before


@pytest.mark.parametrize("broken", ["folding", "run", "status"])
def test_a_piece_is_stored_whole_or_not_at_all(listed, broken):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    before = everything(listed)
    run_id = 10**6 if broken == "run" else begin(listed, WORK)
    judged = ("hex:c", 2, "collides", None, None) if broken == "folding" else CUT
    trials = [replace(COLLIDES, status="fine")] if broken == "status" else [COLLIDES]
    with pytest.raises(Exception, match=r"constraint failed|cannot store"):
        record_verdicts(listed, run_id, replace(WORK, scene="default"), "q#0/1", verdicts_of([judged], trials), RESULT)
    assert everything(listed) == before
    assert told(listed) == ["deploys", 1, 1.5, 0.5]


def test_a_piece_without_designs_is_work_done(listed):
    judge(listed, [], key="q#0/1")
    assert list(finished_batches(listed, replace(WORK, scene="default"), {"deployment": 1})) == ["q#0/1"]
    assert told(listed) == ["undecided", None, None, None]


def test_a_piece_of_many_designs_is_stored(database):
    """More than fit into one statement; the deployments of all of them are made anew."""
    names = [f"hex:{k:04d}" for k in range(2100)]
    record(database, names, creases=[[3]], twists=[[0]])
    judged = [(name, 3, "collides", None, None) for name in names]
    judge(database, judged, trials=[replace(COLLIDES, folding=k) for k in range(len(names))])
    judge(database, [(name, 3, "deploys", 0.5, k / 8) for k, name in enumerate(names)])
    times = select(database, "deployable", columns="circuit,deploy_time", sort="circuit").rows
    assert times == tuple((name, k / 8) for k, name in enumerate(names))
    assert select(database, view="deployments").rows == ()


def test_deleting_a_design_removes_everything_of_it(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "solar", [trial("solar", "collides")])
    (number,) = select(listed, "untwisted", columns="id").rows[0]
    save_scores(listed, {number: 0.5})
    save_scores(listed, {number: 0.25}, "solar")
    with listed.writing() as connection:
        connection.execute(schema.design.delete().where(schema.design.c.id == number))
    left = everything(listed)
    tables = ("outcome", "verdict", "score", "deployment")
    assert [left[name] for name in tables] == [[]] * 4
    assert len(left["design"]) == len(left["folding"]) == 2
    assert scene_names(listed) == ["default", "solar"]


def test_a_newer_search_that_refutes_a_folding_takes_its_verdicts_along(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "solar")
    record(listed, ["hex:c"], prefix="q", until="foldings", creases=[[0]])
    left = everything(listed)
    assert [left[name] for name in ("outcome", "verdict", "deployment")] == [[]] * 3


def test_scores_are_those_of_a_scene(listed):
    judge(listed, [FLAT])
    judge(listed, [CUT], "solar")
    save_scores(listed, {1: 0.5, 3: 0.75})
    save_scores(listed, {1: 0.25, 2: 0.125}, "solar")

    def scores(scene="default"):
        return [score for (score,) in select(listed, columns="score", scene=scene).rows]

    assert (scores(), scores("solar")) == ([0.5, None, 0.75], [0.25, 0.125, None])
    save_scores(listed, {1: None, 3: 1.0}, "solar")
    assert (scores(), scores("solar")) == ([0.5, None, 0.75], [None, 0.125, 1.0])
    assert [row[0] for row in select(listed, "score>0.9", columns="id", scene="solar").rows] == [3]
    order = [row[0] for row in select(listed, columns="id", sort="-score", scene="solar").rows]
    assert order == [3, 2, 1]  # NULL comes last


def test_scenes_survive_closing(path):
    with open_database(str(path), create=True) as database:
        list_designs(database)
        judge(database, [FLAT], "solar")
    with open_database(str(path), create=False) as database:
        assert told(database, "solar") == ["deploys", 1, 1.5, 0.5]
