"""Binary glTF 2.0: a motion as nested hinge nodes with animated rotations, and one mesh per panel.

Each hinge is a node on its line, a child of the hinge by which the parent panel is attached. Rotations are interpolated
linearly (slerp) between the states of the replay, as fold angles are, so hinges turn about their lines in between, too.
Nodes, meshes and extras have the names of `Labels`. Lengths are in metres; glTF has y upwards, so the root node turns
the sheet's z axis to y.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.export.panel_solids import FaceKind, PanelSolid, fan_triangles, panel_solid_of
from hcsearch.subjects.replay import Replay

GLB_ANIMATION_SECONDS = 4.0
"""Duration of the animation, s: paths have no time of their own, and deployments are too fast to watch."""

FACE_COLOURS: dict[FaceKind, tuple[float, float, float]] = {
    "top": (0.86, 0.83, 0.73),
    "bottom": (0.62, 0.65, 0.71),
    "side": (0.45, 0.46, 0.49),
    "valley": (0.01, 0.11, 0.66),
    "mountain": (0.64, 0.01, 0.03),
}
"""Linear RGB colours of the kinds of faces; walls with a hinge have the colours of creases in drawings."""

MAX_KEY_TURN = 0.25 * math.pi
"""Greatest rotation of a hinge between two keyframes, rad."""
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _TRIANGLES = 34962, 34963
_KINDS = tuple(FACE_COLOURS)
_UPWARDS = [-0.5 * 2**0.5, 0.0, 0.0, 0.5 * 2**0.5]
"""A quarter turn about x that takes z to y, as a quaternion x, y, z, w."""


def glb_of(replay: Replay) -> bytes:
    """Return a replay as a binary glTF file with an animation."""
    linkage, labels = replay.linkage, replay.labels
    chain = linkage.chain
    buffer = _Buffer()
    materials = [_material(side) for side in _KINDS]
    nodes: list[dict[str, Any]] = [{"name": replay.title, "rotation": _UPWARDS, "children": []}]
    meshes: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    replay = _in_short_turns(replay)
    times = _rising(GLB_ANIMATION_SECONDS * (replay.at - replay.at[0]) / ((replay.at[-1] - replay.at[0]) or 1.0))
    clock = buffer.add(times[:, None], "SCALAR", bounds=True)
    node_of: dict[int, int] = {}
    for panel in chain.order.tolist():
        parent, hinge = int(chain.parents[panel]), int(chain.hinges[panel])
        origin, parent_node = np.zeros(3), 0
        if parent >= 0:
            origin, parent_node = linkage.points[hinge], node_of[parent]
            parent_hinge = int(chain.hinges[parent])
            shift = origin - (linkage.points[parent_hinge] if parent_hinge >= 0 else np.zeros(3))
            axis = int(chain.signs[panel]) * linkage.directions[hinge]
            rotations = _quaternions(axis, replay.angles[:, hinge])
            name = f"hinge {labels.hinges[hinge]}"
            fold = linkage.pattern.hinges[hinge].crease.fold
            facts = {"hinge": labels.hinges[hinge], "axis": _listed(axis), "crease": fold}
            nodes.append(
                {"name": name, "translation": _listed(shift), "rotation": _listed(rotations[0]), "children": []}
                | {"extras": facts}
            )
            channels.append({"sampler": len(samplers), "target": {"node": len(nodes) - 1, "path": "rotation"}})
            samplers.append({"input": clock, "output": buffer.add(rotations, "VEC4"), "interpolation": "LINEAR"})
            nodes[parent_node]["children"].append(len(nodes) - 1)
            parent_node = len(nodes) - 1
        node_of[panel] = parent_node
        name = f"panel {labels.panels[panel]}"
        nodes.append({"name": name, "mesh": len(meshes), "extras": {"panel": labels.panels[panel]}})
        nodes[parent_node]["children"].append(len(nodes) - 1)
        meshes.append({"name": name, "primitives": _primitives(panel_solid_of(linkage.pattern, panel), origin, buffer)})
    for node in nodes:
        if not node.get("children", True):
            del node["children"]
    document = {
        "asset": {"version": "2.0", "generator": "hcsearch"},
        "scene": 0,
        "scenes": [{"name": replay.title, "nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.content)}],
        "extras": _facts(replay),
    }
    if channels:
        document["animations"] = [{"name": _name(replay), "channels": channels, "samplers": samplers}]
    return _container(document, bytes(buffer.content))


class _Buffer:
    """The binary chunk under construction, with its views and accessors."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: Reals, kind: str, *, bounds: bool = False, target: int | None = None) -> int:
        """Append an array, floats in single precision or indices of vertices; return the index of its accessor."""
        whole = values.dtype.kind in "iu"
        table = np.ascontiguousarray(values, "<u4" if whole else "<f4")
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": table.nbytes}
        self.views.append(view if target is None else view | {"target": target})
        self.content += table.tobytes()
        component = _UNSIGNED if whole else _FLOAT
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(table), "type": kind}
        if bounds:
            accessor |= {"min": _listed(table.min(axis=0)), "max": _listed(table.max(axis=0))}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _primitives(solid: PanelSolid, origin: Reals, buffer: _Buffer) -> list[dict[str, Any]]:
    """Return a primitive for each kind of face; faces share no vertices, which keeps edges sharp."""
    vertices = solid.vertices - origin
    primitives = []
    for number, side in enumerate(_KINDS):
        points: list[Reals] = []
        normals: list[Reals] = []
        triangles: list[tuple[int, int, int]] = []
        for face in solid.faces:
            if face.side != side:
                continue
            corners = vertices[list(face.corners)]
            first = sum(map(len, points))
            triangles += fan_triangles(tuple(range(first, first + len(corners))))
            points.append(corners)
            normals.append(np.tile(_normal(corners), (len(corners), 1)))
        if points:
            attributes = {
                "POSITION": buffer.add(np.concatenate(points), "VEC3", bounds=True, target=_VERTICES),
                "NORMAL": buffer.add(np.concatenate(normals), "VEC3", target=_VERTICES),
            }
            indices = buffer.add(np.array(triangles).reshape(-1, 1), "SCALAR", target=_TRIANGLES)
            primitives.append({"attributes": attributes, "indices": indices, "material": number})
    return primitives


