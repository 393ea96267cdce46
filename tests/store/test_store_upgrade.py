"""Nothing of a database is lost by the upgrades that move verdicts into scenes, and that add motions."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hcsearch.scenes import SCENES
from hcsearch.scenes.scene_file import read_text, scene_in
from hcsearch.store import find_scene, open_database, record_scene, save_scores, select
from hcsearch.store.columns import column_names
from tests.judging import judge

OLD = Path(__file__).with_name("old")
VALUES = {
    "damping_time": 0.043,
    "density": 547.0,
    "flat_pairs": "rigid",
    "gravity": [0.0, 0.0, -9.81],
    "held": "bottom",
    "margin_mm": 0.1,
    "merge": False,
    "panel_mm": "50x50x6",
    "restitution": 0.0,
    "seconds": 1.0,
    "spring": "linear:0.1",
    "springs": {"0": "linear:0.1", "4": "free"},
    "start": 0.999,
}
# Of designs: number of untwisted foldings, best crease, status, score.
DESIGNS = {
    4: (2, 1, "deploys", 0.75),
    5: (2, 0, "undecided", None),
    6: (1, 2, "locked", None),
    7: (1, 2, "undecided", 0.25),
    8: (1, 5, "collides", 0.125),
    9: (0, None, "twisted", None),
}
# Of foldings: design, crease, twist, dof, status, min_clearance, deploy_time.
FOLDINGS = (
    (4, 1, 0, 3, "collides", None, None),
    (4, 4, 0, 5, "deploys", 0.25, 1.5),
    (5, 0, 0, 2, "collides", None, None),
    (5, 2, 0, 4, "undecided", None, None),
    (5, 3, 2, None, "twisted", None, None),
    (6, 2, 0, 1, "locked", None, None),
    (7, 2, 0, 1, "undecided", None, None),
    (8, 5, 0, None, "collides", None, None),
    (9, 1, 1, None, "twisted", None, None),
)
# Of deployments: design, crease, scene, status, clearance, deploy_time.
DEPLOYMENTS = (
    (4, 1, "default", "collides", None, None),
    (4, 4, "default", "collides", None, None),
    (4, 4, "hinged, spread 3", "deploys", 0.25, 1.5),
    (5, 0, "default", "collides", None, None),
    (5, 2, "default", "undecided", None, None),
    (8, 5, "default", "collides", None, None),
)
EVIDENCE = dict.fromkeys(("critical_margin", "unmet_margin"))
KNOWN = {"deploys": "deployment", "movable": "path_proved", "locked": "locked_at_end", "twisted": "twist"}
"""What stands behind a status, where no motion is stored that says more."""
MOTION = dict.fromkeys(("flat_pairs", "needed_margin", "least_gap")) | EVIDENCE
"""Columns that are new since, and without a value in each row of older views."""
PLAY = dict.fromkeys(("needed_margin", "least_gap"))
LIKE = {"as_crease": None}
NEW = {"designs": MOTION, "foldings": MOTION, "deployments": PLAY | LIKE, "runs": {"movable": None}}
BEST_FOLDING = ("kutzbach", "dof", "merged_panels", "kutzbach_merged", "dof_merged")


def views(connection):
    """The rows of the views of the older schema, as dicts."""
    rows = {}
    for view in ("designs", "foldings", "deployments", "runs", "units", "evaluations"):
        cursor = connection.execute(f"SELECT * FROM {view}")
        names = [column[0] for column in cursor.description]
        rows[view] = [dict(zip(names, row, strict=True)) for row in cursor]
    return rows


@pytest.fixture
def before(path):
    """The views of a database of schema 0004 with verdicts, deployments and scores; the file is at `path`."""
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript((OLD / "0004.sql").read_text())
        for number, (untwisted, crease, status, score) in DESIGNS.items():
            values = (number, f"hex:{number}", f"hex:a{number}", 2, untwisted, crease, status, score)
            connection.execute("INSERT INTO design VALUES (?, 'hex', 12, ?, ?, 12, 1, 12, ?, ?, 0, ?, ?, ?)", values)
        for number, crease, twist, dof, *others in FOLDINGS:
            values = (number, crease, crease + 6, twist, dof, *others)
            connection.execute("INSERT INTO folding VALUES (?, ?, ?, ?, 6, ?, 7, 6, 0, NULL, NULL, ?, ?, ?)", values)
        for number, crease, scene, status, clearance, time in DEPLOYMENTS:
            values = (number, crease, scene, json.dumps(VALUES), status, clearance, time)
            connection.execute(
                "INSERT INTO deployment VALUES (?, ?, ?, ?, 'constrained', ?, 'so it was', ?, NULL, ?, 1e-7, 1e-5)",
                values,
            )
        done = "INSERT INTO batch VALUES ('hex', 12, '', 'all', '', 'p', ?, 1, 1, 10, 0.5, 1)"
        connection.executemany(done, [("mobility",), ("deployment",)])
        connection.commit()
        shown = views(connection)
    assert {row["status"] for row in shown["designs"]} >= {"deploys", "undecided", "locked", "collides", "twisted"}
    return shown


@pytest.fixture
def upgraded(before, path):
    with open_database(str(path), create=False) as database:
        yield database


def rows(database, view):
    result = select(database, view=view)
    return [dict(zip(result.columns, row, strict=True)) for row in result.rows]


def sql(database, statement):
    with database.reading() as connection:
        return [tuple(row) for row in connection.exec_driver_sql(statement)]


JUDGED = {4: {1, 4}, 5: {0, 2}, 8: {5}}
"""Designs that the stage `deployment` had judged, and the foldings of each."""


def now(view, row):
    """What a row of an older view is now: that one deployment collides says nothing of a folding."""
    word = row.get("status")
    if view != "deployments" and word == "collides":
        word = "undecided"
    number, crease = row.get("design_id", row.get("id")), row.get("crease")
    judged = number in JUDGED and (view == "designs" or crease in JUDGED[number])
    if view in ("designs", "foldings") and word == "undecided" and not judged:
        word = None  # nobody had looked for a motion
    known = {"known": KNOWN.get(word)} if view in ("designs", "foldings") else {}
    return renamed({**row, **NEW.get(view, {}), **({"status": word} if "status" in row else {}), **known})


def seen(view, row):
    """A row of a view that did not say what stands behind a status."""
    if view not in ("designs", "foldings"):
        return row
    return {**row, **EVIDENCE, "known": KNOWN.get(row["status"])}


def renamed(row):
    """A row of `runs` of schema 0007 or older: what springs alone do was called deployable there."""
    return {"deploys" if "finished" in row and name == "deployable" else name: row[name] for name in row}


def without(row, *names):
    return {name: value for name, value in row.items() if name not in names}


def test_views_show_what_they_showed(before, upgraded):
    for view in ("foldings", "runs", "units", "evaluations"):
        assert rows(upgraded, view) == [now(view, row) for row in before[view]]
        assert before[view]
    assert rows(upgraded, "motions") == []
    # the best folding of a design is one of its status now
    old, new = [now("designs", row) for row in before["designs"]], rows(upgraded, "designs")
    assert [without(row, *BEST_FOLDING) for row in new] == [without(row, *BEST_FOLDING) for row in old]
    assert {row["id"]: (row["dof"], after["dof"]) for row, after in zip(old, new, strict=True)} == {
        **dict.fromkeys((1, 2, 3, 8, 9), (None, None)),
        4: (3, 5),
        5: (2, 4),
        6: (1, 1),
        7: (1, 1),
    }
    assert [without(row, "base", "scene_values") for row in rows(upgraded, "deployments")] == [
        without(now("deployments", row), "scene_values") for row in before["deployments"]
    ]
    assert {row["base"] for row in rows(upgraded, "deployments")} == {"default"}


def test_verdicts_and_scores_are_in_the_scene_that_they_were_of(before, upgraded):
    assert sql(upgraded, "SELECT name, scene_values FROM scene") == [("default", "")]
    outcomes = "SELECT design_id, scene, best_crease, status FROM outcome ORDER BY design_id"
    assert sql(upgraded, outcomes) == [
        (4, "default", 4, "deploys"),
        (5, "default", 2, "undecided"),
        (8, "default", 5, "undecided"),
    ]
    verdicts = "SELECT design_id, crease, scene, status, min_clearance, deploy_time FROM verdict ORDER BY 1, 2"
    assert sql(upgraded, verdicts) == [
        (number, crease, "default", "undecided" if word == "collides" else word, *values)
        for number, crease, twist, _, word, *values in FOLDINGS
        if number in (4, 5, 8) and not twist
    ]
    assert sql(upgraded, "SELECT design_id, scene, score FROM score ORDER BY design_id") == [
        (3, "default", 0.5),
        *((number, "default", values[3]) for number, values in DESIGNS.items() if values[3] is not None),
    ]
    # the stages before a deployment leave these without a status
    known = dict(sql(upgraded, "SELECT id, status FROM design WHERE id > 3"))
    assert known == {4: None, 5: None, 6: "locked", 7: None, 8: None, 9: "twisted"}
    words = sql(upgraded, "SELECT DISTINCT status FROM folding WHERE status IS NOT NULL ORDER BY 1")
    assert words == [("locked",), ("twisted",)]


def test_finished_work_of_other_stages_is_kept(upgraded):
    stages = [stage for (stage,) in sql(upgraded, "SELECT stage FROM batch ORDER BY stage")]
    assert stages == ["circuits", "foldings", "mobility", "twist"]


def test_what_was_simulated_is_read_as_a_scene(upgraded):
    shown = select(upgraded, "design_id=4", view="deployments", columns="crease,scene,scene_values").rows
    assert [row[:2] for row in shown] == [(1, "default"), (4, "default"), (4, "hinged, spread 3")]
    for crease, name, text in shown:
        content = read_text(text, name)
        assert content["design"] == f"hex:4:{crease}"
        assert content["formulation"] == "constrained"
        scene = scene_in(content)
        assert (scene.name, scene.panel, scene.margin) == (name, (0.05, 0.05, 0.006), 1e-4)
        assert (scene.flat_pairs, scene.merge, scene.gravity) == ("rigid", False, (0.0, 0.0, -9.81))
        assert (scene.springs, scene.seconds) == (((0, "linear:0.1"), (4, "free")), 1.0)


def test_the_default_scene_of_an_older_database_is_run_again(upgraded):
    stored = find_scene(upgraded, "default")
    assert scene_in(read_text(stored, "default")) == SCENES["default"]
    record_scene(upgraded, "default", "")
    judge(upgraded, [("hex:4", 4, "movable", None, None), ("hex:7", 2, "deploys", 0.5, 1.0)])
    save_scores(upgraded, {4: None})
    selected = select(upgraded, "id>3 id!=9", columns="id,status,score,needed_margin").rows
    assert selected == (
        (4, "movable", None, 0.01),
        (5, "undecided", None, None),
        (6, "locked", None, None),
        (7, "deploys", 0.25, 0.01),
        (8, "undecided", 0.125, None),
    )


def opened_from(path, version):
    """The views of an old database, and it opened by this program."""
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript((OLD / f"{version}.sql").read_text())
        shown = views(connection)
    return shown, open_database(str(path), create=False)


def assert_readable(database):
    for view in ("designs", "foldings", "deployments", "runs", "units", "evaluations"):
        assert select(database, view=view).columns == column_names(view)
        assert select(database, view=view).rows
    for text in select(database, view="deployments", columns="scene_values").rows:
        assert scene_in(read_text(text[0], "it")).panel is not None


def test_verdicts_of_two_scenes_have_no_motions_yet(path):
    """Schema 0005: foldings that collide are undecided now, each deployment says what it did."""
    before, database = opened_from(path, "0005")
    with database:
        names = "status,deployable,min_clearance,deploy_time,score,flat_pairs,needed_margin,least_gap"
        none = (None,) * 3
        assert select(database, "id=3", columns=names).rows == (("deploys", 1, 1.5, 0.5, 0.5, *none),)
        solar = select(database, "id=3", columns=names, scene="solar").rows
        assert solar == (("undecided", None, None, None, 0.25, *none),)
        shown = select(database, view="deployments", columns="base,scene,status").rows
        assert shown == (
            ("default", "default", "collides"),
            ("default", "hinged", "deploys"),
            ("solar", "solar", "collides"),
        )
        assert_readable(database)
        for view, old in before.items():
            assert rows(database, view) == [now(view, row) for row in old]
        assert select(database, view="motions").rows == ()
        verdicts = "SELECT scene, status, min_clearance, deploy_time FROM verdict ORDER BY 1"
        assert sql(database, verdicts) == [("default", "deploys", 1.5, 0.5), ("solar", "undecided", None, None)]
        outcomes = "SELECT scene, best_crease, status FROM outcome ORDER BY 1"
        assert sql(database, outcomes) == [("default", 3, "deploys"), ("solar", 3, "undecided")]
        judge(database, [("hex:023757", 3, "movable", None, None)], "new")
        selected = select(database, "id=3", columns="status,needed_margin", scene="new").rows
        assert selected == (("movable", 0.01),)


@pytest.mark.parametrize("table", ["outcome", "verdict"])
def test_no_verdict_collides_any_more(path, table):
    _, database = opened_from(path, "0005")
    with database:
        with pytest.raises(Exception, match=r"constraint failed|cannot store"), database.writing() as connection:
            connection.exec_driver_sql(f"UPDATE {table} SET status = 'collides'")
        with database.writing() as connection:
            connection.exec_driver_sql(f"UPDATE {table} SET status = 'movable'")


def test_rewritten_verdicts_go_with_their_designs_and_scenes(path):
    _, database = opened_from(path, "0005")
    with database:
        with database.writing() as connection:
            connection.exec_driver_sql("DELETE FROM scene WHERE name = 'solar'")
        for table in ("outcome", "verdict"):
            assert sql(database, f"SELECT scene FROM {table}") == [("default",)]
        with database.writing() as connection:
            connection.exec_driver_sql("DELETE FROM design WHERE id = 3")
        for table in ("outcome", "verdict"):
            assert sql(database, f"SELECT scene FROM {table}") == []


def test_motions_in_two_scenes_are_kept(path):
    """Schema 0006: what is movable has the play of its path."""
    before, database = opened_from(path, "0006")
    with database:
        names = "status,deployable,min_clearance,deploy_time,score,flat_pairs,needed_margin,least_gap"
        # the play of deployments is known once they are judged anew
        deploys = select(database, "id=3", columns=names).rows
        assert deploys == (("deploys", 1, 1.5, 0.5, 0.5, "rigid", None, None),)
        solar = select(database, "id=3", columns=names, scene="solar").rows
        assert solar == (("movable", 1, None, None, 0.25, "rigid", 0.01, -0.005),)
        shown = select(database, view="motions", columns="scene,slack,states,reason").rows
        assert shown == (
            ("default", 1e-5, 2, "a reason for deploys"),
            ("solar", 1e-5, 2, "a reason for movable"),
        )
        assert select(database, view="runs", columns="id,movable,deploys").rows == ((1, 1, 1), (2, 1, 0))
        assert_readable(database)
        for view, old in before.items():
            new = PLAY | LIKE if view == "deployments" else {}
            play = PLAY if view in ("designs", "foldings") else {}
            assert rows(database, view) == [
                {**seen(view, renamed(row)), **new, **(play if row.get("status") == "deploys" else {})} for row in old
            ]


def test_noise_of_least_gaps_is_none_after_an_upgrade(path):
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript((OLD / "0006.sql").read_text())
        connection.execute("UPDATE motion SET least_gap = -5.6e-14 WHERE scene = 'solar'")
        connection.commit()
    with open_database(str(path), create=False) as database:
        assert select(database, "least_gap>=0", columns="least_gap", scene="solar").rows == ((0.0,),)
        assert sql(database, "SELECT least_gap FROM motion ORDER BY scene") == [(-0.005,), (0.0,)]


def test_the_play_of_deployments_is_kept(path):
    """Schema 0007."""
    before, database = opened_from(path, "0007")
    with database:
        assert select(database, columns="needed_margin,least_gap", view="deployments").rows == (
            (None, None),
            (0.01, -0.005),
            (None, None),
        )
        assert_readable(database)
        for view, old in before.items():
            new = LIKE if view == "deployments" else {}
            assert rows(database, view) == [{**seen(view, renamed(row)), **new} for row in old]


def test_the_newest_old_database_says_whose_motions_it_has(path):
    before, database = opened_from(path, "0008")
    with database:
        for view in ("motions", "deployments"):
            assert set(select(database, columns="as_crease", view=view).rows) == {(None,)}
        assert select(database, view="runs", columns="id,movable,deploys").rows == ((1, 1, 1), (2, 1, 0))
        assert_readable(database)
        for view, old in before.items():
            assert rows(database, view) == [seen(view, row) for row in old]


def test_locks_and_efforts_are_kept(path):
    """Schema 0010."""
    _, database = opened_from(path, "0010")
    with database:
        names = "scene,efforts,lock_pairs,lock_end,lock_cubes,lock_faces,lock_margin,critical_margin,unmet_margin"
        kept = select(database, "lock_cubes>0", columns=names, view="motions").rows
        assert kept == (("locks", 3, "hinged", "packed", 106, 1077, None, None, 2.5),)
        assert select(database, "id=3", columns="status,known", scene="locks").rows == (("locked", "kept_apart"),)
        assert_readable(database)


def test_margins_of_locks_are_kept(path):
    """Schema 0011."""
    _, database = opened_from(path, "0011")
    with database:
        assert select(database, "lock_margin>0", columns="scene,lock_pairs,lock_margin", view="motions").rows == (
            ("locks", "hinged", 0.1),
        )
        assert_readable(database)
