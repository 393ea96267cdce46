"""What leaves the program is of the linkage that gave a folding its status: exports, motions and drives."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch import deploy, save
from hcsearch.cli import hcsearch
from hcsearch.designs.folding import Folding
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.export.formats import EXPORT_FORMATS
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.search.enumeration import ArraySearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import find_verdict, open_database, open_readonly, schema, select
from hcsearch.subjects.resolve import resolve
from tests.judging import judge

CIRCUIT, CREASE = "hex:0233445011", 1
NAME = f"{CIRCUIT}:{CREASE}"
RIGID, HINGED = 8, 10
"""Parts of ten panels, with each flat pair one part, and with hinges in both."""
DEPLOYS = "flat pairs hinged, springs spread 6, as in the deployment that deploys"


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """A design that springs of one set open, with hinged flat pairs, and nothing opens with rigid ones."""
    path = tmp_path_factory.mktemp("ways") / "designs.sqlite"
    with open_database(str(path), create=True) as database:
        run_into(Plan(ArraySearch(parse_array(GRIDS["hex"], "hex:2.f.9.7")), "deployment", keep="untwisted"), database)
    return path


@pytest.fixture
def sprung(tmp_path_factory, monkeypatch):
    """A design whose best folding, and two others, are opened by springs alone; the path of another one is proved.

    No such design is known since all paths of small rectangles are proved: here proofs of the others fail.
    """
    prove = Prover.prove

    def fail(prover, states, margins):
        proof = prove(prover, states, margins)
        return proof if ":1')" in prover.linkage.made_by else replace(proof, clearance=None)

    monkeypatch.setattr(Prover, "prove", fail)
    path = tmp_path_factory.mktemp("ways") / "sprung.sqlite"
    with open_database(str(path), create=True) as database:
        array = parse_array(GRIDS["rectangle"], "4x2")
        run_into(Plan(ArraySearch(array), "deployment", keep="untwisted"), database)
    return path


@pytest.fixture
def here(judged, tmp_path, monkeypatch):
    """A folder with that database."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(judged, tmp_path))


