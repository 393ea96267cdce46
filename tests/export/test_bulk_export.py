"""Exports of all designs of a query: what is written, kept and left out, and what a name is as against a query."""

import csv
import io
from pathlib import Path
from zipfile import ZipFile

import networkx as nx
import pytest
from click.testing import CliRunner

from hcsearch import save, save_designs
from hcsearch.basics.errors import HcsearchError, OutputError, QueryError
from hcsearch.cli import hcsearch
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import column_names, open_database, open_readonly, select
from hcsearch.subjects.resolve import is_query
from tests.export.exports import MOVING
from tests.judging import judge


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A database of 10 hexagons with verdicts in two scenes."""
    path = tmp_path_factory.mktemp("bulk") / "hex.sqlite"
    circuit = MOVING.rpartition(":")[0]
    with open_database(path, create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), database)
        judge(database, [(circuit, 3, "movable", None, None), (circuit, 4, "locked", None, None)])
        judge(database, [(circuit, 4, "deploys", 1.0, 0.1), (circuit, 3, "locked", None, None)], "solar", key="p#0/2")
    return path


@pytest.fixture(scope="module")
def unjudged(tmp_path_factory):
    """A database of 8 hexagons without verdicts."""
    path = tmp_path_factory.mktemp("bulk") / "twist.sqlite"
    with open_database(path, create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 8), "twist"), database)
    return path


@pytest.fixture
def run(tmp_path, monkeypatch, place):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HCSEARCH_DB", str(place))

    def call(*words):
        return CliRunner().invoke(hcsearch, words)

    return call


def rows_of(place, query, columns):
    with open_readonly(place) as database:
        return select(database, query, columns=columns).rows


def index_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def refusal(result):
    assert isinstance(result.exception, HcsearchError), result.output
    return str(result.exception)


def test_each_design_of_a_query_gets_the_file_that_it_has_alone(run, place, tmp_path):
    result = run("export", "two_stack", "symmetry>1", "--output", "sheets", "--format", "svg", "--kerf", "0.2")
    assert (result.exit_code, result.stdout) == (0, "sheets\n")
    count = sum(number for (number,) in rows_of(place, "two_stack symmetry>1", "n_foldings"))
    ids = [number for (number,) in rows_of(place, "two_stack symmetry>1", "id")]
    index = index_of(Path("sheets/index.csv").read_text(encoding="utf-8"))
    assert list(dict.fromkeys(int(row["id"]) for row in index)) == ids
    assert {path.name for path in Path("sheets").iterdir()} == {"index.csv", *(row["file"] for row in index)}
    assert f"{count} written" in result.stderr
    for row in index:
        assert row["file"] == f"{row['id']}-{row['design'].rpartition(':')[2]}.svg"
        (alone,) = save(row["design"], tmp_path / "alone.svg", kerf_mm=0.2, db=place)
        assert (Path("sheets") / row["file"]).read_bytes() == alone.read_bytes()


def test_the_best_folding_is_that_of_the_scene(run, place):
    (number,) = next(iter(rows_of(place, f"circuit={MOVING.rpartition(':')[0]}", "id")))
    assert run("export", f"id={number}", "--output", "one", "--format", "step").exit_code == 0
    assert run("export", f"id={number}", "--output", "two", "--format", "step", "--scene", "solar").exit_code == 0
    assert Path(f"one/{number}-3.step").is_file()
    assert Path(f"two/{number}-4.step").is_file()


def test_an_export_to_a_folder_goes_on_where_it_was_interrupted(place, tmp_path):
    folder = tmp_path / "sheets"

    def interrupt(done, total, note):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save_designs("untwisted", folder, format="step", db=place, progress=interrupt)
    early = len(list(folder.glob("*.step")))
    assert early >= 3
    times = {path: path.stat().st_mtime_ns for path in folder.glob("*.step")}
    saved = save_designs("untwisted", folder, format="step", db=place)
    total = len(list(folder.glob("*.step")))
    assert total > 20
    assert (saved.written, saved.kept, saved.left_out) == (total - early, early, 0)
    assert all(path.stat().st_mtime_ns == time for path, time in times.items())
    assert not list(folder.glob(".*"))


def test_files_of_other_inputs_are_written_anew_and_lost_ones_too(unjudged, tmp_path):
    def saved(**changed):
        done = save_designs("two_stack", tmp_path / "solids", format="stl", db=unjudged, **changed)
        return done.written, done.kept

    count, _ = saved()
    assert count > 2
    assert saved() == (0, count)
    changes = ({"panel": "60x7"}, {"flat_pairs": "hinged"}, {"state": "folded"}, {"values": {"spring": "linear:0.3"}})
    for changed in changes:
        assert saved(**changed) == (count, 0)
        assert saved(**changed) == (0, count)
    assert saved() == (count, 0)
    next((tmp_path / "solids").glob("*.stl")).unlink()
    assert saved() == (1, count - 1)


def test_a_database_without_verdicts_is_exported_with_panels_of_any_scene(unjudged, place, tmp_path):
    saved = save_designs("untwisted", tmp_path / "a.zip", format="bom", db=unjudged, panel="300x12")
    with ZipFile(tmp_path / "a.zip") as archive:
        bills = [archive.read(name).decode() for name in archive.namelist() if name != "index.csv"]
    assert len(bills) == saved.written > 0
    assert all(",600.0," in bill.splitlines()[1] for bill in bills)  # from corner to corner
    with pytest.raises(HcsearchError, match="no verdicts of the scene"):
        save_designs("untwisted", tmp_path / "b.zip", format="bom", db=place, panel="300x12")


def test_designs_without_a_folding_are_left_out_with_the_reason(run, place):
    result = run("export", "n=10", "--output", "x.zip", "--format", "fold")
    count = len(rows_of(place, "n=10", "id"))
    best = MOVING.rpartition(":")[0]  # its other folding is not written
    numbers = [n if circuit != best else 1 for circuit, n in rows_of(place, "two_stack", "circuit,n_foldings")]
    foldable = sum(numbers)
    assert f"{foldable} written; {count - len(numbers)} designs left out (design " in result.stderr
    with ZipFile("x.zip") as archive:
        assert archive.testzip() is None
        index = index_of(archive.read("index.csv").decode())
        assert len(archive.namelist()) == foldable + 1
    assert all(bool(row["file"]) != row["note"].endswith("hcsearch query 'two_stack'") for row in index)
    assert "can be exported; design 2: 2 does not fold" in refusal(
        run("export", "not", "two_stack", "--output", "y.zip", "--format", "fold")
    )
    assert "can be exported" in refusal(run("export", "not two_stack", "--output", "none", "--format", "fold"))
    assert {path.name for path in Path().iterdir()} == {"x.zip"}


def test_archives_of_equal_files_are_equal(place, tmp_path):
    for name in ("a.zip", "b.zip"):
        save_designs("untwisted", tmp_path / name, format="urdf", db=place)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with ZipFile(tmp_path / "a.zip") as archive:
        (loops,) = [name for name in archive.namelist() if name.startswith("1-") and name.endswith(".closure.json")]
        urdf = archive.read(loops.replace(".closure.json", ".urdf")).decode()
        meshes = [name for name in archive.namelist() if name.startswith("1-") and name.endswith(".stl")]
    assert meshes
    assert all(f'"{name}"' in urdf for name in meshes)


def test_graphs_of_a_query_stand_in_one_file_one_a_line(run, place):
    assert run("export", "n=10", "--output", "all.g6").exit_code == 0
    circuits = [circuit for (circuit,) in rows_of(place, "n=10", "circuit")]
    graphs = nx.read_graph6("all.g6")
    assert len(graphs) == len(circuits)
    for graph, circuit in zip(graphs, circuits, strict=True):
        assert nx.is_isomorphic(graph, Circuit.from_notation(circuit).array.graph())


def test_an_archive_that_fails_leaves_the_old_one(place, tmp_path):
    path = tmp_path / "a.zip"
    path.write_bytes(b"old")

    def interrupt(done, total, note):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save_designs("untwisted", path, format="svg", db=place, progress=interrupt)
    assert [own.read_bytes() for own in tmp_path.iterdir()] == [b"old"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("untwistd", "--output", "a.g6"), "there is no assembly 'untwistd', and it is no query: name DESIGN:CREASE"),
        (("untwistd=1", "--output", "a.g6"), "no column 'untwistd' in designs (did you mean untwisted or"),
        (("n=12", "--output", "a.g6"), "satisfies 'n=12': see hcsearch query"),
        (("n=10", "--output", "a.dxf"), "a.dxf is one file, and a query may have several designs: name a folder"),
        (("n=10", "--output", "a.zip"), "a.zip does not say which files it gets: choose their format with --format"),
        (("n=10", "--output", "sub/"), "sub/ does not say which files it gets"),
        (("n=10", "--output", ""), "an empty name has no known ending"),
        (("n=10", "--output", "a.pdf"), "a.pdf has no known ending"),
        (("n=10", "--output", "none/sub", "--format", "svg"), "there is no folder none"),
        (("n=10", "--output", "a", "--format", "svg", "--motion", "path"), "svg holds no motion"),
        (("n=10", "--output", "a", "--format", "fold", "--kerf", "1"), "fold takes no --kerf"),
        (("n=10", "--output", "a", "--format", "svg", "--scene", "moon"), "no verdicts of the scene 'moon'"),
        (("17", "18", "--output", "a", "--format", "svg"), "cannot read '17': write conditions"),
    ],
)
def test_what_cannot_be_is_one_line_and_writes_nothing(run, words, message):
    assert message in refusal(run("export", *words))
    assert list(Path().iterdir()) == []


def test_a_file_that_is_no_index_is_not_overwritten(place, tmp_path):
    (tmp_path / "index.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(OutputError, match=r"index\.csv is no index of an export: move it"):
        save_designs("untwisted", tmp_path, format="svg", db=place)
    assert [path.name for path in tmp_path.iterdir()] == ["index.csv"]


def test_what_is_a_name_is_no_query():
    names = [*ASSEMBLIES, "17", "17:4", MOVING, "hex:0234550132", "array.toml", "n=12.toml", "hex:99", "panels.fold"]
    queries = ["n=12", "untwisted", "n=12 untwisted", "(untwisted)", "circuit=hex:024", "array=@cells.txt", "n<9"]
    assert [name for name in names if is_query(name)] == []
    assert [query for query in [*queries, *column_names("designs")] if not is_query(query)] == []
    for neither in ("unit-iv", "untwistd", "hex", "-"):
        with pytest.raises(HcsearchError, match=r"there is no assembly .* and it is no query"):
            is_query(neither)


def test_a_query_in_python_is_a_text_of_conditions(place, tmp_path):
    with pytest.raises(QueryError, match="no column 'n_panels'"):
        save_designs("n_panels=10", tmp_path / "a.g6", db=place)
    with pytest.raises(HcsearchError, match="save_designs: query cannot be 10: give a text"):
        save_designs(10, tmp_path / "a.g6", db=place)
