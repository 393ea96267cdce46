"""Verdicts of the stages in a scene, in the database: in scenes of their own, kept beside other stages, made anew."""

import math
import re
import shlex
import zlib
from dataclasses import replace

import numpy as np
import pytest
from store_samples import NOT_ALLOWED, begin, record, sample

from hcsearch.basics.errors import DatabaseError, SceneError
from hcsearch.designs.records import NO_NUMBER, DesignBatch, Evidence, StageResult, StoredLock, Trial, WorkKey
from hcsearch.store import (
    find_design,
    find_scene,
    finished_batches,
    open_database,
    record_batches,
    record_scene,
    record_settled,
    record_verdicts,
    save_scores,
    scene_names,
    schema,
    select,
    simulation_accuracy,
    undecided,
)
from tests.judging import judge, verdicts_of

NAMES = ("hex:a", "hex:b", "hex:c")
WORK = WorkKey("hex", 12, "", "all")
RESULTS = [StageResult(stage, 1, 1, 1, 0.5) for stage in ("motion", "deployment")]


MOBILITY = {"kutzbach": 6, "dof": 6, "dof_folded": 7, "dof_flat": 6, "merged_panels": 0} | {
    name: np.full(4, NO_NUMBER) for name in ("kutzbach_merged", "dof_merged")
}
"""Columns of the stage `mobility` of the four foldings of the sample."""


def trial(scene, status, clearance=None, time=None, contact=None, folding=0):
    accuracy = {"method": "dormand-prince", "omitted": ("gravity", "base"), "time_saved": 0.4}
    result = scene, "{}", "constrained", status, "so it was", clearance, contact, time, 1e-7, 2e-9
    errors = {"error_angle": 2e-5, "error_time": 1e-3} if status == "deploys" else {}
    return Trial(folding, *result, **accuracy, **errors)


def list_designs(database, *, locked=False):
    """The sample with the stage `mobility`; the third design has one untwisted folding."""
    word = "locked" if locked else "undecided"
    batch = sample(NAMES)
    best = {"best_crease": np.array([NO_NUMBER, NO_NUMBER, 3]), "status": [None, None, word]}
    foldings = {**batch.foldings, **MOBILITY, "status": [None, None, None, word]}
    designs = DesignBatch({**batch.designs, **best}, foldings)
    record_batches(database, begin(database, WORK), WORK, [("p", designs, [])])


COLLIDES = trial("default", "collides", contact=0.25)
DEPLOYS = trial("hinged", "deploys", clearance=1.5e-3, time=0.5)
FLAT = ("hex:c", 3, "deploys", 1.5, 0.5)
MOVES = ("hex:c", 3, "movable", None, None)
CUT = ("hex:c", 3, "undecided", None, None)
PATH = ["rigid", 0.01, -0.005]
"""Flat pairs, needed margin and least gap (mm) of the motions that `judge` records."""
NO_PATH = [None] * 3
LOCKED = ("hex:c", 3, "locked", None, None)


def row_of(database, scene="default"):
    """What both views say of the third design; they must agree."""
    names = "status,deployable,min_clearance,deploy_time,flat_pairs,needed_margin,least_gap"
    (row,) = select(database, "untwisted", columns=names, scene=scene).rows
    assert select(database, "crease=3", columns=names, view="foldings", scene=scene).rows == (row,)
    return list(row)


def everything(database):
    """The rows of all tables, but for those that say who worked when."""
    contents = {}
    with database.reading() as connection:
        for name, table in schema.metadata.tables.items():
            columns = [column for column in table.c if column.name != "run_id"]
            if name != "run":
                contents[name] = sorted(map(repr, connection.execute(table.select().with_only_columns(*columns))))
    return contents


@pytest.fixture
def listed(database):
    list_designs(database)
    return database


