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

from hcsearch.errors import InputFileError
from hcsearch.outlines import faces_between, joined_faces, same_places, without_straight_corners
from hcsearch.own_patterns.fold_values import FrameValues
from hcsearch.pattern import RIGID, Crease, Face, Facet, Pair, Pattern, facet_area
from hcsearch.system.reading import read_text

MOST_BYTES = 32 * 2**20
UNITS = {"in": 0.0254, "pt": 0.0254 / 72, "m": 1.0, "cm": 0.01, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
SAME = 1e-3
"""Points nearer than this share of the shortest edge are the same, as drawings are rounded."""

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
    return _Reader(FrameValues(_pattern_frame(data, path), path)).drawing()


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


def _pattern_frame(data: Mapping[str, Any], path: str) -> Mapping[str, Any]:
    """The crease pattern: the first frame that says it is one, else the key frame."""
    frames = data.get("file_frames", [])
    if not isinstance(frames, list) or not all(isinstance(frame, dict) for frame in frames):
        raise InputFileError(f"{path} is no sound FOLD file: file_frames is not a list of frames; export it anew")
    if _is_pattern(data):
        return data
    for frame in filter(_is_pattern, frames):
        return {**data, **frame} if frame.get("frame_inherit") and frame.get("frame_parent", 0) == 0 else frame
    return data


def _is_pattern(frame: Mapping[str, Any]) -> bool:
    classes = frame.get("frame_classes")
    return isinstance(classes, list) and "creasePattern" in classes


class _Reader:
    """One crease pattern of a file."""

    def __init__(self, values: FrameValues) -> None:
        self.values = values
        self.points = values.points()
        self.edges = values.edges(len(self.points))
        faces = values.faces(len(self.points))
        if not self.edges and not faces:
            raise values.wrong("it has neither edges nor faces")
        self.named = bool(self.edges)  # else edges are those of faces, of which the file says nothing
        if not self.edges:
            sides = (sorted(side) for face in faces for side in zip(face, [*face[1:], face[0]], strict=True))
            self.edges = list(dict.fromkeys((a, b) for a, b in sides))
        lengths = [math.dist(self.points[a], self.points[b]) for a, b in self.edges]
        self.place = same_places(self.points, SAME * min((length for length in lengths if length > 0.0), default=1.0))
        self.faces = [[self.place[v] for v in face] for face in faces]

    def drawing(self) -> Drawing:
        """The facets and what joins them."""
        marks = self._marks()
        faces, points = self._panels(marks), self.points
        if sum(facet_area([points[v] for v in face]) for face in faces) < 0.0:  # drawn as seen from below
            points = [(-x, y) for x, y in points]
        facets = []
        sides: dict[Side, int] = {}
        for f, face in enumerate(faces):
            corners = tuple(points[v] for v in without_straight_corners(face, points, SAME))
            whole = 2 < len(corners) == len(set(corners))
            if not whole or not facet_area(corners) > SAME * math.dist(corners[0], corners[1]) ** 2:
                raise self.values.wrong(f"face {f} is no polygon that runs counterclockwise, or a sliver")
            facets.append(corners)
            for side in zip(face, [*face[1:], face[0]], strict=True):
                if side in sides:
                    raise self.values.wrong(f"faces {sides[side]} and {f} overlap: they lie on one side of an edge")
                sides[side] = f
        joins = self._joins(sides, marks)
        return Drawing(
            tuple(facets),
            self._ordered(joins, faces),
            UNITS.get(self.values.text("frame_unit")),
            self.values.length("hcsearch:thickness"),
            self.values.text("hcsearch:notation"),
            self.values.loops("hcsearch:loops"),
        )

    def _panels(self, marks: Mapping[tuple[int, int], Join]) -> list[list[int]]:
        """The faces, with those made one that `J` edges join; those between the edges where no faces are listed."""
        if self.faces:
            return joined_faces(self.faces, {pair for pair, mark in marks.items() if mark.assignment == "J"})
        faces = faces_between([pair for pair in marks if marks[pair].assignment != "J"], self.points)
        faces = [face for face in faces if not _is_hole(face, marks)]
        if not faces:
            raise self.values.wrong("its edges bound no panel")
        return faces

    def _joins(self, sides: Mapping[Side, int], marks: Mapping[tuple[int, int], Join]) -> dict[Pair, Join]:
        """What joins each two faces that share an edge; sides : the face on the left of each."""
        joins: dict[Pair, Join] = {}
        kinds: dict[Pair, set[Join | None]] = defaultdict(set)
        for (a, b), f in sides.items():
            g = sides.get((b, a), -1)
            if g > f:
                mark = marks.get((min(a, b), max(a, b)), Join("U"))
                kinds[f, g].add(None if mark.assignment in {"B", "C"} else mark)
        for pair, own_kinds in sorted(kinds.items()):
            if len(own_kinds) > 1:
                raise self.values.wrong(f"the edge between faces {pair[0]} and {pair[1]} has two assignments")
            join = own_kinds.pop()
            if join is not None:
                joins[pair] = join
        return joins

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
        letters, angles, hinges = (
            self.values.of_edges(key) if self.named else None
            for key in ("edges_assignment", "edges_foldAngle", "edges_hcsearch:hingeFace")
        )
        marks: dict[tuple[int, int], Join] = {}
        ends = [sorted(self.place[v] for v in edge) for edge in self.edges]
        times = Counter(map(tuple, ends))
        for k, (a, b) in enumerate(ends):
            if letters is not None:
                letter = str(letters[k]).upper()
            elif angles is not None and angles[k]:
                letter = "V" if self._angle(k, angles[k]) > 0.0 else "M"
            else:
                letter = "U" if times[a, b] == 1 else "B"  # an edge that stands there twice is a slit
            if letter not in {"B", "M", "V", "F", "U", "C", "J"}:
                raise self.values.wrong(f"edge {k} has the assignment {letter!r}: write B, M, V, F, U, C or J")
            face = hinges[k] if hinges is not None and hinges[k] in ("top", "bottom") else None
            mark = Join(letter, face)
            if a != b and marks.setdefault((a, b), mark) != mark:
                raise self.values.wrong(f"edge {k} lies on another one with another assignment")
        return marks

    def _angle(self, edge: int, value: Any) -> float:
        if not isinstance(value, int | float) or math.isnan(value):
            raise self.values.wrong(f"edge {edge} has the fold angle {value!r}, which is no number")
        return value


def _is_hole(face: Sequence[int], marks: Mapping[tuple[int, int], Join]) -> bool:
    """Whether a face has borders alone: a panel would hang on nothing."""
    sides = zip(face, [*face[1:], face[0]], strict=True)
    return all(marks[min(side), max(side)].assignment in {"B", "C"} for side in sides)
