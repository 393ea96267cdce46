"""Frames of a FOLD file with inheritance, and typed access to their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.designs.grid.arrays import MAX_CELLS
from hcsearch.shape.pattern import FacetPair

_OWN = ("frame_parent", "frame_inherit")
"""Keys that are not inherited."""
_NO_PANELS = {"graph", "linkage"}
"""Classes of frames whose edges bound no panels."""


@dataclass(frozen=True)
class FoldFileFrame:
    """A frame, inherited values included; name : for messages."""

    name: str
    values: Mapping[str, Any]


def crease_pattern_frame(data: Mapping[str, Any], path: str) -> FoldFileFrame:
    """Return the frame with the crease pattern; InputFileError for invalid frames or inheritance.

    Among frames with points and edges or faces, the classes are tried in this order: a crease pattern; a frame whose
    classes do not exclude a flat pattern of panels; a graph or linkage; a folded form. Without such a frame, it is the
    first one with points, or else the key frame.
    """
    frames = _frames(data, path)
    pointed = None
    for k in sorted(range(len(frames)), key=lambda k: _rank(frames[k])):
        frame = FoldFileFrame(_name(k, len(frames), path), _with_inherited(frames, k, path))
        if "vertices_coords" not in frame.values:
            continue
        if "edges_vertices" in frame.values or "faces_vertices" in frame.values:
            return frame
        pointed = pointed or frame
    return pointed or FoldFileFrame(_name(0, len(frames), path), frames[0])


def folded_form_frame(data: Mapping[str, Any], path: str, pattern: FoldFileFrame) -> FoldFileFrame | None:
    """Return the first frame of the class `foldedForm` with points in space and faces; None without one.

    pattern : the frame with the crease pattern, which is no folded form. InputFileError as in `crease_pattern_frame`.
    """
    frames = _frames(data, path)
    for k, frame in enumerate(frames):
        points = frame.get("vertices_coords")
        name = _name(k, len(frames), path)
        in_space = isinstance(points, list) and all(isinstance(row, list) and len(row) > 2 for row in points)
        if "foldedForm" in _classes(frame) and in_space and name != pattern.name:
            form = FoldFileFrame(name, _with_inherited(frames, k, path))
            if "faces_vertices" in form.values:
                return form
    return None


def is_animation(data: Mapping[str, Any]) -> bool:
    """Whether a file is of the class `animation`, in which folded forms are steps of a motion."""
    classes = data.get("file_classes")
    return isinstance(classes, list) and "animation" in classes


def _frames(data: Mapping[str, Any], path: str) -> list[Mapping[str, Any]]:
    """Return the key frame and the others, without empty values; InputFileError where they are no frames."""
    listed = data.get("file_frames") or []
    if not isinstance(listed, list) or not all(isinstance(frame, dict) for frame in listed):
        raise InputFileError(f"{path} is no sound FOLD file: file_frames is not a list of frames; export it anew")
    return [_without_empty(frame) for frame in (data, *listed)]


def _rank(frame: Mapping[str, Any]) -> int:
    """Return the rank of a frame's class: frames of lower rank are preferred."""
    classes = _classes(frame)
    if "creasePattern" in classes:
        return 0
    if "foldedForm" in classes:
        return 3
    return 2 if _NO_PANELS & classes else 1


def _name(number: int, count: int, path: str) -> str:
    """Name a frame for messages: the file, and the number where there are several; 0 is the key frame."""
    if count == 1:
        return path
    return f"frame {number} of {path}" if number else f"the first frame of {path}"


def _with_inherited(frames: list[Mapping[str, Any]], number: int, path: str) -> Mapping[str, Any]:
    """Return the values of a frame, with those inherited from its ancestors."""
    values: dict[str, Any] = dict(frames[number])
    lineage = [number]
    while frames[lineage[-1]].get("frame_inherit"):
        parent = frames[lineage[-1]].get("frame_parent", 0)
        if type(parent) is not int or not 0 <= parent < len(frames):
            raise InputFileError(
                f"{path} is no sound FOLD file: frame {lineage[-1]} inherits from {parent!r}, which is no frame; "
                "export it anew"
            )
        if parent in lineage:
            chain = " from ".join(f"frame {k}" for k in (*lineage[lineage.index(parent) :], parent)[:5])
            raise InputFileError(
                f"{path} is no sound FOLD file: {chain} inherits in a circle; write frame_inherit false in one of them"
            )
        lineage.append(parent)
        values = {**frames[parent], **values}
    return {key: value for key, value in values.items() if key not in _OWN}


def _without_empty(frame: Mapping[str, Any]) -> Mapping[str, Any]:
    """Drop keys with null or an empty list, which some programs write for missing values."""
    return {key: value for key, value in frame.items() if value is not None and value != []}


def _classes(frame: Mapping[str, Any]) -> set[str]:
    classes = frame.get("frame_classes")
    return {name for name in classes if isinstance(name, str)} if isinstance(classes, list) else set()


MAX_FOLD_ENTRIES = 10 * MAX_CELLS
"""Limit of the numbers of points, edges and faces: more than the largest array has, points within edges included."""

MAX_COORDINATE = 1e12
"""Limit of coordinates, so that areas do not overflow."""

