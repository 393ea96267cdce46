import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch as command_line
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.eight_r import eight_r, unit_i, unit_ii, unit_iii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.library.assemblies.overlays import neighbouring_facets
from hcsearch.library.assemblies.squares import array_6r, element_6r
from hcsearch.library.unit_search.copies import (
    IDENTITY_PLACEMENT,
    CopyPlacement,
    CopyRings,
    CopySheet,
    congruence_key,
    least_kutzbach,
    marks_of_copies,
)
from hcsearch.library.unit_search.elements import (
    KITE_KIND,
    PARALLELOGRAM_KIND,
    RigidPair,
    element_with_triangles,
    elements_of,
    elements_of_designs,
    isosceles_elements,
    isosceles_shapes,
    rigid_pairs,
    untwisted_foldings_of,
)
from hcsearch.library.unit_search.unit_proofs import generic_freedom, prove_unit
from hcsearch.library.unit_search.unit_search import find_units, search_elements
from hcsearch.motion.searching import Budget
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import VALLEY_CREASE, Pattern, overlay
from hcsearch.store import open_readonly, select
from tests.linkages import congruent, penetration

DEGREES = Parameters(alpha=math.radians(70))
SQUARES = Parameters(width=0.050)
TEN = Circuit.from_notation("triangle:0123434501")
angles = st.floats(0.0, math.tau)
motions = st.builds(
    lambda reflects, exchange, angle, x, y: CopyPlacement(Isometry.by(angle, (x, y), reflects=reflects), exchange),
    st.booleans(),
    st.sampled_from((1, -1)),
    angles,
    st.floats(-3, 3),
    st.floats(-3, 3),
)


def same_class(pattern, length=None):
    """What congruent patterns have in common; similar ones where a length (m) is given to measure them by."""
    sheet = CopySheet(pattern, lattice=False)
    scale = 1.0 if length is None else sheet.unit / length
    return congruence_key([(scale * place, code) for place, code in marks_of_copies(sheet)])


@pytest.fixture(scope="module")
def ten():
    """The search over the element of ten triangles, with a base angle of 70 degrees."""
    (searched, other) = search_elements(isosceles_elements(10, 70.0))
    assert other.skipped.startswith("as ")
    return searched


# copies


@given(motions, motions, st.complex_numbers(max_magnitude=3))
def test_motions_compose_and_turn_back(one, two, point):
    assert (one @ two).isometry(point) == pytest.approx(one.isometry(two.isometry(point)))
    assert (one.inverse @ one).isometry(point) == pytest.approx(point)
    assert (one @ two).face_sign == one.face_sign * two.face_sign
    assert (one @ one.inverse).key == IDENTITY_PLACEMENT.key


@settings(max_examples=25)
@given(motions)
def test_a_motion_moves_a_pattern_as_it_moves_points(motion):
    element = eight_r(DEGREES)
    sheet = CopySheet(element, lattice=False)
    moved = CopySheet(motion.of(element, sheet.unit), lattice=False)
    assert moved.centres == pytest.approx(np.array([motion.isometry(z) for z in sheet.centres]))
    assert {code for *_, code in moved.creases} == {motion.face_sign * code for *_, code in sheet.creases}
    assert (moved.codes[0, 9], moved.codes[0, 2]) == (motion.face_sign * sheet.codes[0, 9], sheet.codes[0, 2])
    assert same_class(moved.pattern) == same_class(element)


def test_placements_are_those_of_joining():
    element = eight_r(DEGREES)
    rings = CopyRings(CopySheet(element, lattice=False), strict=False)
    unit = rings.sheet.unit
    joined = set()
    for placement, _, _ in neighbouring_facets(element, element):
        scaled = placement._replace(shift=placement.shift / unit)
        joined.add(rings.key(CopyPlacement(scaled, -1 if placement.reflects else 1)))
    # turned by pi and inverted the 8R element is itself, so that every inverted copy is a real one too
    assert len(rings.symmetries) == 2
    assert {rings.key(motion) for motion in rings.placements} == joined
    assert len(joined) == 12


