"""The stage `mobility`: whole batches against one linkage at a time, and published freedoms."""

from collections import Counter
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.vocabulary import WAYS
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, fold, folding_at, foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.records import NO_NUMBER, CircuitBatch, FoldingBatch, MobilityBatch, StagedDesigns
from hcsearch.designs.twisting import twist_batch
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.search.enumeration import ArraySearch, FoldedSearch, PolygonSearch
from hcsearch.search.stages import mobility
from hcsearch.search.stages.statuses import best_foldings
from hcsearch.shape.linkage import Linkage
from tests.strategies import circuits, congruences


def run(search):
    """All circuits of a search through the stages."""
    batches = list(search.batches())
    words = np.concatenate([batch.words for batch in batches])
    batch = CircuitBatch(search.grid.name, words, np.ones(len(words), np.int16))
    return stages(batch)


def stages(batch):
    folded = fold(batch)
    twists = twist_batch(batch, folded)
    return batch, folded, twists, mobility.mobility_of_batch(batch, folded, twists)


PANELS = {"hex": 10, "square": 12, "triangle": 14, "rectangle": 10, "kite": 10, "right30": 12, "obtuse": 14}
PANELS |= {"rhombus": 12, "right45": 16}


@pytest.mark.parametrize(("grid", "n"), [("hex", 8), *PANELS.items()])
def test_batches_agree_with_one_linkage_at_a_time(grid, n):
    batch, folded, twists, freedoms = run(PolygonSearch(GRIDS[grid], n))
    panel = default_panel(grid)
    for i, (row, crease, twist) in enumerate(zip(folded.row, folded.crease, twists, strict=True)):
        folding = Folding(Circuit(GRIDS[grid], tuple(batch.words[row].tolist())), int(crease))
        hinged = Linkage(folding.pattern(panel, flat_pairs="hinged"))
        assert freedoms.kutzbach == hinged.pattern.kutzbach
        for angles, dof in ((hinged.folded, freedoms.dof_folded[i]), (hinged.flat, freedoms.dof_flat[i])):
            assert dof == rank_at(hinged, angles).nullity == n - whole_end(hinged, angles).rank
        assert freedoms.merged_panels[i] == len(folding.mirror_pairs)
        merged = Linkage(folding.pattern(panel, flat_pairs="merged"))
        if folding.mirror_pairs:
            assert freedoms.kutzbach_merged[i] == merged.pattern.kutzbach
        else:
            assert freedoms.kutzbach_merged[i] == freedoms.dof_merged[i] == NO_NUMBER
        if twist:
            assert freedoms.dof[i] == NO_NUMBER
            assert not freedoms.locked[i]
            assert not freedoms.locked_hinged[i]
            continue
        assert freedoms.dof[i] == generic_rank(hinged).nullity
        rigid = Linkage(folding.pattern(panel))
        assert freedoms.locked[i] == any(lock_at(rigid, angles).locked for angles in (rigid.folded, rigid.flat))
        # what is locked with hinged flat pairs is locked with rigid ones, whose motions are motions of the others
        locked = any(lock_at(hinged, angles).locked for angles in (hinged.folded, hinged.flat))
        assert freedoms.locked_hinged[i] == (freedoms.locked[i] and locked)
    assert not (freedoms.locked_hinged & ~freedoms.locked).any()
    assert mobility.locked_in_every_way(freedoms, ("rigid", "merged")).tolist() == freedoms.locked.tolist()
    for flat_pairs in (("hinged",), WAYS):
        assert mobility.locked_in_every_way(freedoms, flat_pairs).tolist() == freedoms.locked_hinged.tolist()


@pytest.mark.parametrize(("grid", "n"), [("hex", 10), ("square", 12)])
@pytest.mark.parametrize("thickness", [1e-3, 0.02])
def test_locks_with_other_panels(grid, n, thickness):
    batch, folded, _, freedoms = run(PolygonSearch(GRIDS[grid], n))
    locks = freedoms.locked, freedoms.locked_hinged
    assert mobility.locks_with_panel(batch, folded, locks, default_panel(grid)) == locks
    other = (*default_panel(grid)[:2], thickness)
    orders = []
    for hinged, (before, own) in enumerate(
        zip(locks, mobility.locks_with_panel(batch, folded, locks, other), strict=True)
    ):
        assert not (own & ~before).any()
        for i in np.flatnonzero(before).tolist():
            folding = folding_at(batch, folded, i)
            known = Linkage(folding.pattern(default_panel(grid), flat_pairs=("rigid", "hinged")[hinged]))
            order = min(lock_at(known, angles).order or 3 for angles in (known.folded, known.flat))
            assert own[i] or order == 2  # locks of first order do not depend on the size of panels
            orders.append(order)
    assert 1 in orders


