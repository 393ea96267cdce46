"""Reading of FOLD files: facets, and the joints of facets that share an edge.

Accepts the variants of drawing programs: slits as `C` edges or as two boundary edges, unlisted faces, lines that cross
or end on each other, duplicate points, sheets in any plane, `J` edges within a facet.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.search.own_patterns.drawn_lines import CrossingError, in_plane, place_text, split_lines
from hcsearch.search.own_patterns.fold_values import (
    MAX_FOLD_ENTRIES,
    FrameValues,
    crease_pattern_frame,
    folded_form_frame,
    is_animation,
    is_finite_number,
)
from hcsearch.search.own_patterns.folded_forms import FoldedFormError, ListedSheet, folded_form_angles
from hcsearch.shape.mesh import (
    Facet,
    faces_between,
    facet_area,
    joined_faces,
    sides_of,
    without_dead_ends,
    without_spurs,
    without_straight_corners,
)
from hcsearch.shape.pattern import FacetPair, PanelFace
from hcsearch.system.reading import read_text_file

MAX_FOLD_FILE_BYTES = 32 * 2**20
POINT_ERROR_SHARE = 1e-3
"""Error of points, in the plane and normal to it, over the length of a side: drawings are rounded."""
SAME_DRAWN_POINT_SHARE = 3.0 * POINT_ERROR_SHARE
"""Greatest distance of two images of one point with such errors, over the length of a side."""
STRAIGHT_SIDE_SHARE = 5.0 * POINT_ERROR_SHARE
"""Greatest distance of a point from the side that it lies on, over the root of a panel's area."""
JOIN_TOLERANCES = (SAME_DRAWN_POINT_SHARE, 3.0 * SAME_DRAWN_POINT_SHARE, 10.0 * SAME_DRAWN_POINT_SHARE)
"""Tolerances for merging points, over the length of a typical edge, tried in turn until all lines meet."""
EDGE_LENGTH_RATIO = 1.5
"""Factor from which edges count as longer or shorter than the sides of panels."""

FacetSide = tuple[int, int]


@dataclass(frozen=True)
class FacetJoin:
    """The joint of two facets.

    assignment : M, V, F or U. face : the face of a hinge, where the file states it. angle : the fold angle that the
    file states, degrees, positive for valleys; None without one.
    """

    assignment: str
    face: PanelFace | None = None
    angle: float | None = field(default=None, compare=False)


@dataclass(frozen=True)
class PatternDrawing:
    """A flat pattern as read from a file.

    facets : corners counterclockwise, seen from above, in units of the file. joins : joints of pairs of facets, the
        lower number first; other pairs that share an edge have a slit between them.
    outlines : outlines of the facets, with the points in the middle of their sides at which other lines end.
    unit : metres per unit, None where the file has no physical unit. thickness : in units, None where it is not stated.
    notation : the notation of the exported design or assembly, or empty. loops : as in `Pattern`.
    remarks : sentences for users on the interpretation of the file.
    form_fault : why a folded form in the file gives no packed state, as a sentence; empty without a fault.
    """

    facets: tuple[Facet, ...]
    joins: Mapping[FacetPair, FacetJoin]
    unit: float | None
    thickness: float | None
    notation: str
    outlines: tuple[Facet, ...] = ()
    loops: tuple[tuple[FacetPair, ...], ...] = ()
    remarks: tuple[str, ...] = ()
    form_fault: str = ""


def read_fold(path: str) -> PatternDrawing:
    """Read a FOLD file; InputFileError as in `read_text`, and where it holds no flat pattern."""
    return parse_fold(read_text_file(path, max_bytes=MAX_FOLD_FILE_BYTES), path)