def test_overlap_of_a_copy_with_itself():
    sheet = CopySheet(eight_r(DEGREES), lattice=False)
    overlap = sheet.overlap(IDENTITY_PLACEMENT)
    assert (overlap.facets, overlap.hinges, overlap.creases_in_slits, overlap.agrees) == (10, 8, 0, True)
    assert not sheet.overlap(CopyPlacement(Isometry.by(), -1)).agrees
    assert not sheet.overlap(CopyPlacement(Isometry.by(shift=(0.1, 0.0)), 1)).agrees
    assert sheet.overlap(CopyPlacement(Isometry.by(shift=(100.0, 0.0)), 1)).facets == 0


def test_kutzbach_of_marks_is_a_lower_bound():
    for build in (eight_r, unit_i, unit_ii):
        pattern = build(DEGREES)
        assert least_kutzbach(marks_of_copies(CopySheet(pattern, lattice=False))) == pattern.kutzbach


def test_patterns_of_one_key_are_congruent_or_mirror_each_other():
    units = [build(DEGREES) for build in (unit_i, unit_ii, unit_iii)]
    units += [unit.moved(0.3, (0.01, -0.02), over=True) for unit in units]
    units += [unit.inverted() for unit in units]
    for one, two in itertools.combinations(units, 2):
        assert (same_class(one) == same_class(two)) == (congruent(one, two) or congruent(one, two.inverted()))


# elements


def test_rigid_creases_are_the_flat_ones():
    assert rigid_pairs(TEN) == [
        RigidPair(0, 5, "no fold"),
        RigidPair(1, 6, "element", 2),
        RigidPair(2, 7, "no fold"),
        RigidPair(3, 8, "element", 2),
        RigidPair(4, 9, "no fold"),
    ]
    assert {pair.verdict for pair in rigid_pairs(Circuit.from_notation("triangle:012345"))} <= {"no fold", "twisted"}
    assert "locked" in {pair.verdict for pair in rigid_pairs(Circuit.from_notation("triangle:01234343450101"))}


def test_any_other_rigid_crease_loses_the_fold():
    element = next(iter(elements_of_designs("triangle", 10)))
    linkage = element.linkage
    for hinge in range(linkage.n_hinges):
        held = linkage.folded.copy()
        held[hinge] = 0.0
        assert np.abs(linkage.closure(held)[0]).max() > 0.1


def test_elements_of_ten_triangles_are_the_8r_element():
    (first, second) = elements_of_designs("triangle", 10)
    regular = eight_r(Parameters(alpha=math.pi / 3))
    assert same_class(first.pattern) == same_class(second.pattern) == same_class(regular)
    assert (first.dof, first.locked, first.name) == (2, False, "triangle:0123434501:1")
    with pytest.raises(HcsearchError, match="even number"):
        list(elements_of_designs("triangle", 9))


# isosceles triangles


def test_isosceles_element_is_the_8r_element_for_every_base_angle():
    for alpha in (30.0, 46.0, 70.0, 85.0):
        variants = list(isosceles_elements(10, alpha))
        expected = same_class(eight_r(Parameters(alpha=math.radians(alpha))))
        assert [element.shape for element in variants] == ["parallelogram right", "parallelogram left"]
        assert all(same_class(element.pattern) == expected for element in variants)


def test_scalene_triangles_fold_no_circuit_of_ten_but_one_of_eighteen():
    # (5.28) sums the angles around inner corners; the circuit of eighteen goes around a hole and has none
    scalene = [tuple(map(math.radians, angles)) for angles in itertools.permutations((50.0, 61.0, 69.0))]
    kinds = {}
    for n in (10, 14, 18):
        for folding in untwisted_foldings_of("triangle", n):
            for angles, kind in itertools.product(scalene, (PARALLELOGRAM_KIND, KITE_KIND)):
                pattern = element_with_triangles(folding, angles, kind)
                if pattern is not None:
                    assert generic_freedom(pattern) == 10
                    kinds.setdefault(folding.notation, set()).add(kind)
    assert kinds == {"triangle:012323434345050101:3": {PARALLELOGRAM_KIND}}