def test_a_verdict_is_stored_with_its_deployments(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    assert row_of(listed) == ["deploys", 1, 1.5, 0.5, *PATH]
    rows = select(listed, view="deployments", columns="crease,scene,status,clearance,first_contact,deploy_time").rows
    assert rows == ((3, "default", "collides", None, 0.25, None), (3, "hinged", "deploys", 1.5, None, 0.5))
    errors = select(listed, view="deployments", columns="base,energy_error,closure_error", limit=1).rows
    assert errors == (("default", 1e-7, pytest.approx(2e-6)),)
    rows = select(listed, view="deployments", columns="method,error_angle,error_time,omitted,time_saved").rows
    same = "dormand-prince", "gravity, base"
    assert rows == ((same[0], None, None, same[1], 0.4), (same[0], 2e-5, 1e-3, same[1], 0.4))
    assert simulation_accuracy(listed, replace(WORK, scene="default")) == (0.4, 2e-3, 2e-3, 1, 0)
    of_designs = select(listed, "error_time<1", columns="circuit,error_angle,error_time").rows
    assert of_designs == (("hex:c", 2e-5, 1e-3),)
    assert select(listed, "error_angle<1", columns="crease,error_time", view="foldings").rows == ((3, 1e-3),)
    assert [row["scene"] for row in find_design(listed, "hex:c")["deployments"]] == ["default", "hinged"]
    shown = select(listed, columns="circuit,status,deployable").rows
    assert shown == (("hex:a", "no_folding", 0), ("hex:b", "twisted", 0), ("hex:c", "deploys", 1))


def test_a_motion_is_stored_with_its_path(listed):
    judge(listed, [MOVES])
    assert row_of(listed) == ["movable", 1, None, None, *PATH]
    (row,) = select(listed, view="motions").rows
    assert row == (3, 3, "default", *PATH, pytest.approx(1e-5), 2, "a reason for movable", None, *[None] * 8)
    with listed.reading() as connection:
        (packed,) = connection.execute(schema.motion.select().with_only_columns(schema.motion.c.path)).scalars()
    assert np.frombuffer(zlib.decompress(packed), "<f8").reshape(2, 2).tolist() == [[math.pi, math.pi], [0.0, 0.0]]


def test_without_a_path_a_motion_has_a_reason_and_no_numbers(listed):
    judge(listed, [CUT])
    assert row_of(listed) == ["undecided", None, None, None, *NO_PATH]
    (row,) = select(listed, view="motions").rows
    assert row == (3, 3, "default", None, None, None, None, 0, "a reason for undecided", None, *[None] * 8)
    with listed.reading() as connection:
        assert connection.execute(schema.motion.select()).mappings().one()["path"] is None


def test_what_is_proved_locked_has_no_motion(listed):
    """Nothing was looked for, and what was found before is gone."""
    judge(listed, [LOCKED])
    assert select(listed, view="motions").rows == ()
    judge(listed, [MOVES])
    judge(listed, [MOVES], "solar")
    judge(listed, [LOCKED])
    assert row_of(listed) == ["locked", 0, None, None, *NO_PATH]
    assert select(listed, view="motions", columns="scene").rows == (("solar",),)
    assert row_of(listed, "solar") == ["movable", 1, None, None, *PATH]


def test_motions_are_stored_where_no_deployment_was_simulated(listed):
    """A run until `motion`: nothing deploys by springs as far as is known, and the stage `deployment` is not done."""
    record_scene(listed, "default", "")
    scenic = replace(WORK, scene="default")
    for judged in (MOVES, CUT):
        verdicts = verdicts_of([judged]).with_folding_results(deployment=None)
        record_verdicts(listed, begin(listed, WORK), scenic, "p#0/1", verdicts, RESULTS[:1])
        path = PATH if judged is MOVES else NO_PATH
        assert row_of(listed) == [judged[2], 1 if judged is MOVES else None, None, None, *path]
    assert list(finished_batches(listed, scenic, {"motion": 1})) == ["p#0/1"]
    assert finished_batches(listed, scenic, {"motion": 1, "deployment": 1}) == {}
    assert select(listed, view="deployments").rows == ()


@pytest.mark.parametrize("judged", [FLAT, MOVES, CUT], ids=lambda judged: judged[2])
def test_a_later_run_of_earlier_stages_leaves_the_verdicts(listed, judged):
    judge(listed, [judged], trials=[COLLIDES])
    judge(listed, [MOVES], "solar", [trial("solar", "collides")])
    before = everything(listed), row_of(listed), row_of(listed, "solar")
    assert (before[1][0], before[2][0]) == (judged[2], "movable")
    assert [len(before[0][name]) for name in ("motion", "verdict", "outcome", "deployment")] == [2] * 4
    list_designs(listed)
    assert (everything(listed), row_of(listed), row_of(listed, "solar")) == before


def test_a_proof_of_a_lock_takes_the_place_of_a_verdict_with_the_next_one(listed):
    """A newer stage `mobility` makes the batches of later stages older, so that the next run does all of them."""
    judge(listed, [CUT], trials=[COLLIDES])
    list_designs(listed, locked=True)
    assert row_of(listed)[:2] == [CUT[2], None]
    judge(listed, [LOCKED])
    assert row_of(listed) == ["locked", 0, None, None, *NO_PATH]


def test_what_deploys_with_hinged_pairs_may_be_locked_with_rigid_ones(database):
    list_designs(database, locked=True)
    assert row_of(database) == ["locked", 0, None, None, *NO_PATH]
    judge(database, [FLAT], trials=[DEPLOYS])
    assert row_of(database) == ["deploys", 1, 1.5, 0.5, *PATH]


def test_newer_deployments_take_the_place_of_older_ones_of_their_scene_alone(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [FLAT], "solar", [trial("solar", "collides"), replace(DEPLOYS, scene="solar, hinged")])
    judge(listed, [CUT], trials=[replace(COLLIDES, status="undecided")])
    assert row_of(listed) == ["undecided", None, None, None, *NO_PATH]
    assert row_of(listed, "solar") == ["deploys", 1, 1.5, 0.5, *PATH]
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
    assert row_of(listed) == ["undecided", None, None, None, *NO_PATH]
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    assert row_of(listed) == ["deploys", 1, 1.5, 0.5, *PATH]


def test_verdicts_of_two_scenes_live_beside_each_other(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [MOVES], "solar", [trial("solar", "collides", contact=0.125)])
    judge(listed, [CUT], "dim")
    assert row_of(listed) == ["deploys", 1, 1.5, 0.5, *PATH]
    assert row_of(listed, "solar") == ["movable", 1, None, None, *PATH]
    assert select(listed, "deployable", columns="circuit").rows == (("hex:c",),)
    assert row_of(listed, "dim") == ["undecided", None, None, None, *NO_PATH]
    assert select(listed, "deployable", columns="circuit", scene="solar").rows == (("hex:c",),)
    assert select(listed, "deployable", columns="circuit", scene="dim").rows == ()
    assert select(listed, "status=movable", columns="circuit", scene="solar").rows == (("hex:c",),)
    assert select(listed, "status=movable", columns="circuit").rows == ()
    motions = select(listed, view="motions", columns="scene,flat_pairs,states", sort="scene").rows
    assert motions == (("default", "rigid", 2), ("dim", None, 0), ("solar", "rigid", 2))
    rows = select(listed, "base=solar", view="deployments", columns="scene,first_contact").rows
    assert rows == (("solar", 0.125),)
    # what needs no scene is the same in all of them
    plain = "id,circuit,n_foldings,untwisted,dof,orbit_size"
    assert select(listed, columns=plain, scene="solar").rows == select(listed, columns=plain).rows
    assert scene_names(listed) == ["default", "dim", "solar"]
    assert (find_scene(listed, "solar"), find_scene(listed, "none")) == ('name = "solar"\n', None)


def test_scenes_that_are_simulated_under_one_name_do_not_meet(listed):
    """A scene may be called as a look in another scene is."""
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "hinged", [trial("hinged", "collides")])
    rows = select(listed, "scene=hinged", view="deployments", columns="base,status").rows
    assert rows == (("default", "deploys"), ("hinged", "collides"))


