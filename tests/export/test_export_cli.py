"""`hcsearch export` and `hcsearch check` as a person meets them."""

import json
import math
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.api.exporting import save
from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.cli import hcsearch
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.grid import GRIDS
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat, export_format_of
from hcsearch.export.settings import ExportSettings, read_export_state
from hcsearch.scenes import SCENES
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.own_patterns.fold_reading import read_fold
from hcsearch.search.own_patterns.recognition import recognise_design
from hcsearch.search.own_patterns.single_circuits import check_circuit
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import find_design, open_database
from tests.export.exports import DESIGN, MOVING, exported
from tests.judging import judge


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        return CliRunner().invoke(hcsearch, words)

    return call


def refusal(result):
    assert isinstance(result.exception, HcsearchError), result.output
    return str(result.exception)


@pytest.mark.parametrize(
    "form", [form for form in EXPORT_FORMATS.values() if not form.needs], ids=lambda form: form.name
)
def test_each_format_is_written_by_its_ending_alone(run, form):
    name = f"design{form.endings[0]}"
    result = run("export", MOVING, "--output", name)
    assert result.exit_code == 0, result.output
    first, *beside = result.output.split()
    assert first == name
    assert all(Path(path).stat().st_size for path in (first, *beside))


SEVERAL = [form for form in EXPORT_FORMATS.values() if len(form.endings) > 1 and "ending" not in form.setting_names]
"""Formats with several endings for one content."""


@pytest.mark.parametrize("form", SEVERAL, ids=lambda form: form.name)
def test_each_ending_of_a_format_stands_for_the_same_file(run, form):
    assert {form.name for form in SEVERAL} == {"mjcf", "step"}
    names = [f"design{ending}" for ending in (*form.endings, form.endings[-1].upper())]
    for name in names:
        assert run("export", MOVING, "--output", name).output.split() == [name]
    assert len({Path(name).read_bytes() for name in names}) == 1
    other = next(own for own in EXPORT_FORMATS.values() if own.endings != form.endings)
    assert refusal(run("export", MOVING, "--format", form.name, "--output", f"a{other.endings[0]}")).endswith(
        f"write {' or '.join(form.endings)}"
    )


@pytest.mark.parametrize("form", EXPORT_FORMATS.values(), ids=lambda form: form.name)
def test_each_format_has_a_writer_and_settings_that_there_are(form):
    assert callable(form.writer)
    assert all(ending.startswith(".") for ending in form.endings)
    assert form.setting_names <= set(ExportSettings.__dataclass_fields__)


def test_a_design_of_a_database_stands_for_its_best_folding(run):
    assert run("enumerate", "--grid", "hex", "--n", "8", "--until", "mobility").exit_code == 0
    listed = run("query", "untwisted", "-c", "id,circuit", "--format", "csv").output.splitlines()[1:]
    number, circuit = listed[0].split(",")
    assert run("export", number, "--output", "a.fold").exit_code == 0
    assert f'"{circuit}:' in Path("a.fold").read_text(encoding="utf-8")
    name = MOVING.rpartition(":")[0]
    with open_database("judged.sqlite", create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], len(name) - 4), "twist"), database)
        judge(database, [(name, 3, "movable", None, None), (name, 4, "locked", None, None)])
        judge(database, [(name, 4, "deploys", 1.0, 0.1), (name, 3, "locked", None, None)], "solar", key="p#0/2")
        number = str(find_design(database, name)["id"])
    for crease, scene in ((3, ()), (4, ("--scene", "solar"))):
        words = ("export", number, "--output", "b.fold", "--db", "judged.sqlite", *scene)
        assert run(*words).exit_code == 0
        assert f'"{name}:{crease}"' in Path("b.fold").read_text(encoding="utf-8")


def test_loads_are_taken_where_a_file_holds_a_motion_or_a_scene(run):
    for words in (("a.fold", "--motion", "springs"), ("a.stl", "--state", "0.5"), ("a.csv",), ("a.xml",)):
        assert run("export", DESIGN, "--friction", "0.0001", "--output", *words).exit_code == 0


def test_an_array_needs_no_folding(run):
    assert run("export", "hex:024", "--output", "a.g6").exit_code == 0
    assert "does not fold into two stacks" in refusal(run("export", "hex:024", "--output", "a.fold"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--output", "a.txt"), "a.txt has no known ending: write .fold"),
        (("--output", "a.svg", "--format", "fold"), "a.svg is no name for a file of the format fold: write .fold"),
        (("--output", "a.fold", "--kerf", "1"), "fold takes no --kerf: leave it out, or choose svg, dxf"),
        (("--output", "a.svg", "--friction", "1"), "svg takes no --friction: leave it out, or choose mjcf, urdf"),
        (("--output", "a.fold", "--held", "3"), "fold takes no --held: leave it out, or choose mjcf, urdf or --motion"),
        (("--output", "a.step", "--gravity", "0,0,1"), "step takes no --gravity: leave it out, or choose mjcf, urdf"),
        (("--output", "a.json", "--seconds", "2"), "networkx takes no --seconds: leave it out, or choose mjcf, urdf"),
        (("--output", "a.svg", "--motion", "path"), "svg holds no motion: leave out --motion"),
        (("--output", "a.stl", "--state", "half"), "'half' is no state: write flat, folded, or a share"),
        (("--output", "none/a.svg"), "there is no folder none"),
        (("--output", "a.csv", "--motion", "path", "--merge"), "the folding has no mirror image"),
    ],
)
def test_what_cannot_be_is_one_line(run, words, message):
    assert message in refusal(run("export", DESIGN, *words))