def test_equilateral_triangles_are_the_regular_grid():
    for folding in untwisted_foldings_of("triangle", 14):
        regular = same_class(folding.pattern((0.05, 0.05, 0.006)))
        assert all(
            same_class(element_with_triangles(folding, a, kind)) == regular for _, kind, a in isosceles_shapes(60.0)
        )


@pytest.mark.parametrize("alpha", [0.0, 90.0, math.nan, -20.0])
def test_there_is_no_isosceles_triangle_with_such_an_angle(alpha):
    with pytest.raises(HcsearchError, match="between 0 and 90"):
        list(isosceles_elements(10, alpha))


# the search


def test_units_of_the_thesis_come_out_of_the_search_and_one_more(ten):
    assert ten.complete
    fours = [unit for unit in ten.units if len(unit.copies) == 4]
    assert sorted(unit.known_name for unit in fours) == ["unit-i", "unit-ii", "unit-iii"]
    for unit in fours:
        assert (len(unit.pattern.panels), len(unit.pattern.hinges), unit.pattern.kutzbach) == (21, 24, 0)
        assert same_class(unit.pattern) == same_class(ASSEMBLIES[unit.known_name].build(DEGREES))
        proof = unit.proof
        assert (proof.dof, proof.dof_folded, proof.dof_flat, proof.path_count) == (1, 4, 4, 1)
        assert (proof.path, proof.path_dof, proof.contact) == ("flat", (1,), False)
        assert proof.deployment_ratio == pytest.approx(7)
        assert proof.closure_error < 1e-12
        assert proof.rank_gap > 1e6


def test_two_8r_elements_that_share_three_hinges_have_one_degree_of_freedom(ten):
    (pair,) = (unit for unit in ten.units if len(unit.copies) == 2)
    assert (len(pair.pattern.panels), len(pair.pattern.hinges), pair.pattern.kutzbach) == (12, 13, 1)
    assert pair.proof.holds
    assert pair.proof.contact is False


def test_units_are_unions_of_their_copies(ten):
    for unit in ten.units:
        placements = json.loads(unit.placements)
        assert len(placements) == len(unit.copies)
        # none has to be inverted: every copy is the element itself, as it is or turned over
        assert not any(placement["inverted"] for placement in placements)
        moved = [
            unit.element.pattern.moved(
                math.radians(placement["turn"]), tuple(1e-3 * v for v in placement["shift"]), over=placement["over"]
            )
            for placement in placements
        ]
        assert same_class(overlay(moved)) == same_class(unit.pattern)


def test_a_crease_in_a_slit_leaves_no_folded_state():
    element = next(iter(isosceles_elements(10, 70.0)))
    sheet = CopySheet(element.pattern, lattice=False)
    strict, loose = (
        {congruence_key(rings.marks(ring)): ring for ring in rings.rings()}
        for rings in (CopyRings(sheet), CopyRings(sheet, strict=False))
    )
    assert len(strict) == 3
    assert set(strict) < set(loose)
    for key in set(loose) - set(strict):
        union = overlay([motion.of(element.pattern, sheet.unit) for motion in loose[key]])
        assert generic_freedom(union) is None


def test_panels_cut_through_each_other_below_45_degrees():
    # thesis 5.3.1: the slit's distance p changes its sign there
    proofs = {alpha: prove_unit(unit_i(Parameters(alpha=math.radians(alpha)))) for alpha in (43.0, 47.0)}
    assert [proof.contact for proof in proofs.values()] == [True, False]
    assert all(proof.holds for proof in proofs.values())


