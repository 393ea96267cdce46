"""Nothing of a database is lost by an upgrade, here to a schema that writes designs and verdicts anew."""

import sqlite3
from contextlib import closing
from functools import partial

import pytest
from store_samples import RESULTS, VERSIONS, WORK, circuits, contents, evaluation_row, record, unit_row

from hcsearch.basics.errors import DatabaseError
from hcsearch.designs.records import Trial
from hcsearch.store import (
    best_creases,
    find_evaluations,
    find_paths,
    find_scene,
    finished_batches,
    open_database,
    open_readonly,
    record_evaluations,
    record_scene,
    record_units,
    save_scores,
    select,
)
from hcsearch.store.columns import VIEWS, column_names
from tests import forking, next_schema
from tests.judging import judge

SCENES = ("default", "solar")
TRIAL = Trial(
    *(0, "hinged", 'name = "hinged"\n', "constrained", "deploys", "so it was", 1.5e-3, None, 0.5, 1e-7, 2e-9),
    *("dormand-prince", ("base",), 0.4),
)
TABLES = ("outcome", "verdict", "motion", "score", "deployment")
"""Of what is known of designs in scenes."""


def shown(database):
    """All rows of all views in both scenes, paths, and finished work."""
    rows = {(view, scene): select(database, view=view, scene=scene).rows for view in VIEWS for scene in SCENES}
    assert all(rows.values())
    paths = [find_paths(database, [1, 2, 3], scene) for scene in SCENES]
    assert all(paths)
    return rows, paths, finished_batches(database, WORK, VERSIONS), find_evaluations(database, "thesis-4x4")


def scenes_in(database, table):
    with database.reading() as connection:
        place = "base" if table == "deployment" else "scene"
        return {scene for (scene,) in connection.exec_driver_sql(f"SELECT {place} FROM {table}")}


@pytest.fixture
def before(path):
    """What the views show of a database with verdicts in two scenes, scores, units and evaluations; it is at `path`."""
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 3), results=RESULTS)
        judge(database, [("hex:023757", 3, "deploys", 1.5, 0.5)], trials=[TRIAL])
        judge(database, [("hex:023757", 3, "movable", None, None)], "solar", [TRIAL])
        for scene, score in zip(SCENES, (0.5, 0.25), strict=True):
            save_scores(database, {3: score}, scene)
        record_units(database, [unit_row()])
        record_evaluations(database, [evaluation_row()])
        return shown(database)


@pytest.fixture
def upgraded(before, path, tmp_path, monkeypatch):
    next_schema.install(tmp_path / "migrations", monkeypatch.setattr)
    with open_database(str(path), create=False) as database:
        yield database


def test_views_show_what_they_showed(before, upgraded):
    assert shown(upgraded) == before
    assert all(select(upgraded, view=view).columns == column_names(view) for view in VIEWS)


def test_designs_are_found_with_their_foldings(upgraded):
    rows = contents(upgraded)
    assert [row["circuit"] for row in rows] == ["hex:007919", "hex:015838", "hex:023757"]
    assert [row["status"] for row in rows] == ["no_folding", "twisted", "deploys"]
    assert [[f["crease"] for f in row["foldings"]] for row in rows] == [[], [1, 4], [0, 3]]
    assert best_creases(upgraded, [1, 2, 3]) == {3: 3}


def test_constraints_of_rewritten_tables_hold(upgraded):
    for change in ("UPDATE verdict SET status = 'collides'", "UPDATE design SET status = 'collides'"):
        with pytest.raises(Exception, match=r"constraint failed|cannot store"), upgraded.writing() as connection:
            connection.exec_driver_sql(change)


def test_rewritten_verdicts_go_with_their_designs_and_scenes(upgraded):
    assert all(scenes_in(upgraded, table) == set(SCENES) for table in TABLES)
    with upgraded.writing() as connection:
        connection.exec_driver_sql("DELETE FROM scene WHERE name = 'solar'")
    for table in ("outcome", "verdict", "motion"):
        assert scenes_in(upgraded, table) == {"default"}
    with upgraded.writing() as connection:
        connection.exec_driver_sql("DELETE FROM design WHERE id = 3")
    for table in TABLES:
        assert scenes_in(upgraded, table) == set()


def test_an_upgraded_database_is_judged_and_scored_anew(upgraded):
    record_scene(upgraded, "default", "")
    assert find_scene(upgraded, "solar") == 'name = "solar"\n'
    judge(upgraded, [("hex:023757", 3, "movable", None, None)])
    judge(upgraded, [("hex:023757", 3, "undecided", None, None)], "new")
    save_scores(upgraded, {3: None})
    names = "status,score,needed_margin"
    seen = {scene: select(upgraded, "id=3", columns=names, scene=scene).rows for scene in (*SCENES, "new")}
    assert seen == {
        "default": (("movable", None, 0.01),),
        "solar": (("movable", 0.25, 0.01),),
        "new": (("undecided", None, None),),
    }


def test_rows_that_refer_to_missing_ones_are_not_upgraded(before, path, tmp_path, monkeypatch):
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DELETE FROM design WHERE id = 3")
        connection.commit()
    content = path.read_bytes()
    next_schema.install(tmp_path / "migrations", monkeypatch.setattr)
    with pytest.raises(DatabaseError, match="cannot be upgraded, rows refer to missing ones: restore a copy"):
        open_database(str(path), create=False)
    assert path.read_bytes() == content


@pytest.mark.parametrize("revision", ["0011", "0002", "9999"])
def test_a_database_of_before_the_first_release_is_to_be_made_anew(before, path, revision):
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE hcsearch_version SET version_num = ?", (revision,))
        connection.commit()
    content = path.read_bytes()
    refused = rf"schema {revision}, this one knows .*first release: install .*run `hcsearch enumerate` anew on another"
    for attempt in (partial(open_database, create=True), open_readonly):
        with pytest.raises(DatabaseError, match=refused):
            attempt(str(path))
    for words in (("enumerate", "--grid", "hex", "--n", "6"), ("query",), ("show", "3"), ("rank", "--save")):
        done = forking.run([*words, "--db", path])
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert "`hcsearch enumerate` anew" in done.stderr
    assert path.read_bytes() == content
    assert [file.name for file in path.parent.iterdir()] == [path.name]
