import json
import math
from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.library.assemblies import ASSEMBLIES, Parameters
from hcsearch.library.assemblies.packages import folded_package
from hcsearch.library.assemblies.squares import (
    LOOP_PANELS,
    THESIS_4X4_CIRCUIT,
    THESIS_4X4_CREASE,
    array_6r,
    element_6r,
    stepwise_angles,
    thesis_4x4,
)
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.motion.kinematics.numerical_rank import decide_rank, rank_at
from hcsearch.search.enumeration import ArraySearch
from hcsearch.shape.linkage import Linkage

GOLDEN = json.loads((Path(__file__).parents[1] / "golden" / "thesis_chapter6.json").read_text("utf-8"))["assemblies"]
ARRAY = ASSEMBLIES["thesis-4x4"].defaults
SQUARES = ASSEMBLIES["array-6r"].defaults
SIZES = [(columns, rows) for columns in range(1, 5) for rows in range(1, 5)]
lengths = st.floats(0.01, 1.0)


def joints(pattern):
    graph = nx.Graph()
    graph.add_edges_from((hinge.first, hinge.second) for hinge in pattern.hinges)
    return graph


def dof(pattern, angles):
    linkage = Linkage(pattern)
    assert np.abs(linkage.closure(angles)[0]).max() <= CLOSED_LOOP_RESIDUAL
    return rank_at(linkage, angles).nullity


# the 4x4 array of chapter 4


def test_4x4_array_has_the_published_panels_joints_loop_and_branch():
    facts, pattern = GOLDEN["thesis-4x4"], thesis_4x4(ARRAY)
    assert (len(pattern.panels), len(pattern.hinges), pattern.kutzbach) == (12, 12, 6)
    assert [facts[name] for name in ("panels", "hinges", "kutzbach")] == [12, 12, 6]
    assert [1e3 * x for x in (ARRAY.side, ARRAY.width, ARRAY.thickness)] == pytest.approx(facts["size_mm"])
    graph = joints(pattern)
    (loop,) = nx.cycle_basis(graph)
    assert set(loop) == set(LOOP_PANELS)
    assert len(loop) == facts["loop"]
    at, (first, last) = facts["branches_at"], facts["branch"]
    assert [len(graph[panel]) for panel in (at, first, last)] == [3, 2, 1]
    assert set(graph[first]) == {at, last}
    areas = [round(len(panel)) for panel in pattern.panels]
    assert [panel for panel, cells in enumerate(areas) if cells == 2] == [0, 5, 6, 7]


def test_joints_of_the_4x4_array_are_numbered_as_in_the_thesis():
    hinges = [(hinge.first, hinge.second) for hinge in thesis_4x4(ARRAY).hinges]
    # joint i connects panel i to the panel before, the one between 5 and 8 is the cut one, c_1 connects 11 to 0
    assert hinges == [
        (0, 1),
        (1, 2),
        (2, 3),
        (3, 4),
        (4, 5),
        (5, 6),
        (6, 7),
        (5, 8),
        (8, 9),
        (9, 10),
        (10, 11),
        (0, 11),
    ]


def test_only_one_folding_of_the_4x4_array_has_a_branch_of_two_panels():
    kinds = {}
    for batch in ArraySearch(parse_array(GRIDS["rectangle"], "4x4")).batches():
        for word in batch.words.tolist():
            for folding in foldings(Circuit(GRIDS["rectangle"], tuple(word))):
                pattern = folding.pattern((0.05, 0.04, 0.006), flat_pairs="merged")
                if len(pattern.panels) == len(pattern.hinges) == 12:
                    ends = [panel for panel, degree in joints(pattern).degree if degree == 1]
                    kinds.setdefault(len(ends), []).append(folding.notation)
    # one circuit for each way round of a cell; two loose panels of the other circuit are no branch of two
    assert sorted(kinds[1]) == ["rectangle:0122233300012210:6", f"{THESIS_4X4_CIRCUIT}:{THESIS_4X4_CREASE}"]
    assert len(kinds[2]) == 2


def test_the_held_panel_is_opposite_the_branch_and_in_an_outer_layer():
    pattern = thesis_4x4(ARRAY)
    linkage = Linkage(pattern)
    heights = [solid[..., 2].min() for solid in linkage.solids(linkage.folded)]
    assert heights[0] == pytest.approx(min(heights))
    assert nx.shortest_path_length(joints(pattern), 0, 5) == len(LOOP_PANELS) // 2
    assert folded_package(pattern).heights == (8,)
    assert folded_package(pattern).void_volume == folded_package(pattern).overlap_volume == 0


def rank_of_cut_hinge(linkage, angles, cut):
    """Rank of the five equations that hold a cut hinge together, as functions of the other hinges (4.2.2)."""
    _, jacobian = linkage.closure(angles)
    screw = jacobian[:, cut] / np.linalg.norm(jacobian[:, cut])
    others = np.delete(jacobian, cut, axis=1)
    others = others - np.outer(screw, screw @ others)
    return decide_rank(np.linalg.svd(others, compute_uv=False), others.shape[1]).rank


def test_nullity_of_the_4x4_array_and_rank_of_its_cut_hinge():
    linkage = Linkage(thesis_4x4(ARRAY))
    between = close_linkage(linkage, np.random.default_rng(3).uniform(0.8, 2.2, 12))
    assert between.closed
    ranks = []
    for angles in (linkage.flat, between.angles, linkage.folded):
        rank = rank_at(linkage, angles)
        assert rank_of_cut_hinge(linkage, angles, 7) == rank.rank - 1
        ranks.append((rank.nullity, rank.rank))
    # six equations of the loop: 4 flat, 5 folded; five of the cut hinge: 3 flat, 4 folded
    assert ranks == [(8, 4), (6, 6), (7, 5)]


