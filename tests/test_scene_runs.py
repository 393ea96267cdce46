"""Runs of the pipeline in scenes: many in one database, in pieces, and each deployment repeated as `show` says."""

import json
import re
import shlex
from dataclasses import replace

import pytest
from click.testing import CliRunner

from hcsearch.basics.vocabulary import STATUSES
from hcsearch.cli import hcsearch
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import read_panel
from hcsearch.scenes import SCENES, with_panel
from hcsearch.search.enumeration import search_all
from hcsearch.search.pipeline import Plan, run_dry, run_into
from hcsearch.store import open_database, open_readonly, select, select_sql
from tests.report.pages import column, data_of

ROWS = "SELECT d.circuit, p.* FROM deployments AS p JOIN designs AS d ON d.id = p.design_id ORDER BY p.scene, d.circuit"


def call(*words, code=0):
    result = CliRunner().invoke(hcsearch, [str(word) for word in words], standalone_mode=True)
    if code == 2 and result.exception is not None and not isinstance(result.exception, SystemExit):
        return str(result.exception)  # `main` prints it as one line and exits with 2
    assert result.exit_code == code, result.output
    return result.stdout


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A database with verdicts in two scenes."""
    file = tmp_path_factory.mktemp("scenes") / "designs.sqlite"
    for more in ((), ("--panel", "1000x20")):
        text = call("enumerate", "--grid", "hex", "--n", 8, "--keep", "untwisted", "--db", file, *more)
        assert "movable" in text
        assert "deployed by springs" in text
        assert re.search(r"^left out: [1-9]\d % of the work of a simulation", text, re.MULTILINE)
    assert "scene: 1000x1000x20, panels of 1000x1000x20 mm" in text
    assert "1 taken from before" in text  # what depends on no scene
    return file


def queried(path, *words):
    return json.loads(call("query", "untwisted", "--db", path, "--format", "json", "-c", "circuit,status", *words))


def test_sql_reads_the_verdicts_of_the_scene_that_is_asked_for(path):
    sql = "SELECT circuit, status, deploy_time FROM designs WHERE untwisted ORDER BY circuit"
    words = ("query", "--db", path, "--format", "json", "--sql", sql)
    columns = (
        "query",
        "untwisted",
        "--db",
        path,
        "--format",
        "json",
        "-c",
        "circuit,status,deploy_time",
        "-s",
        "circuit",
    )
    asked = [(), ("--scene", "default"), ("--panel", "50x6"), ("--panel", "1000x20"), ("--scene", "1000x1000x20")]
    found = [json.loads(call(*words, *scene)) for scene in asked]
    assert found == [json.loads(call(*columns, *scene)) for scene in asked]
    assert found[0] == found[1] == found[2] != found[3] == found[4]
    assert "no verdicts of the scene 'earth'" in call(*words, "--scene", "earth", code=2)


def assert_consistent(database, scene):
    """What is said of foldings, motions and deployments in a scene agrees."""
    names = "design_id,crease,status,deployable,deploy_time,needed_margin,least_gap,flat_pairs"
    selected = select(database, "untwisted", columns=names, view="foldings", scene=scene)
    motions = select(database, f"scene={scene}", view="motions")
    planned = {row[:2]: dict(zip(motions.columns, row, strict=True)) for row in motions.rows}
    chosen = "design_id,crease,needed_margin,least_gap"
    deployed = select(database, f"base={scene} status=deploys", columns=chosen, view="deployments").rows
    springs = {row[:2]: list(row[2:]) for row in deployed}
    assert selected.rows
    for number, crease, status, deployable, seconds, *play, pairs in selected.rows:
        motion = planned.get((number, crease))
        assert deployable == {"deploys": 1, "movable": 1, "undecided": None, "locked": 0}[status]
        assert (seconds is not None) == (status == "deploys")
        assert (motion is None) <= (status == "locked")
        if motion is None:
            assert [*play, pairs] == [None] * 3
            continue
        path = [motion[name] for name in ("flat_pairs", "needed_margin", "least_gap")]
        assert pairs == path[0]
        assert play == (springs[number, crease] if status == "deploys" else path[1:])  # of what gives the status
        assert motion["reason"]
        assert (motion["states"] > 1) >= (path[0] is not None)  # a path need not be proved
        assert (motion["states"] > 1) == ("a path" in motion["reason"])
        assert len({value is None for value in (*path, motion["slack"])}) == 1
        if status == "movable":
            assert path[1] > 0.0
            assert path[2] >= -2 * path[1]
            assert motion["slack"] >= 0.0


def test_each_scene_has_verdicts_of_its_own(path):
    with open_readonly(str(path)) as database:
        bases = select_sql(database, "SELECT base, count(DISTINCT design_id) FROM deployments GROUP BY base").rows
        assert {base for base, _ in bases} == {"default", "1000x1000x20"}
        for base, _ in bases:
            words = {status for _, status in select(database, "untwisted", columns="id,status", scene=base).rows}
            assert words <= {*STATUSES}
            assert_consistent(database, base)
    assert queried(path) == queried(path, "--scene", "default") == queried(path, "--panel", "50x6")
    assert queried(path, "--panel", "1000x20") == queried(path, "--scene", "1000x1000x20")
    assert queried(path, "--scene", "1000x20") == queried(path, "--scene", "1000x1000x20")
    for nothing in ("", ",", ",1000x20", "solar, 1000x20"):
        assert "no verdicts of the scene" in call("query", "untwisted", "--db", path, "--scene", nothing, code=2)
    assert queried(path, "--across", f"{1000 * 3**0.5:.10g}x20") == queried(path, "--panel", "1000x20")


def test_what_was_tried_is_repeated_by_the_command_that_show_prints(path):
    with open_readonly(str(path)) as database:
        rows = select(database, view="deployments").rows
        names = select(database, view="deployments").columns
    shown = call("show", rows[0][0], "--db", path).splitlines()
    commands = [line.strip() for line in shown if line.strip().startswith("hcsearch deploy ")]
    assert len(commands) == len(rows)
    by_scene = {row[names.index("scene")]: dict(zip(names, row, strict=True)) for row in rows}
    for command in commands:
        words = shlex.split(command)[1:]
        scene = words[words.index("--scene") + 1]
        # a path with hinged pairs gave the status: the scene as it stands is asked for by its rigid ones
        row = by_scene["default" if scene == "rigid" else scene]
        facts = json.loads(call(*words, "--json", code=0 if row["status"] == "deploys" else 1))
        assert facts["verdict"] == row["status"]
        assert row["deploy_time"] == (facts["flat_time_s"] if row["status"] == "deploys" else None)
        assert facts["collision_s"] == (row["first_contact"] if row["status"] == "collides" else None)


def test_stored_values_are_a_file_that_deploy_reads(path, tmp_path):
    with open_readonly(str(path)) as database:
        (values, status, time), *_ = select(
            database, view="deployments", columns="scene_values,status,deploy_time", sort="-scene"
        ).rows
    file = tmp_path / "scene.toml"
    file.write_text(values, encoding="utf-8")
    facts = json.loads(call("deploy", file, "--json", code=0 if status == "deploys" else 1))
    assert facts["verdict"] == status
    assert time == (facts["flat_time_s"] if status == "deploys" else None)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--scene", "solar"), "no verdicts of the scene 'solar'"),
        (("--panel", "70x6"), "hcsearch enumerate --scene 70x70x6"),
        (("--panel", ""), "is no panel"),
        (("--panel", "50x6", "--across", "50x6"), "either --panel or --across"),
    ],
)
@pytest.mark.parametrize("command", ["query", "rank", "report"])
def test_scenes_that_were_never_run_are_refused(path, command, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert message in call(command, "untwisted", "--db", path, *words, code=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--scene", ""), "a scene has a name"),
        (("--scene", "solar"), "there is no scene 'solar'"),
        (("--scene", "earth, 50x6, 30x4"), "there is no scene 'earth, 50x6, 30x4'"),
        (("--panel", ""), "is no panel"),
        (("--panel", "50x40x6"), "have one side"),
        (("--scene", "satellite"), "holds no panel"),
        (("--scene", "none.toml"), "name a file that is there"),
    ],
)
def test_scenes_that_cannot_be_are_refused_before_a_database_is_made(tmp_path, words, message):
    database = tmp_path / "none.sqlite"
    assert message in call("enumerate", "--grid", "hex", "--n", 8, "--db", database, *words, code=2)
    assert not database.exists()


def test_a_margin_that_leaves_nothing_of_a_panel_is_refused(tmp_path):
    file, database = tmp_path / "thin.toml", tmp_path / "none.sqlite"
    file.write_text('panel_mm = "1000x3"\nmargin_mm = 2\n', encoding="utf-8")
    said = call("enumerate", "--grid", "hex", "--n", 8, "--db", database, "--scene", file, code=2)
    assert "less than 1.5 mm as margin_mm of a scene file, or thicker panels" in said
    assert not database.exists()


def test_a_file_is_a_scene_by_its_name(tmp_path):
    file, database = tmp_path / "solar.toml", tmp_path / "designs.sqlite"
    file.write_text('panel_mm = "1000x20"\n[scene]\nareal_mass = 10.9\nspring = "linear:20"\n', encoding="utf-8")
    words = ("enumerate", "--grid", "square", "--n", 4, "--db", database)
    assert "scene: solar, panels of 1000x1000x20 mm" in call(*words, "--scene", file)
    assert "0 done" in call(*words, "--scene", "solar")  # it is in the database now
    listed = call("query", "untwisted", "--db", database, "--scene", file, "-c", "status", "--format", "csv")
    assert "deploys" in listed
    file.write_text('panel_mm = "1000x20"\n', encoding="utf-8")
    assert "another scene 'solar'" in call(*words, "--scene", file, code=2)
    file.write_text('name = "default"\npanel_mm = "1000x20"\n', encoding="utf-8")
    assert "give it another name" in call(*words, "--scene", file, code=2)
    file.write_text('name = "mountains first"\npanel_mm = "1000x20"\n', encoding="utf-8")
    assert "a variant of a scene" in call(*words, "--scene", file, code=2)
    file.write_text('design = "hex:023350:1"\n', encoding="utf-8")
    assert "give it to hcsearch deploy" in call(*words, "--scene", file, code=2)


def test_a_report_plays_first_the_motion_that_its_words_are_about(path, tmp_path):
    file = tmp_path / "report.html"
    call("report", "untwisted", "--db", path, "--panel", "1000x20", "--output", file)
    data = data_of(file.read_text(encoding="utf-8"))
    (why,) = column(data, "foldings", "why")
    assert why.startswith("flat after ")
    (player,) = [player for player in data["players"] if player is not None]
    assert player["axis"] == "time"
    seconds = float(why.split()[2])
    assert abs(player["at"][-1] - seconds) < 0.05 * seconds
    assert "certified clear with panels" in why
    assert not {"needed_margin", "least_gap", "min_clearance"} & set(data["card_columns"])


def test_an_envelope_in_centimetres_is_an_empty_table_with_the_sizes_there_are(path):
    done = CliRunner().invoke(hcsearch, ["query", "fits=10x10x34", "--db", str(path), "--format", "csv", "-c", "id"])
    assert (done.exit_code, done.stdout) == (0, "id\n")
    (box,) = re.findall(r"^no design: the smallest folded array here is (\S+) mm, and sizes are in mm$", done.stderr)
    assert call("query", f"fits={box}", "--db", path, "--format", "csv", "-c", "id").count("\n") > 1
    refused = call("report", "fits=10x10x34", "--db", path, "--output", path.with_name("none.html"), code=2)
    assert f": the smallest folded array here is {box} mm, and sizes are in mm" in refused


class StopError(Exception):
    pass


def stopping(after):
    """Progress that ends the run once some pieces are done."""

    def show(_done, _total, note):
        deployed = re.match(r"deployment, (\d+) of ", note)
        if deployed and int(deployed[1]) >= after:
            raise StopError

    return show


def rows_of(path):
    with open_readonly(str(path)) as database:
        return [row[0:1] + row[2:] for row in select_sql(database, ROWS).rows]


def test_a_run_that_ends_early_keeps_its_pieces_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr("hcsearch.search.pipeline.judging.PIECE_CORE_SECONDS", 0.01)  # a piece for each design
    search = search_all(GRIDS["square"], 10, "untwisted")
    brief = replace(with_panel(SCENES["default"], read_panel("20x2"), "square"), flat_pairs="rigid", seconds=0.01)
    plan = Plan(search, "deployment", "untwisted", brief)
    one, other = tmp_path / "whole.sqlite", tmp_path / "parts.sqlite"
    with open_database(str(one), create=True) as database:
        summary = run_into(plan, database)
    whole = rows_of(one)
    pieces = summary.batches_done - len(search.prefixes)
    assert pieces == summary.funnel.untwisted > 3
    with open_database(str(other), create=True) as database:
        with pytest.raises(StopError):
            run_into(plan, database, stopping(2))
        kept = rows_of(other)
        assert kept
        assert set(kept) < set(whole)
        again = run_into(plan, database)
        assert rows_of(other) == whole
        assert again.funnel == summary.funnel
        assert again.batches_done + again.batches_reused == summary.batches_done
        assert again.batches_reused > len(search.prefixes)
        assert run_into(plan, database).batches_done == 0
    assert run_dry(plan).funnel == summary.funnel


def test_progress_and_times_are_known_beforehand(tmp_path, monkeypatch):
    monkeypatch.setattr("hcsearch.search.pipeline.run.LONG_RUN_SECONDS", 0.0)
    seen, said, funnels = [], [], []

    def show(done, total, note):
        seen.append((done, total, note))

    def listed(funnel):
        funnels.append((funnel, len(seen)))

    plan = Plan(search_all(GRIDS["square"], 8, "untwisted"), "deployment", "untwisted")
    summary = run_dry(plan, show, said.append, listed)
    ((known, count),) = funnels
    assert known == replace(summary.funnel, movable=None, deploys=None)
    batches = len(plan.search.prefixes)
    assert [note.split(", ")[0] for _, _, note in seen[:count]] == [
        f"batch {k} of {batches}" for k in range(batches + 1)
    ]
    judging = seen[count:]
    foldings = int(re.fullmatch(r"motion, 0 of (\d+) foldings", judging[0][2])[1])
    assert judging[-1][2] == f"deployment, {foldings} of {foldings} foldings"
    assert (seen[0][0], seen[-1][0]) == (0, seen[-1][1])
    assert [entry[0] for entry in seen] == sorted(entry[0] for entry in seen)
    assert len({entry[1] for entry in seen}) == 1
    (sentence,) = said
    assert sentence.startswith(f"{foldings} foldings to judge in the scene default: about ")
