"""Reading of mechanisms that `hcsearch export` wrote for simulators: URDF with its file of closures, and MJCF.

A loop is cut through a panel there, whose parts are welded to each other. All frames have the axes of the flat state,
in which models are written, so that places add up along the tree. The result is a drawing, as of a FOLD file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.motion.collision.panel_prisms import inset_facet
from hcsearch.search.own_patterns.drawn_lines import PointNumbers
from hcsearch.search.own_patterns.fold_reading import PatternDrawing, parse_fold
from hcsearch.search.own_patterns.fold_values import MAX_COORDINATE, is_finite_number
from hcsearch.shape.mesh import Facet, PlanePoint, components, facet_area, sides_of
from hcsearch.system.reading import read_text_file

MAX_MODEL_BYTES = 64 * 2**20
SAME_MODEL_POINT_SHARE = 1e-5
"""Points nearer than this share of the largest panel's size are one: meshes have single precision."""
_STL_HEAD_BYTES = 84
_STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A triangle of a binary STL file; the head holds a title and the number of triangles."""


@dataclass(frozen=True, eq=False)
class _ModelHinge(ByValue):
    """A joint of a model: its two links, its line in the flat state, and whether it starts closed.

    point : of the line. normal : (2,), unit vector of the plane across it.
    """

    first: str
    second: str
    point: Reals
    normal: Reals
    closes: bool

    def distance(self, point: Sequence[float]) -> float:
        """Return the distance of a point of the plane from the line, seen from above."""
        return abs(float(self.normal @ (np.array(point) - self.point[:2])))


@dataclass(eq=False)
class _Model:
    """The links of a model in the flat state, m.

    frames : origins. faces : convex polygons of each link's shape. welds : pairs of links that are parts of one panel.
    heights : of the bottom and top faces.
    """

    frames: dict[str, Reals] = field(default_factory=dict)
    faces: dict[str, list[Facet]] = field(default_factory=dict)
    hinges: list[_ModelHinge] = field(default_factory=list)
    welds: list[tuple[str, str]] = field(default_factory=list)
    heights: list[float] = field(default_factory=list)


def read_model(path: str) -> PatternDrawing:
    """Read a model that `hcsearch export` wrote, `.urdf`, `.xml` or `.mjcf`, as a drawing in metres.

    InputFileError for other files, and where the closures or a mesh of a URDF file are missing.
    """
    try:
        root = Xml.fromstring(read_text_file(path, max_bytes=MAX_MODEL_BYTES))
    except Xml.ParseError as error:
        raise InputFileError(f"{path} is no model, which is XML: {error}; write it by hcsearch export") from None
    try:
        model = {"robot": _read_urdf, "mujoco": _read_mjcf}[root.tag](root, path)
        return parse_fold(json.dumps(_fold_data(model)), path)
    except (LookupError, ValueError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        if isinstance(error, InputFileError):
            raise
        raise InputFileError(
            f"{path} is no model that hcsearch export wrote ({type(error).__name__}: {error}); others are not read: "
            "give the flat pattern as a file .fold"
        ) from None


def _read_urdf(root: Xml.Element, path: str) -> _Model:
    """Read the tree of a URDF file, its meshes, and the loops from the file of closures beside it."""
    closure_path = Path(path).with_suffix(".closure.json")
    closures = json.loads(read_text_file(closure_path, "the loops, which URDF cannot hold, in", MAX_MODEL_BYTES))
    model = _Model(frames={str(closures["base"]): np.zeros(3)})
    for joint in root.iterfind("joint"):
        first, second = (_found(joint, tag).attrib["link"] for tag in ("parent", "child"))
        model.frames[second] = model.frames[first] + _numbers(_found(joint, "origin").attrib["xyz"])
        start = float(closures["joints"][joint.attrib["name"]]["start_rad"])
        across = _across(_found(joint, "axis").attrib["xyz"])
        model.hinges.append(_ModelHinge(first, second, model.frames[second], across, start > 0.5 * math.pi))
    for link in root.iterfind("link"):
        visual = link.find("visual")
        if visual is not None:
            shift = model.frames[link.attrib["name"]] + _numbers(_found(visual, "origin").attrib["xyz"])
            mesh = Path(path).parent / Path(_found(visual, "geometry/mesh").attrib["filename"]).name
            _add_triangles(model, link.attrib["name"], _stl_corners(mesh) + shift)
    model.welds = [(str(each["first"]["link"]), str(each["second"]["link"])) for each in closures["closures"]]
    return model


def _stl_corners(path: Path) -> Reals:
    """Return the corners of the triangles of a binary STL file, (k, 3, 3)."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputFileError(f"cannot read the mesh {path}: {error.strerror}; keep it beside the model") from None
    corners: Reals = np.frombuffer(content[_STL_HEAD_BYTES:], _STL_RECORD)["corners"].astype(float)
    return corners


