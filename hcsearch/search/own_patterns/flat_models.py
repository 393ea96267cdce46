"""A mechanism in its flat state, as a simulator's model holds it, and its panels and hinges as data of a FOLD file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.search.own_patterns.drawn_lines import MAX_DRAWN_PANELS, PointNumbers
from hcsearch.search.own_patterns.model_parts import model_error
from hcsearch.shape.mesh import Facet, PlanePoint, components, facet_area, sides_of

SAME_MODEL_POINT_SHARE = 1e-5
"""Points nearer than this share of the largest panel's size are one: meshes have single precision."""
MAX_MODEL_JOINTS = 3 * MAX_DRAWN_PANELS
"""Greatest number of joints of a model; each is compared with each face."""
_Heights = tuple[float, float]
"""Heights of the bottom and the top face, m."""


@dataclass(frozen=True, eq=False)
class ModelHinge(ByValue):
    """A joint of a model.

    Parameters
    ----------
    name
        The name of the joint.
    first, second
        The names of its links.
    point
        A point of its line in the flat state, (3,), m.
    normal
        The unit vector of the plane across the line, (2,).
    packed_angle
        Its fold angle in the packed state, rad.
    """

    name: str
    first: str
    second: str
    point: Reals
    normal: Reals
    packed_angle: float

    def distance(self, point: Sequence[float]) -> float:
        """Return the distance of a point of the plane from the line, seen from above."""
        return abs(float(self.normal @ (np.array(point) - self.point[:2])))


@dataclass(eq=False)
class FlatModel:
    """The links of a model in the flat state, m.

    Parameters
    ----------
    path
        The file, for messages.
    frames
        The origin of each link.
    faces
        The convex polygons of each link's shape, counterclockwise.
    heights
        The heights of each link's faces.
    hinges
        The joints.
    welds
        Pairs of links that are parts of one panel.
    """

    path: str
    frames: dict[str, Reals] = field(default_factory=dict)
    faces: dict[str, list[Facet]] = field(default_factory=dict)
    heights: dict[str, _Heights] = field(default_factory=dict)
    hinges: list[ModelHinge] = field(default_factory=list)
    welds: list[tuple[str, str]] = field(default_factory=list)

    def wrong(self, what: str) -> InputFileError:
        """Return the error for this model."""
        return model_error(self.path, what)

    def fold_data(self) -> dict[str, Any]:
        """Return the panels as the data of a FOLD file in metres: faces, rigid edges within panels, and hinges.

        InputFileError where panels do not lie in one sheet, or a joint lies on no edge between its links.
        """
        for pair in self.welds:
            for link in pair:
                if link not in self.frames:
                    raise self.wrong(f"a closure joins {link!r:.60}, which is no link")
        parts = components(self.frames, self.welds)
        panel_of = {link: number for number, part in enumerate(parts) for link in part}
        faces = [(panel_of[link], ring) for link, rings in self.faces.items() for ring in rings]
        if not faces:
            raise self.wrong("no link has a mesh")
        if len(faces) > MAX_DRAWN_PANELS:
            raise self.wrong(f"its meshes have {len(faces):,} faces on top, and at most {MAX_DRAWN_PANELS:,} are read")
        if len(self.hinges) > MAX_MODEL_JOINTS:
            raise self.wrong(f"it has {len(self.hinges):,} joints, and at most {MAX_MODEL_JOINTS:,} are read")
        size = math.sqrt(max(facet_area(ring) for _, ring in faces))
        if not size > 0.0:
            raise self.wrong("its meshes have no area")
        return _FlatDrawing(self, panel_of, faces, size).data()

    def sheet(self, tolerance: float) -> _Heights:
        """Return the heights of the sheet's faces; InputFileError where a panel or a hinge lies off them."""
        bottom = min(low for low, _ in self.heights.values())
        top = max(high for _, high in self.heights.values())
        for link, (low, high) in self.heights.items():
            if max(low - bottom, top - high) > tolerance:
                raise self.wrong(f"the mesh of link {link!r:.60} lies at another height than others in the flat state")
        for hinge in self.hinges:
            if min(abs(hinge.point[2] - bottom), abs(hinge.point[2] - top)) > tolerance:
                raise self.wrong(f"joint {hinge.name!r:.60} lies on neither face of the panels in the flat state")
        return bottom, top


