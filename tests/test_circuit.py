import contextlib
import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import NotationError, SizeError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.grid.turning import step_tables
from hcsearch.kernels.circuits.words import array_rows, canonicalise, write_rows
from hcsearch.search.enumeration import FoldedSearch
from hcsearch.search.enumeration.polygon_search import MAX_SEARCH_PANELS
from tests import naive
from tests.strategies import SIZES, circuits, congruences, words


@given(circuits())
def test_notation_round_trips(circuit):
    assert Circuit.from_notation(circuit.notation) == circuit
    assert circuit.canonical() == circuit


@given(st.data())
def test_canonical_form_symmetry_and_foldings_depend_on_the_circuit_alone(data):
    circuit = data.draw(circuits())
    moved = data.draw(congruences(circuit))
    assert moved.canonical() == circuit
    assert moved.symmetry == circuit.symmetry
    assert moved.array.canonical() == circuit.array.canonical()


@given(circuits())
def test_symmetry_is_the_number_of_symmetries_that_fix_the_circuit(circuit):
    images = naive.congruent(circuit.grid, naive.pairs(circuit))
    assert circuit.n_fixed == len(images)
    assert circuit.array.symmetry % circuit.symmetry == 0


@given(st.data())
def test_canonical_form_is_the_least_of_all_writings(data):
    circuit = data.draw(congruences(data.draw(circuits())))
    grid, codes = circuit.grid, step_tables(circuit.grid).codes
    counterclockwise = naive.area(circuit.points) > 0
    keys = []
    for isometry in grid.point_group:
        ahead = [isometry.steps[step] for step in circuit.word]
        back = [grid.backwards[step] for step in reversed(ahead)]
        word = ahead if (isometry.sign > 0) == counterclockwise else back
        for start in range(circuit.n):
            turned = word[start:] + word[:start]
            turns = [int(codes[pair]) for pair in zip(turned, turned[1:] + turned[:1], strict=True)]
            keys.append((turns, grid.step_kinds[turned[0]][0] > 0, turned[0], tuple(turned)))
    *_, least = min(keys)
    assert circuit.canonical().word == least
    assert circuit.symmetry == sum(word == least for *_, word in keys)


NAMED_BY_EDGES = ("rhombus", "kite", "right45", "right30", "obtuse")


@given(st.data())
def test_digits_are_the_edges_of_a_panel_that_is_carried_along_by_reflections(data):
    circuit = data.draw(circuits(NAMED_BY_EDGES).flatmap(congruences))
    grid, cells, creases = circuit.grid, naive.cells(circuit), naive.creases(circuit)
    panels = [[isometry(corner) for corner in grid.polygon] for isometry in grid.point_group]
    moves = [(cells[0][0][0] - min(panel)[0], cells[0][0][1] - min(panel)[1]) for panel in panels]
    panels = [[(x + dx, y + dy) for x, y in panel] for panel, (dx, dy) in zip(panels, moves, strict=True)]
    panel = next(panel for panel in panels if set(panel) == set(cells[0]))
    kind = grid.step_kinds[circuit.word[0]][0]
    digits = [" bcdefghijkl"[kind].strip()]
    for crease in creases:
        edges = [{p, q} for p, q in zip(panel, panel[1:] + panel[:1], strict=True)]
        digits.append(str(edges.index(set(crease))))
        panel = [naive.mirrored(grid, corner, crease) for corner in panel]
    assert circuit.notation == f"{grid.name}:{''.join(digits)}"


@given(circuits())
def test_turns_add_up_to_one_full_turn(circuit):
    assert abs(sum(circuit.turns)) == circuit.grid.directions
    assert len(circuit.creases) == len(set(circuit.creases)) == circuit.n


@given(st.data())
def test_kernels_agree_with_the_plain_forms(data):
    circuit = data.draw(congruences(data.draw(circuits())))
    grid, words = circuit.grid, np.array([circuit.word], np.int8)
    least, symmetry = np.empty_like(words), np.empty(1, np.int16)
    canonicalise(words, step_tables(grid), grid.step_classes, least, symmetry)
    assert (tuple(least[0]), symmetry[0]) == (circuit.canonical().word, circuit.symmetry)
    assert written_array(circuit) == (circuit.array.canonical().notation, circuit.array.symmetry)


