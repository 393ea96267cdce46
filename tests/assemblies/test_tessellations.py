import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies import ASSEMBLIES, Parameters
from hcsearch.library.assemblies.eight_r import eight_r, skew_symmetric_angles, unit_i, unit_ii
from hcsearch.library.assemblies.overlays import neighbouring_facets
from hcsearch.library.assemblies.packages import flat_overlap, folded_package
from hcsearch.library.assemblies.tessellations import ASSEMBLIES as TESSELLATIONS
from hcsearch.library.assemblies.tessellations import possible_layings
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import overlay
from tests.linkages import congruent

GOLDEN = json.loads((Path(__file__).parents[1] / "golden" / "thesis_assemblies.json").read_text("utf-8"))["assemblies"]

EQUILATERAL = Parameters(alpha=math.pi / 3)
UNITS = {"I": unit_i(EQUILATERAL), "II": unit_ii(EQUILATERAL)}

tessellations = pytest.mark.parametrize("assembly", TESSELLATIONS, ids=lambda entry: entry.name)
parameters = st.builds(
    Parameters, alpha=st.floats(20, 84).map(math.radians), base=st.floats(0.01, 0.5), thickness=st.floats(0.002, 0.05)
)


@pytest.fixture(scope="module")
def layings():
    """All ways to lay two units together, with equilateral triangles."""
    pairs = (("I", "I"), ("II", "II"), ("II", "I"))
    return {pair: list(possible_layings(UNITS[pair[0]], UNITS[pair[1]], EQUILATERAL.alpha)) for pair in pairs}


def built(name):
    return ASSEMBLIES[name].build(EQUILATERAL)


def alike(one, two):
    return congruent(one, two) or congruent(one, two.inverted())


def classes(chosen):
    """One of each class of ways that are congruent or mirror each other."""
    kept = []
    for way in chosen:
        if not any(alike(way.union, other.union) for other in kept):
            kept.append(way)
    return kept


def merged(way):
    return 48 - len(way.union.hinges)


@tessellations
def test_published_numbers(assembly):
    entry = GOLDEN[assembly.name.removesuffix("-other")]
    stated = entry["facts"] | entry.get("differs", {})
    pattern = built(assembly.name)
    assert stated.get("merged_joints", 16) == 24 * (3 if assembly.name == "fig-5.12" else 2) - len(pattern.hinges)
    sizes = [len(panel) for panel in pattern.panels]
    if "panels_by_facets" in stated:
        assert {str(size): sizes.count(size) for size in set(sizes)} == stated["panels_by_facets"]
    assert folded_package(pattern).whole_ratio == stated.get("deployment_ratio", folded_package(pattern).whole_ratio)
    linkage = Linkage(pattern)
    assert rank_at(linkage, assembly.generic_angles(EQUILATERAL)).nullity == 1 == stated["dof"]


@tessellations
@given(parameters, st.floats(0.1, 3.0))
@settings(max_examples=6)
def test_every_base_angle_will_do(assembly, values, first):
    pattern, equilateral = assembly.build(values), built(assembly.name)
    assert [len(panel) for panel in pattern.panels] == [len(panel) for panel in equilateral.panels]
    assert len(pattern.hinges) == len(equilateral.hinges)
    assert flat_overlap(pattern) == 0
    linkage = Linkage(pattern)
    assert len(pattern.loops) == linkage.n_rows // 6  # the elements are all loops there are
    angles = skew_symmetric_angles(pattern, values.alpha, first)
    assert np.abs(linkage.closure(angles)[0]).max() < 1e-9
    assert rank_at(linkage, angles).nullity == 1
    folded = folded_package(pattern)
    assert folded.whole_ratio == folded_package(equilateral).whole_ratio
    assert folded.heights == folded_package(equilateral).heights
    assert folded.void_volume == folded.overlap_volume == 0