@pytest.mark.parametrize("ending", ["fold", "g6"])
def test_a_name_that_is_no_assembly_is_called_so_whatever_the_format(run, ending):
    assert "there is no assembly 'unit-iv'" in refusal(run("export", "unit-iv", "--output", f"a.{ending}"))


def test_a_format_whose_program_is_missing_names_the_extra(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    assert "dxf needs ezdxf: pip install 'hcsearch[export]'" in refusal(run("export", DESIGN, "--output", "a.dxf"))


def test_python_writes_what_the_command_writes(run, tmp_path):
    assert run("export", DESIGN, "--output", "a.svg", "--sheet", "panels", "--kerf", "0.3").exit_code == 0
    folding = Folding.from_notation(DESIGN)
    assert save(folding, tmp_path / "b.svg", sheet="panels", kerf_mm=0.3) == [tmp_path / "b.svg"]
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    with pytest.raises(HcsearchError, match="exports have no setting 'colour'"):
        save(folding, tmp_path / "b.svg", colour="red")


@pytest.mark.parametrize(("crease", "canonical"), [(2, "hex:0234550132:3"), (3, "hex:0234550132:4")])
def test_a_folding_of_a_circuit_in_another_order_is_written_by_python(tmp_path, crease, canonical):
    folding = Folding(Circuit.from_notation("hex:2345501320"), crease)
    (path,) = save(folding, tmp_path / "a.fold")
    assert [str(own) for own in recognise_design(read_fold(str(path))).foldings] == [canonical]


@pytest.mark.parametrize(
    ("name", "chosen", "message"),
    [
        ("a.svg", {"kerf_mm": -1.0}, "kerf_mm cannot be -1.0: give a number from 0 to 10"),
        ("a.svg", {"kerf_mm": math.nan}, "kerf_mm cannot be nan"),
        ("a.svg", {"kerf_mm": "1"}, "kerf_mm cannot be '1'"),
        ("a.svg", {"sheet": "panels", "hinge_gap_mm": -3}, "hinge_gap_mm cannot be -3: give a number from 0$"),
        ("a.svg", {"sheet": "apart"}, "sheet cannot be 'apart': choose assembled or panels"),
        ("a.svg", {"profile": "plotter"}, "profile cannot be 'plotter': choose laser or simulator"),
        ("a.stl", {"state": "half"}, "'half' is no state"),
        ("a.stl", {"state": 2.0}, "'2.0' is no state"),
        ("a.xml", {"timestep_s": 0}, "timestep_s cannot be 0: give a number from 1e-09 to 1"),
        ("a.csv", {"motion": "spring"}, "motion cannot be 'spring': give 'path' or 'springs'"),
        ("", {}, "an empty name has no known ending"),
    ],
)
def test_python_refuses_what_the_command_refuses(tmp_path, monkeypatch, name, chosen, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(HcsearchError, match=message):
        save(DESIGN, name, **chosen)
    assert not list(tmp_path.iterdir())


def test_a_whole_number_is_a_share_of_the_motion():
    assert [ExportSettings(state=share).state for share in (0, 1)] == [0.0, 1.0]


def test_files_beside_are_written_with_the_first_or_not_at_all(tmp_path, monkeypatch):
    files = {".urdf": "<robot/>", ".closure.json": b"{}"}
    monkeypatch.setitem(EXPORT_FORMATS, "urdf", ExportFormat("urdf", (".urdf",), "a robot", lambda value: files))
    paths = save(DESIGN, tmp_path / "a.urdf")
    assert [path.name for path in paths] == ["a.urdf", "a.closure.json"]
    assert paths[1].read_bytes() == b"{}"
    (tmp_path / "b.closure.json").mkdir()
    with pytest.raises(OutputError):
        save(DESIGN, tmp_path / "b.urdf")
    assert not (tmp_path / "b.urdf").exists()


def test_states_are_ends_or_shares_of_the_motion():
    assert [read_export_state(text) for text in ("flat", "folded", "0", "0.25")] == ["flat", "folded", 0.0, 0.25]
    value = exported(MOVING, "csv")
    assert value.angles(0.0) == pytest.approx(value.motion.angles[0])
    assert value.angles(1.0) == pytest.approx(value.motion.angles[-1])
    for text in ("1.5", "nan", "-1", ""):
        with pytest.raises(HcsearchError, match="is no state"):
            read_export_state(text)
    with pytest.raises(OutputError, match="there is no format 'obj'"):
        export_format_of("a.obj", "obj")


def test_check_takes_a_file_through_every_stage(run):
    assert run("export", MOVING, "--output", "mine.fold", "--panel", "60x7").exit_code == 0
    result = run("check", "mine.fold", "--json")
    report = json.loads(result.output)
    assert (report["circuit"], report["panel_mm"]) == (MOVING.rpartition(":")[0], "60x60x7")
    assert [folding["folding"] for folding in report["foldings"]] == [MOVING]
    assert result.exit_code == (0 if report["foldings"][0]["status"] == "deploys" else 1)
    assert list(report["funnel"].values())[1:5] == [1, 1, 1, 1]
    again = run("check", "mine.fold", "--json", "--panel", "50x6", "--flat-pairs", "rigid")
    assert json.loads(again.output)["panel_mm"] == "50x50x6"


def test_check_reports_each_stage_of_each_untwisted_folding():
    calls = []
    circuit = Circuit.from_notation("hex:0234435011")
    scene = replace(SCENES["default"], seconds=0.01)
    checked = check_circuit(circuit, scene, [1, 4], lambda *call: calls.append(call))
    assert [verdict.folding.crease for verdict in checked.verdicts] == [1, 4]
    assert calls == [(done, 2, stage) for done in (0, 1) for stage in ("mobility", "motion", "deployment")]


def test_check_says_the_same_of_a_circuit_in_any_order(run):
    name = MOVING.rpartition(":")[0]
    word = name.partition(":")[2]
    moved = "hex:" + "".join(str((int(d) + 2) % 6) for d in word[3:] + word[:3])
    one, two = run("check", f"{name}:4"), run("check", moved)
    assert one.exit_code == two.exit_code
    assert one.output.splitlines()[0] == two.output.splitlines()[0]
    assert f"{MOVING}: " in two.output
    assert "; springs: no set that was tried with hinged flat pairs brings it flat" in two.output


def test_the_command_that_check_prints_repeats_the_deployment(run):
    Path("moon.toml").write_text("[scene]\ngravity = [0.0, 0.0, -0.1]\n", encoding="utf-8")
    options = ("--scene", "moon.toml", "--panel", "52x6", "--flat-pairs", "hinged", "--seconds", "0.5")
    *_, reason, gap, command = run("check", MOVING, *options).output.splitlines()
    program, *words = shlex.split(command)
    assert (program, words) == (
        "hcsearch",
        ["deploy", MOVING, "--scene", "moon.toml, 52x52x6", "--seconds", "0.5", "--flat-pairs", "hinged"],
    )
    seconds = reason.split()[2]
    assert f"flat after {seconds} s" in run(*words).output
    assert gap.startswith("  leave 0.0624 mm between faces")


def test_check_simulates_for_as_long_as_it_is_asked_to(run):
    result = run("check", MOVING, "--seconds", "0.05")
    assert result.exit_code == 1
    assert "springs: moving at 0.05 s" in result.output


def test_check_ends_with_1_where_nothing_folds(run):
    result = run("check", "hex:024")
    assert (result.exit_code, "two-stack foldings           0" in result.output) == (1, True)


def test_check_says_how_much_memory_too_many_panels_would_take(run):
    long = "square:" + 999 * "0" + "1" + 999 * "2" + "3"
    message = refusal(run("check", long))
    assert "planning the motions of 2,000 panels takes about 4.5 GB of memory, more than 2 GB" in message
    assert "at most 1,200 panels" in message


def test_check_says_what_it_leaves_out_of_a_file(run):
    line = {"vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1], [2, 2]], "frame_unit": "parsec"}
    line |= {"edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [2, 4]], "edges_assignment": [*"BBBBVU"]}
    Path("line.fold").write_text(json.dumps(line), encoding="utf-8")
    result = run("check", "line.fold")
    assert "line.fold is no design of a grid, as panel 0 at (0.667, 0.333) has one crease" in result.stderr
    assert "line.fold: frame_unit 'parsec' is no unit of length" in result.stderr
    assert "line.fold: edge 5 from (1, 1) to (2, 2) ends at no other edge" in result.stderr


def test_check_refuses_what_is_no_pattern(run):
    Path("bad.fold").write_text("no JSON", encoding="utf-8")
    assert "bad.fold is no FOLD file" in refusal(run("check", "bad.fold"))
    assert "name a file .fold, or a notation" in refusal(run("check", "nothing"))
    assert "name a file that is there" in refusal(run("check", "none.fold"))
