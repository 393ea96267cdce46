"""The atlas: equal bytes in every run, true counts, files that others read, and a page that searches it."""

import csv
import hashlib
import io
import json
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import zipfile
from pathlib import Path
from unittest import mock

import pytest
from click.testing import CliRunner
from filelock import FileLock

from hcsearch import build_atlas
from hcsearch.basics.errors import NotationError, OutputError, SizeError
from hcsearch.cli import hcsearch
from hcsearch.designs.grid import GRIDS
from hcsearch.motion.certificates.certifying import verify_certificate
from hcsearch.store import open_readonly, select, select_sql
from hcsearch.store.columns import VIEWS
from hcsearch.web.atlas.atlas_card import table_columns
from tests import golden
from tests.commands import without_progress
from tests.report.browser import driven

pytestmark = pytest.mark.extra
SMALL = {"n": 8, "until": "twist"}
ORDER = ["hex", "kite", "obtuse", "rectangle", "rhombus", "right30", "right45", "square", "triangle"]


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """All designs with up to eight panels."""
    return build_atlas(tmp_path_factory.mktemp("atlas") / "small", jobs=1, **SMALL)


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """Six hexagons, through all stages: one ring, which springs open."""
    return build_atlas(tmp_path_factory.mktemp("atlas") / "proved", n=6, grids=["hex"], jobs=1)


def contents(path):
    return {file.relative_to(path).as_posix(): file.read_bytes() for file in Path(path).rglob("*") if file.is_file()}


def terms(path):
    lines = [line for line in path.read_text(encoding="ascii").splitlines() if not line.startswith("#")]
    return {int(index): int(value) for index, value in map(str.split, lines)}


def test_a_killed_atlas_goes_on_and_has_the_same_bytes_with_other_jobs(small, tmp_path):
    path = tmp_path / "again"
    words = ("atlas", "--output", str(path), "--n", "8", "--until", "twist", "--jobs", "2")
    with subprocess.Popen([sys.executable, "-m", "hcsearch", *words], stdout=subprocess.DEVNULL) as running:
        while not (path / "work" / "designs.sqlite").exists() and running.poll() is None:
            time.sleep(0.01)
        time.sleep(0.5)
        running.send_signal(signal.SIGKILL)
    assert not (path / "SHA256SUMS").exists()
    assert (path / "work").is_dir()
    again = build_atlas(path, jobs=2, **SMALL)
    assert again.checksum == small.checksum
    assert contents(path) == contents(small.path)


def test_a_finished_atlas_is_checked_and_left(small, tmp_path):
    path = shutil.copytree(small.path, tmp_path / "copy")
    times = {file: file.stat().st_mtime_ns for file in path.rglob("*")}
    assert build_atlas(path, **SMALL).checksum == small.checksum
    assert {file: file.stat().st_mtime_ns for file in path.rglob("*")} == times
    with (path / "bfiles" / "b284869.txt").open("a", encoding="ascii") as file:
        file.write("9 9\n")
    with pytest.raises(OutputError, match=r"b284869\.txt is missing or was changed"):
        build_atlas(path, **SMALL)


@pytest.mark.parametrize(
    ("kept", "fault"),
    [
        (lambda sums: "", "has no checksum of datapackage.json"),
        (lambda sums: "".join(one for one in sums if "index.html" not in one), "has no checksum of index.html"),
        (lambda sums: "".join(one for one in sums if "README.md" not in one), "has no checksum of README.md"),
        (lambda sums: "".join(sums)[:-1], "has a line that is not a checksum, two spaces and a name"),
        (lambda sums: "".join(sums).replace("  ", " "), "has a line that is not a checksum, two spaces and a name"),
    ],
)
def test_checksums_that_are_not_whole_are_refused(small, tmp_path, kept, fault):
    path = shutil.copytree(small.path, tmp_path / "copy")
    sums = (path / "SHA256SUMS").read_text(encoding="utf-8").splitlines(keepends=True)
    (path / "SHA256SUMS").write_text(kept(sums), encoding="utf-8")
    with pytest.raises(OutputError, match=f"SHA256SUMS {fault}: remove .* and build the atlas anew"):
        build_atlas(path, **SMALL)