def _add_triangles(model: _Model, link: str, corners: Reals) -> None:
    """Add the top faces of a link's triangles, and the heights of both faces."""
    model.heights += [float(corners[..., 2].min()), float(corners[..., 2].max())]
    middle = 0.5 * sum(model.heights[-2:])
    faces = model.faces.setdefault(link, [])
    for triangle in corners[(corners[..., 2] > middle).all(axis=1)]:
        ring = tuple((float(x), float(y)) for x, y, _ in triangle)
        faces.append(ring if facet_area(ring) > 0.0 else ring[::-1])


def _read_mjcf(root: Xml.Element, _path: str) -> _Model:
    """Read the bodies of a model of MuJoCo, whose meshes are facets, shrunk by the margin of the scene."""
    model = _Model()
    meshes = {
        mesh.attrib["name"]: _numbers(mesh.attrib["vertex"]).reshape(2, -1, 3) for mesh in root.iterfind("asset/mesh")
    }
    base = _found(root, "worldbody/body")
    start = _numbers(_found(root, "keyframe/key[@name='start']").attrib["qpos"])
    angles = start[0 if base.find("freejoint") is None else 7 :].tolist()
    margin = min(float(corners[0, :, 2].min()) for corners in _placed_meshes(base, np.zeros(3), meshes))
    for body, parent, frame in _bodies(base, None, np.zeros(3)):
        name = body.attrib["name"]
        model.frames[name] = frame
        if parent is not None:
            across = _across(_found(body, "joint").attrib["axis"])
            model.hinges.append(_ModelHinge(parent, name, frame, across, angles[len(model.hinges)] > 0.5 * math.pi))
        for geom in body.iterfind("geom"):
            corners = meshes[geom.attrib["mesh"]] + frame
            ring = tuple((float(x), float(y)) for x, y, _ in corners[0])
            model.faces.setdefault(name, []).append(inset_facet(ring, -margin))
            model.heights += [float(corners[0, 0, 2]) - margin, float(corners[1, 0, 2]) + margin]
    model.welds = [(weld.attrib["body1"], weld.attrib["body2"]) for weld in root.iterfind("equality/weld")]
    return model


def _bodies(body: Xml.Element, parent: str | None, origin: Reals) -> Iterator[tuple[Xml.Element, str | None, Reals]]:
    """Yield each body, its parent's name and the origin of its frame, depth-first, as MuJoCo numbers joints."""
    frame = origin + _numbers(body.attrib["pos"])
    yield body, parent, frame
    for child in body.iterfind("body"):
        yield from _bodies(child, body.attrib["name"], frame)


def _placed_meshes(base: Xml.Element, origin: Reals, meshes: Mapping[str, Reals]) -> Iterator[Reals]:
    """Yield the corners of all meshes where they lie in the flat state."""
    for body, _, frame in _bodies(base, None, origin):
        for geom in body.iterfind("geom"):
            yield meshes[geom.attrib["mesh"]] + frame