_METRES = {
    "in": (0.0254, ("inch", "inches", '"')),
    "ft": (0.3048, ("foot", "feet")),
    "pt": (0.0254 / 72, ("point", "points")),
    "m": (1.0, ("metre", "metres", "meter", "meters")),
    "cm": (0.01, ("centimetre", "centimetres", "centimeter", "centimeters")),
    "mm": (1e-3, ("millimetre", "millimetres", "millimeter", "millimeters")),
    "um": (1e-6, ("µm", "μm", "micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers")),
    "nm": (1e-9, ("nanometre", "nanometres", "nanometer", "nanometers")),
}
_UNIT_NAMES = {name: metres for unit, (metres, others) in _METRES.items() for name in (unit, *others)}
_NO_UNITS = ("", "unit", "units")
"""Units of length by the names that programs use, and names that stand for no physical unit."""


class FrameValues:
    """Typed access to the values of one frame; InputFileError, with frame and key, for invalid values."""

    def __init__(self, frame: FoldFileFrame) -> None:
        self._frame, self._name = frame.values, frame.name

    @property
    def name(self) -> str:
        """The name of the frame, for messages."""
        return self._name

    def points(self) -> Reals:
        """Return `vertices_coords`, shape (k, 3); the third coordinate is 0 where a file has two."""
        rows = self._listed("vertices_coords")
        if not rows:
            raise self.wrong("it has no vertices_coords")
        for k, row in enumerate(rows):
            if not (isinstance(row, list) and len(row) >= 2 and all(map(is_finite_number, row))):
                raise self._unsound(
                    f"vertex {k} in vertices_coords is not two or three numbers below {MAX_COORDINATE:g}"
                )
        return np.array([[*map(float, row), 0.0][:3] for row in rows])

    def edges(self, n_points: int) -> list[tuple[int, int]]:
        """Return `edges_vertices`; empty where it is missing."""
        edges = [self._vertices(row, n_points) for row in self._listed("edges_vertices")]
        for k, edge in enumerate(edges):
            if len(edge) != 2:
                raise self.wrong(f"edge {k} has not two ends")
        return [(edge[0], edge[1]) for edge in edges]

    def faces(self, n_points: int) -> list[list[int]]:
        """Return `faces_vertices`; empty where it is missing."""
        faces = [self._vertices(row, n_points) for row in self._listed("faces_vertices")]
        for k, face in enumerate(faces):
            if len(face) < 3:
                raise self.wrong(f"face {k} is no polygon: it has {len(face)} corners")
        return faces

    def of_edges(self, key: str) -> list[Any] | None:
        """Return a value for each edge; None where the frame lacks the key."""
        if key not in self._frame:
            return None
        values, edges = self._listed(key), self._listed("edges_vertices")
        if len(values) != len(edges):
            raise self._unsound(f"{key} has {len(values)} values for {len(edges)} edges")
        return values

    def length(self, key: str) -> float | None:
        """Return a positive length; None where the frame lacks the key."""
        value = self._frame.get(key)
        if value is None:
            return None
        if not is_finite_number(value) or value <= 0:
            raise self._unsound(f"{key} is not a length above 0 and below {MAX_COORDINATE:g}")
        return float(value)

    def unit(self) -> tuple[float | None, str | None]:
        """Return metres per unit of `frame_unit`, None without a physical unit, and a remark on an unknown unit."""
        return metres_of(self._frame.get("frame_unit"))

    def text(self, key: str) -> str:
        """Return a text; empty where the frame lacks the key."""
        value = self._frame.get(key, "")
        return value if isinstance(value, str) else ""

    def loops(self, key: str) -> tuple[tuple[FacetPair, ...], ...]:
        """Return loops, as lists of pairs of facets."""
        loops = self._listed(key)
        for loop in loops:
            if not (isinstance(loop, list) and all(isinstance(pair, list) and len(pair) == 2 for pair in loop)):
                raise self._unsound(f"{key} are not lists of pairs of faces")
        if not all(type(face) is int for loop in loops for pair in loop for face in pair):
            raise self._unsound(f"{key} are not lists of pairs of faces")
        return tuple(tuple((i, j) for i, j in loop) for loop in loops)

    def wrong(self, what: str) -> InputFileError:
        """Return the error for a frame that is no flat pattern."""
        return InputFileError(f"{self._name} is no flat pattern: {what}; draw panels edge to edge, and export anew")

    def _unsound(self, what: str) -> InputFileError:
        return InputFileError(f"{self._name} is no sound FOLD file: {what}; export it anew")

    def _listed(self, key: str) -> list[Any]:
        values = self._frame.get(key)
        if values is None:
            return []
        if not isinstance(values, list):
            raise self._unsound(f"{key} is not a list")
        if len(values) > MAX_FOLD_ENTRIES:
            raise self._unsound(f"{key} has more than {MAX_FOLD_ENTRIES} values")
        return values

    def _vertices(self, row: Any, n_points: int) -> list[int]:
        if not isinstance(row, list):
            raise self._unsound(f"{row!r} is no list of vertices")
        for number in row:
            if type(number) is not int or not 0 <= number < n_points:  # True is no number here
                raise self.wrong(f"{number!r} is no vertex")
        return row


def is_finite_number(value: Any) -> bool:
    """Return whether a value of a file is a number below `MAX_COORDINATE`."""
    return type(value) in (int, float) and abs(value) < MAX_COORDINATE  # never of NaN


def metres_of(unit: object) -> tuple[float | None, str | None]:
    """Return metres per unit, None without a physical unit, and a remark on an unknown unit."""
    if unit is None:
        return None, None
    name = unit.strip().rstrip(".").lower() if isinstance(unit, str) else None
    if name in _NO_UNITS:
        return None, None
    if name is not None and name in _UNIT_NAMES:
        return _UNIT_NAMES[name], None
    known = ", ".join(_METRES)
    return None, f"frame_unit {unit!r} is no unit of length: sizes are not taken from the file; write {known}"
