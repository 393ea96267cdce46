import csv
import json

from click.testing import CliRunner

from hcsearch.cli import hcsearch
from tests import golden


def test_the_quick_bench(tmp_path):
    arguments = ["bench", "enumeration", "--quick", "--limit", "2", "--output", str(tmp_path / "out")]
    result = CliRunner().invoke(hcsearch, [*arguments, "--json", str(tmp_path / "all.json")], catch_exceptions=False)
    assert result.exit_code == 0
    files_are_there(tmp_path, result.stdout)
    counts_are_the_published_ones(json.loads((tmp_path / "all.json").read_text()))
    every_engine_is_in_the_table_finished_or_not(tmp_path, result.stdout)
    the_machine_is_named(tmp_path, result.stdout)


def files_are_there(folder, printed):
    names = {path.name for path in (folder / "out").iterdir()}
    tables = {f"{name}.csv" for name in ("arrays", "listing", "growth", "counting")}
    assert names == tables | {"machine.json", "enumeration.md", "arrays.png", "growth.png"}
    assert (folder / "out" / "growth.png").read_bytes().startswith(b"\x89PNG")
    assert f"saved in {folder / 'out'}" in printed


def counts_are_the_published_ones(data):
    published = golden.values("A003763", step=2)
    counts = {(row["array"], row["circuits"]) for row in data["arrays"] + data["counting"] if not row["note"]}
    assert counts == {("4x4", published[4]), ("6x6", published[6]), ("8x8", published[8])}
    fixed = {
        "hex": golden.values("A036418"),
        "square": golden.values("A002931", step=2),
        "triangle": golden.values("A006774", step=2),
    }
    for row in data["listing"]:
        assert row["fixed"] == fixed[row["grid"]][row["n"]]
        _, free, two_stack, untwisted = golden.FOLDABLE.get((row["grid"], row["n"]), (0, *[None] * 3))
        assert free in (None, row["free"])
        assert two_stack in (None, row["two_stack"])
        assert untwisted in (None, row["untwisted"])


def every_engine_is_in_the_table_finished_or_not(folder, printed):
    with (folder / "out" / "arrays.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["engine"] for row in rows} == {"hcsearch", "Graphillion", "networkx", "Python backtracker"}
    assert all((row["circuits"] == "") == (row["note"] in ("over 2 s", "not installed", "not tried")) for row in rows)
    assert all(row["note"] == "" for row in rows if row["engine"] == "hcsearch")
    assert "Graphillion" in printed


def the_machine_is_named(folder, printed):
    machine = json.loads((folder / "out" / "machine.json").read_text())
    assert {"python", "numba", "numpy", "networkx", "graphillion", "hcsearch"} <= set(machine["versions"])
    assert machine["processor"] in printed
    assert machine["processor"] in (folder / "out" / "enumeration.md").read_text()
