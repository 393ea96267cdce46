"""FOLD 1.2 files: the crease pattern as a mesh cut along its slits, the folded states, and a motion.

The key frame is the pattern, cut along its slits: these are pairs of boundary edges, not `C` edges, which some programs
do not read. Frame 1 is the sheet folded flat without thickness, with the order of its layers. Frame 2 has the panels
packed as they are, by their middle surfaces: thick panels share no points, so that each face has vertices of its own.
The states of a motion follow, in the same way.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from itertools import chain
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.cases.replay import Replay
from hcsearch.designs.circuit import Circuit
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import Edge, PlanePoint, components
from hcsearch.shape.pattern import FacetPair, Fold, Pattern

FacetCorner = tuple[int, int]
"""A facet, and the place of a corner in it; also the side that begins there."""


@dataclass(frozen=True)
class CutMesh:
    """A cut pattern.

    points : of the vertices (m), in the flat state; those on slits stand there once for each side.
    faces : vertices of each facet, counterclockwise.
    edges : first the creases, in the pattern's order, with their first facet on the left; then the borders, with their
        facet on the left. The ends of an edge are those of no other one.
    creases : the pair of facets of each crease.
    """

    points: tuple[PlanePoint, ...]
    faces: tuple[tuple[int, ...], ...]
    edges: tuple[Edge, ...]
    creases: tuple[FacetPair, ...]


def cut_mesh_of(pattern: Pattern) -> CutMesh:
    """The mesh of a pattern.

    Corners of facets are one vertex where a chain of creases joins them. A slit whose ends both lie inside gets a
    vertex in its middle on each side: its sides would have the same two ends.
    """
    creased = [_sides(pattern, pair) for pair in pattern.creases]
    sides = {side for both in creased for side in both}
    joined: list[tuple[FacetCorner, FacetCorner]] = []
    for (i, a), (j, b) in creased:
        joined += [((i, a), (j, (b + 1) % len(pattern.faces[j]))), ((i, (a + 1) % len(pattern.faces[i])), (j, b))]
    corners = [[(f, k) for k in range(len(face))] for f, face in enumerate(pattern.faces)]
    parts = components(chain.from_iterable(corners), joined)
    number = {corner: k for k, part in enumerate(parts) for corner in part}
    faces = [[number[corner] for corner in own] for own in corners]
    points = [pattern.facets[f][k] for f, k in map(min, parts)]
    edges = [(faces[i][a], faces[i][(a + 1) % len(faces[i])]) for (i, a), _ in creased]
    twice = _twice(faces, sides)
    outlines: list[tuple[int, ...]] = []
    for f, face in enumerate(faces):
        whole: list[int] = []
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            whole.append(start)
            if (f, k) in sides:
                continue
            if (min(start, end), max(start, end)) in twice:
                (x, y), (to_x, to_y) = points[start], points[end]
                whole.append(len(points))
                points.append((0.5 * (x + to_x), 0.5 * (y + to_y)))
                edges.append((start, whole[-1]))
                start = whole[-1]  # noqa: PLW2901 - the second half begins there
            edges.append((start, end))
        outlines.append(tuple(whole))
    return CutMesh(tuple(points), tuple(outlines), tuple(edges), tuple(pattern.creases))


def _sides(pattern: Pattern, pair: FacetPair) -> tuple[FacetCorner, FacetCorner]:
    """The sides of two facets along their shared edge."""
    (first, second), (start, end) = pair, pattern.edges[pair]
    return (first, pattern.faces[first].index(start)), (second, pattern.faces[second].index(end))


def _twice(faces: Sequence[Sequence[int]], sides: Collection[FacetCorner]) -> set[Edge]:
    """Ends that two sides along borders have in common."""
    seen: set[Edge] = set()
    twice: set[Edge] = set()
    for f, face in enumerate(faces):
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            ends = (min(start, end), max(start, end))
            if (f, k) not in sides:
                (twice if ends in seen else seen).add(ends)
    return twice


FoldFrame = dict[str, Any]

_PACKED = 2
"""The frame that has the panels packed, whose faces the frames of a motion take over."""
_DIGITS = 9
"""Decimals of millimetres."""
_ASSIGNMENTS: dict[Fold, str] = {"flat": "F", "valley": "V", "mountain": "M"}
_ANGLES: dict[Fold, int] = {"flat": 0, "valley": 180, "mountain": -180}
_ATTRIBUTES = ("manifold", "orientable", "noCuts", "noJoins", "convexFaces")


def fold_of(
    name: str, linkage: Linkage, labels: Labels, circuit: Circuit | None = None, replay: Replay | None = None
) -> str:
    """Return the text of a file with a property a line; circuit : None of an assembly."""
    mesh = cut_mesh_of(linkage.pattern)
    frames = [folded_frame(mesh, linkage), packed_frame(linkage)]
    if replay is not None:
        frames += motion_frames(replay)
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
    """The key frame: the flat pattern, with its assignments, and what only thick panels have."""
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
        "edges_foldAngle": [*(_ANGLES[crease.fold] for crease in creases), *[0] * borders],
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


def folded_frame(mesh: CutMesh, linkage: Linkage) -> FoldFrame:
    """The sheet folded flat, as if it had no thickness, with the order of its layers.

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
    """Which of two facets that lie over each other in the folded state is above: [f, g, s], f < g.

    s : +1 where f lies on the side of g's normal, the top of the flat sheet; else -1.
    """
    import shapely  # noqa: PLC0415 - only this format needs it

    pattern, solids = linkage.pattern, linkage.solids(linkage.folded)
    outlines = shapely.polygons([shapely.linearrings(solid[0, :, :2]) for solid in solids])
    heights = np.array([solid[:, :, 2].mean() for solid in solids])
    normals = linkage.poses(linkage.folded)[list(pattern.panel_of), 2, 2]
    first, second = shapely.STRtree(outlines).query(outlines, predicate="intersects")
    first, second = first[first < second], second[first < second]
    # with a grid, as GEOS may take panels side by side, with ends that differ in the last bit, for one on the other
    common = shapely.intersection(outlines[first], outlines[second], grid_size=1e-6 * pattern.size)
    overlap = shapely.area(common) > 1e-6 * pattern.size**2
    pairs = sorted(zip(first[overlap].tolist(), second[overlap].tolist(), strict=True))
    return [[f, g, int(np.sign((heights[f] - heights[g]) * normals[g]))] for f, g in pairs]