def test_each_scene_has_its_own_finished_work(listed):
    judge(listed, [FLAT])
    for stages in ({"deployment": 1}, {"motion": 1}, {"motion": 1, "deployment": 1}):
        assert list(finished_batches(listed, replace(WORK, scene="default"), stages)) == ["p#0/1"]
        assert finished_batches(listed, replace(WORK, scene="solar"), stages) == {}
        assert finished_batches(listed, WORK, stages) == {}


def test_the_best_folding_of_a_design_differs_between_scenes(database):
    record(database, ["hex:d"], creases=[[1, 4]], twists=[[0, 0]])
    with database.writing() as connection:
        connection.execute(schema.design.update().values(best_crease=1, status="undecided"))
        connection.execute(schema.folding.update().values(dof=schema.folding.c.crease, status="undecided"))
    shown = [select(database, columns="status,dof,min_clearance").rows]
    judge(database, [("hex:d", 4, "deploys", 0.25, 1.0), ("hex:d", 1, "undecided", None, None)])
    judge(database, [("hex:d", 1, "deploys", 0.75, 2.0), ("hex:d", 4, "movable", None, None)], "solar")
    judge(database, [("hex:d", 4, "movable", None, None), ("hex:d", 1, "undecided", None, None)], "dim")
    scenes = ("default", "solar", "dim")
    shown += [select(database, columns="status,dof,min_clearance", scene=scene).rows for scene in scenes]
    assert shown == [
        (("undecided", 1, None),),
        (("deploys", 4, 0.25),),
        (("deploys", 1, 0.75),),
        (("movable", 4, None),),
    ]
    columns = "crease,status,deployable,deploy_time,needed_margin"
    statuses = select(database, view="foldings", columns=columns, scene="solar").rows
    assert statuses == ((1, "deploys", 1, 2.0, 0.01), (4, "movable", 1, None, 0.01))
    # of the best folding, as all else
    statuses = select(database, view="foldings", columns=columns, scene="dim").rows
    assert statuses == ((1, "undecided", None, None, None), (4, "movable", 1, None, 0.01))
    best = select(database, columns="deployable,flat_pairs,needed_margin,least_gap", scene="dim").rows
    assert best == ((1, *PATH),)