def _normal(corners: Reals) -> Reals:
    cross = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal: Reals = cross / np.linalg.norm(cross)
    return normal


def _material(side: FaceKind) -> dict[str, Any]:
    properties = {"baseColorFactor": [*FACE_COLOURS[side], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
    return {"name": side, "pbrMetallicRoughness": properties}


def _quaternions(axis: Reals, angles: Reals) -> Reals:
    """Return rotations about an axis as unit quaternions x, y, z, w, (k, 4).

    Hinge angles of 0 to pi give half-angles of 0 to pi/2, between which slerp turns in the same sense as the hinge.
    SciPy's `Rotation` gives the same but takes a tenth of a second to import.
    """
    halves = 0.5 * angles[:, None]
    return np.hstack([np.sin(halves) * axis, np.cos(halves)])


def _in_short_turns(replay: Replay) -> Replay:
    """Insert states, linear in fold angles, where a hinge turns by more than `MAX_KEY_TURN` from one state to the next.

    Over half a turn the sense of rotation would depend on rounding, and viewers that interpolate quaternions linearly
    would deviate.
    """
    turns = np.abs(np.diff(replay.angles, axis=0)).max(axis=1, initial=0.0)
    parts = np.maximum(np.ceil(turns / MAX_KEY_TURN - 1e-9).astype(int), 1)
    place = np.concatenate([k + np.arange(count) / count for k, count in enumerate(parts)] + [[float(len(parts))]])
    states = np.arange(len(replay.angles))
    angles = np.column_stack([np.interp(place, states, column) for column in replay.angles.T])
    return replace(replay, at=np.interp(place, states, replay.at), angles=angles)


def _rising(times: Reals) -> Reals:
    """Make times strictly increasing in single precision."""
    single = times.astype(np.float32)
    for k in range(1, len(single)):
        if single[k] <= single[k - 1]:
            single[k] = np.nextafter(single[k - 1], np.float32(np.inf))
    return single.astype(float)


def _name(replay: Replay) -> str:
    return "packed to flat" if replay.ends_flat else "from packed, not as far as flat"


def _collision(replay: Replay) -> dict[str, Any] | None:
    """Return where panels first collide on the axis of the replay, and which panels; None without a collision."""
    if replay.collision is None:
        return None
    at, panels = replay.collision
    return {"at": float(at), "panels": [replay.labels.panels[panel] for panel in panels]}


def _facts(replay: Replay) -> dict[str, Any]:
    in_tree = set(replay.linkage.chain.hinges.tolist())
    unit = "s" if replay.axis == "time" else "share of the path"
    return {
        "notation": replay.title,
        "source": replay.source,
        "axis": replay.axis,
        "axis_unit": unit,
        "axis_range": _listed(replay.at[[0, -1]]),
        "animation_seconds": GLB_ANIMATION_SECONDS,
        "ends_flat": replay.ends_flat,
        "collision": _collision(replay),
        "thickness_m": replay.linkage.pattern.thickness,
        "interpolation_error_rad": replay.error,
        # they have no node: both of their panels are attached by other hinges
        "hinges_that_close_loops": [name for k, name in enumerate(replay.labels.hinges) if k not in in_tree],
    }


def _listed(values: Reals | Sequence[float]) -> list[float]:
    return [float(x) for x in values]


def _container(document: dict[str, Any], content: bytes) -> bytes:
    """Return header and two chunks, each padded to a multiple of four bytes."""
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    content += b"\0" * (-len(content) % 4)
    length = 12 + 8 + len(text) + 8 + len(content)
    head = struct.pack("<4sII", b"glTF", 2, length)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(content), b"BIN\0") + content
