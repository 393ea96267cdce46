import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import NotationError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, fold, folding_of, foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.twisting import gauss_linking, twist, twist_batch
from hcsearch.search.enumeration import ArraySearch, PolygonSearch, enumerate_circuits
from tests import golden, naive
from tests.strategies import circuits, congruences, rewritten


def counts(search):
    """(fixed or on the array, classes, two-stack, untwisted, foldings, untwisted foldings)."""
    total = free = two_stack = untwisted = n_foldings = n_untwisted = 0
    for batch in search.batches():
        folded = fold(batch)
        twists = twist_batch(batch, folded)
        total += int((search.group_order // batch.symmetry).sum())
        free += len(batch)
        two_stack += len(np.unique(folded.row))
        untwisted += len(np.unique(folded.row[twists == 0]))
        n_foldings += len(folded)
        n_untwisted += int((twists == 0).sum())
    return total, free, two_stack, untwisted, n_foldings, n_untwisted


@pytest.mark.parametrize(("grid", "n"), golden.FOLDABLE)
def test_known_two_stack_and_untwisted_counts(grid, n):
    assert counts(PolygonSearch(GRIDS[grid], n))[:4] == golden.FOLDABLE[grid, n]


@pytest.mark.parametrize(("grid", "n"), golden.TILINGS)
def test_known_counts_on_further_tilings(grid, n):
    assert counts(PolygonSearch(GRIDS[grid], n)) == golden.TILINGS[grid, n]


@pytest.mark.parametrize("spec", golden.FOLDABLE_ARRAYS)
def test_known_counts_on_square_arrays(spec):
    assert counts(ArraySearch(parse_array(GRIDS["square"], spec)))[:4] == golden.FOLDABLE_ARRAYS[spec]


def test_brick_wall_of_twelve_hexagons_has_two_foldings_both_twisted():
    # thesis Fig. 3.15 and 3.16
    search = ArraySearch(parse_array(GRIDS["hex"], "4-4-4"))
    (batch,) = search.batches()
    pair = fold(batch)
    assert twist_batch(batch, pair).tolist() == [1, 1]
    assert counts(search)[:4] == (12, 6, 2, 0)


def test_ten_hexagons_have_a_circuit_with_two_adjacent_untwisted_foldings():
    # thesis Fig. 3.12
    (batch,) = ArraySearch(parse_array(GRIDS["hex"], "3-4-3")).batches()
    creases = [
        [(f.crease, twist(f)) for f in foldings(Circuit(GRIDS["hex"], tuple(word)))] for word in batch.words.tolist()
    ]
    assert any(len(c) == 2 and c[1][0] - c[0][0] in (1, 4) and {t for _, t in c} == {0} for c in creases)


@given(st.data())
def test_foldings_are_those_whose_reflected_edges_coincide(data):
    circuit = data.draw(congruences(data.draw(circuits())))
    creases = [folding.crease for folding in foldings(circuit)]
    assert creases == naive.folding_creases(circuit)
    assert creases == list(naive.creases_with_opposite_image(circuit))


@given(circuits(even=True))
def test_twist_is_the_gauss_linking_number(circuit):
    for folding in foldings(circuit):
        assert abs(gauss_linking(folding)) == twist(folding)


@pytest.mark.parametrize(
    ("grid", "n"), [("rhombus", 12), ("kite", 12), ("right45", 18), ("right30", 16), ("obtuse", 22)]
)
def test_twists_on_further_tilings_are_gauss_linking_numbers(grid, n):
    found = [folding for circuit in enumerate_circuits(grid, n=n) for folding in foldings(circuit)]
    assert len(found) == golden.TILINGS[grid, n][4]
    twists = [abs(gauss_linking(folding)) for folding in found]
    assert twists == list(map(twist, found))
    assert twists.count(0) == golden.TILINGS[grid, n][5] < len(found)


@given(st.data())
def test_number_of_foldings_and_twists_do_not_depend_on_the_way_a_circuit_is_given(data):
    circuit = data.draw(circuits(even=True))
    moved = data.draw(congruences(circuit))
    assert sorted(map(twist, foldings(moved))) == sorted(map(twist, foldings(circuit)))


@given(circuits(even=True))
def test_twist_changes_sign_under_reflection(circuit):
    mirror = next(isometry for isometry in circuit.grid.point_group if isometry.sign < 0)
    mirrored = rewritten(circuit, mirror, 0, backwards=False)
    signed = [gauss_linking(folding) for folding in foldings(circuit)]
    assert [gauss_linking(folding) for folding in foldings(mirrored)] == [-lk for lk in signed]


@given(circuits(even=True))
def test_layers_hinges_and_assignment(circuit):
    half = circuit.n // 2
    for folding in foldings(circuit):
        first, second = folding.stacks
        assert sorted(first + second) == list(range(circuit.n))
        assert [folding.layers[p] for p in first] == [folding.layers[p] for p in second] == list(range(half))
        assert [k for k, a in enumerate(folding.assignment) if a == "flat"] == [folding.crease, folding.opposite]
        for k, (assigned, face) in enumerate(zip(folding.assignment, folding.hinge_faces, strict=True)):
            low, high = sorted((folding.layers[k], folding.layers[(k + 1) % circuit.n]))
            if assigned == "flat":
                assert low == high
                continue
            assert high == low + 1
            # the lowest layer has its top face up, so the faces that meet above layer t are tops for even t
            assert face == ("top" if low % 2 == 0 else "bottom")
            assert assigned == ("valley" if face == "top" else "mountain")
        kinds = folding.assignment
        # thesis 3.1 says the numbers always differ by two; without the flat creases that holds for n = 0 mod 4 only
        assert kinds.count("valley") - kinds.count("mountain") == (2 if circuit.n % 4 == 0 else 0)
        assert {folding.hinge_faces[k] for k in (folding.crease, folding.opposite)} == (
            {"bottom"} if circuit.n % 4 == 0 else {"top", "bottom"}
        )


@given(circuits(even=True))
def test_all_foldings_of_a_circuit_have_the_same_twist(circuit):
    # docs/explanation/theory.md, statement 10
    assert len({twist(folding) for folding in foldings(circuit)}) <= 1


@pytest.mark.parametrize("n", [12, 16, 20, 24, 28])
def test_triangles_never_fold_untwisted_where_four_divides_n(n):
    # docs/explanation/theory.md, statement 14
    total, _, two_stack, untwisted, *_ = counts(PolygonSearch(GRIDS["triangle"], n))
    assert untwisted == 0
    assert two_stack > 0 or total < 10


def test_full_rectangles_are_untwisted_and_one_of_them_has_circuits_that_do_not_fold():
    # docs/explanation/theory.md, statements 12 and 13, and the counter-example on 8 x 7
    for spec in ("4x3", "4x4", "5x4", "6x4", "6x6", "8x4", "8x5"):
        _, free, two_stack, untwisted, *_ = counts(ArraySearch(parse_array(GRIDS["square"], spec)))
        assert free == two_stack == untwisted
    _, free, two_stack, untwisted, *_ = counts(ArraySearch(parse_array(GRIDS["square"], "8x7")))
    assert (free, two_stack, untwisted) == (75547, 75545, 75545)


def test_odd_circuits_do_not_fold():
    assert len(fold(next(PolygonSearch(GRIDS["hex"], 9).batches()))) == 0


def test_folding_by_either_crease_and_a_crease_that_does_not_fold():
    circuit = next(circuit for circuit in enumerate_circuits("hex", n=6) if foldings(circuit))
    folding = foldings(circuit)[0]
    assert folding_of(circuit, folding.opposite) == folding == Folding(circuit, folding.crease)
    assert str(folding) == f"{circuit}:{folding.crease}"
    with pytest.raises(NotationError, match=r"at crease 0 or any other, as an odd number of panels, 3, .*: choose"):
        folding_of(Circuit.from_notation("hex:024"), 0)


@pytest.mark.parametrize(
    "search",
    [PolygonSearch(GRIDS[grid], n) for grid, n in (("hex", 8), ("square", 12), ("rhombus", 12), ("right45", 14))],
    ids=str,
)
def test_foldings_exist_at_their_creases_alone(search):
    for batch in search.batches():
        for word in batch.words.tolist():
            circuit = Circuit(search.grid, tuple(word))
            creases = {folding.crease for folding in foldings(circuit)}
            for crease in range(-1, circuit.n + 1):
                if crease in creases:
                    assert Folding.from_notation(Folding(circuit, crease).notation) == Folding(circuit, crease)
                else:
                    with pytest.raises(NotationError, match="has no two-stack folding at crease"):
                        Folding(circuit, crease)


def folds_around(folding):
    """Folds from a flat crease on, the same for either crease, direction and face."""
    folds = folding.assignment
    starts = [folds[k:] + folds[:k] for k in (folding.crease, folding.opposite)]
    starts += [fold[:1] + fold[:0:-1] for fold in starts]
    other = {"flat": "flat", "valley": "mountain", "mountain": "valley"}
    return min(starts + [tuple(other[fold] for fold in start) for start in starts])


@given(circuits(even=True).flatmap(lambda circuit: st.tuples(st.just(circuit), congruences(circuit))))
def test_notations_of_foldings_are_read_back_whatever_the_order_of_their_circuit(pair):
    circuit, moved = pair
    read = [Folding.from_notation(folding.notation) for folding in foldings(moved)]
    for folding, again in zip(foldings(moved), read, strict=True):
        assert again.circuit == circuit
        assert folds_around(again) == folds_around(folding)
    if circuit.symmetry == 1:
        assert sorted(read, key=lambda folding: folding.crease) == foldings(circuit)


@pytest.mark.parametrize(
    "text", ["hex:0234550132", "hex:0234550132:x", "17:4:1", "hex", "", "hex:024:0", "hex:02345501324:1"]
)
def test_what_is_no_notation_of_a_folding_is_refused(text):
    with pytest.raises(NotationError):
        Folding.from_notation(text)


def test_a_notation_may_have_any_position_order_and_opposite():
    folding = Folding.from_notation("hex:0234550132:3")
    assert Folding.from_notation("hex:0234550132:8") == folding
    turned = "".join(str((int(step) + 1) % 6) for step in "0234550132")
    assert Folding.from_notation(f"hex:{turned}:3") == folding
