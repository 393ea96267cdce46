"""Names of panels and hinges: those of the picture of a design, whatever is joined."""

import tomllib
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import WAYS
from hcsearch.designs.folding import Folding, foldings
from hcsearch.scenes import SCENES, Scene
from hcsearch.scenes.scene_file import read_scene_text, scene_file_text, scene_in
from hcsearch.scenes.setup import scene_of_setup, setup_of_scene
from hcsearch.shape.labels import Labels, label_data, label_ranges, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern
from hcsearch.springs.deployment.compiled_scene import compile_scene
from tests.linkages import linkage_named
from tests.strategies import circuits

DEFAULT = SCENES["default"]
MERGED = "square:012230:1"


@st.composite
def joined(draw):
    """A folding and its linkage, joined in some way."""
    choices = foldings(draw(circuits(even=True)))
    assume(choices)
    folding = draw(st.sampled_from(choices))
    pairs = draw(st.sampled_from(WAYS))
    return folding, folding.linkage(flat_pairs=pairs), pairs


def members(name):
    return [int(part) for part in name.split("+")]


@given(joined())
def test_names_are_numbers_of_panels_and_creases_of_the_circuit(drawn):
    folding, linkage, pairs = drawn
    labels, n, pattern = labels_of(linkage), folding.circuit.n, linkage.pattern
    assert sorted(panel for name in labels.panels for panel in members(name)) == list(range(n))
    joined_pairs = {(k, (k + 1) % n) for k in (folding.crease, folding.opposite)} if pairs != "hinged" else set()
    joined_pairs |= set(folding.mirror_pairs) if pairs == "merged" else set()
    for a, b in joined_pairs:
        assert labels.panel(str(a)) == labels.panel(str(b)) == labels.panel(f"{b}+{a}")
    assert len(labels.merged) <= len(joined_pairs)
    carried = [crease for name in labels.hinges for crease in members(name)]
    assert len(carried) == len(set(carried))
    for k, (name, hinge) in enumerate(zip(labels.hinges, pattern.hinges, strict=True)):
        for crease in members(name):
            ends = {pattern.panel_of[crease], pattern.panel_of[(crease + 1) % n]}
            assert ends == {hinge.first, hinge.second}
            assert labels.hinge(str(crease)) == labels.hinge(name) == k
    for crease in set(range(n)) - set(carried):
        assert pattern.panel_of[crease] == pattern.panel_of[(crease + 1) % n]
        with pytest.raises(HcsearchError, match=f"crease {crease} carries no hinge here, its panels are one, "):
            labels.hinge(str(crease))
    if pairs == "hinged":
        assert labels.hinges == labels.panels == tuple(map(str, range(n)))


def test_assemblies_keep_the_numbers_of_their_pattern():
    for name in ("thesis-4x4", "unit-i", "array-6r"):
        linkage = linkage_named(name)
        assert labels_of(linkage) == Labels(
            tuple(map(str, range(linkage.n_panels))), tuple(map(str, range(linkage.n_hinges)))
        )


def test_a_pattern_of_a_design_that_is_moved_keeps_its_names():
    linkage = Folding.from_notation(MERGED).linkage()
    moved = replace(linkage, pattern=linkage.pattern.moved(0.3, (1.0, 2.0), over=True))
    assert labels_of(moved) == labels_of(linkage)


@pytest.mark.parametrize(
    ("names", "text"),
    [
        ((), ""),
        (("0",), "0"),
        (("0", "1"), "0, 1"),
        (("0", "1", "2", "4", "5+7", "8", "9", "10"), "0 to 2, 4, 5+7, 8 to 10"),
    ],
)
def test_names_are_listed_in_one_line(names, text):
    assert label_ranges(names) == text


def test_names_as_data_are_numbers_unless_several_are_one():
    assert [label_data(name) for name in ("7", "3+4")] == [7, "3+4"]


def test_names_that_there_are_not_list_those_that_there_are():
    labels = labels_of(Folding.from_notation(MERGED).linkage())
    for name, message in (
        ("99", "there is no hinge 99: the hinges are 0, 2, 3, 5"),
        ("0+2", r"there is no hinge 0\+2: the hinges are 0, 2, 3, 5"),
    ):
        with pytest.raises(HcsearchError, match=f"^{message}$"):
            labels.hinge(name)
    with pytest.raises(HcsearchError, match=r"^there is no panel 0\+3: the panels are 0, 1\+2, 3, 4\+5$"):
        labels.panel("0+3")
    alone = Linkage(Pattern.from_polygons((((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)),), {}, 0.1))
    with pytest.raises(HcsearchError, match="there is no hinge 0: there are no hinges"):
        labels_of(alone).hinge("0")


@given(joined(), st.data())
def test_scenes_come_back_from_files_with_names(drawn, data):
    folding, linkage, *_ = drawn
    labels = labels_of(linkage)
    some = st.lists(st.integers(0, linkage.n_hinges - 1), unique=True, max_size=3)
    hinges = data.draw(some)
    springs = tuple((labels.hinges[hinge], f"linear:{hinge + 1}") for hinge in hinges)
    held = data.draw(st.just("bottom") | st.sampled_from(labels.panels))
    scene = replace(DEFAULT, springs=springs, held=held)
    text = scene_file_text({"design": folding.notation}, None, scene)
    table = tomllib.loads(text)
    assert "scene" not in table
    assert [members(name) for name in table.get("springs", {})] == [members(labels.hinges[k]) for k in hinges]
    again = scene_in(read_scene_text(text, "a text"))
    assert again == scene
    setup = setup_of_scene(again, linkage)
    laws = {hinge: f"linear:{hinge + 1}" for hinge in hinges}
    assert [law.text for law in setup.laws] == [laws.get(hinge, DEFAULT.spring) for hinge in range(linkage.n_hinges)]
    assert setup.held == (linkage.base if held == "bottom" else labels.panels.index(held))
    assert setup_of_scene(scene_of_setup(setup, scene, labels), linkage) == setup


def test_two_springs_of_one_hinge_are_refused():
    linkage = Folding.from_notation(MERGED).linkage(flat_pairs="merged")
    together = next(name for name in labels_of(linkage).hinges if "+" in name)
    one, two = together.split("+")[:2]
    scene = Scene(springs=((one, "linear:0.1"), (two, "linear:0.2")))
    with pytest.raises(HcsearchError, match="is given two springs: leave one out"):
        compile_scene(linkage, scene)
    laws = compile_scene(linkage, replace(scene, springs=((one, "free"), (two, "free")))).setup.laws
    free = labels_of(linkage).hinge(one)
    assert [law.text for law in laws] == ["free" if hinge == free else scene.spring for hinge in range(len(laws))]