def test_files_that_others_add_are_not_counted(small, tmp_path):
    path = shutil.copytree(small.path, tmp_path / "copy")
    (path / "notes.txt").write_text("mine", encoding="utf-8")
    (path / "bfiles" / "notes.txt").write_text("mine", encoding="utf-8")
    again = build_atlas(path, **SMALL)
    assert (again.files, again.size) == (small.files, small.size)
    assert (small.files, small.size) == (len(contents(small.path)), sum(map(len, contents(small.path).values())))


@pytest.mark.parametrize("begun", [False, True])
def test_work_left_beside_a_whole_atlas_is_removed(small, tmp_path, begun):
    path = shutil.copytree(small.path, tmp_path / "copy")
    (path / "work").mkdir()
    if begun:
        request = json.loads((path / "datapackage.json").read_text(encoding="utf-8"))["hcsearch"]
        (path / "work" / "request.json").write_text(json.dumps(request), encoding="utf-8")
        (path / "work" / "certificates").mkdir()
    assert build_atlas(path, **SMALL).checksum == small.checksum
    assert not (path / "work").exists()


@pytest.mark.parametrize("name", ["thesis.txt", "request.json", "download.part"])
def test_a_folder_named_work_that_is_not_of_the_atlas_is_left(small, tmp_path, name):
    path = shutil.copytree(small.path, tmp_path / "copy")
    (path / "work").mkdir()
    (path / "work" / name).write_text('{"url": "mine"}', encoding="utf-8")
    assert build_atlas(path, **SMALL).checksum == small.checksum
    assert contents(path / "work") == {name: b'{"url": "mine"}'}
    (path / "SHA256SUMS").unlink()
    with pytest.raises(OutputError, match="work is not the work of an atlas: move it away, or name another folder"):
        build_atlas(path, **SMALL)
    assert contents(path / "work") == {name: b'{"url": "mine"}'}


@pytest.mark.parametrize("name", ["work", "designs", "work/draft", "work/certificates"])
def test_links_to_folders_are_refused_before_the_search(small, tmp_path, monkeypatch, name):
    path = tmp_path / "atlas"
    (path / "work").mkdir(parents=True)
    request = json.loads((small.path / "datapackage.json").read_text(encoding="utf-8"))["hcsearch"]
    (path / "work" / "request.json").write_text(json.dumps(request), encoding="utf-8")
    (tmp_path / "elsewhere").mkdir()
    if name == "work":
        (path / "work").rename(tmp_path / "elsewhere" / "work")
    else:
        (tmp_path / "elsewhere" / "work").mkdir()
    (path / name).symlink_to(tmp_path / "elsewhere" / "work")
    before = contents(tmp_path)
    monkeypatch.setattr("hcsearch.api.building_atlas.run_enumeration", mock.Mock(side_effect=AssertionError))
    reason = "is not the work of an atlas" if name == "work" else "is a link to a folder elsewhere"
    with pytest.raises(OutputError, match=f"{path / name} {reason}: move it away, or name another folder"):
        build_atlas(path, **SMALL)
    assert contents(tmp_path) == before


def test_a_link_named_work_beside_a_whole_atlas_is_left(small, tmp_path):
    path = shutil.copytree(small.path, tmp_path / "copy")
    (tmp_path / "mine").mkdir()
    (path / "work").symlink_to(tmp_path / "mine")
    assert build_atlas(path, **SMALL).checksum == small.checksum
    assert (path / "work").is_symlink()
    assert (tmp_path / "mine").is_dir()


def test_folders_of_something_else_are_refused_and_left(small, tmp_path):
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="is not empty and holds no atlas"):
        build_atlas(tmp_path / "own", **SMALL)
    assert contents(tmp_path / "own") == {"thesis.txt": b"mine"}
    (tmp_path / "other" / "work").mkdir(parents=True)
    (tmp_path / "other" / "work" / "request.json").write_text('{"url": "a", "n": 8}', encoding="utf-8")
    with pytest.raises(OutputError, match="other is not empty and holds no atlas: name another folder"):
        build_atlas(tmp_path / "other", **SMALL)
    with pytest.raises(OutputError, match="holds an atlas of n 8, not of n 7: name another folder"):
        build_atlas(small.path, n=7, until="twist")
    with pytest.raises(SizeError, match="n = 2 is too small"):
        build_atlas(tmp_path / "none", n=2)
    with pytest.raises(SizeError, match=r"--n 10{12} is too large to list on this grid"):
        build_atlas(tmp_path / "none", n=10**12)
    with pytest.raises(NotationError, match="an atlas needs a grid"):
        build_atlas(tmp_path / "none", grids=[])
    assert not (tmp_path / "none").exists()


