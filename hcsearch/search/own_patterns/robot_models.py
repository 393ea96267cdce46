"""Reading of mechanisms that `hcsearch export` wrote for simulators: URDF with its file of closures, and MJCF.

A loop is cut through a panel there, whose parts are welded to each other. All frames have the axes of the flat state,
in which models are written, so that places add up along the tree. The result is a drawing, as of a FOLD file.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.motion.collision.panel_prisms import inset_facet
from hcsearch.search.own_patterns.flat_models import FlatModel, ModelHinge
from hcsearch.search.own_patterns.fold_reading import PatternDrawing, parse_fold
from hcsearch.search.own_patterns.fold_values import MAX_COORDINATE
from hcsearch.search.own_patterns.model_parts import (
    MAX_MODEL_BYTES,
    ModelClosures,
    ModelPart,
    model_error,
    read_closures,
    read_model_file,
    unused_loads,
)
from hcsearch.shape.mesh import Facet, facet_area, sides_of
from hcsearch.system.reading import read_binary_file

MIN_CORNER_TURN = 1e-6
"""Sine of the angle by which the sides of a convex polygon may turn the wrong way."""
_ROTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
"""Attributes by which MJCF turns the frame of a body."""


def read_model(path: str) -> PatternDrawing:
    """Read a model that `hcsearch export` wrote, `.urdf`, `.xml` or `.mjcf`, as a drawing in metres.

    InputFileError for other files, and where the closures or a mesh of a URDF file are missing.
    """
    root = read_model_file(path)
    if root.element.tag not in ("robot", "mujoco"):
        raise model_error(path, f"its outermost element is {root.element.tag:.60}, neither robot nor mujoco")
    closures = read_closures(path) if root.element.tag == "robot" else None
    model = _read_mjcf(root) if closures is None else _read_urdf(root, closures)
    drawing = parse_fold(json.dumps(model.fold_data()), path)
    return replace(drawing, remarks=(*drawing.remarks, *unused_loads(root, closures)))


def _read_urdf(root: ModelPart, closures: ModelClosures) -> FlatModel:
    """Read the tree of a URDF file, its meshes, and the loops from its closures."""
    model = FlatModel(root.path, frames={closures.base: np.zeros(3)}, welds=closures.welds)
    for joint in root.parts("joint"):
        _add_joint(model, joint, closures)
    left = MAX_MODEL_BYTES
    for link in root.parts("link"):
        name = link.text("name")
        if name not in model.frames:
            raise link.wrong("is neither the base nor the child of a joint")
        for visual in list(link.parts("visual"))[:1]:
            mesh = visual.part("geometry/mesh")
            if "scale" in mesh.element.attrib:
                raise link.wrong("has a mesh with a scale")
            # meshes lie beside the model, whichever folder it names
            file = Path(root.path).parent / Path(mesh.text("filename")).name
            corners = read_stl(file, left)
            left -= file.stat().st_size
            _add_triangles(model, link, corners + model.frames[name] + _origin(visual))
    return model


def _add_joint(model: FlatModel, joint: ModelPart, closures: ModelClosures) -> None:
    """Add the child of a joint, and its hinge."""
    name, kind = joint.text("name"), joint.text("type")
    if kind != "revolute":
        raise joint.wrong(f"is {kind:.60}, where hinges are revolute")
    parent, child = joint.part("parent").text("link"), joint.part("child").text("link")
    if parent not in model.frames:
        raise joint.wrong(f"hangs on {parent!r:.60}, which is neither the base nor the child of a joint before it")
    if child in model.frames:
        raise joint.wrong(f"leads to {child!r:.60}, to which another joint leads, or which is the base")
    if name not in closures.packed_angles:
        raise joint.wrong("has no packed state in the file of closures")
    model.frames[child] = model.frames[parent] + _origin(joint)
    across = _across(joint.part("axis"), "xyz")
    model.hinges.append(ModelHinge(name, parent, child, model.frames[child], across, closures.packed_angles[name]))


def _origin(part: ModelPart) -> Reals:
    """Return the origin of a part; its axes must be the axes of the flat state."""
    origin = part.part("origin")
    if "rpy" in origin.element.attrib and origin.vector("rpy").any():
        raise part.wrong("has a rotated origin (rpy)")
    return origin.vector("xyz")


def _add_triangles(model: FlatModel, link: ModelPart, corners: Reals) -> None:
    """Add the top faces of a link's triangles, and the heights of both faces."""
    name = link.text("name")
    low, high = float(corners[..., 2].min()), float(corners[..., 2].max())
    model.heights[name] = (low, high)
    faces = model.faces.setdefault(name, [])
    for triangle in corners[(corners[..., 2] > 0.5 * (low + high)).all(axis=1)]:
        ring = tuple((float(x), float(y)) for x, y, _ in triangle)
        faces.append(ring if facet_area(ring) > 0.0 else ring[::-1])
    if not faces:
        raise link.wrong("has a mesh without triangles on top")


