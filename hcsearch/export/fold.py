"""FOLD 1.2 files: the crease pattern as a mesh cut along its slits, the folded states, and a motion.

The key frame is the pattern, cut along its slits, which are pairs of boundary edges and not `C` edges, since some
programs do not read those. Frame 1 is the sheet folded flat without thickness, with the order of its layers. Frame 2
has the thick panels packed, by their middle surfaces; these share no points, so each face has its own vertices. The
states of a motion follow, represented like frame 2. Where hinges are between their stops in the packed state, there is
no sheet folded flat, and the packed panels are frame 1.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from itertools import chain
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.designs.circuit import Circuit
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import Edge, PlanePoint, components
from hcsearch.shape.pattern import Crease, FacetPair, Fold, Pattern
from hcsearch.subjects.replay import Replay

FacetCorner = tuple[int, int]
"""A facet and the index of one of its corners; also denotes the side that begins there."""


@dataclass(frozen=True)
class CutMesh:
    """A pattern cut along its slits.

    points : of the vertices (m), in the flat state; a vertex on a slit is listed once for each side.
    faces : vertices of each facet, counterclockwise.
    edges : first the creases, in the pattern's order, with their first facet on the left; then the borders, with their
        facet on the left. No two edges have the same two ends.
    creases : the pair of facets of each crease.
    """

    points: tuple[PlanePoint, ...]
    faces: tuple[tuple[int, ...], ...]
    edges: tuple[Edge, ...]
    creases: tuple[FacetPair, ...]


def cut_mesh_of(pattern: Pattern) -> CutMesh:
    """Return the mesh of a pattern cut along its slits.

    Corners of facets are one vertex where a chain of creases connects them. A slit with both ends inside the sheet gets
    a middle vertex on each side, since its two sides would otherwise have the same two ends.
    """
    creased = [_sides(pattern, pair) for pair in pattern.creases]
    sides = {side for both in creased for side in both}
    joined: list[tuple[FacetCorner, FacetCorner]] = []
    for (i, a), (j, b) in creased:
        joined += [((i, a), (j, (b + 1) % len(pattern.faces[j]))), ((i, (a + 1) % len(pattern.faces[i])), (j, b))]
    corners = [[(f, k) for k in range(len(face))] for f, face in enumerate(pattern.faces)]
    parts = components(chain.from_iterable(corners), joined)
    number = {corner: k for k, part in enumerate(parts) for corner in part}
    faces = [[number[corner] for corner in facet_corners] for facet_corners in corners]
    points = [pattern.facets[f][k] for f, k in map(min, parts)]
    edges = [(faces[i][a], faces[i][(a + 1) % len(faces[i])]) for (i, a), _ in creased]
    shared_ends = _twice(faces, sides)
    outlines: list[tuple[int, ...]] = []
    for f, face in enumerate(faces):
        outline: list[int] = []
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            outline.append(start)
            if (f, k) in sides:
                continue
            if (min(start, end), max(start, end)) in shared_ends:
                (x, y), (to_x, to_y) = points[start], points[end]
                outline.append(len(points))
                points.append((0.5 * (x + to_x), 0.5 * (y + to_y)))
                edges.append((start, outline[-1]))
                start = outline[-1]  # noqa: PLW2901 - the second half begins there
            edges.append((start, end))
        outlines.append(tuple(outline))
    return CutMesh(tuple(points), tuple(outlines), tuple(edges), tuple(pattern.creases))


def _sides(pattern: Pattern, pair: FacetPair) -> tuple[FacetCorner, FacetCorner]:
    """Return the sides of two facets along their shared edge."""
    (first, second), (start, end) = pair, pattern.edges[pair]
    return (first, pattern.faces[first].index(start)), (second, pattern.faces[second].index(end))


def _twice(faces: Sequence[Sequence[int]], sides: Collection[FacetCorner]) -> set[Edge]:
    """Return the pairs of ends that two border sides have in common."""
    known: set[Edge] = set()
    twice: set[Edge] = set()
    for f, face in enumerate(faces):
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            ends = (min(start, end), max(start, end))
            if (f, k) not in sides:
                (twice if ends in known else known).add(ends)
    return twice


FoldFrame = dict[str, Any]
_DIGITS = 9
"""Decimals of lengths in millimetres and of angles in degrees."""
_ASSIGNMENTS: dict[Fold, str] = {"flat": "F", "valley": "V", "mountain": "M"}
_SENSES: dict[Fold, int] = {"flat": 0, "valley": 1, "mountain": -1}
_ATTRIBUTES = ("manifold", "orientable", "noCuts", "noJoins", "convexFaces")


def fold_of(
    name: str, linkage: Linkage, labels: Labels, circuit: Circuit | None = None, replay: Replay | None = None
) -> str:
    """Return the text of a FOLD file, one property per line; circuit : None of an assembly."""
    mesh = cut_mesh_of(linkage.pattern)
    # a sheet without thickness has no order of layers between the stops
    frames = [*([folded_frame(mesh, linkage)] if linkage.folds_flat else []), packed_frame(linkage)]
    if replay is not None:
        frames += motion_frames(replay, len(frames))
    head: FoldFrame = {
        "file_spec": 1.2,
        "file_creator": f"hcsearch {version('hcsearch')}",
        "file_title": name,
        "file_classes": ["singleModel", *(["animation"] if replay is not None else [])],
    }
    return _text(head | write_pattern_frame(mesh, name, linkage.pattern, labels, circuit) | {"file_frames": frames})


def write_pattern_frame(
    mesh: CutMesh, name: str, pattern: Pattern, labels: Labels, circuit: Circuit | None
) -> FoldFrame:
    """Return the key frame: the flat pattern with its assignments, and the properties of thick panels."""
    creases = [pattern.creases[pair] for pair in mesh.creases]
    borders = len(mesh.edges) - len(creases)
    hinges = [
        None if crease.face is None else labels.hinges[pattern.hinge_of(pair)]
        for pair, crease in zip(mesh.creases, creases, strict=True)
    ]
    frame: FoldFrame = {
        "frame_title": f"{name}, flat, seen from above",
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D", *_ATTRIBUTES],
        "frame_unit": "mm",
        "hcsearch:notation": name,
        "hcsearch:thickness": _millimetres(pattern.thickness),
        "vertices_coords": _millimetres(mesh.points),
        "edges_vertices": [list(edge) for edge in mesh.edges],
        "edges_assignment": [*(_ASSIGNMENTS[crease.fold] for crease in creases), *["B"] * borders],
        "edges_foldAngle": [*map(_fold_angle, creases), *[0] * borders],
        "edges_hcsearch:hinge": [*hinges, *[None] * borders],
        "edges_hcsearch:hingeFace": [*(crease.face for crease in creases), *[None] * borders],
        "faces_vertices": [list(face) for face in mesh.faces],
        "faces_hcsearch:panel": [labels.panels[panel] for panel in pattern.panel_of],
    }
    if circuit is not None:
        frame["edges_hcsearch:crease"] = [k if k < circuit.n else None for k in range(len(mesh.edges))]
    if pattern.loops:
        frame["hcsearch:loops"] = [[list(pair) for pair in loop] for loop in pattern.loops]
    return frame


def _fold_angle(crease: Crease) -> float:
    """Return the fold angle of a crease in the folded state, degrees, positive for a valley."""
    return _SENSES[crease.fold] * (180 if crease.angle == math.pi else round(math.degrees(crease.angle), _DIGITS))


def folded_frame(mesh: CutMesh, linkage: Linkage) -> FoldFrame:
    """Return the frame of the sheet folded flat without thickness, with the order of its layers.

    It inherits from the key frame: in plane, panels fold as the sheet does, and points on hinges stay together.
    """
    poses = linkage.poses(linkage.folded)
    coords = np.zeros((len(mesh.points), 2))
    for facet, face in enumerate(mesh.faces):
        pose = poses[linkage.pattern.panel_of[facet]]
        for vertex in face:
            coords[vertex] = pose[:2, :2] @ mesh.points[vertex] + pose[:2, 3]
    return {
        "frame_title": "folded, without thickness",
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["2D", *_ATTRIBUTES, "selfTouching", "nonSelfIntersecting"],
        "frame_parent": 0,
        "frame_inherit": True,
        "vertices_coords": _millimetres(coords),
        "faceOrders": face_orders(linkage),
    }


def face_orders(linkage: Linkage) -> list[list[int]]:
    """Return the layer order of facets that overlap in the folded state: [f, g, s] with f < g.

    s : +1 where f lies on the side of g's normal (the top of the flat sheet), else -1.
    """
    import shapely  # noqa: PLC0415 - only this format needs it

    pattern, solids = linkage.pattern, linkage.solids(linkage.folded)
    outlines = shapely.polygons([shapely.linearrings(solid[0, :, :2]) for solid in solids])
    heights = np.array([solid[:, :, 2].mean() for solid in solids])
    normals = linkage.poses(linkage.folded)[list(pattern.panel_of), 2, 2]
    first, second = shapely.STRtree(outlines).query(outlines, predicate="intersects")
    first, second = first[first < second], second[first < second]
    # with a grid: otherwise GEOS may find an overlap of adjacent panels whose corners differ in the last bit
    common = shapely.intersection(outlines[first], outlines[second], grid_size=1e-6 * pattern.size)
    overlap = shapely.area(common) > 1e-6 * pattern.size**2
    pairs = sorted(zip(first[overlap].tolist(), second[overlap].tolist(), strict=True))
    return [[f, g, int(np.sign((heights[f] - heights[g]) * normals[g]))] for f, g in pairs]


def packed_frame(linkage: Linkage) -> FoldFrame:
    """Return the frame of the packed thick panels, by their middle surfaces; faces share no vertices."""
    faces, edges = [], []
    count = 0
    for facet in linkage.pattern.facets:
        corners = list(range(count, count + len(facet)))
        faces.append(corners)
        edges += [[a, b] for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
        count += len(facet)
    return {
        "frame_title": "packed, middle surfaces of the panels",
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D", *_ATTRIBUTES, "nonSelfIntersecting"],
        "frame_unit": "mm",
        "vertices_coords": _middles(linkage, linkage.folded),
        "edges_vertices": edges,
        "edges_assignment": ["B"] * len(edges),
        "faces_vertices": faces,
    }


def motion_frames(replay: Replay, packed: int) -> list[FoldFrame]:
    """Return a frame like the packed one for each state of a motion, with the fold angles of the hinges (degrees).

    packed : number of the packed frame, from which these inherit their faces.
    """
    name, unit = ("hcsearch:time", "s") if replay.axis == "time" else ("hcsearch:pathShare", "of the path")
    return [
        {
            "frame_title": f"{at:.4g} {unit}",
            "frame_classes": ["foldedForm"],
            "frame_parent": packed,
            "frame_inherit": True,
            name: at,
            "hcsearch:hingeAngles": np.degrees(angles).round(_DIGITS).tolist(),
            "vertices_coords": _middles(replay.linkage, angles),
        }
        for at, angles in zip(replay.at.tolist(), replay.angles, strict=True)
    ]


def _middles(linkage: Linkage, angles: Reals) -> Any:
    """Return the corners of the facets' middle surfaces, facet after facet, in mm."""
    return _millimetres(np.concatenate([solid.mean(axis=0) for solid in linkage.solids(angles)]))


def _millimetres(lengths: Any) -> Any:
    numbers = (1e3 * np.asarray(lengths, float)).round(_DIGITS) + 0.0  # no -0
    return numbers.tolist()


def _text(data: Mapping[str, Any]) -> str:
    """Format JSON with one property of a frame per line."""

    def lines(frame: Mapping[str, Any], indent: str) -> str:
        inner = (f"{indent} {json.dumps(key)}: {shown(value, indent + ' ')}" for key, value in frame.items())
        return "{\n" + ",\n".join(inner) + f"\n{indent}}}"

    def shown(value: Any, indent: str) -> str:
        if isinstance(value, Sequence) and value and isinstance(value[0], dict):
            return "[" + ", ".join(lines(frame, indent) for frame in value) + "]"
        return json.dumps(value, separators=(",", ":"), allow_nan=False)

    return lines(data, "") + "\n"