def parse_fold(text: str, path: str = "the text") -> PatternDrawing:
    """Parse a FOLD text; path : name of the file for messages."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        syntax = isinstance(error, json.JSONDecodeError | RecursionError)
        why = error if syntax else "a number in it has thousands of digits"
        raise InputFileError(f"{path} is no FOLD file, which is JSON: {why}; export it as FOLD") from None
    if not isinstance(data, dict):
        raise InputFileError(f"{path} is no FOLD file: it holds no object; export it as FOLD")
    return drawing_of_data(data, path)


def drawing_of_data(data: Mapping[str, Any], path: str) -> PatternDrawing:
    """Return the drawing in the data of a FOLD file; path : name of the file for messages."""
    frame = crease_pattern_frame(data, path)
    form = folded_form_frame(data, path, frame)
    reader = _Reader(FrameValues(frame), None if form is None else FrameValues(form), is_animation(data))
    try:
        return reader.drawing()
    except CrossingError as error:  # with every tolerance
        raise InputFileError(f"{path} has too many lines for a pattern: they {error}; draw fewer") from None


class _Reader:
    """The points, edges and faces of one crease pattern, as listed in a file.

    form_angles : fold angles of the edges in a folded form; None without one. form_fault : as in `PatternDrawing`.
    form_is_step : whether the form is a step of a motion, so that its angles between the stops do not count.
    """

    def __init__(self, values: FrameValues, form: FrameValues | None, form_is_step: bool) -> None:
        self.values = values
        points = values.points()
        self.edges = values.edges(len(points))
        self.faces = values.faces(len(points))
        if not self.edges and not self.faces:
            raise values.wrong("it has neither edges nor faces")
        self.named = bool(self.edges)  # else edges are the sides of faces, without assignments
        sides = dict.fromkeys((min(side), max(side)) for face in self.faces for side in sides_of(face))
        if not self.edges:
            self.edges = list(sides)
        # sides of faces are split where lines of the drawing are, so that faces share whole sides
        listed = {(min(edge), max(edge)) for edge in self.edges}
        self.lines = [*self.edges, *(side for side in sides if side not in listed)]
        ends = points[np.array(self.edges)]
        lengths = np.sort(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
        drawn = np.cumsum(lengths)
        if not drawn[-1] > 0.0:
            raise values.wrong("all of its edges are points")
        # edge lengths below which half and a quarter of the total drawn length lie, so that many specks count little
        self.median, self.short = (float(lengths[np.searchsorted(drawn, share * drawn[-1])]) for share in (0.5, 0.25))
        self.points = self._flat(points)
        self.form_angles: list[float | None] | None = None
        self.form_fault = ""
        if form is not None and self.faces and not (self.named and any(values.of_edges("edges_foldAngle") or ())):
            tolerance = SAME_DRAWN_POINT_SHARE * self.median
            plane = self.points.tolist()
            corners = [without_straight_corners(face, plane, STRAIGHT_SIDE_SHARE) for face in self.faces]
            sheet = ListedSheet(points, self.faces, corners, self.edges)
            try:
                angles = folded_form_angles(values, sheet, form, tolerance)
                if not form_is_step or all(angle is None or abs(angle) in {0.0, 180.0} for angle in angles):
                    self.form_angles = angles
            except InputFileError as error:
                self.form_fault = str(error)
            except FoldedFormError as error:
                self.form_fault = (
                    f"{form.name} is a folded form that gives no packed state, as {error}: correct this frame or leave "
                    "it out, or write edges_foldAngle"
                )

    def borders(self) -> Sequence[int]:
        """Return the lines that bound faces, where the file lists none."""
        if self.faces:
            return ()
        letters = self.values.of_edges("edges_assignment")
        return [k for k in range(len(self.edges)) if letters is None or str(letters[k]).upper() != "J"]

    def _flat(self, points: Reals) -> Reals:
        """Project the points at which lines end onto their plane; InputFileError where the sheet is folded."""
        used = np.array(sorted({v for line in self.lines for v in line}))
        projected, distances = in_plane(points[used])
        worst = int(distances.argmax())
        if distances[worst] > SAME_DRAWN_POINT_SHARE * self.median:
            where, far = (
                place_text(points[used[worst]].tolist(), self.median),
                place_text([distances[worst]], self.median),
            )
            raise self.values.wrong(
                f"it is folded: vertex {used[worst]} at {where} is {far[1:-1]} off the plane of the "
                "others; put the flat crease pattern first"
            )
        flat = np.zeros((len(points), 2))
        flat[used] = projected
        return flat

    def drawing(self) -> PatternDrawing:
        """Read the facets and their joints, with the tolerance at which all lines meet.

        Points nearer than a share of a typical edge are merged. Where lines then have loose ends, greater shares, and a
        share of a shorter edge, are tried until all lines meet. Edges may be drawn across several panels or in parts:
        where the sides of panels differ in length from edges, their length is used for the tolerance.
        """
        tolerances = [share * self.median for share in JOIN_TOLERANCES]
        if self.short < self.median / EDGE_LENGTH_RATIO:
            tolerances.append(SAME_DRAWN_POINT_SHARE * self.short)
        read: list[_Reading] = []
        first: InputFileError | None = None
        for tolerance in tolerances:
            try:
                reading = _Reading(self, tolerance)
            except InputFileError as error:
                first = first or error
                continue
            read.append(reading)
            if not reading.loose:
                break
        if not read:
            assert first is not None
            raise first
        best = read[0] if read[-1].loose else read[-1]
        if not self.median / EDGE_LENGTH_RATIO < best.side < EDGE_LENGTH_RATIO * self.median:
            try:
                again = _Reading(self, SAME_DRAWN_POINT_SHARE * best.side)
            except InputFileError:
                return best.drawing()
            best = min((again, best), key=lambda reading: reading.loose)
        return best.drawing()


class _Reading:
    """The interpretation of a pattern with points nearer than a tolerance merged.

    loose : number of lines with a loose end.
    """

    def __init__(self, whole: _Reader, tolerance: float) -> None:
        self.values, self.whole, self.tolerance = whole.values, whole, tolerance
        split = split_lines(whole.points, whole.lines, tolerance, MAX_FOLD_ENTRIES, whole.borders())
        self.points, self.place_of_point = split.points, split.place_of_point
        self.places_of_edge = split.places_along[: len(whole.edges)]
        self.places_along = {(places[0], places[-1]): places for places in split.places_along if places}
        self.marks = self._marks()
        self.loose = 0
        self.faces = self._panels()
        if sum(facet_area([self.points[v] for v in face]) for face in self.faces) < 0.0:  # drawn from below
            self.points = [(-x, y) for x, y in self.points]
        self.facets, self.sides = self._facets()
        self.joins = self._joins()

    @property
    def side(self) -> float:
        """The median length of the panels' sides."""
        lengths = sorted(math.dist(*side) for facet in self.facets for side in sides_of(facet))
        return lengths[(len(lengths) - 1) // 2]

    def drawing(self) -> PatternDrawing:
        """Return the result, with remarks on loose lines and units."""
        values = self.values
        unit, remark = values.unit()
        remarks = [] if remark is None else [remark]
        if self.loose:
            remarks.append(f"{self._first_loose()}; lines that lead to no other are left out")
        return PatternDrawing(
            tuple(self.facets),
            self._ordered(),
            unit,
            values.length("hcsearch:thickness"),
            values.text("hcsearch:notation"),
            tuple(tuple(self.points[v] for v in face) for face in self.faces),
            values.loops("hcsearch:loops"),
            tuple(remarks),
            self.whole.form_fault,
        )

    def _at(self, *places: int) -> str:
        """Format places for messages."""
        return " to ".join(place_text(self.points[v], self.whole.median) for v in places)

    def _facets(self) -> tuple[list[Facet], dict[FacetSide, int]]:
        """Return the corners of each face, and the face on the left of each side."""
        facets = []
        sides: dict[FacetSide, int] = {}
        for f, listed in enumerate(self.faces):
            # some programs list faces clockwise
            face = listed if facet_area([self.points[v] for v in listed]) >= 0.0 else listed[::-1]
            self.faces[f] = face
            corners = tuple(self.points[v] for v in without_straight_corners(face, self.points, STRAIGHT_SIDE_SHARE))
            whole = 2 < len(corners) == len(set(corners))
            if not whole or not facet_area(corners) > POINT_ERROR_SHARE * math.dist(corners[0], corners[1]) ** 2:
                raise self.values.wrong(f"face {f} at {self._at(face[0])} is no polygon, or a sliver")
            facets.append(corners)
            for side in sides_of(face):
                if side in sides:
                    raise self.values.wrong(
                        f"faces {sides[side]} and {f} overlap: they lie on one side of the edge from {self._at(*side)}"
                    )
                sides[side] = f
        return facets, sides

    def _panels(self) -> list[list[int]]:
        """Return the listed faces, or else the faces that edges bound; faces joined by `J` edges are merged."""
        marks = self.marks
        if self.whole.faces:
            rings = [self._ring(face) for face in self.whole.faces]
            faces = [ring for ring in rings if len(ring) > 2]
            faces = joined_faces(faces, {pair for pair, mark in marks.items() if mark.assignment == "J"})
        else:
            drawn = [pair for pair in marks if marks[pair].assignment != "J"]
            closed = without_dead_ends(drawn)
            self.loose = len(drawn) - len(closed)
            faces = faces_between(closed, self.points)
            faces = [face for face in faces if not _is_hole(face, marks)]
        if not faces:
            loose = "" if not self.loose else f": {self._first_loose()}"
            raise self.values.wrong(f"its edges bound no panel{loose}")
        return faces

    def _first_loose(self) -> str:
        """Describe the first edge with a loose end."""
        drawn = [pair for pair, mark in self.marks.items() if mark.assignment != "J"]
        closed = set(without_dead_ends(drawn))
        for k, places in enumerate(self.places_of_edge):
            for pair in pairwise(places):
                if (min(pair), max(pair)) not in closed:
                    return f"edge {k} from {self._at(places[0], places[-1])} ends at no other edge"
        return "edges end at no others"  # pragma: no cover

    def _ring(self, face: Sequence[int]) -> list[int]:
        """Return a listed face with the places on its sides inserted, and without spurs."""
        ring: list[int] = []
        for a, b in sides_of([self.place_of_point[v] for v in face]):
            ring += self._places_between(a, b)[:-1] if a != b else []
        return without_spurs(ring)

    def _places_between(self, a: int, b: int) -> list[int]:
        """Return the places along a line between two end places."""
        return self.places_along[a, b] if (a, b) in self.places_along else self.places_along[b, a][::-1]

    def _joins(self) -> dict[FacetPair, FacetJoin]:
        """Return the joints of faces that share an edge; InputFileError where their marks contradict each other.

        Faces whose common sides are shorter than twice the tolerance only touch at a corner, which has two images.
        """
        joins: dict[FacetPair, FacetJoin] = {}
        kinds: dict[FacetPair, dict[FacetJoin | None, FacetSide]] = defaultdict(dict)
        shared: dict[FacetPair, float] = defaultdict(float)
        for (a, b), f in self.sides.items():
            g = self.sides.get((b, a), -1)
            if g > f:
                mark = self.marks.get((min(a, b), max(a, b)), FacetJoin("U"))
                kinds[f, g][None if mark.assignment in {"B", "C"} else mark] = (a, b)
                shared[f, g] += math.dist(self.points[a], self.points[b])
        for pair, joint_sides in sorted(kinds.items()):
            if shared[pair] < 2.0 * self.tolerance:
                continue
            if len(joint_sides) > 1:
                joint_sides.pop(FacetJoin("U"), None)
            if len(joint_sides) > 1:
                where = " and ".join(
                    f"{'slit' if join is None else join.assignment} from {self._at(*side)}"
                    for join, side in joint_sides.items()
                )
                raise self.values.wrong(f"the edge between faces {pair[0]} and {pair[1]} has two assignments: {where}")
            join = next(iter(joint_sides))
            if join is not None:
                joins[pair] = join
        return joins

    def _ordered(self) -> dict[FacetPair, FacetJoin]:
        """Sort joints in the order of the file's edges, by which hinges are numbered."""
        first_edge: dict[FacetPair, int] = {}
        for k, places in enumerate(self.places_of_edge):
            for a, b in pairwise(places):
                faces = sorted({self.sides.get((a, b), -1), self.sides.get((b, a), -1)})
                if len(faces) == 2 and faces[0] >= 0:
                    first_edge.setdefault((faces[0], faces[1]), k)
        return dict(sorted(self.joins.items(), key=lambda item: first_edge.get(item[0], len(self.places_of_edge))))

    def _marks(self) -> dict[tuple[int, int], FacetJoin]:
        """Return the mark of each edge, by its two places; InputFileError where coincident edges differ."""
        letters, angles, hinges = (
            self.values.of_edges(key) if self.whole.named else None
            for key in ("edges_assignment", "edges_foldAngle", "edges_hcsearch:hingeFace")
        )
        angles = angles if self.whole.form_angles is None else self.whole.form_angles
        marks: dict[tuple[int, int], FacetJoin] = {}
        edges_between: dict[tuple[int, int], list[int]] = defaultdict(list)
        for k, places in enumerate(self.places_of_edge):
            for a, b in pairwise(places):
                edges_between[min(a, b), max(a, b)].append(k)
        edge_marks = [self._mark(k, letters, angles, hinges) for k in range(len(self.places_of_edge))]
        for pair, edges in edges_between.items():
            if letters is None and len(edges) > 1 and all(edge_marks[k].assignment == "U" for k in edges):
                marks[pair] = FacetJoin("B")  # a duplicate edge without an assignment is a slit
                continue
            for k in edges:
                mark, other = edge_marks[k], marks.get(pair)
                if other is None or other == FacetJoin("U"):
                    marks[pair] = mark
                elif mark not in (other, FacetJoin("U")) and {mark.assignment, other.assignment} != {"B", "C"}:
                    first = next(j for j in edges if edge_marks[j] == other)
                    raise self.values.wrong(
                        f"edge {k} ({mark.assignment}) lies on edge {first}, another one with another assignment "
                        f"({other.assignment}), from {self._at(*pair)}"
                    )
        return marks

    def _mark(self, k: int, letters: list[Any] | None, angles: list[Any] | None, hinges: list[Any] | None) -> FacetJoin:
        """Return the assignment of an edge, or else the one that its fold angle's sign implies, and its hinge face."""
        angle = None if angles is None else self._angle(k, angles[k])
        letter = "U" if letters is None else str(letters[k]).upper()
        if letter not in {"B", "M", "V", "F", "U", "C", "J"}:
            raise self.values.wrong(f"edge {k} has the assignment {letter!r}: write B, M, V, F, U, C or J")
        # the folded form has no sign for faces that lie on each other
        if letter == "U" and angle and (self.whole.form_angles is None or abs(angle) < 180.0):
            letter = "V" if angle > 0.0 else "M"
        face = hinges[k] if hinges is not None and hinges[k] in ("top", "bottom") else None
        return FacetJoin(letter, face, angle)

    def _angle(self, edge: int, value: Any) -> float | None:
        """Return the fold angle of an edge, degrees; None for null."""
        if value is None:
            return None
        if not is_finite_number(value):
            raise self.values.wrong(f"edge {edge} has the fold angle {value!r:.40}, which is no number")
        return float(value)


def _is_hole(face: Sequence[int], marks: Mapping[tuple[int, int], FacetJoin]) -> bool:
    """Whether all sides of a face are borders, so that it would be an unattached panel."""
    return all(marks[min(side), max(side)].assignment in {"B", "C"} for side in sides_of(face))
