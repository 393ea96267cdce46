"""Values of Python: texts that rebuild them, and circuits in the coordinates of their array."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

import hcsearch
from hcsearch import GRIDS, SCENES, Circuit, Folding, Linkage, Scene, enumerate_circuits, foldings
from hcsearch.basics.errors import ArrayError
from hcsearch.designs.twisting import twist
from hcsearch.search.enumeration import ArraySearch
from hcsearch.shape.pattern import VALLEY_CREASE, Pattern
from tests.strategies import circuits, congruences

NAMES = {name: getattr(hcsearch, name) for name in hcsearch.__all__}
panels = st.sampled_from([None, (0.05, 0.05, 0.006)])


def rebuilt(value):
    """The value that its text gives."""
    text = repr(value)
    assert "\n" not in text
    return eval(text, dict(NAMES))


@given(st.data())
def test_texts_of_circuits_arrays_and_foldings_rebuild_them(data):
    circuit = data.draw(circuits().flatmap(congruences))
    assert rebuilt(circuit) == circuit
    assert rebuilt(circuit.grid) is circuit.grid
    assert rebuilt(circuit.array) == circuit.array
    moved = circuit.on(circuit.array)
    assert rebuilt(moved).cells == moved.cells
    for folding in foldings(circuit)[:1]:
        assert rebuilt(folding) == folding
        canonical = foldings(circuit.canonical())[0]
        assert repr(canonical) == f"Folding.from_notation('{canonical.notation}')"
        assert rebuilt(canonical) == canonical


@given(
    st.sampled_from(["hex:0234550132:4", "square:012230:1"]),
    panels,
    st.sampled_from(["rigid", "hinged", "merged"]),
)
def test_texts_of_linkages_of_foldings_rebuild_them(name, panel, flat_pairs):
    linkage = Folding.from_notation(name).linkage(panel, flat_pairs=flat_pairs)
    assert rebuilt(linkage) == linkage


def test_a_linkage_of_another_pattern_says_how_large_it_is():
    facets = (((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), ((1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)))
    assert (
        repr(Linkage(Pattern.from_polygons(facets, {(0, 1): VALLEY_CREASE}, 0.1)))
        == "<Linkage of 2 panels and 1 hinges, base 0>"
    )


@given(
    st.builds(
        Scene,
        name=st.sampled_from(["default", "solar"]),
        spring=st.sampled_from(["linear:0.1", "free"]),
        springs=st.sampled_from([(), (("7", "linear:0.2"),), ((0, "free"), ("1+3", "free"))]),
        held=st.sampled_from(["bottom", "3", 3]),
        seconds=st.none() | st.floats(1e-3, 1e3),
        gravity=st.tuples(*[st.floats(-10, 10)] * 3),
    )
)
def test_texts_of_scenes_rebuild_them(scene):
    assert rebuilt(scene) == scene


def test_the_text_of_a_scene_says_what_is_not_as_by_default():
    assert repr(SCENES["default"]) == "Scene()"
    assert repr(SCENES["earth"]) == "Scene(name='earth', gravity=(0.0, 0.0, -9.81))"


@given(st.data())
def test_circuits_of_an_array_run_through_its_cells(data):
    """Of arrays of all grids, in any position: as they are asked for, not as their congruence classes have them."""
    array = data.draw(circuits().flatmap(congruences)).array
    graph, seen = array.graph(), set()
    for circuit in enumerate_circuits(array=array, limit=20):
        assert circuit.array == array
        assert set(circuit.cells) == set(graph.nodes)
        steps = zip(circuit.cells, circuit.cells[1:] + circuit.cells[:1], strict=True)
        assert all(graph.has_edge(*step) for step in steps)
        seen.add(circuit.canonical().notation)
    words = [tuple(word) for batch in ArraySearch(array).batches() for word in batch.words.tolist()]
    assert seen <= {Circuit(array.grid, word).notation for word in words}
    assert len(seen) == min(20, len(words))


@given(circuits(even=True))
def test_creases_keep_their_numbers_on_an_array(circuit):
    for image in circuit.array._images[:4]:
        moved = circuit.on(image)
        assert moved.canonical() == circuit
        assert [(one.crease, twist(one)) for one in foldings(moved)] == [
            (one.crease, twist(one)) for one in foldings(circuit)
        ]
        assert [Folding.from_notation(one.notation) for one in foldings(moved)] == foldings(circuit)


def test_circuits_of_other_arrays_are_refused():
    other = hcsearch.parse_array(GRIDS["square"], "3x2")
    for text in ("square:0123", "hex:012345", "rectangle:001223"):
        with pytest.raises(ArrayError, match=r"is no circuit of square:7\.7"):
            Circuit.from_notation(text).on(other)