def test_two_processes_do_not_build_one_atlas(tmp_path):
    (tmp_path / "work").mkdir()
    with FileLock(tmp_path / "work" / "lock"), pytest.raises(OutputError, match="another process builds the atlas"):
        build_atlas(tmp_path, **SMALL)


def test_the_command_prints_the_checksum_and_refuses_in_one_line(small, tmp_path):
    path = shutil.copytree(small.path, tmp_path / "copy")
    done = CliRunner().invoke(hcsearch, ["atlas", "--output", str(path), "--n", "8", "--until", "twist"])
    assert done.exit_code == 0
    assert done.stdout.splitlines()[0] == f"{small.designs:,} designs, {small.foldings:,} foldings"
    assert done.stdout.endswith(f"{small.checksum}\n")
    words = [sys.executable, "-m", "hcsearch", "atlas", "--output", str(path), "--until", "nothing"]
    refused = subprocess.run(words, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert len(without_progress(refused.stderr).splitlines()) == 1


def test_b_files_have_the_published_counts(small):
    folder = small.path / "bfiles"
    for number, name in (
        ("A036418", "A036418"),
        ("A284869", "A284869"),
        ("A002931", "A002931"),
        ("A266549", "A266549"),
        ("A006774", "A006774"),
        ("A258206", "A258206 honeycomb"),
        ("A005397", "A005397"),
    ):
        counted = terms(folder / f"b{number[1:]}.txt")
        published = golden.values(name)
        shared = counted.keys() & published.keys()
        assert len(shared) >= 2
        assert {index: counted[index] for index in shared} == {index: published[index] for index in shared}
        assert list(counted) == list(range(min(counted), max(counted) + 1))
    check_tilings(folder, 8)


def check_tilings(folder, most):
    """Counts on the grids that the OEIS does not have, and of designs that fold."""
    for (grid, n), (fixed, free, two_stack, untwisted, *_) in golden.TILINGS.items():
        if n <= most:
            if grid != "rhombus":
                assert terms(folder / f"{grid}-circuits.txt")[n] == fixed
            numbers = {"classes": free, "two_stack": two_stack, "untwisted": untwisted}
            assert {name: terms(folder / f"{grid}-{name}.txt")[n] for name in numbers} == numbers
    for (grid, n), (_, _, two_stack, untwisted) in golden.FOLDABLE.items():
        if n <= most:
            assert terms(folder / f"{grid}-two_stack.txt")[n] == two_stack
            assert terms(folder / f"{grid}-untwisted.txt")[n] == untwisted


def test_parquet_partitions_hold_the_views(small):
    import pyarrow.dataset

    with open_readonly(small.path / "atlas.sqlite") as database:
        for view in ("designs", "foldings"):
            found = pyarrow.dataset.dataset(small.path / view, partitioning="hive")
            names = [quantity.name for quantity in table_columns(view)]
            assert found.schema.names == [*names, "grid", "n"]
            units = {quantity.name: quantity.unit for quantity in VIEWS[view]}
            assert all(found.schema.field(name).metadata[b"unit"].decode() == units[name] for name in names)
            keys = [(key, "ascending") for key in ("id", "design_id", "crease") if key in names]
            rows = found.to_table().sort_by(keys).select(names).to_pylist()
            assert rows == select(database, view=view, columns=names).records()
            schemas = [one.physical_schema for one in found.get_fragments()]
            assert all(schema.equals(schemas[0], check_metadata=True) for schema in schemas)


def test_pandas_reads_numbers_of_panels_as_numbers(small):
    import pandas as pd

    for view in ("designs", "foldings"):
        table = pd.read_parquet(small.path / view)
        assert pd.api.types.is_integer_dtype(table.n)
        assert not isinstance(table.grid.dtype, pd.CategoricalDtype)
        with open_readonly(small.path / "atlas.sqlite") as database:
            joined = f"{view} AS v JOIN designs AS d ON d.id = v.{table.columns[0]}"
            (count,) = select_sql(database, f"SELECT count(*) FROM {joined} WHERE d.n >= 7").rows[0]
        assert len(table[table.n >= 7]) == count > 0
        some = pd.read_parquet(small.path / view, filters=[("grid", "==", "hex"), ("n", ">", 6)])
        assert len(some) == ((table.grid == "hex") & (table.n > 6)).sum() > 0
        assert list(table[table.columns[0]]) == sorted(table[table.columns[0]])  # files are in the order of sizes


def test_ids_are_in_the_order_of_grid_size_and_circuit(small):
    with sqlite3.connect(small.path / "atlas.sqlite") as connection:
        rows = connection.execute("SELECT id, grid, n, circuit FROM designs ORDER BY id").fetchall()
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
        assert connection.execute("SELECT count(*) FROM runs").fetchone() == (0,)
    connection.close()
    assert [row[0] for row in rows] == list(range(1, small.designs + 1))
    assert [row[1:] for row in rows] == sorted(row[1:] for row in rows)
    assert list(dict.fromkeys(row[1] for row in rows)) == ORDER == sorted(GRIDS)


def test_the_card_names_all_files_and_columns(proved):
    files = contents(proved.path)
    sums = dict(line.split("  ")[::-1] for line in files["SHA256SUMS"].decode().splitlines())
    assert sums == {name: hashlib.sha256(text).hexdigest() for name, text in files.items() if name != "SHA256SUMS"}
    description = json.loads(files["datapackage.json"])
    named = {path for resource in description["resources"] for path in resource["path"]}
    assert named == set(sums) - {"README.md", "datapackage.json"}
    fields = {field["name"]: field for field in description["resources"][0]["schema"]["fields"]}
    assert fields["least_gap"]["unit"] == "mm"
    card = files["README.md"].decode()
    assert all(f"`{quantity.name}`" in card for quantity in VIEWS["foldings"] if quantity.name != "design_id")
    assert "CC BY 4.0" in card
    assert str(proved.path) not in card + files["index.html"].decode() + files["datapackage.json"].decode()


def test_certificates_hold_and_are_made_once(proved, tmp_path):
    with zipfile.ZipFile(proved.path / "certificates" / "grid=hex" / "n=6.zip") as archive:
        index = list(csv.DictReader(io.StringIO(archive.read("index.csv").decode())))
        texts = {name: archive.read(name) for name in archive.namelist() if name != "index.csv"}
    assert texts
    assert [row["file"] for row in index if row["file"]] == list(texts)
    for row in index:
        if row["file"]:
            assert "; ".join(verify_certificate(json.loads(texts[row["file"]]))) == row["proves"]

    def stop(_done, _total, note):
        if note.startswith("certificates, folding 1 of "):
            raise KeyboardInterrupt

    path = tmp_path / "again"
    with pytest.raises(KeyboardInterrupt):
        build_atlas(path, n=6, grids=["hex"], jobs=1, progress=stop)
    (made,) = (path / "work" / "certificates").iterdir()
    before = made.stat().st_mtime_ns
    times = []

    def watch(_done, _total, note):
        times.extend([made.stat().st_mtime_ns] if note.endswith(", made before") else [])

    assert build_atlas(path, n=6, grids=["hex"], jobs=1, progress=watch).checksum == proved.checksum
    assert times == [before]


def test_the_page_searches_all_designs(small):
    page = small.path.with_name("index.html")
    page.write_bytes((small.path / "index.html").read_bytes())
    driver = """
    const find = document.getElementById("find"), state = document.getElementById("state");
    probe.found = ["", "grid=hex n=8 two_stack", "untwisted n<=6", "grid=kite or grid=square"].map((words) => {
      find.value = words;
      find.dispatchEvent(new Event("input", { bubbles: true }));
      return Number(state.textContent.split(" ")[0]);
    });
    """
    probe = driven(page, driver)
    assert probe["errors"] == []
    with open_readonly(small.path / "atlas.sqlite") as database:
        queries = ["", "grid=hex n=8 two_stack", "untwisted n<=6", "grid=kite or grid=square"]
        assert probe["found"] == [len(select(database, query).rows) for query in queries]


@pytest.mark.slow
def test_the_atlas_of_twelve_panels_has_the_counts_of_an_independent_program(tmp_path):
    atlas = build_atlas(tmp_path / "twelve", n=12, until="twist")
    check_tilings(atlas.path / "bfiles", 12)
    assert terms(atlas.path / "bfiles" / "b284869.txt")[12] == 1175
    again = build_atlas(tmp_path / "again", n=12, until="twist", jobs=1)
    assert again.checksum == atlas.checksum