def test_limits_stop_a_search_and_say_so():
    element = next(iter(elements_of_designs("triangle", 14)))
    assert not find_units(element, budget=Budget(efforts=5)).complete
    assert not find_units(element, budget=Budget(seconds=0.0)).complete
    (searched, *_) = search_elements([element], max_dof=3)
    assert searched.skipped == "more than 3 degrees of freedom"


def test_circuits_of_fourteen_triangles_make_no_units():
    results = list(search_elements(elements_of_designs("triangle", 14)))
    searched = [result for result in results if not result.skipped]
    assert [result.element.dof for result in searched] == [6, 6]
    assert all(result.complete and not result.units for result in searched)
    assert "locked" in {result.skipped for result in results}


def test_hexagons_around_the_centres_of_triangles_make_the_same_units():
    folding = next(folding for folding in foldings(Circuit.from_notation("hex:0123434501")) if folding.crease == 1)
    (element,) = elements_of(folding)
    searched = find_units(element, copies=(4,))
    steps = math.sqrt(3) * 0.050, DEGREES.base / math.sqrt(3)  # from panel to panel
    regular = replace(DEGREES, alpha=math.pi / 3)
    known = {same_class(build(regular), steps[1]) for build in (unit_i, unit_ii)}
    assert len(searched.units) == 3
    assert known < {same_class(unit.pattern, steps[0]) for unit in searched.units}
    assert {unit.proof.contact for unit in searched.units} == {False}


def test_two_6r_elements_in_a_column_are_no_unit():
    element = next(iter(elements_of_designs("square", 8)))
    assert same_class(element.pattern) == same_class(element_6r(SQUARES))
    searched = find_units(element, copies=(2,))
    assert not searched.units
    columns = [unit for unit in searched.refuted if unit.proof.overlap == 0]
    assert [same_class(unit.pattern) for unit in columns] == [same_class(array_6r(replace(SQUARES, size=(1, 2))))]
    # one motion leads from folded to the stage between, from where each row goes on by itself
    assert not columns[0].proof.holds


# contacts


def test_two_panels_cut_into_each_other_beyond_their_stop():
    squares = tuple(((x, 0.0), (x + 1, 0.0), (x + 1, 1.0), (x, 1.0)) for x in (0.0, 1.0))
    linkage = Linkage(Pattern.from_polygons(squares, {(0, 1): VALLEY_CREASE}, 0.1))
    for angle in (0.0, 0.5, 2.0, math.pi):
        assert penetration(linkage, np.array([angle])) == pytest.approx(0.0, abs=1e-12)
    assert penetration(linkage, np.array([math.pi + 0.05])) == pytest.approx(math.sin(0.05), rel=0.1)
    assert penetration(linkage, np.array([-0.1])) > 1e-3


# the command line


def run(*words):
    result = CliRunner().invoke(command_line, ["units", *words])
    assert result.exit_code == 0, result.output
    return result.output


def test_command_prints_and_stores_units_once(tmp_path):
    words = ("--grid", "triangle", "--n", "10", "--copies", "2", "--db", str(tmp_path / "units.sqlite"))
    assert "1 units, 1 of them new" in run(*words)
    (line,) = run(*words, "--json").splitlines()
    printed = json.loads(line)
    assert "1 units, 0 of them new" in run(*words)
    with open_readonly(str(tmp_path / "units.sqlite")) as database:
        stored = select(database, view="units")
    (row,) = stored.rows
    assert dict(zip(stored.columns, row, strict=True)) == {"id": 1, **printed}


def test_command_refuses_base_angles_of_other_cells():
    result = CliRunner().invoke(command_line, ["units", "--grid", "square", "--n", "8", "--alpha", "70"])
    assert isinstance(result.exception, HcsearchError)
    assert run("--grid", "triangle", "--n", "12") == "0 units\n"
