"""Fold-first search against listing everything and filtering, and the laws it rests on."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import SizeError
from hcsearch.designs.folding import fold, foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.twisting import twist_batch
from hcsearch.search.enumeration import FoldedSearch, PolygonSearch
from tests import golden
from tests.strategies import circuits

NEAR = {
    "hex": range(3, 15),
    "square": range(4, 21, 2),
    "rectangle": range(4, 19, 2),
    "triangle": range(6, 31, 2),
    "rhombus": range(4, 17, 2),
    "kite": range(3, 15),
    "right45": range(4, 23, 2),
    "right30": range(4, 23, 2),
    "obtuse": range(4, 25, 2),
}
FAR = {"hex": (16, 18), "square": (22, 24), "rectangle": (20,), "triangle": (34, 38)}
FAR |= {"rhombus": (18, 20), "kite": (16, 18), "right45": (26, 28), "right30": (26, 28), "obtuse": (30, 36)}

# counted by this search, and once each by listing and filtering
UNTWISTED = {"hex": {18: 218_086, 20: 2_328_698}, "square": {26: 642_693}, "triangle": {38: 116_979}}


@lru_cache(1)
def filtered(grid, n):
    """Circuits that fold, and untwisted ones, as sets of words with their symmetry, by listing all."""
    two_stack, untwisted = set(), set()
    for batch in PolygonSearch(GRIDS[grid], n).batches():
        folded = fold(batch)
        twists = twist_batch(batch, folded)
        named = [(word.tobytes(), int(order)) for word, order in zip(batch.words, batch.symmetry, strict=True)]
        two_stack |= {named[row] for row in folded.row}
        untwisted |= {named[row] for row in folded.row[twists == 0]}
    return {"two-stack": two_stack, "untwisted": untwisted}


def joined(search, batch_size=1000):
    """The same by joining half-chains, shard by shard; nothing may come twice."""
    circuits = [
        (word.tobytes(), int(order))
        for prefix in search.prefixes
        for batch in search.circuits(prefix, batch_size)
        for word, order in zip(batch.words, batch.symmetry, strict=True)
    ]
    assert len(circuits) == len(set(circuits))
    return set(circuits)


def counted(search):
    counts = [search.count(shard) for shard in search.counting_shards]
    return sum(classes for classes, _ in counts), sum(fixed for _, fixed in counts)


def check(grid, n, untwisted):
    search = FoldedSearch(GRIDS[grid], n, untwisted)
    expected = filtered(grid, n)[search.lists]
    assert joined(search) == expected
    assert counted(search) == (len(expected), sum(search.group_order // order for _, order in expected))


@pytest.mark.parametrize("untwisted", [False, True])
@pytest.mark.parametrize(("grid", "n"), [(grid, n) for grid in NEAR for n in NEAR[grid]])
def test_joining_finds_what_filtering_finds(grid, n, untwisted):
    check(grid, n, untwisted)


@pytest.mark.slow
@pytest.mark.parametrize("untwisted", [False, True])
@pytest.mark.parametrize(("grid", "n"), [(grid, n) for grid in FAR for n in FAR[grid]])
def test_joining_finds_what_filtering_finds_far_out(grid, n, untwisted):
    check(grid, n, untwisted)


@pytest.mark.parametrize(("grid", "n"), [(grid, n) for grid, counts in UNTWISTED.items() for n in counts])
def test_untwisted_counts_out_of_reach_of_listing(grid, n):
    assert counted(FoldedSearch(GRIDS[grid], n, untwisted=True))[0] == UNTWISTED[grid][n]


@pytest.mark.parametrize("untwisted", [False, True])
@pytest.mark.parametrize(("grid", "n"), [(grid, n) for grid, n in golden.TILINGS if n % 2 == 0])
def test_joining_finds_the_known_numbers(grid, n, untwisted):
    search = FoldedSearch(GRIDS[grid], n, untwisted)
    known = golden.TILINGS[grid, n][3 if untwisted else 2]
    assert len(joined(search)) == counted(search)[0] == known


@pytest.mark.parametrize("batch_size", [1, 7, 1 << 16])
def test_batches_do_not_depend_on_their_size(batch_size):
    search = FoldedSearch(GRIDS["hex"], 12, untwisted=False)
    words = [word.tobytes() for batch in search.batches(batch_size) for word in batch.words]
    assert words == [word.tobytes() for batch in search.batches(100) for word in batch.words]


def test_units_split_keys_and_join_them(monkeypatch):
    monkeypatch.setattr("hcsearch.search.enumeration.folded._SHARD_PAIRS", 500)
    search = FoldedSearch(GRIDS["hex"], 14, untwisted=True)
    assert any(":" in prefix for prefix in search.prefixes)
    assert any(":" not in prefix for prefix in search.prefixes)
    assert joined(search) == filtered("hex", 14)["untwisted"]
    monkeypatch.setattr("hcsearch.search.enumeration.folded._COUNTED_PAIRS", 800)
    assert any(":" in shard for shard in search.counting_shards)
    assert counted(search)[0] == len(filtered("hex", 14)["untwisted"])


def image(circuit, crease, steps):
    """Face to which `steps` creases, one after the other, carry a crease's face by reflection."""
    m = circuit.grid.directions
    face = crease
    for d in steps:
        face = (2 * d + m // 2 - face) % m
    return face


@given(st.data())
def test_each_half_chain_carries_one_flat_crease_to_the_other(data):
    circuit = data.draw(circuits(even=True))
    m, n, word = circuit.grid.directions, circuit.n, circuit.directions
    for folding in foldings(circuit):
        for start in (folding.crease, folding.opposite):
            inner = [word[(start + i) % n] for i in range(1, n // 2)]
            assert image(circuit, (word[start] + m // 2) % m, inner) == word[(start + n // 2) % n]


@given(st.data())
def test_given_one_folding_one_congruence_tells_the_others(data):
    circuit = data.draw(circuits(even=True))
    m, half, folded = circuit.grid.directions, circuit.n // 2, foldings(circuit)
    for folding in folded:
        turns = np.roll(circuit.turns, -folding.crease - 1)  # from panel j + 1 on
        mine, mate = alternating(turns[:half]), alternating(-turns[: half - 1 : -1])
        flat = {
            (k + folding.crease) % half
            for k in range(1, half)
            if (mine[k - 1] + mate[half - k - 1] - half * (m // 2)) % m == 0
        }
        assert flat == {f.crease % half for f in folded} - {folding.crease % half}


def alternating(turns):
    """Sums of a half-chain's first 1, 2, .. turns with alternating signs (docs/explanation/theory.md, statement 23)."""
    return np.cumsum([(-1) ** t * turn for t, turn in enumerate(turns)])


@pytest.mark.parametrize(("grid", "n"), [("hex", 2), ("hex", 44), ("square", 66), ("triangle", 122), ("hex", 40)])
def test_sizes_out_of_reach_are_refused(grid, n):
    with pytest.raises(SizeError, match="use"):
        len(FoldedSearch(GRIDS[grid], n, untwisted=True).prefixes)


def test_too_many_to_list_can_still_be_counted():
    search = FoldedSearch(GRIDS["square"], 38, untwisted=True)
    with pytest.raises(SizeError, match="hcsearch count --keep untwisted"):
        len(search.prefixes)
    assert search.n_pairs > 2e12