@settings(max_examples=15, deadline=None)
@given(lengths, lengths, st.floats(1e-4, 0.2))
def test_4x4_array_folds_for_any_size(side, width, thickness):
    pattern = thesis_4x4(Parameters(side=side, width=width, thickness=thickness))
    folded = folded_package(pattern)
    assert folded.heights == (8,)
    assert folded.whole_ratio == "8:1"
    assert [rank_at(Linkage(pattern), state).nullity for state in (Linkage(pattern).flat, Linkage(pattern).folded)] == [
        8,
        7,
    ]


# the 6R element


def test_6r_element_has_the_published_panels():
    facts, pattern = GOLDEN["element-6r"], element_6r(SQUARES)
    assert (len(pattern.panels), len(pattern.hinges)) == (facts["panels"], facts["hinges"])
    assert pattern.kutzbach == 0
    assert pattern.area / SQUARES.side**2 == pytest.approx(facts["area"])
    assert [(hinge.first, hinge.second) for hinge in pattern.hinges][:5] == [(k, k + 1) for k in range(5)]


@settings(max_examples=25, deadline=None)
@given(lengths, lengths, st.floats(1e-3, 0.2), st.floats(0.05, math.pi - 0.05))
def test_6r_element_moves_in_two_stages_with_one_dof_each(side, width, thickness, angle):
    element = element_6r(Parameters(side=side, width=width, thickness=thickness))
    assert dof(element, stepwise_angles(element, [angle], [0.0])) == 1
    assert dof(element, stepwise_angles(element, [math.pi], [angle])) == 1  # (6.1)


def test_6r_element_bifurcates_flat_and_between_its_stages():
    element = element_6r(SQUARES)
    flat, middle, folded = (stepwise_angles(element, [h], [v]) for h, v in ((0, 0), (math.pi, 0), (math.pi, math.pi)))
    assert [dof(element, state) for state in (flat, middle, folded)] == [2, 3, 2]
    # flat, the other branch folds the element in half along a_1 and a_4; so does a third one between the stages,
    # where these two coincide, but there P2 and P5 stand in its way
    line, across = stepwise_angles(element, [0], [1]), stepwise_angles(element, [math.pi], [0])
    line[[1, 4]] = 0.0
    across[[0, 3]] = 1.0, -1.0
    assert dof(element, line) == dof(element, across) == 1
    assert across.min() < 0  # beyond a stop


# arrays of 6R elements


def test_array_of_four_6r_elements_has_the_published_area_and_ratio():
    facts, pattern = GOLDEN["array-6r"], array_6r(SQUARES)
    cells = [len(panel) for panel in pattern.panels]
    assert (cells.count(1), cells.count(2)) == (facts["squares"], facts["rectangles"])
    assert pattern.area / SQUARES.side**2 == pytest.approx(facts["area"])
    folded = folded_package(pattern)
    assert folded.footprint_area / SQUARES.side**2 == pytest.approx(facts["footprint"])
    assert folded.whole_ratio == facts["deployment_ratio"]
    assert folded.void_volume == folded.overlap_volume == 0
    # no cuboid: seven layers on one half of the footprint, four on the other
    assert folded.heights == (4, 7)
    assert [(column.panels, round(column.area / SQUARES.side**2)) for column in folded.columns] == [
        (7, 2),
        (4, 1),
        (4, 1),
    ]


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_dof_of_arrays_are_their_rows_at_first_and_their_columns_then(columns, rows):
    pattern = array_6r(replace(SQUARES, size=(columns, rows)))
    rng = np.random.default_rng(columns + 10 * rows)
    first, second = rng.uniform(0.3, 2.8, rows).tolist(), rng.uniform(0.3, 2.8, columns).tolist()
    assert dof(pattern, stepwise_angles(pattern, first, [0.0] * columns)) == rows
    assert dof(pattern, stepwise_angles(pattern, [math.pi] * rows, second)) == columns
    # a lone row can fold along each vertical line as well; then the state between the stages is the singular one
    assert dof(pattern, stepwise_angles(pattern, [0.0] * rows, [0.0] * columns)) == (1 + columns if rows == 1 else rows)
    assert dof(pattern, stepwise_angles(pattern, [math.pi] * rows, [0.0] * columns)) == rows + 2 * columns
    folded = folded_package(pattern)
    assert pattern.area / SQUARES.side**2 == pytest.approx(3 * columns * rows + 3 * columns + 2 * rows)
    assert folded.footprint_area / SQUARES.side**2 == pytest.approx(columns + rows)
    assert folded.void_volume == folded.overlap_volume == 0


def test_elements_of_a_column_share_their_creases():
    pattern = array_6r(replace(SQUARES, size=(1, 2)))
    a, b = ([pattern.hinge_of(pair) for pair in loop] for loop in pattern.loops)
    assert (a[4], a[3]) == (b[0], b[1])  # a_5 on b_1, a_4 on b_2
    side_by_side = array_6r(replace(SQUARES, size=(2, 1)))
    a, c = ([side_by_side.hinge_of(pair) for pair in loop] for loop in side_by_side.loops)
    assert a[2] == c[5]  # c_6 on a_3


@settings(max_examples=10, deadline=None)
@given(lengths, lengths, st.floats(1e-3, 0.2))
@example(0.944579356627106, 0.015625, 0.125)
def test_arrays_of_6r_elements_fold_for_any_size(side, width, thickness):
    parameters = Parameters(side=side, width=width, thickness=thickness, size=(3, 2))
    pattern = array_6r(parameters)
    assert dof(pattern, ASSEMBLIES["array-6r"].generic_angles(parameters)) == 3
    assert folded_package(pattern).whole_ratio == "31:5"