def packed_frame(linkage: Linkage) -> FoldFrame:
    """The thick panels packed, by their middle surfaces, each face with vertices and borders of its own."""
    faces, edges = [], []
    count = 0
    for facet in linkage.pattern.facets:
        own = list(range(count, count + len(facet)))
        faces.append(own)
        edges += [[a, b] for a, b in zip(own, [*own[1:], own[0]], strict=True)]
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


def motion_frames(replay: Replay) -> list[FoldFrame]:
    """The states of a motion, as the packed frame, with the fold angles of the hinges in their order (degrees)."""
    name, unit = ("hcsearch:time", "s") if replay.axis == "time" else ("hcsearch:pathShare", "of the path")
    return [
        {
            "frame_title": f"{at:.4g} {unit}",
            "frame_classes": ["foldedForm"],
            "frame_parent": _PACKED,
            "frame_inherit": True,
            name: at,
            "hcsearch:hingeAngles": np.degrees(angles).round(_DIGITS).tolist(),
            "vertices_coords": _middles(replay.linkage, angles),
        }
        for at, angles in zip(replay.at.tolist(), replay.angles, strict=True)
    ]


def _middles(linkage: Linkage, angles: Reals) -> Any:
    """Corners of the facets' middle surfaces, facet after facet, in mm."""
    return _millimetres(np.concatenate([solid.mean(axis=0) for solid in linkage.solids(angles)]))


def _millimetres(lengths: Any) -> Any:
    numbers = (1e3 * np.asarray(lengths, float)).round(_DIGITS) + 0.0  # no -0
    return numbers.tolist()


def _text(data: Mapping[str, Any]) -> str:
    """JSON with a property of a frame on each line."""

    def lines(frame: Mapping[str, Any], indent: str) -> str:
        inner = (f"{indent} {json.dumps(key)}: {shown(value, indent + ' ')}" for key, value in frame.items())
        return "{\n" + ",\n".join(inner) + f"\n{indent}}}"

    def shown(value: Any, indent: str) -> str:
        if isinstance(value, Sequence) and value and isinstance(value[0], dict):
            return "[" + ", ".join(lines(frame, indent) for frame in value) + "]"
        return json.dumps(value, separators=(",", ":"), allow_nan=False)

    return lines(data, "") + "\n"
