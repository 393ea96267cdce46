import math
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings

from hcsearch.basics.errors import HcsearchError, SizeError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.search.enumeration import ArraySearch, PolygonSearch, count_array, enumerate_circuits
from hcsearch.search.enumeration.array_circuits import array_sweep, frontier_layers
from tests import golden, naive
from tests.strategies import arrays


def listed(grid, n):
    """(classes, fixed) of a listing over all arrays, shard by shard."""
    search = PolygonSearch(GRIDS[grid], n)
    free = fixed = 0
    for prefix in search.prefixes:
        for batch in search.circuits(prefix):
            free += len(batch)
            fixed += int((search.group_order // batch.symmetry).sum())
    return free, fixed


FREE = {
    "hex": golden.values("A284869") | golden.values("free triangular-lattice SAPs"),
    "square": golden.values("A266549", step=2),
    "triangle": golden.values("A258206 honeycomb", step=2),
}
FIXED = {
    "hex": golden.values("A036418"),
    "square": golden.values("A002931", step=2),
    "triangle": golden.values("A006774", step=2),
}
REACH = {"hex": 18, "square": 26, "triangle": 40}
FAR = {"hex": 19, "square": 28, "triangle": 44}


@pytest.mark.parametrize(
    ("grid", "n"), [(grid, n) for grid in REACH for n in FREE[grid] if 3 <= n <= REACH[grid] and n in FIXED[grid]]
)
def test_published_polygon_counts(grid, n):
    assert listed(grid, n) == (FREE[grid][n], FIXED[grid][n])


@pytest.mark.slow
@pytest.mark.parametrize(("grid", "n"), [(grid, n) for grid in FAR for n in FREE[grid] if REACH[grid] < n <= FAR[grid]])
def test_published_polygon_counts_far_out(grid, n):
    assert listed(grid, n) == (FREE[grid][n], FIXED[grid][n])


@pytest.mark.parametrize("n", range(3, 25))
def test_published_polygons_on_the_kagome_lattice(n):
    # A005397 counts the polygons through one of three sites, in either direction
    assert 2 * n * listed("rhombus", n)[1] == 3 * golden.values("A005397")[n]


@pytest.mark.parametrize("n", [*range(3, 29), 33, 40])
def test_polygons_of_3_12_12_are_those_of_honeycombs_with_triangles_for_vertices(n):
    # each vertex of a honeycomb becomes a triangle, of which a polygon takes one edge or two; its edges stay
    grown = sum(
        fixed * math.comb(length, n - 2 * length) for length, fixed in FIXED["triangle"].items() if n >= 2 * length
    )
    assert listed("obtuse", n)[1] == grown + (2 if n == 3 else 0)


@pytest.mark.parametrize("n", range(4, 24, 2))
def test_rectangle_classes_add_up_to_the_same_fixed_polygons(n):
    assert listed("rectangle", n)[1] == FIXED["square"][n]


@pytest.mark.parametrize(("index", "symmetric"), golden.values("A316194").items())
def test_published_symmetric_square_polygons(index, symmetric):
    batches = PolygonSearch(GRIDS["square"], max(2 * index, 3)).batches()
    assert sum(int((batch.symmetry > 1).sum()) for batch in batches) == symmetric


@pytest.mark.parametrize("name", ["hexagon-cell", "square-cell", "triangle-cell"])
def test_published_numbers_of_arrays_with_a_circuit(name):
    grid = {"hexagon-cell": "hex", "square-cell": "square", "triangle-cell": "triangle"}[name]
    for n, circuits, n_arrays, most in golden.table(name)["values"]:
        if n > {"hex": 12, "square": 18, "triangle": 24}[grid]:
            continue
        counts: dict[str, int] = {}
        for circuit in enumerate_circuits(grid, n=n):
            notation = circuit.array.canonical().notation
            counts[notation] = counts.get(notation, 0) + 1
        assert (sum(counts.values()), len(counts), max(counts.values(), default=0)) == (circuits, n_arrays, most)


@pytest.mark.parametrize(
    ("grid", "n"),
    [("hex", n) for n in range(3, 10)]
    + [("square", 4), ("square", 8), ("square", 10), ("square", 12)]
    + [("rectangle", 8), ("rectangle", 10), ("triangle", 6), ("triangle", 10), ("triangle", 12), ("triangle", 14)]
    + [(grid, n) for grid in ("rhombus", "kite") for n in range(3, 13)]
    + [(grid, n) for grid, most in (("right45", 18), ("right30", 16)) for n in range(4, most + 1, 2)]
    + [("obtuse", n) for n in range(3, 19)],
)
def test_one_circuit_of_every_class_against_the_naive_walk(grid, n):
    everything = naive.polygons(GRIDS[grid], n)
    met = set()
    for circuit in enumerate_circuits(grid, n=n):
        images = naive.congruent(circuit.grid, naive.pairs(circuit))
        assert circuit.canonical() == circuit
        assert images <= everything
        assert not images & met
        met |= images
    assert met == everything


def array_totals(array):
    """Circuits by summing over the classes listed, and classes."""
    total = classes = 0
    for _, symmetry in ArraySearch(array).masks():
        classes += len(symmetry)
        total += int((array.symmetry // symmetry).sum())
    return total, classes


def array_cases():
    cases = []
    for m, n, total, free in golden.table("m x n square grid")["values"]:
        cases.append(("square", f"{m}x{n}", total, free))
    for m, n, total, free in golden.table("m x n parallelogram")["values"]:
        cases.append(("hex", f"p{m}x{n}", total, free))
    for side, total, free in golden.table("triangle with s points")["values"]:
        cases.append(("hex", f"t{side}", total, free))
    for side, total, free in golden.table("hexagon with s points")["values"]:
        if free is not None:
            cases.append(("hex", f"h{side}", total, free))
    return cases


@pytest.mark.parametrize(("grid", "spec", "total", "free"), array_cases())
def test_published_array_counts_listed_and_counted(grid, spec, total, free):
    array = parse_array(GRIDS[grid], spec)
    counted = count_array(array)
    assert (counted.circuits, counted.classes) == (total, free)
    if total < 50_000_000:
        assert array_totals(array) == (total, free)


@pytest.mark.parametrize(("half", "free"), [(k, v) for k, v in golden.values("A209077").items() if k <= 7])
def test_published_square_arrays_up_to_symmetry_without_listing(half, free):
    counted = count_array(parse_array(GRIDS["square"], f"{2 * half}x{2 * half}"))
    assert (counted.circuits, counted.classes) == (golden.values("A003763")[half], free)


@pytest.mark.parametrize(("n", "total"), [(n, v) for n, v in golden.values("A222200").items() if n <= 13])
def test_published_n_by_n_plus_one(n, total):
    assert count_array(parse_array(GRIDS["square"], f"{n}x{n + 1}")).circuits == total


def test_published_rectangles_and_parallelograms():
    triangle = iter(golden.table("A321172")["values"])
    for m in range(2, 11):
        for n in range(2, m + 1):
            assert count_array(parse_array(GRIDS["square"], f"{m}x{n}")).circuits == next(triangle)
    antidiagonals = iter(golden.table("A339849")["values"])
    for total in range(4, 13):
        for k in range(2, total - 1):
            value = next(antidiagonals)
            if k <= total - k:
                assert count_array(parse_array(GRIDS["hex"], f"p{total - k}x{k}")).circuits == value


@pytest.mark.parametrize(("side", "total"), [(n, v) for n, v in golden.values("A112676").items() if 3 <= n <= 13])
def test_published_triangles_of_hexagons(side, total):
    # the index counts points a side from 1, with 1 for the single point
    assert count_array(parse_array(GRIDS["hex"], f"t{side}")).circuits == total


@pytest.mark.parametrize(
    ("grid", "spec"),
    [
        *((grid, spec) for grid in ("rhombus", "kite", "right30", "obtuse") for spec in ("t2", "p1x1")),
        *(("rhombus", spec) for spec in ("h1", "h2", "s1", "p3x2", "2-3-2", "3-2")),
        *(("kite", spec) for spec in ("t3", "h1", "3-2")),
        *(("right45", spec) for spec in ("3x2", "4x2", "p1x1", "p3x2", "2x2", "4x3")),
        *(("obtuse", spec) for spec in ("t3", "h1")),
    ],
)
def test_circuits_of_small_arrays_against_the_naive_walk(grid, spec):
    array = parse_array(grid, spec)
    counted = count_array(array)
    assert counted.circuits == len(naive.hamiltonian_circuits(array))
    assert (counted.circuits, counted.classes) == array_totals(array)


@pytest.mark.parametrize(
    ("grid", "spec", "total", "free"),
    [("right45", "6x4", 21, 8), ("kite", "s1", 8, 2), ("kite", "p3x2", 123, 66), ("right30", "2-3-2", 733, 74)],
)
def test_counting_and_listing_agree_on_larger_arrays(grid, spec, total, free):
    array = parse_array(grid, spec)
    counted = count_array(array)
    assert (counted.circuits, counted.classes) == array_totals(array) == (total, free)


def test_hexagon_of_side_five():
    total = golden.table("hexagon with s points")["values"][-1][1]
    assert count_array(parse_array(GRIDS["hex"], "h5")).circuits == total


@settings(max_examples=300)
@given(arrays(max_cells=16))
def test_array_listing_and_counting_against_the_naive_walk(array):
    everything = naive.hamiltonian_circuits(array)
    counted = count_array(array)
    assert counted.circuits == len(everything)
    listed_circuits = list(enumerate_circuits(array=array))
    assert counted.classes == len(listed_circuits)
    images = [naive.congruent(array.grid, naive.pairs(circuit)) for circuit in listed_circuits]
    assert len(frozenset().union(*images)) == sum(map(len, images))
    assert sum(circuit.orbit_size for circuit in listed_circuits) == len(everything)
    assert all(circuit.array.canonical() == array.canonical() for circuit in listed_circuits)


@settings(max_examples=100)
@given(arrays(max_cells=14))
def test_the_frontier_graph_never_dies_after_its_dead_states_are_left_out(array):
    search = ArraySearch(array)
    assert search.n_circuits == len(naive.hamiltonian_circuits(array))
    batches = [batch for prefix in search.prefixes for batch in search.circuits(prefix, batch_size=1)]
    assert all(len(batch) == 1 for batch in batches)


def test_shards_and_small_batches_give_the_same_circuits_as_one_walk():
    for search in (ArraySearch(parse_array(GRIDS["square"], "8x6")), PolygonSearch(GRIDS["hex"], 14)):
        whole = np.concatenate([batch.words for batch in search.batches()])
        batches = [batch.words for prefix in search.prefixes for batch in search.circuits(prefix, batch_size=100)]
        assert max(map(len, batches)) <= 100
        assert {w.tobytes() for w in np.concatenate(batches)} == {w.tobytes() for w in whole}
        assert sum(map(len, batches)) == len(whole)


def test_results_are_lazy_at_any_size():
    for circuit in islice(enumerate_circuits("square", n=60), 5):
        assert circuit.n == 60
    for circuit in enumerate_circuits(array=parse_array(GRIDS["square"], "12x12"), limit=5):
        assert circuit.n == 144
        assert circuit.array.canonical().notation == "square:" + ".".join(["fff"] * 12)


@pytest.mark.parametrize(
    ("grid", "n"),
    [("square", 7), ("triangle", 8), ("triangle", 5), ("rectangle", 5), ("rhombus", 4), ("right45", 9), ("right30", 5)],
)
def test_no_circuits_is_a_result(grid, n):
    assert list(enumerate_circuits(grid, n=n)) == []


@pytest.mark.parametrize("spec", ["3x3", "1x5", "2x1", "1x1", "5x7"])
def test_arrays_without_circuits(spec):
    array = parse_array(GRIDS["square"], spec)
    assert count_array(array).circuits == 0
    assert list(enumerate_circuits(array=array)) == []


@pytest.mark.parametrize("n", [-1, 0, 2, 121])
def test_sizes_out_of_reach(n):
    with pytest.raises(SizeError, match="--n"):
        PolygonSearch(GRIDS["hex"], n)


def test_arrays_too_wide():
    with pytest.raises(SizeError, match="too wide"):
        count_array(parse_array(GRIDS["square"], "40x40"))
    with pytest.raises(SizeError, match="too many to store"):
        _ = ArraySearch(parse_array(GRIDS["square"], "12x12")).prefixes


def test_enumerate_circuits_needs_one_target():
    with pytest.raises(HcsearchError, match="give a grid and n"):
        enumerate_circuits("hex")


def test_frontier_states_are_what_the_sweep_says():
    sweep = array_sweep(parse_array(GRIDS["square"], "4x4"))
    layers = list(frontier_layers(sweep))
    assert len(layers) == 24
    assert sweep.width == 5


def test_circuits_of_python_are_ready_for_use():
    (circuit,) = enumerate_circuits("triangle", n=6)
    assert circuit == Circuit.from_notation("triangle:012345")
