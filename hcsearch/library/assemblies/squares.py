"""Arrays of rectangles: the 4x4 array of chapter 4, and the 6R element with its arrays (thesis 4.1, 6.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import folding_of
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, FacetPair, Pattern, overlay

THESIS_4X4_CIRCUIT, THESIS_4X4_CREASE = "rectangle:1233300011123321", 6
"""Circuit and flat crease of thesis Fig. 4.1(b); lengths run along the rows."""

THESIS_PANEL_ORDER = (6, 7, 5, 4, 3, 2, 1, 12, 0, 13, 14, 15, 11, 10, 9, 8)
"""Cells of that circuit in the order of the thesis's panels; the merged ones, 0, 5, 6 and 7, have two cells each."""

LOOP_PANELS = (0, 1, 2, 3, 4, 5, 8, 9, 10, 11)
"""Panels of the thesis's closed loop; 6 and 7 are a branch at 5."""

ELEMENT_6R_JOINTS: tuple[FacetPair, ...] = ((1, 2), (2, 3), (3, 4), (5, 6), (6, 7), (0, 7))
"""Pairs of facets at joints a_1 to a_6 of the 6R element."""


def thesis_4x4(parameters: Parameters) -> Pattern:
    """Return the 4x4 array with the panels on its mirror axis merged (thesis Fig. 4.1c).

    Panels as numbered in 4.1.2: 0 is held, 0 to 5 lead to the branch 5, 6, 7, and 5, 8 to 11 back to 0. Hinge i - 1
    is the thesis's joint i, on panel i; the last one, between 11 and 0, is c_1. The loop starts at panel 0.
    """
    folding = folding_of(Circuit.from_notation(THESIS_4X4_CIRCUIT), THESIS_4X4_CREASE)
    size = (parameters.side, parameters.width, parameters.thickness)
    pattern = _renumbered(folding.pattern(size, flat_pairs="merged"), THESIS_PANEL_ORDER)
    of = pattern.panel_of
    between = {frozenset((of[i], of[j])): (i, j) for (i, j), crease in pattern.creases.items() if crease.face}
    loop = tuple(
        between[frozenset(panels)] for panels in zip(LOOP_PANELS, (*LOOP_PANELS[1:], LOOP_PANELS[0]), strict=True)
    )
    left = min(x for x, _ in pattern.vertices)
    low = min(y for _, y in pattern.vertices)
    return replace(pattern, loops=(loop,)).moved(shift=(-left, -low))


def _renumbered(pattern: Pattern, order: Sequence[int]) -> Pattern:
    """Reorder the facets of a pattern, and sort hinges by the later of their facets."""
    number = {facet: k for k, facet in enumerate(order)}
    creases: dict[FacetPair, Crease] = {}
    for (i, j), crease in pattern.creases.items():
        creases[min(number[i], number[j]), max(number[i], number[j])] = crease
    ordered = sorted(creases, key=lambda pair: (pair[1], -pair[0]))
    faces = tuple(pattern.faces[facet] for facet in order)
    return Pattern(pattern.vertices, faces, {pair: creases[pair] for pair in ordered}, pattern.thickness)


def element_6r(parameters: Parameters) -> Pattern:
    """Return the 6R element of eight squares (thesis Fig. 6.1b); its loop is joints a_1 to a_6.

    Facets: P1 (two), P2, P3 from left to right in the top row, P4 (two), P5, P6 from right to left below. Joint a_i
    lies between P_i and P_{i+1}; the faces are as in the circuit's two-stack folding.
    """
    return _sized(_unit_element(parameters.thickness), parameters)


def _unit_element(thickness: float) -> Pattern:
    """Return the 6R element with cells of 1 m by 1 m."""
    cells = ((0, 0), (1, 0), (2, 0), (3, 0), (3, -1), (2, -1), (1, -1), (0, -1))
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    facets = tuple(tuple((float(i + x), float(j + y)) for x, y in corners) for i, j in cells)
    faces = (VALLEY_CREASE, MOUNTAIN_CREASE, VALLEY_CREASE, VALLEY_CREASE, MOUNTAIN_CREASE, VALLEY_CREASE)
    creases = dict(zip(ELEMENT_6R_JOINTS, faces, strict=True)) | {(0, 1): RIGID_CREASE, (4, 5): RIGID_CREASE}
    return Pattern.from_polygons(facets, creases, thickness, (ELEMENT_6R_JOINTS,))