def test_the_search_finds_those_of_two_units(layings):
    names = {"I": ("5.10a", "5.10a-other", "5.10b"), "II": ("5.11a", "5.11a-other", "5.11b")}
    for unit, known in names.items():
        for name in known:
            pattern = built(f"fig-{name}")
            same = [way for way in layings[unit, unit] if len(way.union.facets) == len(pattern.facets)]
            assert any(alike(way.union, pattern) for way in same), name


def test_what_the_published_numbers_force(layings):
    """Forced: the one class of 44 triangles with 11:1, and of 38 with 38:5. Two classes each merge four or three."""
    ones, twos = layings["I", "I"], layings["II", "II"]
    (only,) = classes([way for way in ones if len(way.union.facets) == 44])
    assert (merged(only), only.package.whole_ratio) == (8, "11:1")
    (only,) = classes([way for way in twos if len(way.union.facets) == 38])
    assert (merged(only), only.package.whole_ratio) == (15, "38:5")
    assert all(merged(way) != 14 for way in twos)
    fours = classes([way for way in ones if merged(way) == 4])
    assert [way.package.whole_ratio for way in fours] == ["25:3", "25:3"]
    threes = classes([way for way in twos if merged(way) == 3])
    assert sorted(way.package.whole_ratio for way in threes) == ["10:1", "52:7"]
    assert not alike(built("fig-5.10a"), built("fig-5.10a-other"))
    # two units II make 44:4 of 24 triangles and 10 parallelograms, too
    (other,) = classes([way for way in twos if len(way.union.facets) == 44])
    assert (merged(other), dict(other.areas), other.package.whole_ratio) == (8, {1: 24, 2: 10}, "11:1")


def test_a_unit_ii_between_two_units_i(layings):
    """The two ways that merge most joints, which are alike; together they make Fig. 5.12."""
    beside = layings["II", "I"]
    most = [way for way in beside if merged(way) == max(map(merged, beside))]
    assert [merged(way) for way in most] == [8, 8]
    assert len(classes(most)) == 1
    both = overlay([way.union for way in most])
    pattern = built("fig-5.12")
    assert congruent(both, pattern)
    assert folded_package(pattern).whole_ratio == "8:1"
    assert folded_package(pattern).heights == (5, 9)  # those of a unit


def test_an_inverted_unit_is_a_turned_one():
    """So the search need not invert: the inversions of Fig. 5.11 are among its turns."""
    for unit in UNITS.values():
        assert congruent(unit, unit.inverted())


def test_some_unions_move_but_cannot_fold_for_panels_in_one_place(layings):
    """Units I and II overlap in more ways than fold: those that fold merge eight joints at most."""
    unions = [union for _, _, union in neighbouring_facets(UNITS["II"], UNITS["I"])]
    assert min(len(union.facets) for union in unions) < min(len(way.union.facets) for way in layings["II", "I"]) == 46


def test_neighbours_as_a_naive_twin_finds_them():
    """On the lattice of equilateral triangles: every turn, the sheet over or not, and each facet on each facet."""
    still = eight_r(EQUILATERAL)

    def hinged(pattern):
        return sum(crease.face is not None for crease in pattern.creases.values())

    def key(pattern):
        places = (np.round(np.mean(facet, axis=0) / still.size, 3) + 0.0 for facet in pattern.facets)
        return frozenset(map(tuple, places))

    expected = set()
    for turn, over, on, of in itertools.product(range(6), (False, True), range(10), range(10)):
        moved = still.moved(turn * math.pi / 3, over=over)
        x, y = np.mean(still.facets[on], axis=0) - np.mean(moved.facets[of], axis=0)
        try:
            union = overlay([still, moved.moved(0.0, (float(x), float(y)))])
        except PatternError:
            continue
        if len(union.facets) > 10 and hinged(union) < 2 * hinged(still):
            expected.add(key(union))
    layings = list(neighbouring_facets(still, still))
    assert {key(union) for _, _, union in layings} == expected
    for placement, merged_creases, union in layings:
        assert key(overlay([still, still.placed(placement)])) == key(union)
        assert len(merged_creases) == 2 * hinged(still) - hinged(union)