def test_a_scene_that_was_never_run_is_refused(listed):
    for view in ("designs", "foldings", "motions", "deployments"):
        with pytest.raises(SceneError, match=r"'earth' in .*: none yet; run `hcsearch enumerate --scene earth`"):
            select(listed, view=view, scene="earth")
    judge(listed, [FLAT])
    judge(listed, [CUT], "moon")
    judge(listed, [CUT], "moon, 300x300x4")
    known = (
        "its scenes are: default, moon, 'moon, 300x300x4'; name one of these with --scene, or run "
        "`hcsearch enumerate --scene 'moon, 70x70x6'`"
    )
    with pytest.raises(SceneError, match=known):
        select(listed, scene="moon, 70x70x6")


@pytest.mark.parametrize("scene", ["eart", "low moon", "low moon, 70x70x6"])
def test_a_scene_that_there_is_not_is_run_from_a_file_of_its_own(listed, scene):
    judge(listed, [FLAT])
    own = "name one of these with --scene, or for a scene of your own run `hcsearch enumerate --scene FILE.toml`"
    with pytest.raises(SceneError, match=own):
        select(listed, scene=scene)


def test_the_default_scene_may_be_asked_about_before_it_was_run(listed):
    assert scene_names(listed) == []
    assert len(select(listed, scene="default").rows) == 3


@pytest.mark.parametrize("scene", ["o'brien", "a :b", "%s", "100%", '"', "\\", "'; DROP TABLE design; --"])
def test_any_name_of_a_scene_is_a_value(listed, scene):
    judge(listed, [FLAT], scene)
    assert row_of(listed, scene) == ["deploys", 1, 1.5, 0.5, *PATH]
    with pytest.raises(SceneError, match=re.escape(f"its scenes are: {shlex.quote(scene)}; name one of these")):
        row_of(listed)


