"""FOLD files read back: facets, and what joins each two that share an edge.

Takes what drawing programs write, too: slits as `C` edges or as two boundary edges, faces that are not listed, points
that stand there twice, points in the middle of an edge, `J` edges within a facet.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcsearch.errors import HcsearchError, InputFileError
from hcsearch.export.outlines import faces_between, joined_faces, same_places, without_straight_corners
from hcsearch.pattern import RIGID, Crease, Face, Facet, Pair, Pattern, Point, facet_area
from hcsearch.system.reading import read_text
from hcsearch.typing import Reals

MOST_BYTES = 32 * 2**20
UNITS = {"in": 0.0254, "pt": 0.0254 / 72, "m": 1.0, "cm": 0.01, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
SAME = 1e-3
"""Points nearer than this share of the shortest edge are the same, as drawings are rounded."""

FAR = 1e12
"""Coordinates are below this, so that areas do not overflow."""

Side = tuple[int, int]


@dataclass(frozen=True)
class Join:
    """What joins two facets: M, V, F or U; the face of a hinge where the file says so."""

    assignment: str
    face: Face | None = None


@dataclass(frozen=True)
class Drawing:
    """A flat pattern as a file has it.

    facets : corners counterclockwise, seen from above, in units of the file. joins : of pairs of facets, the lower
        first; other pairs that share an edge have a slit between them.
    unit : metres to a unit, None where the file has no physical one. thickness : in units, None where it has none.
    notation : of the design or assembly that it was written from, or empty. loops : as of `Pattern`.
    """

    facets: tuple[Facet, ...]
    joins: Mapping[Pair, Join]
    unit: float | None
    thickness: float | None
    notation: str
    loops: tuple[tuple[Pair, ...], ...] = ()


def read_fold(path: str) -> Drawing:
    """The drawing in a file; InputFileError as of `read_text`, and for what is no FOLD file of a flat pattern."""
    return parse_fold(read_text(path, most=MOST_BYTES), path)


def parse_fold(text: str, path: str = "the text") -> Drawing:
    """The drawing in a FOLD text; path : named in messages."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputFileError(f"{path} is no FOLD file, which is JSON: {error}; export it as FOLD") from None
    if not isinstance(data, dict):
        raise InputFileError(f"{path} is no FOLD file: it holds no object; export it as FOLD")
    try:
        return _Reader(_pattern_frame(data), path).drawing()
    except HcsearchError:
        raise
    except (TypeError, ValueError, KeyError, IndexError, AttributeError, OverflowError) as error:
        raise InputFileError(f"{path} is no sound FOLD file: {error}; export it anew") from None


def pattern_of(drawing: Drawing, thickness: float | None = None) -> Pattern:
    """The pattern of thick panels that a drawing shows, m.

    thickness : m; that of the file unless given. A file without a physical unit is in metres. Flat creases (F) are
    rigid unless the file says which face carries a hinge. InputFileError where creases are unassigned, or nothing says
    how thick panels are.
    """
    unit = 1.0 if drawing.unit is None else drawing.unit
    if thickness is None:
        if drawing.thickness is None:
            raise InputFileError("the file does not say how thick panels are: give a thickness")
        thickness = unit * drawing.thickness
    creases = {}
    for pair, join in drawing.joins.items():
        if join.assignment == "U":
            raise InputFileError(f"the edge between facets {pair[0]} and {pair[1]} is unassigned: write M, V, F or C")
        if join.assignment == "F":
            creases[pair] = RIGID if join.face is None else Crease(join.face, closes=False)
        else:
            creases[pair] = Crease("top" if join.assignment == "V" else "bottom")
    facets = tuple(tuple((unit * x, unit * y) for x, y in facet) for facet in drawing.facets)
    return Pattern(facets, creases, thickness, drawing.loops)


