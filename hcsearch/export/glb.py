"""Binary glTF 2.0: a motion as nested hinge nodes whose rotations are animated, one mesh a panel.

Each hinge is a node on its line, below the hinge by which its panel hangs on; its rotation runs linearly (slerp)
between the states of the replay, as the fold angles do, so that a hinge turns about its line between them, too. Nodes,
meshes and extras bear the names of `Labels`. Metres; glTF has y upwards, so that the root turns the sheet's z there.
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
from hcsearch.cases.replay import Replay
from hcsearch.export.panel_solids import FaceKind, PanelSolid, fan_triangles, panel_solid_of

GLB_ANIMATION_SECONDS = 4.0
"""How long the animation takes: paths have no time of their own, and deployments are over too soon to be seen."""

FACE_COLOURS: dict[FaceKind, tuple[float, float, float]] = {
    "top": (0.86, 0.83, 0.73),
    "bottom": (0.62, 0.65, 0.71),
    "side": (0.45, 0.46, 0.49),
    "valley": (0.01, 0.11, 0.66),
    "mountain": (0.64, 0.01, 0.03),
}
"""Linear red, green and blue of each kind of face; walls with a hinge have the colours of creases in drawings."""

MAX_KEY_TURN = 0.25 * math.pi
"""The furthest that a hinge turns between two keys, rad."""
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _TRIANGLES = 34962, 34963
_KINDS = tuple(FACE_COLOURS)
_UPWARDS = [-0.5 * 2**0.5, 0.0, 0.0, 0.5 * 2**0.5]
"""A quarter turn about x that takes z to y, as a quaternion x, y, z, w."""


def glb_of(replay: Replay) -> bytes:
    """A replay as an animation."""
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
        origin, above = np.zeros(3), 0
        if parent >= 0:
            origin, above = linkage.points[hinge], node_of[parent]
            before = int(chain.hinges[parent])
            shift = origin - (linkage.points[before] if before >= 0 else np.zeros(3))
            turn = int(chain.signs[panel]) * linkage.directions[hinge]
            turns = _quaternions(turn, replay.angles[:, hinge])
            name = f"hinge {labels.hinges[hinge]}"
            fold = linkage.pattern.hinges[hinge].crease.fold
            facts = {"hinge": labels.hinges[hinge], "axis": _listed(turn), "crease": fold}
            nodes.append(
                {"name": name, "translation": _listed(shift), "rotation": _listed(turns[0]), "children": []}
                | {"extras": facts}
            )
            channels.append({"sampler": len(samplers), "target": {"node": len(nodes) - 1, "path": "rotation"}})
            samplers.append({"input": clock, "output": buffer.add(turns, "VEC4"), "interpolation": "LINEAR"})
            nodes[above]["children"].append(len(nodes) - 1)
            above = len(nodes) - 1
        node_of[panel] = above
        name = f"panel {labels.panels[panel]}"
        nodes.append({"name": name, "mesh": len(meshes), "extras": {"panel": labels.panels[panel]}})
        nodes[above]["children"].append(len(nodes) - 1)
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
    """The binary part, as it grows."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: Reals, kind: str, *, bounds: bool = False, target: int | None = None) -> int:
        """Add rows as single precision, or numbers of vertices, and return the number of their accessor."""
        whole = values.dtype.kind in "iu"
        table = np.ascontiguousarray(values, "<u4" if whole else "<f4")
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": table.nbytes}
        self.views.append(view if target is None else view | {"target": target})
        self.content += table.tobytes()
        accessor = {
            "bufferView": len(self.views) - 1,
            "componentType": _UNSIGNED if whole else _FLOAT,
            "count": len(table),
            "type": kind,
        }
        if bounds:
            accessor |= {"min": _listed(table.min(axis=0)), "max": _listed(table.max(axis=0))}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _primitives(solid: PanelSolid, origin: Reals, buffer: _Buffer) -> list[dict[str, Any]]:
    """A primitive for each kind of face; corners are not shared between faces, so that edges are sharp."""
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
    look = {"baseColorFactor": [*FACE_COLOURS[side], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
    return {"name": side, "pbrMetallicRoughness": look}


def _quaternions(axis: Reals, angles: Reals) -> Reals:
    """Rotations about an axis as unit quaternions x, y, z, w, (k, 4).

    Angles of hinges, 0 to pi, give halves of 0 to pi/2, which slerp connects on the way that the hinge turns. SciPy's
    `Rotation` gives the same, but takes a tenth of a second to import, and nothing else of an export does so.
    """
    halves = 0.5 * angles[:, None]
    return np.hstack([np.sin(halves) * axis, np.cos(halves)])


def _in_short_turns(replay: Replay) -> Replay:
    """Add states to a replay wherever a hinge turns further than `MAX_KEY_TURN`, as fold angles run linearly.

    At half a turn the sense of a rotation would hang on rounding, and viewers that do not follow the sphere lag behind.
    """
    turns = np.abs(np.diff(replay.angles, axis=0)).max(axis=1, initial=0.0)
    parts = np.maximum(np.ceil(turns / MAX_KEY_TURN - 1e-9).astype(int), 1)
    place = np.concatenate([k + np.arange(count) / count for k, count in enumerate(parts)] + [[float(len(parts))]])
    states = np.arange(len(replay.angles))
    angles = np.column_stack([np.interp(place, states, column) for column in replay.angles.T])
    return replace(replay, at=np.interp(place, states, replay.at), angles=angles)


def _rising(times: Reals) -> Reals:
    """Times that rise in single precision, too."""
    single = times.astype(np.float32)
    for k in range(1, len(single)):
        if single[k] <= single[k - 1]:
            single[k] = np.nextafter(single[k - 1], np.float32(np.inf))
    return single.astype(float)


def _name(replay: Replay) -> str:
    return "packed to flat" if replay.ends_flat else "from packed, not as far as flat"


def _collision(replay: Replay) -> dict[str, Any] | None:
    """Where panels collide first, on the axis of the replay, and which."""
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
        # they have no node: both of their panels hang on other ones
        "hinges_that_close_loops": [name for k, name in enumerate(replay.labels.hinges) if k not in in_tree],
    }


def _listed(values: Reals | Sequence[float]) -> list[float]:
    return [float(x) for x in values]


def _container(document: dict[str, Any], content: bytes) -> bytes:
    """Header and two chunks, each filled up to a multiple of four bytes."""
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    content += b"\0" * (-len(content) % 4)
    length = 12 + 8 + len(text) + 8 + len(content)
    head = struct.pack("<4sII", b"glTF", 2, length)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(content), b"BIN\0") + content