def written_array(circuit):
    """The notation of the canonical array of a circuit and its symmetry, by kernels, in the room that searches have."""
    grid, words = circuit.grid, np.array([circuit.word], np.int8)
    room = grid.rows_per_cell * (circuit.n // 2 + 2)
    rows, heights, order = np.empty((1, room), np.uint64), np.empty(1, np.int64), np.empty(1, np.int16)
    array_rows(words, np.array(grid.row_moves), (grid.columns_per_cell, grid.rows_per_cell), rows, heights, order)
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    text = np.zeros((1, len(prefix) + 2 * (circuit.n + room)), np.uint8)
    length = write_rows(rows, heights, prefix, text)
    return bytes(text[0, :length]).decode(), order[0]


@pytest.mark.parametrize("grid", GRIDS.values(), ids=str)
def test_rows_have_bits_for_all_circuits_that_are_searched(grid):
    # the cells of a circuit lie at most half its steps from each other, by the shortest way or a longer one
    with pytest.raises(SizeError):
        FoldedSearch(grid, MAX_SEARCH_PANELS + 2, untwisted=False)
    moves = []
    for (kind, target), (x, y) in zip(grid.step_kinds, grid.steps, strict=True):
        px, py = grid.point((0, 0, kind))
        moves.append((kind, target, grid.cell((px + x, py + y))[:2]))
    for axis, room in ((0, 64 // grid.columns_per_cell), (1, MAX_SEARCH_PANELS // 2 + 2)):
        for start in range(grid.kinds):
            furthest = {start: 0}
            for _ in range(MAX_SEARCH_PANELS // 2):
                longer = [(target, furthest[kind] + move[axis]) for kind, target, move in moves if kind in furthest]
                for kind, reach in longer:
                    furthest[kind] = max(reach, furthest.get(kind, reach))
            assert max(furthest.values()) + 1 <= room


@pytest.mark.parametrize("grid", GRIDS.values(), ids=str)
def test_arrays_of_long_thin_circuits_fit_into_rows(grid):
    circuit = stretched_out(grid)
    assert MAX_SEARCH_PANELS - 10 < circuit.n <= MAX_SEARCH_PANELS
    assert written_array(circuit) == (circuit.array.canonical().notation, circuit.array.symmetry)
    assert len(circuit.array.canonical().rows) <= 11  # so that it is long and thin


def stretched_out(grid):
    """A circuit that grows from a small one as two of its parts, to a translate of a panel and back, are repeated."""
    for n in SIZES[grid.name]:
        for word in words(grid.name, n):
            kinds = [grid.step_kinds[step][0] for step in word]
            ends = [(i, j) for i in range(n) for j in range(i + 1, n) if kinds[i] == kinds[j]]
            moves = {(i, j): np.sum([grid.steps[step] for step in word[i:j]], axis=0) for i, j in ends}
            for (i, j), (k, m) in itertools.product(ends, ends):
                if j <= k and not (moves[i, j] + moves[k, m]).any():
                    more = (MAX_SEARCH_PANELS - n) // (j - i + m - k)
                    with contextlib.suppress(NotationError):  # it meets itself
                        return Circuit(grid, word[:j] + word[i:j] * more + word[j:m] + word[k:m] * more + word[m:])
    raise AssertionError(f"no circuit of {grid} grows")


@pytest.mark.parametrize(
    "text",
    [
        *("hex", "hex:", "hex:02", "hex:0267", "hex:02x", "octagon:024", "square:0022", "square:0000"),
        *(
            "square:00112233x",
            "square:0123 ",
            "triangle:000000",
            "square:012301",
            "hex:024:1",
            "hex:\u0660\u0662\u0664",
        ),
        *(
            "rhombus:",
            "rhombus:0",
            "rhombus:1444",
            "rhombus:g012",
            "right45:0000",
            "right45:3123",
            "kite:a1b2",
            "hex:b024",
        ),
    ],
)
def test_malformed_notation_is_refused(text):
    with pytest.raises(NotationError) as caught:
        Circuit.from_notation(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["hex:" + "0" * 10**6, "hex:" + "024" * 10_000])
def test_circuits_have_a_largest_size(text):
    with pytest.raises(SizeError, match="the circuit is larger than 20000 cells"):
        Circuit.from_notation(text)


def test_long_circuits_take_little_memory():
    side = 4999
    ring = Circuit.from_notation("square:" + "".join(str(d) * side for d in range(4)))
    tracemalloc.start()
    turned = Circuit(ring.grid, ring.word[side + 7 :] + ring.word[: side + 7]).canonical()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert turned.word == ring.canonical().word
    assert ring.symmetry == 8
    assert peak < 50 * 2**20  # its keys are 20,000 texts of as many letters, twice


@pytest.mark.parametrize("text", ["hex:\0", "hex:02\ud800", "\udcff:024", "hex:0\x1b[31m4"])
def test_strange_notations_are_one_printable_line(text):
    with pytest.raises(NotationError) as caught:
        Circuit.from_notation(text)
    assert str(caught.value).isprintable()