def _pattern_frame(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The crease pattern: the first frame that says it is one, else the key frame."""
    if "creasePattern" in data.get("frame_classes", ()):
        return data
    for frame in data.get("file_frames", ()):
        if "creasePattern" in frame.get("frame_classes", ()):
            return {**data, **frame} if frame.get("frame_inherit") and frame.get("frame_parent", 0) == 0 else frame
    return data


class _Reader:
    """One crease pattern of a file."""

    def __init__(self, frame: Mapping[str, Any], path: str) -> None:
        self.frame, self.path = frame, path
        self.points = self._flat(frame.get("vertices_coords"))
        self.edges = [tuple(map(self._vertex, edge)) for edge in frame.get("edges_vertices", ())]
        if any(len(edge) != 2 for edge in self.edges):
            raise self._wrong("an edge has not two ends")
        faces = [[self._vertex(v) for v in face] for face in frame.get("faces_vertices", ())]
        if not self.edges and not faces:
            raise self._wrong("it has neither edges nor faces")
        if not self.edges:
            sides = (sorted(side) for face in faces for side in zip(face, [*face[1:], face[0]], strict=True))
            self.edges = list(dict.fromkeys((a, b) for a, b in sides))
        lengths = [math.dist(self.points[a], self.points[b]) for a, b in self.edges]
        self.place = same_places(self.points, SAME * min((length for length in lengths if length > 0.0), default=1.0))
        self.faces = [[self.place[v] for v in face] for face in faces]

    def drawing(self) -> Drawing:
        """The facets and what joins them."""
        marks = self._marks()
        faces = self.faces
        if not faces:
            faces = faces_between([pair for pair in marks if marks[pair].assignment != "J"], self.points)
            faces = [face for face in faces if not _is_hole(face, marks)]
        else:
            faces = joined_faces(faces, {pair for pair, mark in marks.items() if mark.assignment == "J"})
        points = self.points
        if sum(facet_area([points[v] for v in face]) for face in faces) < 0.0:  # drawn as seen from below
            points = [(-x, y) for x, y in points]
        facets = []
        sides: dict[Side, int] = {}
        joins: dict[Pair, Join] = {}
        for f, face in enumerate(faces):
            corners = tuple(points[v] for v in without_straight_corners(face, points, SAME))
            whole = 2 < len(corners) == len(set(corners))
            if not whole or not facet_area(corners) > SAME * math.dist(corners[0], corners[1]) ** 2:
                raise self._wrong(f"face {f} is no polygon that runs counterclockwise, or a sliver")
            facets.append(corners)
            for side in zip(face, [*face[1:], face[0]], strict=True):
                if side in sides:
                    raise self._wrong(f"faces {sides[side]} and {f} overlap: they lie on one side of an edge")
                sides[side] = f
        kinds: dict[Pair, set[Join | None]] = defaultdict(set)
        for (a, b), f in sides.items():
            g = sides.get((b, a), -1)
            if g > f:
                mark = marks.get((min(a, b), max(a, b)), Join("U"))
                kinds[f, g].add(None if mark.assignment in {"B", "C"} else mark)
        for pair, own_kinds in sorted(kinds.items()):
            if len(own_kinds) > 1:
                raise self._wrong(f"the edge between faces {pair[0]} and {pair[1]} has two assignments")
            found = own_kinds.pop()
            if found is not None:
                joins[pair] = found
        return Drawing(
            tuple(facets),
            self._ordered(joins, faces),
            UNITS.get(str(self.frame.get("frame_unit"))),
            self._number("hcsearch:thickness"),
            str(self.frame.get("hcsearch:notation", "")),
            tuple(tuple((int(i), int(j)) for i, j in loop) for loop in self.frame.get("hcsearch:loops", ())),
        )

    def _ordered(self, joins: dict[Pair, Join], faces: Sequence[Sequence[int]]) -> dict[Pair, Join]:
        """Joins in the order of the file's edges, which numbers hinges."""
        at: dict[Pair, int] = {}
        of: dict[tuple[int, int], list[int]] = defaultdict(list)
        for f, face in enumerate(faces):
            for a, b in zip(face, [*face[1:], face[0]], strict=True):
                of[min(a, b), max(a, b)].append(f)
        for k, edge in enumerate(self.edges):
            a, b = sorted(self.place[v] for v in edge)
            beside = sorted(of.get((a, b), ()))
            if len(beside) == 2:
                at.setdefault((beside[0], beside[1]), k)
        return dict(sorted(joins.items(), key=lambda item: at.get(item[0], len(self.edges))))

    def _marks(self) -> dict[tuple[int, int], Join]:
        """What the file says of each edge, by its two places; of edges that lie on each other they must agree."""
        own = self.frame if self.frame.get("edges_vertices") else {}  # else edges are those of faces, in their order
        letters = own.get("edges_assignment")
        angles = own.get("edges_foldAngle")
        hinges = own.get("edges_hcsearch:hingeFace")
        found: dict[tuple[int, int], Join] = {}
        ends = [sorted(self.place[v] for v in edge) for edge in self.edges]
        times = Counter(map(tuple, ends))
        for k, (a, b) in enumerate(ends):
            if letters is not None:
                letter = str(letters[k]).upper()
            elif angles is not None and angles[k]:
                letter = "V" if angles[k] > 0 else "M"
            else:
                letter = "U" if times[a, b] == 1 else "B"  # an edge that stands there twice is a slit
            if letter not in {"B", "M", "V", "F", "U", "C", "J"}:
                raise self._wrong(f"edge {k} has the assignment {letter!r}: write B, M, V, F, U, C or J")
            face = hinges[k] if hinges is not None and hinges[k] in {"top", "bottom"} else None
            mark = Join(letter, face)
            if a != b and found.setdefault((a, b), mark) != mark:
                raise self._wrong(f"edge {k} lies on another one with another assignment")
        return found

    def _flat(self, coords: Any) -> list[Point]:
        """Coordinates in the plane; InputFileError where points do not lie in one."""
        if not coords:
            raise self._wrong("it has no vertices_coords")
        table = np.array([[*map(float, point), 0.0][:3] for point in coords])
        if table.ndim != 2 or table.shape[1] != 3 or not (np.abs(table) < FAR).all():
            raise self._wrong(f"vertices_coords are not points of two or three numbers below {FAR:g}")
        extent: Reals = np.ptp(table, axis=0)
        if extent[2] > 1e-6 * max(extent[:2]):
            raise self._wrong("its first frame is folded: put the flat crease pattern first")
        return [(float(x), float(y)) for x, y in table[:, :2]]

    def _vertex(self, number: Any) -> int:
        if not isinstance(number, int) or not 0 <= number < len(self.points):
            raise self._wrong(f"{number!r} is no vertex")
        return number

    def _number(self, key: str) -> float | None:
        found = self.frame.get(key)
        return float(found) if isinstance(found, int | float) and found > 0 else None

    def _wrong(self, what: str) -> InputFileError:
        return InputFileError(f"{self.path} is no flat pattern: {what}; draw panels edge to edge, and export anew")


def _is_hole(face: Sequence[int], marks: Mapping[tuple[int, int], Join]) -> bool:
    """Whether a face has borders alone: a panel would hang on nothing."""
    sides = zip(face, [*face[1:], face[0]], strict=True)
    return all(marks[min(side), max(side)].assignment in {"B", "C"} for side in sides)
