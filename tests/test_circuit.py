import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import NotationError, SizeError
from hcsearch.designs.circuit import Circuit
from hcsearch.kernels.circuits.words import array_rows, canonicalise, write_rows
from tests import naive
from tests.strategies import circuits, congruences


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


@given(circuits())
def test_turns_add_up_to_one_full_turn(circuit):
    assert abs(sum(circuit.turns)) == circuit.grid.directions
    assert len(circuit.creases) == len(set(circuit.creases)) == circuit.n


@given(st.data())
def test_kernels_agree_with_the_plain_forms(data):
    circuit = data.draw(congruences(data.draw(circuits())))
    grid, words = circuit.grid, np.array([circuit.word], np.int8)
    least, symmetry = np.empty_like(words), np.empty(1, np.int16)
    canonicalise(words, grid.directions, len(grid.first_directions), least, symmetry)
    assert (tuple(least[0]), symmetry[0]) == (circuit.canonical().word, circuit.symmetry)
    rows, heights, order = np.empty(words.shape, np.uint64), np.empty(1, np.int64), np.empty(1, np.int16)
    array_rows(words, np.array(grid.row_moves), 2 if grid.is_triangle else 1, rows, heights, order)
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    text = np.zeros((1, len(prefix) + 2 * circuit.n), np.uint8)
    length = write_rows(rows, heights, prefix, text)
    assert bytes(text[0, :length]).decode() == circuit.array.canonical().notation
    assert order[0] == circuit.array.symmetry


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
