"""Counts for several n, and the sequences of the OEIS that they are."""

import csv
import io
import json
import subprocess
import sys

import pytest

from hcsearch import HcsearchError, count, count_array, parse_array
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.grid.sequences import known_sequences
from tests import golden
from tests.commands import run_here

TERMS = {
    "a(n)": lambda n, circuits: (n, circuits),
    "a(n/2)": lambda n, circuits: (n / 2, circuits),
    "a(n) 3 / 2n": lambda n, circuits: (n, circuits * 2 * n / 3),
}
SPECS = {"2kx2k": "{2k}x{2k}", "kx(k+1)": "{k}x{k+1}", "tk": "t{k}"}


@pytest.fixture
def run(capfd):
    def call(*words, code=0):
        done = run_here(words, capfd)
        assert done.returncode == code, done.stderr + done.stdout
        return done

    return call


def test_several_sizes_are_the_counts_of_each():
    table = count(grid="hex", n=[10, 6, 7], keep="untwisted")
    assert [row.n for row in table.rows] == [6, 7, 10]
    for row in table.rows:
        kept, everything = count(grid="hex", n=row.n, keep="untwisted"), count(grid="hex", n=row.n)
        assert (row.kept_circuits, row.kept_classes) == (kept.circuits, kept.classes)
        assert (row.circuits, row.classes) == (everything.circuits, everything.classes)
    assert [row.ratio for row in table.rows] == [None, None, 210 / 6]


def test_all_circuits_beside_those_that_fold_are_left_out_where_they_are_too_many(monkeypatch):
    monkeypatch.setattr("hcsearch.api.counting._LISTED_BESIDE", 100)
    few, many = count(grid="hex", n=[6, 12], keep="untwisted").rows
    assert (few.circuits, few.kept_circuits) == (15, 6)
    assert (many.circuits, many.classes, many.kept_circuits) == (None, None, 974)


def test_the_growth_of_hexagons_is_that_of_the_triangular_lattice():
    table = count(grid="hex", n=range(3, 17))
    assert abs(table.biased_growth.mu - 4.150797) <= table.biased_growth.mu_error < 0.2
    assert table.growth == table.rows[-1].growth
    assert [row.growth is None for row in table.rows[:6]] == [True] * 5 + [False]
    assert [row.ratio for row in table.rows[:2]] == [None, 1.5]


def test_odd_rows_of_squares_are_empty():
    table = count(grid="square", n=range(4, 22))
    assert all(row.growth is None and row.ratio is None for row in table.rows if row.n % 2)
    assert table.growth == table.rows[-2].growth is not None


def test_a_table_is_a_pandas_table_of_integers_of_any_size():
    frame = count(grid="square", n=[4, 5, 6]).table()
    assert frame["circuits"].tolist() == [1, 0, 2]
    assert frame["circuits_oeis"].tolist() == ["A002931"] * 3
    assert frame["mu"].isna().all()


@pytest.mark.parametrize("sequence", known_sequences(), ids=lambda s: f"{s.number}-{s.grid}")
def test_known_sequences_are_what_is_counted(sequence):
    assert sequence.grid in GRIDS
    if sequence.number in ("A321172", "A339849"):  # tables, compared in test_enumeration
        assert golden.table(sequence.number)["values"]
        return
    published = golden.values("A258206 honeycomb" if sequence.number == "A258206" else sequence.number)
    compared = 0
    for k in range(3, 9) if sequence.array else range(8, 14, 2):
        if sequence.array:
            sizes = {"{2k}": 2 * k, "{k}": k, "{k+1}": k + 1}
            spec = SPECS[sequence.array]
            for name, size in sizes.items():
                spec = spec.replace(name, str(size))
            if max(sizes.values()) > 12:
                continue
            index, term = k, getattr(count_array(parse_array(sequence.grid, spec)), sequence.counts)
        else:
            index, term = TERMS[sequence.term](k, getattr(count(grid=sequence.grid, n=k), sequence.counts))
        assert term == published[index]
        compared += 1
    assert compared >= 3


def test_csv_and_json_hold_the_same_rows(run):
    words = ("count", "--grid", "triangle", "--n", "6,8-10")
    records = list(csv.DictReader(io.StringIO(run(*words, "--format", "csv").stdout)))
    assert [(r["n"], r["circuits"], r["classes_oeis"]) for r in records] == [
        ("6", "1", "A258206"),
        ("8", "0", "A258206"),
        ("9", "0", "A258206"),
        ("10", "3", "A258206"),
    ]
    same = json.loads(run(*words, "--format", "json").stdout)
    assert [{k: "" if v is None else str(v) for k, v in row.items()} for row in same] == records


def test_one_row_for_one_size_and_for_one_array(run):
    assert run("count", "--grid", "hex", "--n", "6", "--format", "csv").stdout == "n,circuits,classes\n6,15,4\n"
    done = run("count", "--grid", "square", "--array", "4x4", "--keep", "untwisted", "--format", "json")
    assert json.loads(done.stdout) == [
        {"array": "square:f.f.f.f", "n": 16, "keep": "untwisted", "circuits": 6, "classes": 2}
    ]


def test_the_table_for_people_names_growth_and_sequences(run):
    lines = run("count", "--grid", "hex", "--n", "6-13").stdout.splitlines()
    assert lines[0].split() == ["n", "circuits", "classes", "ratio", "mu"]
    assert lines[2].split() == ["6", "15", "4", "-", "-"]
    assert lines[9].split()[:3] == ["13", "45144", "3807"]
    assert lines[9].split()[-1] in lines[11]
    assert lines[-2:] == ["all circuits       OEIS A036418", "their classes      OEIS A284869"]


@pytest.mark.parametrize(
    ("sizes", "reason"),
    [
        ("6-x", "is no number of panels: write 12, a range 6-16 or a list 6,8,10"),
        ("16-6", "is empty: write the smaller number first"),
        ("6,,8", "is no number of panels"),
        ("6,8,6", "n = 6 is given twice"),
        ("2-6", "--n 2 is too small"),
        ("6-120", "is too large to list"),
        ("1-999999", "has more than 1000 numbers"),
    ],
)
def test_wrong_sizes_are_refused_in_one_line(run, sizes, reason):
    done = run("count", "--grid", "hex", "--n", sizes, code=2)
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""


def test_several_sizes_are_no_array(run):
    done = run("count", "--grid", "hex", "--n", "6-8", "--array", "3-4-3", code=2)
    assert "give either --n" in done.stderr
    with pytest.raises(HcsearchError, match="at least one"):
        count(grid="hex", n=[])
    with pytest.raises(HcsearchError, match="count: n"):
        count(grid="hex", n=["6"])


def test_counting_loads_no_database():
    lines = "import sys, hcsearch; hcsearch.count(grid='hex', n=6); print('sqlalchemy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
