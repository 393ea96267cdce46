import math
import re
import sys

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch_bench.enumeration import arrays
from hcsearch_bench.enumeration.listing import CONNECTIVE, growth_factor
from hcsearch_bench.peers import engines
from hcsearch_bench.peers.backtracker import hamiltonian_circuits
from hcsearch_bench.run.machine import MISSING, this_machine
from hcsearch_bench.run.process import run_measured
from hcsearch_bench.run.table import Table, markdown, text
from hcsearch_bench.run.timing import repeated
from tests import golden, naive


def engine(job):
    (match,) = [engine for engine in engines.ENGINES if engine.job is job]
    return match


def silent(_):
    pass


@pytest.mark.parametrize(("grid", "spec"), [("square", "4x4"), ("square", "5x4"), ("hex", "3-4-3"), ("hex", "p3x3")])
def test_backtracker_finds_every_circuit_once(grid, spec):
    array = parse_array(GRIDS[grid], spec)
    circuits = [
        frozenset(map(frozenset, zip(path, (*path[1:], path[0]), strict=True)))
        for path in hamiltonian_circuits(array.n, [(u, v) for u, v, _ in array.edges()])
    ]
    assert len(set(circuits)) == len(circuits)
    assert set(circuits) == naive.hamiltonian_circuits(array)


@pytest.mark.parametrize("spec", ["3x3", "5x1"])
def test_backtracker_on_arrays_without_circuits(spec):
    array = parse_array(GRIDS["square"], spec)
    assert list(hamiltonian_circuits(array.n, [(u, v) for u, v, _ in array.edges()])) == []


@pytest.mark.parametrize(
    "engine",
    # an engine that is an extra is tried where the extra is installed, with the slow tests
    [pytest.param(e, marks=[pytest.mark.extra] if e.package else []) for e in engines.ENGINES],
    ids=lambda engine: engine.job.__name__,
)
def test_engines_agree_with_the_published_number(engine):
    row = engine.job("square", "6x4", 1)
    (published,) = [entry for entry in golden.table("m x n square grid")["values"] if entry[:2] == [6, 4]]
    circuits, classes = published[2:]
    assert row["circuits"] == circuits
    assert row["classes"] in (None, classes)
    assert row["listed"] in (None, classes, circuits)
    assert row["runs"] == 1


def test_a_peer_past_its_limit_is_reported_and_not_tried_again():
    peer = engine(engines.networkx_list)
    rows = arrays.measure_arrays(
        [("square", "8x6"), ("square", "8x8")], limit=0.5, repeats=1, say=silent, engines=[peer]
    )
    assert [row.note for row in rows] == ["over 0.5 s", "not tried"]
    assert rows[0].circuits is None
    assert rows[0].seconds is None


def test_a_peer_that_is_missing_is_reported():
    absent = engines.Engine("nobody", "list: all", list, "a_package_that_nobody_has")
    (row,) = arrays.measure_arrays([("square", "4x4")], limit=5, repeats=1, say=silent, engines=[absent])
    assert row.note == MISSING


def test_a_peer_that_fails_is_reported():
    broken = engines.Engine("broken", "list: all", math.factorial)
    (row,) = arrays.measure_arrays([("square", "4x4")], limit=60, repeats=1, say=silent, engines=[broken])
    # math.integer.factorial, says Python 3.15
    assert re.fullmatch(r"failed: TypeError: math\.(integer\.)?factorial\(\) takes no keyword arguments", row.note)


def test_different_counts_are_an_error(monkeypatch):
    def measure(grid, spec, engine, **_):
        return arrays.ArrayRow(grid, spec, engine.name, engine.task, circuits=len(engine.name))

    monkeypatch.setattr(arrays, "_measure", measure)
    with pytest.raises(HcsearchError, match=r"square 4x4: engines disagree on circuits: hcsearch, count 8; .* 11"):
        arrays.measure_arrays([("square", "4x4")], limit=1, repeats=1, say=silent)


def test_a_process_is_measured():
    done = run_measured([sys.executable, "-c", "import sys; x = bytearray(64 << 20); print(6); sys.exit(3)"], 60)
    assert (done.status, done.output) == (3, "6\n")
    assert done.peak_mib > 64
    assert done.cpu > 0
    assert 0 < done.wall < 60


def test_a_late_process_is_ended():
    done = run_measured([sys.executable, "-c", "import time; time.sleep(60)"], 0.2)
    assert done.status is None
    assert done.wall < 30


def test_medians_of_repeated_runs():
    runs = iter([{"s": 3.0, "n": 7}, {"s": 1.0, "n": 7}, {"s": 2.0, "n": 7}])
    assert repeated(lambda: next(runs), 3) == {"s": 2.0, "n": 7, "runs": 3}
    differing = iter([{"n": 7}, {"n": 8}])
    with pytest.raises(AssertionError, match="differ in n"):
        repeated(lambda: next(differing), 2)


def test_growth_factor_of_an_exact_power():
    assert growth_factor([10, 12, 14], [5 * 2.5**n for n in (10, 12, 14)]) == pytest.approx(2.5)


@pytest.mark.parametrize(("grid", "name", "step"), [("hex", "A036418", 1), ("square", "A002931", 2)])
def test_published_counts_tend_to_the_connective_constant(grid, name, step):
    # p_n ~ B mu^n n^(-5/2); the last two published numbers give mu to about 1 / n^2
    counts = golden.values(name, step)
    *_, before, last = sorted(counts)
    ratio = counts[last] / counts[before] * (last / before) ** 2.5
    assert ratio ** (1 / (last - before)) == pytest.approx(CONNECTIVE[grid], rel=0.005)


def test_machine_names_what_is_there_and_what_is_not():
    machine = this_machine(("a-package-that-nobody-has",))
    assert machine.cores >= 1
    assert machine.versions["a-package-that-nobody-has"] == MISSING
    assert machine.versions["numpy"] in str(machine)


def test_tables_show_three_figures_exact_integers_and_dashes():
    rows = [
        arrays.ArrayRow("square", "14x14", "one", "count", circuits=56126499620491437281263608, build_s=0.0123456),
        arrays.ArrayRow("square", "14x14", "two", "count", build_s=math.nan, note="over 1 s"),
    ]
    table = Table("arrays", "Title", "About.", rows, hidden=("wall_s",))
    for made in (text(table), markdown(table)):
        assert "56,126,499,620,491,437,281,263,608" in made
        assert "0.0123 " in made
        assert "over 1 s" in made
        assert "wall_s" not in made
        assert "nan" not in made.lower()
