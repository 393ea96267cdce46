"""Drawings of any panels as linkages: thick convex panels, with hinges on their faces, in any number of loops.

A mountain has its hinge on the bottom face and a valley on the top face, so that every hinge turns by 0 to 180 degrees
from the flat state. Flat edges make one panel of two faces, unless the file states the face of a hinge there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError, SceneError
from hcsearch.designs.panel_sizes import MAX_PANEL_LENGTH, MIN_PANEL_LENGTH, read_panel
from hcsearch.search.own_patterns.drawn_lines import MAX_DRAWN_PANELS
from hcsearch.search.own_patterns.fold_reading import (
    POINT_ERROR_SHARE,
    STRAIGHT_SIDE_SHARE,
    PatternDrawing,
)
from hcsearch.search.own_patterns.folded_forms import FOLDED_ANGLE_TOLERANCE
from hcsearch.search.own_patterns.recognition import panel_named
from hcsearch.shape.mesh import Facet, PlanePoint, components, facet_area, sides_of
from hcsearch.shape.pattern import RIGID_CREASE, Crease, FacetPair, PanelFace, Pattern

DEFAULT_LONGEST_EDGE = 0.05
"""Longest edge (m) of a drawing that has no physical unit."""
DEFAULT_THICKNESS_SHARE = 0.12
"""Thickness over the root of the mean area of a face, where none is stated: the ratio of the panels of `default`."""
OVERLAP_GRID_SHARE = 1e-6
"""Grid on which faces are intersected, over the root of their mean area, as GEOS needs one for faces that touch."""
FACE_OF: dict[str, PanelFace] = {"V": "top", "M": "bottom"}
"""The face of the hinge of a valley, and of a mountain."""


def pattern_of_drawing(drawing: PatternDrawing, panel: str | None = None) -> Pattern:
    """Return the pattern of a drawing; unassigned creases are valleys until `packed_states` assigns them.

    panel : longest edge x thickness, mm, as in `--panel`; None for the sizes that the file states.

    Hinges close in the packed state where the file says nothing else: a stated fold angle of 0 leaves them flat there,
    if any other angle is not 0. PatternError for panels that are not convex, overlap or hang on no other, and for
    contradictory hinges.
    """
    _check_panels(drawing)
    unit, thickness = _sizes(drawing, panel)
    polygons = [tuple((unit * x, unit * y) for x, y in outline) for outline in _outlines(drawing)]
    creases = {pair: _crease(drawing, pair) for pair in drawing.joins}
    pattern = Pattern.from_polygons(polygons, creases, thickness, drawing.loops)
    for number, loop in enumerate(pattern.loops):
        if not _is_ring(pattern, loop):
            raise PatternError(
                f"loop {number} in hcsearch:loops is no ring of panels, each joined to the next by a hinge: leave out "
                "hcsearch:loops"
            )
    return pattern


def _is_ring(pattern: Pattern, loop: Sequence[FacetPair]) -> bool:
    """Whether pairs of facets are the hinges around a ring of panels, each of which comes once."""
    creases = [pattern.creases.get((min(pair), max(pair))) for pair in loop]
    if len(loop) < 2 or any(crease is None or crease.face is None for crease in creases):
        return False
    joints = [{pattern.panel_of[facet] for facet in pair} for pair in loop]
    ring = sorted(joints[0] & joints[1])[:1]
    for joint in (*joints[1:], joints[0]):
        ring += joint - {ring[-1]} if ring and ring[-1] in joint else ()
    return len(ring) == len(loop) + 1 == len(set(ring)) + 1 and ring[0] == ring[-1]


def states_angles(drawing: PatternDrawing) -> bool:
    """Whether a drawing states the fold angles of a packed state: some are not 0, as all are in the flat state."""
    return any(join.angle for join in drawing.joins.values())


def _crease(drawing: PatternDrawing, pair: FacetPair) -> Crease:
    """Return the crease of a joint."""
    join = drawing.joins[pair]
    turn = abs(join.angle or 0.0)
    if turn > 180.0 + FOLDED_ANGLE_TOLERANCE or (join.assignment == "F" and turn > FOLDED_ANGLE_TOLERANCE):
        limit = "a flat edge (F) has 0" if join.assignment == "F" else "hinges turn by up to 180 degrees"
        raise PatternError(
            f"the crease between {panel_named(drawing, pair[0])} and panel {pair[1]} has the fold angle "
            f"{join.angle:.6g}, and {limit}: correct edges_foldAngle, or assign M or V"
        )
    if join.assignment == "F" and join.face is None:
        return RIGID_CREASE
    face = join.face or FACE_OF.get(join.assignment, "top")
    if face != FACE_OF.get(join.assignment, face):
        raise PatternError(
            f"the crease between {panel_named(drawing, pair[0])} and panel {pair[1]} is {join.assignment} with its "
            f"hinge on the {face} face, about which thick panels cannot fold that way: mountains have it on the bottom "
            "face, valleys on the top face"
        )
    flat = turn < 90.0 and states_angles(drawing) and not states_between_stops(drawing)
    return Crease(face, closes=join.assignment != "F" and not flat)


def states_between_stops(drawing: PatternDrawing) -> bool:
    """Whether a drawing states a hinge at a fold angle between 0 and 180 degrees."""
    angles = (abs(join.angle or 0.0) for join in drawing.joins.values() if join.assignment != "F")
    return any(FOLDED_ANGLE_TOLERANCE < angle < 180.0 - FOLDED_ANGLE_TOLERANCE for angle in angles)


def stated_angles(drawing: PatternDrawing, pattern: Pattern) -> Reals:
    """Return the stated fold angles of the hinges, (n_hinges,), rad; angles near a stop are set to it.

    PatternError where creases of one hinge differ.
    """
    angles = np.full(len(pattern.hinges), math.nan)
    for pair, join in drawing.joins.items():
        if pattern.creases[pair].face is None:
            continue
        hinge, turn = pattern.hinge_of(pair), abs(join.angle or 0.0)
        if abs(angles[hinge] - turn) > FOLDED_ANGLE_TOLERANCE:
            raise PatternError(
                f"the crease between {panel_named(drawing, pair[0])} and panel {pair[1]} has the fold angle "
                f"{turn:.6g}, and another one on its line {angles[hinge]:.6g}: give both the same"
            )
        angles[hinge] = turn
    angles[angles < FOLDED_ANGLE_TOLERANCE] = 0.0
    angles[angles > 180.0 - FOLDED_ANGLE_TOLERANCE] = 180.0
    radians: Reals = np.radians(angles)
    return radians


def _sizes(drawing: PatternDrawing, panel: str | None) -> tuple[float, float]:
    """Return metres per unit of the drawing, and the thickness (m)."""
    longest = longest_edge(drawing.facets, [pair for pair in drawing.joins if _crease(drawing, pair).face is None])
    size = math.sqrt(sum(map(facet_area, drawing.facets)) / len(drawing.facets))
    if panel is not None:
        length, thickness = _read_sizes(panel)
        return length / longest, thickness
    unit = DEFAULT_LONGEST_EDGE / longest if drawing.unit is None else drawing.unit
    thickness = unit * (DEFAULT_THICKNESS_SHARE * size if drawing.thickness is None else drawing.thickness)
    if not all(MIN_PANEL_LENGTH <= length <= MAX_PANEL_LENGTH for length in (unit * longest, thickness)):
        raise PatternError(
            f"the longest edge is {1e3 * unit * longest:.6g} mm and the thickness {1e3 * thickness:.6g} mm: take "
            f"lengths from {1e3 * MIN_PANEL_LENGTH:g} to {1e3 * MAX_PANEL_LENGTH:g} mm, as by --panel 50x6"
        )
    return unit, thickness


def longest_edge(facets: Sequence[Facet], rigid: Iterable[FacetPair]) -> float:
    """Return the length of the longest side of panels; sides between facets of one panel are left out.

    facets : without corners in the middle of straight sides. rigid : pairs of facets that a flat edge joins.
    """
    sides = [set(sides_of(facet)) for facet in facets]
    for i, j in rigid:
        within = {(start, end) for start, end in sides[i] if (end, start) in sides[j]}
        sides[i] -= within
        sides[j] -= {(end, start) for start, end in within}
    return max(math.dist(*side) for own in sides for side in own)


def _read_sizes(panel: str) -> tuple[float, float]:
    """Read the longest edge and the thickness (m) of a pattern in millimetres; PatternError for another text."""
    try:
        sizes = read_panel(panel) if panel.count("x") == 1 else ()
    except SceneError:
        sizes = ()
    if not sizes:
        raise PatternError(
            f"{panel!r} is no size of a pattern of any panels: write its longest edge x the thickness, each from "
            f"{1e3 * MIN_PANEL_LENGTH:g} to {1e3 * MAX_PANEL_LENGTH:g} mm, such as 50x6"
        )
    return sizes[0], sizes[2]


def _check_panels(drawing: PatternDrawing) -> None:
    """Refuse drawings whose faces are no connected set of separate convex panels; PatternError."""
    n = len(drawing.facets)
    if n > MAX_DRAWN_PANELS:
        raise PatternError(f"the drawing has {n:,} faces: take at most {MAX_DRAWN_PANELS:,}")
    for panel, facet in enumerate(drawing.facets):
        corner = _reflex_corner(facet)
        if corner is not None:
            raise PatternError(
                f"{panel_named(drawing, panel)} is not convex, at its corner {corner}: divide it into convex faces by "
                "flat edges (F), which make one panel of them"
            )
    _check_overlaps(drawing)
    first, *others = components(range(n), drawing.joins)
    if others:
        other = min(others[0])
        raise PatternError(
            f"{panel_named(drawing, other)} is joined to none of the {len(first)} panels around panel {min(first)}: "
            "join all panels by creases (M, V or F), or take one part alone"
        )
    if n == 1:
        raise PatternError("the drawing has one panel and no crease: draw panels, and M and V edges between them")


def _reflex_corner(facet: Facet) -> int | None:
    """Return the first corner at which a polygon is not convex; None where it is."""
    size = math.sqrt(facet_area(facet))
    for k, ((ax, ay), (x, y), (bx, by)) in enumerate(
        zip((facet[-1], *facet[:-1]), facet, (*facet[1:], facet[0]), strict=True)
    ):
        long = math.dist((ax, ay), (bx, by))
        if (x - ax) * (by - y) - (y - ay) * (bx - x) < -POINT_ERROR_SHARE * size * long:
            return k
    return None


def _check_overlaps(drawing: PatternDrawing) -> None:
    """Refuse faces that cover each other, as faces around a hole with a loose panel in it do; PatternError."""
    size = math.sqrt(sum(map(facet_area, drawing.facets)) / len(drawing.facets))
    for one, two in overlapping_polygons([np.array(facet) / size for facet in drawing.facets], STRAIGHT_SIDE_SHARE):
        raise PatternError(
            f"{panel_named(drawing, one)} and panel {two} overlap in the flat pattern: draw panels beside each other"
        )


def overlapping_polygons(polygons: Sequence[Reals], allowed: float) -> list[tuple[int, int]]:
    """Return the pairs of polygons that overlap by more than a share of the smaller one.

    polygons : corners, (k, 2), in units of about the root of their mean area. Pairs are in rising order.
    """
    import shapely  # noqa: PLC0415 - only drawings need it

    shapes = np.array([shapely.Polygon(corners) for corners in polygons])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    first, second = first[first < second], second[first < second]
    # with a grid: otherwise GEOS may find an overlap of panels whose common edge differs in the last bit
    shared = shapely.area(shapely.intersection(shapes[first], shapes[second], grid_size=OVERLAP_GRID_SHARE))
    overlaps = shared > allowed * np.minimum(shapely.area(shapes[first]), shapely.area(shapes[second]))
    return sorted(zip(first[overlaps].tolist(), second[overlaps].tolist(), strict=True))


def _outlines(drawing: PatternDrawing) -> list[Facet]:
    """Return the outlines of all faces with the points at which some face has a corner, moved onto straight sides.

    Faces that share a part of a side then share a whole side.
    """
    corners = {corner for facet in drawing.facets for corner in facet}
    places: dict[PlanePoint, PlanePoint] = {}
    for outline, facet in zip(drawing.outlines, drawing.facets, strict=True):
        for point, (start, end) in _points_on_sides(outline, facet).items():
            if point in corners and point not in places:
                places[point] = _nearest(point, start, end)
    return [tuple(places.get(point, point) for point in outline if point in corners) for outline in drawing.outlines]


def _points_on_sides(outline: Facet, facet: Facet) -> dict[PlanePoint, tuple[PlanePoint, PlanePoint]]:
    """Return the points of an outline that are no corners of its polygon, each with the ends of its side."""
    own = set(facet)
    start = next(k for k, point in enumerate(outline) if point in own)
    ring = [*outline[start:], *outline[:start], outline[start]]
    ends = [k for k, point in enumerate(ring) if point in own]
    return {ring[k]: (ring[a], ring[b]) for a, b in pairwise(ends) for k in range(a + 1, b)}


def _nearest(point: Sequence[float], start: Sequence[float], end: Sequence[float]) -> PlanePoint:
    """Return the point of a line nearest to another point."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    share = ((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / (dx * dx + dy * dy)
    return (start[0] + share * dx, start[1] + share * dy)
