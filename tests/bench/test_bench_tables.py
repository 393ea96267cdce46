import csv

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS
from hcsearch_bench.tables.funnels import FunnelRow, Patience, check_laws
from hcsearch_bench.tables.one_array import measure_hexagon_rows, measure_rectangles, row_lengths
from tests import golden
from tests.strategies import words

FIXED = {
    "hex": golden.values("A036418"),
    "square": golden.values("A002931", step=2),
    "rectangle": golden.values("A002931", step=2),
    "triangle": golden.values("A006774", step=2),
}
FREE = {
    "hex": golden.values("A284869"),
    "square": golden.values("A266549", step=2),
    "triangle": golden.values("A258206 honeycomb", step=2),
}
ARRAYS = {"hex": "hexagon-cell arrays", "square": "square-cell arrays", "triangle": "triangle-cell arrays"}


def silent(_):
    pass


def number(text):
    return (float(text) if "." in text else int(text)) if text else None


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    result = CliRunner().invoke(hcsearch, ["bench", "tables", "--quick", "--output", str(folder)])
    assert result.exit_code == 0, result.output
    return folder


@pytest.fixture(scope="module")
def designs(quick):
    with (quick / "tables" / "designs.csv").open() as file:
        return [{k: v if k == "grid" else number(v) for k, v in row.items()} for row in csv.DictReader(file)]


def test_one_command_writes_the_page_and_its_files(quick):
    names = {path.name for path in (quick / "tables").iterdir()}
    assert names == {"designs.csv", "rectangles.csv", "hexagon-rows.csv", "machine.json"}
    page = (quick / "tables.md").read_text()
    assert all(f"## {title}" in page for title in ("All arrays of n cells", "Full rectangles", "Hexagons in rows"))


def test_circuits_are_the_published_ones(designs):
    full = [row for row in designs if row["free"] is not None]
    assert {row["grid"] for row in full} == set(GRIDS)
    for row in full:
        if row["grid"] in FIXED:
            assert row["fixed"] == FIXED[row["grid"]][row["n"]]
        if row["grid"] in FREE:
            assert row["free"] == FREE[row["grid"]][row["n"]]


def test_circuits_of_the_further_grids_are_those_of_an_independent_program(designs):
    shared = [row for row in designs if (row["grid"], row["n"]) in golden.TILINGS and row["free"] is not None]
    assert len(shared) > 20
    for row in shared:
        counted = tuple(row[name] for name in ("fixed", "free", "two_stack", "untwisted"))
        assert counted == golden.TILINGS[row["grid"], row["n"]][:4]


def test_t_is_always_divisible_but_on_hexagons(designs):
    counted = {(row["grid"], row["n"]): (row["divisible"], row["free"]) for row in designs if row["n"] % 2 == 0}
    assert all(divisible == free for (grid, _), (divisible, free) in counted.items() if grid != "hex")
    by_words = {}
    for n in (4, 6, 8, 10):
        turns = [Circuit(GRIDS["hex"], word).turns for word in words("hex", n)]
        by_words[n] = sum((sum(t[::2]) - sum(t[1::2])) % 6 == 0 for t in turns), len(turns)
    assert by_words == {n: counted["hex", n] for n in by_words}
    assert all(row["divisible"] is row["share"] is None for row in designs if row["n"] % 2)


@pytest.mark.parametrize("grid", ARRAYS)
def test_arrays_are_those_of_an_independent_program(designs, grid):
    counts = {entry[0]: entry[2] for entry in golden.table(ARRAYS[grid])["values"]}
    compared = [row for row in designs if row["grid"] == grid and row["free"] and row["n"] in counts]
    assert compared
    assert all(row["arrays"] == counts[row["n"]] for row in compared)


def test_designs_are_those_of_an_independent_program(designs):
    compared = {(row["grid"], row["n"]): (row["two_stack"], row["untwisted"]) for row in designs}
    shared = golden.FOLDABLE.keys() & compared
    assert len(shared) >= 10
    assert all(golden.FOLDABLE[key][2:] == compared[key] for key in shared)


def test_what_is_only_counted_leaves_the_rest_open(designs):
    last = next(row for row in designs if (row["grid"], row["n"]) == ("hex", 12))
    assert (last["two_stack"], last["untwisted"]) == (239, 88)
    assert last["fixed"] is last["free"] is last["arrays"] is last["untwisted_arrays"] is None


def test_rectangles_are_the_published_ones():
    rows = {row.array: row for row in measure_rectangles(24, ["6x5"], limit=60, say=silent)}
    published = {f"{a}x{b}": (circuits, classes) for a, b, circuits, classes in golden.table("m x n square")["values"]}
    assert len(rows.keys() & published) >= 8
    for spec in rows.keys() & published:
        assert (rows[spec].circuits, rows[spec].classes) == published[spec]
    assert [rows["6x5"].two_stack, rows["6x5"].unfolded] == [43, 1]


def test_a_rectangle_that_takes_too_long_has_no_numbers():
    rows = measure_rectangles(6, [], limit=1e-9, say=silent)
    assert [row.circuits for row in rows] == [None, None]


def test_rows_of_hexagons():
    rows = {row.array: row for row in measure_hexagon_rows(12, say=silent)}
    assert (rows["4-4-4"].untwisted, rows["4-4-4"].least_twist) == (0, 1)
    assert rows["3-4-3"].untwisted > 0
    assert not {"1-2", "2-1"} <= rows.keys(), "congruent arrays have one row"


def test_row_lengths():
    assert row_lengths(4) == [(1, 1), (1, 2), (2, 1), (1, 1, 1), (2, 2), (1, 1, 2), (1, 2, 1), (2, 1, 1), (1, 1, 1, 1)]


@pytest.mark.parametrize(
    ("row", "law"),
    [
        (FunnelRow("hex", 8, 123, 16, 14, None, None, 2, 3, 1), "two-stack >= untwisted"),
        (FunnelRow("hex", 8, 123, 16, 14, 6, 0.375, 7, 1, 1), "divisible >= two-stack"),
        (FunnelRow("square", 8, 7, 3, 3, 2, 0.667, 1, 1, 1), "divisible everywhere but on hexagons"),
        (FunnelRow("hex", 8, 123, 16, 17, None, None, 2, 1, 1), "free >= arrays"),
        (FunnelRow("hex", 9, None, None, None, None, None, 1, 0, None), "n is odd"),
        (FunnelRow("triangle", 20, None, None, None, None, None, 12, 1, None), "4 divides n"),
    ],
)
def test_a_broken_law_is_one_line(row, law):
    with pytest.raises(HcsearchError, match=f"breaks a law: .*{law}.*; report this$"):
        check_laws(row)


def test_what_was_late_once_is_not_tried_again():
    patience, tried = Patience(1e-9), []

    def work(progress):
        tried.append(True)
        progress(1, 2, "")

    assert [patience.run("task", work), patience.run("task", work)] == [None, None]
    assert len(tried) == 1