def test_the_default_scene_is_refused_where_others_alone_were_run(listed):
    judge(listed, [FLAT], "solar")
    for view in ("designs", "foldings"):
        with pytest.raises(SceneError, match=r"no verdicts of the scene 'default' in .*: solar; name one"):
            select(listed, view=view)
    for view in ("motions", "runs"):  # these name the scene of each row, or have none
        assert select(listed, view=view).rows


def test_another_scene_under_a_taken_name_is_refused(listed):
    judge(listed, [FLAT], "solar")
    before = everything(listed)
    with pytest.raises(SceneError, match="has another scene 'solar', with verdicts of its own: give this one another"):
        record_scene(listed, "solar", "density = 600.0\n")
    record_scene(listed, "solar", 'name = "solar"\n')
    assert everything(listed) == before


def test_a_design_that_is_missing_is_damage(listed):
    judge(listed, [FLAT])
    before = everything(listed)
    with pytest.raises(DatabaseError, match="is damaged, it lacks 1 designs that were stored: restore a copy"):
        judge(listed, [CUT, ("hex:z", 3, "deploys", 1.0, 1.0)])
    assert everything(listed) == before


@pytest.mark.parametrize("broken", ["folding", "run", "status", "verdict", "outcome", "pairs"])
def test_a_piece_is_stored_whole_or_not_at_all(listed, broken):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    before = everything(listed)
    run_id = 10**6 if broken == "run" else begin(listed, WORK)
    judged = ("hex:c", 2, "undecided", None, None) if broken == "folding" else CUT
    trials = [replace(COLLIDES, status="fine")] if broken == "status" else [COLLIDES]
    verdicts = verdicts_of([judged], trials)
    if broken == "verdict":  # of a deployment alone
        verdicts = replace(verdicts, folding_status=["collides"])
    elif broken == "outcome":
        verdicts = replace(verdicts, status=["collides"])
    elif broken == "pairs":
        verdicts = verdicts.with_folding_results(motion=replace(verdicts.motion, flat_pairs=["either"]))
    with pytest.raises(Exception, match=NOT_ALLOWED):
        record_verdicts(listed, run_id, replace(WORK, scene="default"), "q#0/1", verdicts, RESULTS)
    assert everything(listed) == before
    assert row_of(listed) == ["deploys", 1, 1.5, 0.5, *PATH]


def test_a_piece_without_designs_is_work_done(listed):
    judge(listed, [], key="q#0/1")
    stages = {"motion": 1, "deployment": 1}
    assert list(finished_batches(listed, replace(WORK, scene="default"), stages)) == ["q#0/1"]
    assert row_of(listed) == ["undecided", None, None, None, *NO_PATH]


def test_a_piece_of_many_designs_is_stored(database):
    """More than fit into one statement; the deployments of all of them are made anew."""
    names = [f"hex:{k:04d}" for k in range(2100)]
    record(database, names, creases=[[3]], twists=[[0]])
    judged = [(name, 3, "undecided", None, None) for name in names]
    judge(database, judged, trials=[replace(COLLIDES, folding=k) for k in range(len(names))])
    assert select(database, "deployable", columns="circuit").rows == ()
    judge(database, [(name, 3, "deploys", 0.5, k / 8) for k, name in enumerate(names)])
    times = select(database, "deployable", columns="circuit,deploy_time", sort="circuit").rows
    assert times == tuple((name, k / 8) for k, name in enumerate(names))
    assert select(database, view="deployments").rows == ()


def test_deleting_a_design_removes_everything_of_it(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [MOVES], "solar", [trial("solar", "collides")])
    (number,) = select(listed, "untwisted", columns="id").rows[0]
    save_scores(listed, {number: 0.5})
    save_scores(listed, {number: 0.25}, "solar")
    with listed.writing() as connection:
        connection.execute(schema.design.delete().where(schema.design.c.id == number))
    left = everything(listed)
    tables = ("outcome", "verdict", "score", "motion", "deployment")
    assert [left[name] for name in tables] == [[]] * 5
    assert len(left["design"]) == len(left["folding"]) == 2
    assert scene_names(listed) == ["default", "solar"]