def call(*words, code=0):
    result = CliRunner().invoke(hcsearch, [*map(str, words)], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result.stdout, result.stderr


def outlines(path):
    """Lines that are cut in a drawing."""
    (cut,) = re.findall(r'<g id="CUT".*?</g>', Path(path).read_text(encoding="utf-8"), re.DOTALL)
    return cut.count("<path ")


def solids(path):
    return Path(path).read_text(encoding="ascii").count("MANIFOLD_SOLID_BREP(")


@pytest.mark.parametrize("name", ["1", "1:1", NAME, f"{CIRCUIT}:6", "hex:1344550122:1"])
def test_drawings_and_solids_have_the_parts_of_the_linkage_that_deploys(here, name):
    for words, parts in (
        (("--sheet", "panels", "--output", "panels.svg"), lambda: outlines("panels.svg")),
        (("--output", "panels.step"), lambda: solids("panels.step")),
    ):
        _, told = call("export", name, *words, "--db", here)
        assert (parts(), told.strip()) == (HINGED, DEPLOYS)
        _, told = call("export", name, *words, "--db", here, "--flat-pairs", "rigid")
        assert (parts(), told) == (RIGID, "")


@pytest.mark.extra
def test_drawings_for_a_cutter_have_the_parts_of_the_linkage_that_deploys(here):
    import ezdxf

    for words, parts in (((), HINGED), (("--flat-pairs", "rigid"), RIGID)):
        call("export", "1", "--sheet", "panels", "--output", "panels.dxf", "--db", here, *words)
        assert len(ezdxf.readfile("panels.dxf").modelspace().query("LWPOLYLINE[layer=='CUT']")) == parts


def test_each_format_is_said_to_be_of_the_way_that_deploys(here):
    for form in EXPORT_FORMATS.values():
        file = f"design{form.endings[0]}"
        if form.needs or form.subject == "array":  # graphs of circuits have no linkage
            continue
        _, told = call("export", "1", "--output", file, "--db", here)
        assert told.startswith("flat pairs hinged"), file
        assert told.endswith("as in the deployment that deploys\n"), file
        assert told.count("\n") == 1


def test_motions_drives_and_deployments_are_of_the_same_linkage(here):
    out, told = call("deploy", "1", "--db", here, "--json")
    facts = json.loads(out)
    assert (told.strip(), facts["panels"], facts["verdict"]) == (DEPLOYS, HINGED, "deploys")
    out, told = call("drive", "1", "--db", here, "--json")
    facts = json.loads(out)
    assert (facts["flat_pairs"], facts["hinges"]) == ("hinged", HINGED)
    assert told.strip() == "flat pairs hinged, as in the deployment that deploys"  # a path asks for no springs
    for by in ("path", "springs"):
        assert resolve("1", str(here), path=by == "path").replay(by)[0].angles.shape[1] == HINGED
    assert resolve("1", str(here)).linkage.n_panels == HINGED


def test_python_takes_the_same_linkage(here, capfd):
    save(Folding.from_notation(NAME), "python.step", db=str(here))
    assert solids("python.step") == HINGED
    assert deploy("1", db=str(here)).facts()["panels"] == HINGED
    assert DEPLOYS in capfd.readouterr().err


def test_springs_of_ones_own_keep_the_flat_pairs_alone(here):
    _, told = call("deploy", "1", "--db", here, "--spring", "linear:0.2", "--seconds", "0.01", code=1)
    assert told.strip() == "flat pairs hinged, as in the deployment that deploys"


def test_another_scene_or_an_unknown_design_has_the_way_of_its_scene(here):
    unjudged = f"scene 60x60x6, without verdicts in {here}: its scenes are default\n"
    for words, said in (
        (("1", "--panel", "60x6"), unjudged),
        ((NAME, "--scene", "rigid"), ""),
        (("hex:0234550132:4",), ""),
    ):
        _, told = call("export", *words, "--output", "other.step", "--db", here)
        assert (solids("other.step"), told) == (RIGID, said)


def test_a_motion_that_is_not_clear_or_does_not_end_flat_is_said_to_be_so(here):
    rigid = ("export", "1", "--db", here, "--flat-pairs", "rigid", "--motion", "springs", "--output", "a.glb")
    assert call(*rigid)[1].strip() == "the motion: it is not certified that panels keep apart"
    told = call("export", "hex:02234400:1", "--db", here, "--motion", "springs", "--output", "a.glb")[1]
    assert told.startswith("the motion: panels ")
    assert "collide at 0.01282 s" in told
    told = call(*rigid, "--seconds", "0.01")[1]
    assert told.strip() == "the motion: not flat at the end"


def test_the_way_of_a_proved_path_is_taken_of_what_is_movable(here):
    with open_database(str(here), create=False) as database, database.writing() as connection:
        for table in (schema.outcome, schema.verdict):
            connection.execute(table.update().values(status="movable"))
    _, told = call("export", "1", "--output", "movable.step", "--db", here)
    assert (solids("movable.step"), told.strip()) == (HINGED, "flat pairs hinged, as in the proved path")


def test_an_id_is_of_the_only_scene_that_was_run(here):
    other = str(here.with_name("other.sqlite"))
    with open_database(other, create=True) as database:
        run_into(Plan(ArraySearch(parse_array(GRIDS["hex"], "hex:2.f.9.7")), "mobility", keep="untwisted"), database)
        judge(database, [(CIRCUIT, CREASE, "movable", None, None)], "solar")
    told = call("export", "1", "--output", "s.step", "--db", other)[1]
    assert told.startswith(f"scene solar, the only one that {other} has verdicts of; flat pairs rigid, as in")


def test_show_names_the_way_that_gave_a_design_its_numbers(here):
    shown = call("show", "1", "--db", here)[0]
    assert f"flat pairs      hinged, in the deployment of folding {CREASE}\n" in shown
    with open_readonly(str(here)) as database:
        (row,) = select(database, columns="needed_margin,deploy_time").rows
    assert f"needed margin   {row[0]:.6g} mm\n" in shown
    assert f"deploy time     {row[1]:.6g} s\n" in shown


def test_a_certified_motion_by_springs_comes_before_a_path_that_is_not_proved(sprung, tmp_path):
    opened = resolve("1:2", str(sprung)).replay()[0]
    assert (opened.axis, opened.certified) == ("time", ((0.0, opened.at[-1]),))
    unproved = resolve("1:2", str(sprung), path=True).replay("path")[0]
    assert (unproved.axis, unproved.certified) == ("path", ())
    _, told = call("export", "1:2", "--db", sprung, "--output", tmp_path / "a.glb")
    assert told.strip() == "flat pairs rigid, as in the deployment that deploys"
    _, told = call("export", "1:2", "--db", sprung, "--output", tmp_path / "a.glb", "--motion", "path")
    assert told.endswith("; the motion: it is not certified that panels keep apart\n")


def test_a_design_is_driven_along_the_proved_path_that_one_of_its_foldings_has(sprung):
    with open_readonly(str(sprung)) as database:
        ways = [find_verdict(database, 1, crease).path_flat_pairs for crease in range(4)]
    assert ways == [None, "rigid", None, None]
    out, told = call("drive", "1", "--db", sprung)
    assert told.startswith("folding 1, as no path of the best one, 3, is proved; flat pairs rigid")
    assert "verdict                       deploys" in out
    out, _ = call("drive", "1:3", "--db", sprung, code=1)
    assert out.startswith("no drive: undecided")
    assert out.endswith("; try other panels or --flat-pairs hinged or a scene file with a greater margin_mm\n")