def test_freedoms_of_the_thesis():
    """6 x 5 rectangles: 24; merged 19 where one loop is left, 14 where two are; 4 x 4: 6 (thesis 3.2.2, 4.1.1)."""
    *_, freedoms = run(ArraySearch(parse_array(GRIDS["rectangle"], "6x5")))
    assert freedoms.kutzbach == 24
    merged = Counter(zip(freedoms.kutzbach_merged.tolist(), freedoms.merged_panels.tolist(), strict=True))
    assert {key: merged[key] for key in merged if key[1]} == {(19, 5): 3, (14, 5): 4}
    *_, freedoms = run(ArraySearch(parse_array(GRIDS["rectangle"], "4x4")))
    assert {6, 1} <= set(freedoms.kutzbach_merged.tolist())


def test_the_cut_hinge_of_the_thesis_4x4():
    """Merged: 12 hinges, six loop rows of rank 5 folded and 4 flat; of the cut hinge's five rows one less each."""
    folding = foldings(Circuit.from_notation("rectangle:0122233300012210"))[-1]
    assert len(folding.mirror_pairs) == 4
    linkage = Linkage(folding.pattern((0.05, 0.04, 0.006), flat_pairs="merged"))
    assert [rank_at(linkage, angles).nullity for angles in (linkage.folded, linkage.flat)] == [7, 8]
    assert generic_rank(linkage).nullity == 6


@pytest.mark.parametrize(
    ("grid", "n", "untwisted", "locked", "hinged"),
    [
        ("hex", 10, 40, 14, 2),
        ("hex", 12, 131, 10, 0),
        ("square", 12, 42, 2, 0),
        ("triangle", 10, 2, 0, 0),
        ("triangle", 14, 5, 1, 0),
        ("kite", 12, 54, 5, 0),
        ("rhombus", 14, 46, 0, 0),
    ],
)
def test_how_many_foldings_are_locked(grid, n, untwisted, locked, hinged):
    _, _, twists, freedoms = run(FoldedSearch(GRIDS[grid], n, untwisted=True))
    counted = (twists == 0, freedoms.locked, freedoms.locked_hinged)
    assert tuple(int(flags.sum()) for flags in counted) == (untwisted, locked, hinged)


@given(st.data())
def test_freedoms_and_locks_do_not_depend_on_the_way_a_circuit_is_given(data):
    circuit = data.draw(circuits(even=True).filter(foldings))
    moved = data.draw(congruences(circuit))
    outcomes = []
    for one in (circuit, moved):
        _, _, twists, freedoms = stages(
            CircuitBatch(one.grid.name, np.array([one.word], np.int8), np.ones(1, np.int16))
        )
        columns = (
            freedoms.dof,
            freedoms.dof_merged,
            freedoms.dof_folded,
            freedoms.dof_flat,
            freedoms.merged_panels,
            freedoms.kutzbach_merged,
            freedoms.locked,
            freedoms.locked_hinged,
            twists,
        )
        outcomes.append(sorted(zip(*(column.tolist() for column in columns), strict=True)))
    assert outcomes[0] == outcomes[1]


def test_an_empty_batch_has_no_rows():
    *_, freedoms = stages(CircuitBatch("hex", np.empty((0, 6), np.int8), np.empty(0, np.int16)))
    assert len(freedoms.dof) == len(freedoms.locked) == len(freedoms.locked_hinged) == 0


def test_best_foldings_have_the_lowest_dof_then_crease():
    """Four circuits: a tie, an undecided dof, a twisted folding with the lowest dof, and no untwisted one."""
    folded = FoldingBatch(np.array([0, 0, 0, 1, 1, 2, 2, 3]), np.array([5, 3, 1, 0, 2, 0, 4, 0]))
    twists = np.array([0, 0, 0, 0, 0, 1, 0, 2], np.int16)
    dof = np.array([4, 4, 5, NO_NUMBER, 6, 1, 7, 1])
    columns = {field.name: dof for field in fields(MobilityBatch)} | {
        "kutzbach": 4,
        "locked": dof > 0,
        "locked_hinged": dof > 5,
    }
    words = np.zeros((4, 8), np.int8)
    circuits = CircuitBatch("hex", words, np.ones(4, np.int16))
    designs = StagedDesigns(circuits, np.ones(4), folded)
    best = best_foldings(designs.with_folding_results(twist=twists, mobility=MobilityBatch(**columns)))
    assert best.tolist() == [1, 4, 6, -1]