class _FlatDrawing:
    """The faces of a model with their corners numbered.

    panel_of : panel of each link. faces : panel and corners of each face. size : the size of the largest face, m.
    """

    def __init__(
        self, model: FlatModel, panel_of: Mapping[str, int], faces: Sequence[tuple[int, Facet]], size: float
    ) -> None:
        self.model, self.panel_of, self.faces = model, panel_of, faces
        self.tolerance = SAME_MODEL_POINT_SHARE * size
        numbers = PointNumbers(self.tolerance)
        self.rings = [[numbers.number(point) for point in ring] for _, ring in faces]
        known: dict[int, PlanePoint] = {}
        for ring, (_, corners) in zip(self.rings, faces, strict=True):
            for number, point in zip(ring, corners, strict=True):
                known.setdefault(number, point)
        self.points = self._on_hinge_lines([known[number] for number in range(len(known))])

    def data(self) -> dict[str, Any]:
        """Return the drawing as the data of a FOLD file."""
        bottom, top = self.model.sheet(self.tolerance)
        beside: dict[tuple[int, int], list[int]] = {}
        for face, ring in enumerate(self.rings):
            for a, b in sides_of(ring):
                beside.setdefault((min(a, b), max(a, b)), []).append(face)
        letters: list[str] = []
        angles: list[float] = []
        hinge_faces: list[str | None] = []
        used: set[int] = set()
        for side, pair in beside.items():
            panels = [self.faces[face][0] for face in pair]
            number = None if len(pair) < 2 else self._hinge_along(panels, [self.points[v] for v in side])
            if number is None:
                letters.append("F" if len(pair) == 2 and panels[0] == panels[1] else "B")
                angles.append(0.0)
                hinge_faces.append(None)
            else:
                used.add(number)
                hinge = self.model.hinges[number]
                on_top = hinge.point[2] > 0.5 * (bottom + top)
                letters.append(("V" if on_top else "M") if hinge.packed_angle else "F")
                angles.append(math.degrees(hinge.packed_angle) * (1.0 if on_top else -1.0))
                hinge_faces.append("top" if on_top else "bottom")
        for number, hinge in enumerate(self.model.hinges):
            if number not in used:
                raise self.model.wrong(
                    f"joint {hinge.name!r:.60} lies on no edge that links {hinge.first!r:.60} and {hinge.second!r:.60} "
                    "share in the flat state"
                )
            if not 0.0 <= hinge.packed_angle <= math.pi:
                raise self.model.wrong(f"joint {hinge.name!r:.60} has a packed angle that is not from 0 to pi")
        return {
            "frame_unit": "m",
            "vertices_coords": [list(point) for point in self.points],
            "faces_vertices": self.rings,
            "edges_vertices": [list(side) for side in beside],
            "edges_assignment": letters,
            "edges_foldAngle": angles,
            "edges_hcsearch:hingeFace": hinge_faces,
            "hcsearch:thickness": top - bottom,
        }

    def _hinge_along(self, panels: Sequence[int], side: Sequence[PlanePoint]) -> int | None:
        """Return the number of the hinge between two panels on the line of a side; None without one."""
        for number, hinge in enumerate(self.model.hinges):
            joins = {self.panel_of[hinge.first], self.panel_of[hinge.second]} == set(panels)
            if joins and max(map(hinge.distance, side)) < self.tolerance:
                return number
        return None

    def _on_hinge_lines(self, points: Sequence[PlanePoint]) -> list[PlanePoint]:
        """Return points moved onto the lines of their panels' hinges: joints have double precision, meshes may not."""
        lines: list[list[ModelHinge]] = [[] for _ in points]
        for (panel, _), ring in zip(self.faces, self.rings, strict=True):
            for hinge in self.model.hinges:
                if panel in (self.panel_of[hinge.first], self.panel_of[hinge.second]):
                    for number in ring:
                        if hinge.distance(points[number]) < self.tolerance:
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