def test_a_newer_search_that_refutes_a_folding_takes_its_verdicts_along(listed):
    judge(listed, [FLAT], trials=[COLLIDES, DEPLOYS])
    judge(listed, [CUT], "solar")
    record(listed, ["hex:c"], prefix="q", until="foldings", creases=[[0]])
    left = everything(listed)
    assert [left[name] for name in ("outcome", "verdict", "motion", "deployment")] == [[]] * 4


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


def test_scenes_survive_closing(place):
    with open_database(place, create=True) as database:
        list_designs(database)
        judge(database, [FLAT], "solar")
    with open_database(place, create=False) as database:
        assert row_of(database, "solar") == ["deploys", 1, 1.5, 0.5, *PATH]


def settled(database, judged, key="budget 3, design 3"):
    """What verdicts on some foldings of designs that were judged before add to the counts of their stages."""
    work = replace(WORK, scene="default")
    return record_settled(database, begin(database, WORK), work, key, verdicts_of(judged), RESULTS)


def test_a_folding_that_is_settled_changes_the_verdict_on_its_design(listed):
    judge(listed, [CUT])
    motion, deployment = settled(listed, [MOVES])
    assert row_of(listed)[:2] == ["movable", 1]
    assert (motion.passed, motion.n_fixed, deployment.passed) == (1, 2, 0)
    motion, deployment = settled(listed, [FLAT], "again")
    assert row_of(listed)[:4] == ["deploys", 1, 1.5, 0.5]
    assert (motion.passed, deployment.passed, deployment.n_fixed) == (0, 1, 2)
    done = finished_batches(listed, replace(WORK, scene="default"), {"motion": 1, "deployment": 1})
    assert sum(result.passed for results in done.values() for result in results if result.stage == "motion") == 1


def test_what_is_undecided_is_listed_until_its_budget_is_spent(listed):
    work = replace(WORK, scene="default")
    judge(listed, [CUT])
    assert [(one.circuit, one.crease, one.efforts) for one in undecided(listed, work)] == [("hex:c", 3, 0)]
    assert undecided(listed, replace(work, n=10)) == []
    assert undecided(listed, replace(work, scene="solar")) == []
    assert undecided(listed, replace(work, target="hex:other")) == []
    evidence = Evidence(3, StoredLock("rigid", False, "packed", 106, 865, 1e-4), None, 2.5e-3)
    verdicts = verdicts_of([CUT])
    verdicts = verdicts.with_folding_results(motion=replace(verdicts.motion, evidence=[evidence]))
    record_settled(listed, begin(listed, WORK), work, "k", verdicts, RESULTS)
    assert [one.efforts for one in undecided(listed, work, 4)] == [3]
    assert undecided(listed, work, 3) == []
    names = "efforts,lock_pairs,lock_end,lock_cubes,lock_faces,lock_margin,critical_margin,unmet_margin"
    assert select(listed, view="motions", columns=names).rows == ((3, "rigid", "packed", 106, 865, 0.1, None, 2.5),)
    assert select(listed, "crease=3", view="foldings", columns="known,unmet_margin").rows == (("no_path_met", 2.5),)
    settled(listed, [MOVES])
    assert undecided(listed, work) == []


def test_a_kinematic_lock_is_known_as_one(listed):
    evidence = Evidence(3, StoredLock("hinged", True, "flat", 4, 42))
    verdicts = verdicts_of([LOCKED])
    motion = replace(verdicts.motion, reason=["they are kept apart"], evidence=[evidence])
    assert motion.locked.tolist() == [True]
    judge(listed, [CUT])
    verdicts = verdicts.with_folding_results(motion=motion)
    record_settled(listed, begin(listed, WORK), replace(WORK, scene="default"), "k", verdicts, RESULTS)
    for view, query in (("designs", "untwisted"), ("foldings", "crease=3")):
        assert select(listed, query, view=view, columns="status,known,deployable").rows == (
            ("locked", "kept_apart", 0),
        )