def _read_mjcf(root: ModelPart) -> FlatModel:
    """Read the bodies of a model of MuJoCo, whose meshes are facets, shrunk by the margin of the scene."""
    model = FlatModel(root.path)
    meshes = {mesh.text("name"): _prism(mesh) for mesh in root.parts("asset/mesh")}
    base = root.part("worldbody/body")
    floats = next(base.parts("freejoint"), None) is not None
    packed = root.part("keyframe/key[@name='packed']")
    angles = packed.numbers("qpos")[7 if floats else 0 :].tolist()
    bodies = list(_bodies(base))
    if len(angles) != len(bodies) - 1:
        raise packed.wrong(f"has {len(angles)} fold angles for {len(bodies) - 1} hinges")
    placed = [(body, _placed_prisms(body, frame, meshes)) for body, _, frame in bodies]
    shapes = [corners for _, prisms in placed for corners in prisms]
    if not shapes:
        raise root.wrong("has no body with a mesh")
    margin = min(float(corners[0, :, 2].min()) for corners in shapes)
    for (body, parent, frame), packed_angle in zip(bodies, [0.0, *angles], strict=True):
        name = body.text("name")
        if name in model.frames:
            raise body.wrong("is there twice")
        model.frames[name] = frame
        if parent is not None:
            joint = body.part("joint")
            if joint.element.get("type", "hinge") != "hinge":
                raise joint.wrong("is no hinge")
            across = _across(joint, "axis")
            model.hinges.append(ModelHinge(joint.text("name"), parent, name, frame, across, packed_angle))
    for body, prisms in placed:
        for corners in prisms:
            _add_prism(model, body, corners, margin)
    model.welds = [(weld.text("body1"), weld.text("body2")) for weld in root.parts("equality/weld")]
    return model


def _bodies(base: ModelPart) -> Iterator[tuple[ModelPart, str | None, Reals]]:
    """Yield each body, its parent's name and the origin of its frame, depth-first, as MuJoCo numbers joints."""
    waiting: list[tuple[ModelPart, str | None, Reals]] = [(base, None, np.zeros(3))]
    while waiting:
        body, parent, origin = waiting.pop()
        for attribute in _ROTATIONS:
            if attribute in body.element.attrib:
                raise body.wrong(f"has a rotated frame ({attribute})")
        frame = origin + body.vector("pos")
        yield body, parent, frame
        name = body.text("name")
        waiting += [(child, name, frame) for child in reversed(list(body.parts("body")))]


def _prism(mesh: ModelPart) -> Reals:
    """Return the corners of the bottom and the top face of a mesh, (2, k, 3)."""
    numbers = mesh.numbers("vertex")
    if len(numbers) < 18 or len(numbers) % 6:
        raise mesh.wrong(f"has {len(numbers)} coordinates, which are not those of a prism")
    corners = numbers.reshape(2, -1, 3)
    if not _is_convex(_ring(corners)):
        raise mesh.wrong("has a bottom face that is no convex polygon, counterclockwise")
    return corners


def _is_convex(ring: Facet) -> bool:
    """Whether a polygon is convex and counterclockwise."""
    sides = [(b[0] - a[0], b[1] - a[1]) for a, b in sides_of(ring)]
    if not facet_area(ring) > 0.0 or not all(math.hypot(*side) > 0.0 for side in sides):
        return False
    return all(
        x * to_y - y * to_x >= -MIN_CORNER_TURN * math.hypot(x, y) * math.hypot(to_x, to_y)
        and x * to_x + y * to_y > -(1.0 - MIN_CORNER_TURN) * math.hypot(x, y) * math.hypot(to_x, to_y)
        for (x, y), (to_x, to_y) in sides_of(sides)
    )