def _fold_data(model: _Model) -> dict[str, Any]:
    """Return a model as the data of a FOLD file in metres: faces, rigid edges within panels, and hinges."""
    parts = components(model.frames, model.welds)
    panel_of = {link: number for number, part in enumerate(parts) for link in part}
    faces = [(panel_of[link], ring) for link, rings in model.faces.items() for ring in rings]
    size = math.sqrt(max(abs(facet_area(ring)) for _, ring in faces))
    numbers = PointNumbers(SAME_MODEL_POINT_SHARE * size)
    known: list[PlanePoint] = []
    rings: list[list[int]] = []
    for _, ring in faces:
        rings.append([numbers.number(point) for point in ring])
        for number, point in zip(rings[-1], ring, strict=True):
            if number == len(known):
                known.append(point)
    points = _on_hinge_lines(model, panel_of, faces, rings, known, size)
    beside: dict[tuple[int, int], list[int]] = {}
    for number, corners in enumerate(rings):
        for a, b in sides_of(corners):
            beside.setdefault((min(a, b), max(a, b)), []).append(number)
    top, middle = max(model.heights), 0.5 * (min(model.heights) + max(model.heights))
    edges: list[list[int]] = []
    letters: list[str] = []
    hinge_faces: list[str | None] = []
    angles: list[int] = []
    for side, pair in beside.items():
        panels = [faces[face][0] for face in pair]
        hinge = None if len(pair) < 2 else _hinge_along(model, panel_of, panels, [points[v] for v in side], size)
        edges.append(list(side))
        if hinge is None:
            letters.append("F" if len(pair) == 2 and panels[0] == panels[1] else "B")
            hinge_faces.append(None)
        else:
            on_top = hinge.point[2] > middle
            letters.append(("V" if on_top else "M") if hinge.closes else "F")
            hinge_faces.append("top" if on_top else "bottom")
        angles.append({"V": 180, "M": -180}.get(letters[-1], 0))
    return {
        "frame_unit": "m",
        "vertices_coords": [list(point) for point in points],
        "faces_vertices": rings,
        "edges_vertices": edges,
        "edges_assignment": letters,
        "edges_foldAngle": angles,
        "edges_hcsearch:hingeFace": hinge_faces,
        "hcsearch:thickness": top - min(model.heights),
    }


def _hinge_along(
    model: _Model, panel_of: Mapping[str, int], panels: list[int], side: Sequence[PlanePoint], size: float
) -> _ModelHinge | None:
    """Return the hinge between two panels on the line of a side, seen from above; None without one."""
    for hinge in model.hinges:
        joins = {panel_of[hinge.first], panel_of[hinge.second]} == set(panels)
        if joins and max(map(hinge.distance, side)) < SAME_MODEL_POINT_SHARE * size:
            return hinge
    return None


def _on_hinge_lines(
    model: _Model,
    panel_of: Mapping[str, int],
    faces: Sequence[tuple[int, Facet]],
    rings: Sequence[Sequence[int]],
    points: Sequence[PlanePoint],
    size: float,
) -> list[PlanePoint]:
    """Return points moved onto the lines of the hinges of their panels: joints have double precision, meshes may not.

    faces : the panel and the corners of each face. rings : their corners as numbers of points.
    """
    lines: list[list[_ModelHinge]] = [[] for _ in points]
    for (panel, _), ring in zip(faces, rings, strict=True):
        for hinge in model.hinges:
            if panel in (panel_of[hinge.first], panel_of[hinge.second]):
                for number in ring:
                    if hinge.distance(points[number]) < SAME_MODEL_POINT_SHARE * size:
                        lines[number].append(hinge)
    moved: list[PlanePoint] = []
    for point, through in zip(points, lines, strict=True):
        place = np.array(point)
        if through:
            normals = np.array([hinge.normal for hinge in through])
            offsets = [float(hinge.normal @ (hinge.point[:2] - place)) for hinge in through]
            place = place + np.linalg.lstsq(normals, np.array(offsets), rcond=1e-6)[0]
        moved.append((float(place[0]), float(place[1])))
    return moved


def _across(axis: str) -> Reals:
    """Return the unit vector of the plane across the axis of a joint."""
    x, y, _ = _numbers(axis).tolist()
    length = math.hypot(x, y)
    return np.array([-y / length, x / length])


def _found(element: Xml.Element, tag: str) -> Xml.Element:
    """Return a part of an element; KeyError where it is missing."""
    part = element.find(tag)
    if part is None:
        raise KeyError(f"no {tag} in {element.tag}")
    return part


def _numbers(text: str) -> Reals:
    """Return the numbers of a text, separated by spaces; ValueError for those that are no coordinates."""
    numbers = [float(part) for part in text.split()]
    if not all(map(is_finite_number, numbers)):
        raise ValueError(f"{text[:40]!r} holds a number that is not below {MAX_COORDINATE:g}")
    return np.array(numbers)