def _sized(pattern: Pattern, parameters: Parameters) -> Pattern:
    """Scale a pattern with cells of 1 m by 1 m to the parameters; creases on one line stay exactly collinear."""
    length, width = parameters.side, parameters.width
    return replace(pattern, vertices=tuple((length * x, width * y) for x, y in pattern.vertices))


def array_6r(parameters: Parameters) -> Pattern:
    """Return an array of 6R elements (thesis Fig. 6.4); loops are the elements, row by row from the top left.

    size : columns and rows of elements; two by two unless given. The element below another one is its inversion, with
        a_5 on b_1 and a_4 on b_2; the one to its right is a copy, with c_6 on a_3.
    """
    columns, rows = parameters.size or (2, 2)
    element = _unit_element(parameters.thickness)
    placed = []
    for row in range(rows):
        kind = element.inverted() if row % 2 else element
        for column in range(columns):
            placed.append(kind.moved(shift=(float(3 * column - row), float(-row))))
    return _sized(overlay(placed), parameters)


def stepwise_angles(pattern: Pattern, horizontal: Sequence[float], vertical: Sequence[float]) -> Reals:
    """Return fold angles (n_hinges,) of an array of 6R elements; loops close within either stage of 6.1.

    horizontal : angle (rad) of the creases a_3, a_6 of the elements in each row. First stage: arbitrary, with
    `vertical` 0.
    vertical : angle of a_1, a_2, a_4, a_5 in each column (6.1). Second stage: arbitrary, with `horizontal` pi.
    """
    angles = np.zeros(len(pattern.hinges))
    for k, loop in enumerate(pattern.loops):
        row, column = divmod(k, len(vertical))
        for joint, pair in enumerate(loop):
            angles[pattern.hinge_of(pair)] = horizontal[row] if joint in {2, 5} else vertical[column]
    return angles


def _between_element(parameters: Parameters) -> Reals:
    """Return fold angles of the 6R element in its second stage."""
    return stepwise_angles(element_6r(parameters), [math.pi], [1.0])


def _between_array(parameters: Parameters) -> Reals:
    """Return fold angles of an array in its second stage, with a different angle for each column."""
    columns, rows = parameters.size or (2, 2)
    return stepwise_angles(array_6r(parameters), [math.pi] * rows, np.linspace(1.0, 2.0, columns).tolist())


_SQUARES = Parameters(width=0.050)
_USES = ("side", "width", "thickness")

ASSEMBLIES = (
    Assembly(
        "thesis-4x4",
        "4x4 array with merged panels",
        "section 4.1.1, Figs. 4.1 and 4.2",
        _USES,
        thesis_4x4,
        published={"panels": 12, "hinges": 12, "kutzbach": 6, "loop_lengths": [10], "panels_in_no_loop": 2},
        defaults=Parameters(thickness=0.006),
        notes=(
            "whether lengths run along the rows is not said; the array with widths along them folds alike",
            "panel 0 is held, as in Fig. 4.2: the merged panel across the loop from the one with the branch, panel 5",
        ),
    ),
    Assembly(
        "element-6r",
        "6R element",
        "section 6.1, Figs. 6.1 to 6.3",
        _USES,
        element_6r,
        _between_element,
        published={"panels": 6, "hinges": 6, "dof": 1},
        defaults=_SQUARES,
        notes=("moves in two stages: first a_3 and a_6 to the end, then the planar 4R of the other four joints",),
    ),
    Assembly(
        "array-6r",
        "Array of 6R elements",
        "section 6.1, Figs. 6.4 and 6.5",
        (*_USES, "size"),
        array_6r,
        _between_array,
        published_at_defaults={"panels": 15, "dof": 2, "deployment_ratio": "11:2"},
        defaults=_SQUARES,
        notes=(
            "degrees of freedom: as many as rows in the first stage, as many as columns in the second",
            "the package is no cuboid: two by two is seven layers high on two squares and four on the other two",
        ),
    ),
)