def _placed_prisms(body: ModelPart, frame: Reals, meshes: Mapping[str, Reals]) -> list[Reals]:
    """Return the corners of a body's meshes where they lie in the flat state."""
    placed = []
    for geom in body.parts("geom"):
        if {"pos", *_ROTATIONS} & set(geom.element.attrib):
            raise body.wrong("has a mesh with a place of its own")
        name = geom.text("mesh")
        if name not in meshes:
            raise body.wrong(f"has the mesh {name!r:.60}, which the model lacks")
        placed.append(meshes[name] + frame)
    return placed


def _add_prism(model: FlatModel, body: ModelPart, corners: Reals, margin: float) -> None:
    """Add a facet of a body, expanded by the margin (m)."""
    name = body.text("name")
    model.faces.setdefault(name, []).append(inset_facet(_ring(corners), -margin))
    low, high = float(corners[0, 0, 2]) - margin, float(corners[1, 0, 2]) + margin
    known_low, known_high = model.heights.get(name, (low, high))
    model.heights[name] = (min(low, known_low), max(high, known_high))


def _ring(corners: Reals) -> Facet:
    """Return the corners of the bottom face of a prism, seen from above."""
    return tuple((float(x), float(y)) for x, y, _ in corners[0])


def _across(part: ModelPart, attribute: str) -> Reals:
    """Return the unit vector of the plane across the axis of a joint, which lies in the plane."""
    x, y, z = part.vector(attribute).tolist()
    length = math.hypot(x, y)
    if not length > 0.0 or abs(z) > MIN_CORNER_TURN * length:
        raise part.wrong(f"has a direction in {attribute} that is not in the plane of the panels")
    return np.array([-y / length, x / length])


_HEAD_BYTES = 84
"""The title and the number of triangles of a binary file."""
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A triangle of a binary file."""
_FACET = re.compile(
    rb"facet\s+normal(?:\s+\S+){3}\s+outer\s+loop((?:\s+vertex(?:\s+\S+){3}){3})\s+endloop\s+endfacet\s*"
)
_CORNERS = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl(path: Path, max_bytes: int) -> Reals:
    """Return the corners of the triangles of an STL file, (k, 3, 3), in its unit.

    InputFileError as in `read_binary_file`, for a file without triangles, a file that is cut off, and coordinates that
    are not below `MAX_COORDINATE`.
    """
    content = read_binary_file(path, "the mesh", max_bytes)
    count = int.from_bytes(content[_HEAD_BYTES - 4 : _HEAD_BYTES], "little")
    whole = _HEAD_BYTES + count * _RECORD.itemsize
    # the titles of some binary files begin like text
    if len(content) != whole and content.lstrip().startswith(b"solid"):
        corners = _text_corners(content, path)
    elif len(content) < _HEAD_BYTES or len(content) != whole:
        raise _no_mesh(path, f"it has {len(content):,} bytes where its head promises {whole:,}")
    else:
        corners = np.frombuffer(content[_HEAD_BYTES:], _RECORD)["corners"].astype(float)
    if not len(corners):
        raise _no_mesh(path, "it has no triangle")
    if not (np.abs(corners) < MAX_COORDINATE).all():  # never of NaN
        raise _no_mesh(path, f"a corner has a coordinate that is no number below {MAX_COORDINATE:g}")
    return corners


def _text_corners(content: bytes, path: Path) -> Reals:
    """Return the corners of a text file."""
    body = content.partition(b"facet")
    facets, place = [], 0
    text = body[1] + body[2]
    while match := _FACET.match(text, place):
        facets.append(match[1])
        place = match.end()
    if not text[place:].startswith(b"endsolid"):
        raise _no_mesh(path, f"its text breaks off after {len(facets):,} triangles")
    try:
        numbers = [[float(number) for number in corner] for facet in facets for corner in _CORNERS.findall(facet)]
    except ValueError:
        raise _no_mesh(path, "a corner has a coordinate that is no number") from None
    return np.array(numbers).reshape(-1, 3, 3)


def _no_mesh(path: Path, why: str) -> InputFileError:
    return InputFileError(f"{path} is no sound STL file: {why}; export it anew")
