"""An animated SVG picture of a motion: thick panels moving from packed to flat and back.

The frames lie side by side in a strip, which a CSS animation shifts by one frame at a time. Panels are drawn in
parallel projection by the painter's algorithm, from back to front. Linkages of many panels have fewer frames, so that
files stay small, and faces that others hide are left out. Viewers without animations, and those that ask for
reduced motion, show a single frame from the middle of the motion.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import combinations, compress
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hcsearch.basics.array_values import Reals
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.shape.drawing import svg_path
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.replay import Replay, stacks_of

COPLANAR_COSINE = 1e-9
"""A direction is parallel to a face where the magnitude of its dot product with the unit normal is below this."""
EQUAL_LENGTH_SHARE = 1e-9
"""Lengths that differ by less than this, over the extent of all prisms, are equal: rounding decides no order."""


def painters_order(prisms: Sequence[Reals], towards: Reals) -> list[int]:
    """Return the order in which to draw prisms, each (2, n_corners, 3), from back to front.

    towards : unit vector to the viewer at infinity. Of two disjoint prisms, the one on the viewer's side of a
    separating plane is in front. Cycles of prisms that hide each other are broken at the farthest one.
    """
    n = len(prisms)
    points = [prism.reshape(-1, 3) for prism in prisms]
    axes = [_axes(prism) for prism in prisms]
    equal = EQUAL_LENGTH_SHARE * float(np.ptp(np.vstack(points), axis=0).max())
    side = np.cross(towards, np.eye(3)[np.abs(towards).argmin()])
    across = np.stack([side, np.cross(towards, side)]) / np.linalg.norm(side)
    boxes = [(corners @ across.T) for corners in points]
    low, high = np.array([box.min(axis=0) for box in boxes]), np.array([box.max(axis=0) for box in boxes])
    before: list[set[int]] = [set() for _ in range(n)]
    for i, j in combinations(range(n), 2):
        if (high[j] - low[i] > equal).all() and (high[i] - low[j] > equal).all():
            front = _in_front(points[i], points[j], _between(axes[i], axes[j]), towards, equal)
            if front > 0:
                before[i].add(j)
            elif front < 0:
                before[j].add(i)
    depth = [equal * round(float(corners.mean(axis=0) @ towards) / equal) for corners in points]
    return _sorted(before, depth)


def _axes(prism: Reals) -> tuple[Reals, Reals]:
    """Return the unit normals of a prism's faces and the unit directions of its edges."""
    bottom, top = prism
    up = (top - bottom)[0] / np.linalg.norm((top - bottom)[0])
    edges = np.roll(bottom, -1, axis=0) - bottom
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    return np.vstack([up, np.cross(edges, up)]), np.vstack([up, edges])


def _between(first: tuple[Reals, Reals], second: tuple[Reals, Reals]) -> Reals:
    """Return the unit normals of all candidate separating planes of two prisms (separating axis theorem)."""
    crossed = np.cross(first[1][:, None], second[1][None]).reshape(-1, 3)
    lengths = np.linalg.norm(crossed, axis=1)
    normals: Reals = np.vstack([first[0], second[0], crossed[lengths > 1e-6] / lengths[lengths > 1e-6][:, None]])
    return normals


def _in_front(first: Reals, second: Reals, normals: Reals, towards: Reals, equal: float) -> int:
    """Return 1 where the first of two solids may hide the second, -1 for the reverse, 0 for neither.

    equal : by what gaps along normals that count as equal differ at most; the first normal of these decides.
    """
    a, b = first @ normals.T, second @ normals.T
    above, below = a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0)
    facing = normals @ towards
    gaps = np.maximum(above, below)
    best = int((gaps >= gaps.max() - equal).argmax())
    if abs(facing[best]) < COPLANAR_COSINE:
        return 0
    return 1 if (facing[best] > 0) == (above[best] > below[best]) else -1


def _sorted(before: list[set[int]], depth: Sequence[float]) -> list[int]:
    """Topological order of items after all their predecessors `before`; the deepest available one comes first."""
    waiting = [set(predecessors) for predecessors in before]
    ready = [(depth[k], k) for k, predecessors in enumerate(waiting) if not predecessors]
    heapq.heapify(ready)
    remaining, order = set(range(len(depth))), []
    while remaining:
        k = heapq.heappop(ready)[1] if ready else min(remaining, key=lambda k: depth[k])
        if k not in remaining:
            continue
        remaining.discard(k)
        order.append(k)
        for other in remaining:
            if k in waiting[other]:
                waiting[other].discard(k)
                if not waiting[other]:
                    heapq.heappush(ready, (depth[other], other))
    return order


MIN_FRAME_COUNT, MAX_FRAME_COUNT = 20, 40
DRAWN_PANEL_COUNT = 600
"""About how many panels all frames show together; the least and the greatest number of frames go first."""
ANIMATION_SECONDS = 5.0
"""Duration from packed to flat, rests at both ends included, and of the way back, s."""
REST_SHARE = 0.14
"""Share of the duration for which the picture rests at each end."""
STILL_FRAME_SHARE = 0.55
"""Share of the motion that viewers without animations show."""
FRAME_WIDTH, FRAME_PIXELS = 960, 480
"""Width of a frame in user units and in pixels."""
FRAME_MARGIN = 14
VIEW_TURN, VIEW_ELEVATION = math.radians(14.0), math.radians(42.0)
"""Direction of view, rad: azimuth from where the stacks lie side by side, and elevation above the flat state."""
SHADE_COUNT = 16
STACK_COLOURS = ((238, 214, 160), (158, 190, 222))
"""RGB colours of the two stacks in full light."""
PANEL_COLOUR = (222, 218, 206)
"""RGB colour of panels of linkages without two stacks."""

_LIGHT = np.array([0.25, -0.45, 0.86])
_LINES = {"m": "#d1202f", "v": "#1c5fd4", "f": "#6a4fc0"}
"""Colours of mountain, valley and flat hinges, by the first letter of their fold."""


@dataclass(frozen=True)
class PaintedMark:
    """A polygon or a line of a picture.

    look : a key of `MARK_COLOURS`. points : x to the right and y down, in units of the picture.
    """

    look: str
    points: list[tuple[float, float]]
    is_face: bool


def animation_of(replay: Replay) -> str:
    """Return a replay as an animated SVG; the sum of hinge rotations is the same between all frames."""
    n_frames = frame_count_of(len(replay.linkage.pattern.faces))
    moving = [centred_solids(replay.linkage.solids(angles)) for angles in _even_steps(replay, n_frames)]
    painter = MotionPainter(replay.linkage, moving, FRAME_WIDTH)
    frames = [_seen_marks(painter.marks(solids)) for solids in moving]
    strip = "".join(
        f'<g transform="translate({k * FRAME_WIDTH})">{_frame(marks)}</g>' for k, marks in enumerate(frames)
    )
    looks = {mark.look for marks in frames for mark in marks}
    still = round(STILL_FRAME_SHARE * (n_frames - 1)) * FRAME_WIDTH
    pixels = round(painter.height * FRAME_PIXELS / FRAME_WIDTH)
    size = f'width="{FRAME_PIXELS}" height="{pixels}" viewBox="0 0 {FRAME_WIDTH} {painter.height}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {size}>'
        f"<title>{escape(_description(replay))}</title><style>{_style(n_frames, looks)}</style>"
        f'<g class="strip" transform="translate(-{still})">{strip}</g></svg>\n'
    )


def _description(replay: Replay) -> str:
    """Return what the picture shows: a title, where the motion comes from, and its faults."""
    return f"{replay.title}, {replay.source}" + (f"; {replay.faults}" if replay.faults else "")


class _FrameMark(NamedTuple):
    """A mark of a frame in whole units, otherwise as `PaintedMark`."""

    look: str
    points: list[tuple[int, int]]
    is_face: bool


_FLAT_AREA = 1.0
"""Area below which a polygon is drawn by its outline alone, square units of the picture."""
_SLIVER = 0.05
"""Area that may remain uncovered, square units of the picture: nobody sees it."""


def _seen_marks(marks: Iterable[PaintedMark]) -> list[_FrameMark]:
    """Return the marks of a frame that are seen, from back to front."""
    whole = [_FrameMark(mark.look, [(round(x), round(y)) for x, y in mark.points], mark.is_face) for mark in marks]
    widths = {True: OUTLINE_WIDTH, False: HINGE_WIDTH}
    inks = [ink_of(mark.points, widths[mark.is_face], is_face=mark.is_face) for mark in whole]
    return list(compress(whole, seen(inks)))


def ink_of(points: Sequence[tuple[float, float]], width: float, *, is_face: bool) -> BaseGeometry:
    """Return what a mark covers: a filled polygon with its outline, or a line; width : of the line, with round ends."""
    shape = shapely.Polygon(points) if is_face else shapely.LineString(points)
    if is_face and shape.area < _FLAT_AREA:
        shape = shapely.LineString([*points, points[0]])
    return shape.buffer(0.5 * width, quad_segs=4)


def seen(inks: Sequence[BaseGeometry]) -> list[bool]:
    """Return for each mark, from back to front, whether any part of it is seen."""
    shapes = np.array(inks, dtype=object)
    shapely.prepare(shapes)
    left, top, right, bottom = shapely.bounds(shapes).T
    found = []
    for number, shape in enumerate(shapes):
        meets = (left < right[number]) & (left[number] < right) & (top < bottom[number]) & (top[number] < bottom)
        meets[: number + 1] = False
        found.append(_is_seen(shape, shapes[meets]))
    return found


def _is_seen(shape: BaseGeometry, above: np.ndarray) -> bool:
    # most marks that are seen show a corner, which is quick to find
    corners = shapely.get_coordinates(shape)
    if not shapely.intersects_xy(above[:, None], corners[:, 0], corners[:, 1]).any(axis=0).all():
        return True
    for other in above:
        shape = shape.difference(other)
        if shape.area < _SLIVER:
            return False
    return True


def _frame(marks: Iterable[_FrameMark]) -> str:
    return "".join(svg_path(mark.look, [mark.points], closed=mark.is_face) for mark in marks)


def frame_count_of(n_panels: int) -> int:
    """Return the number of frames of the picture of a linkage of some panels."""
    return min(MAX_FRAME_COUNT, max(MIN_FRAME_COUNT, DRAWN_PANEL_COUNT // n_panels))


def _even_steps(replay: Replay, n_frames: int) -> Reals:
    """Fold angles of the frames, (n_frames, n_hinges), at equal steps of accumulated rotation instead of time."""
    length = accumulated_turn(replay.angles)
    return replay.at_time(np.interp(np.linspace(0.0, length[-1], n_frames), length, replay.at))


def centred_solids(solids: list[Reals]) -> list[Reals]:
    """Translate solids so that the mean of their centres is the origin, which keeps them in the picture."""
    middle = np.mean([solid.mean(axis=(0, 1)) for solid in solids], axis=0)
    return [solid - middle for solid in solids]


def _across(linkage: Linkage) -> float:
    """Direction from the first stack to the second, rad from the x axis; 0 where there are no two stacks."""
    stacks = stacks_of(linkage)
    if stacks is None:
        return 0.0
    middles = np.array([solid.mean(axis=(0, 1)) for solid in linkage.solids(linkage.folded)])
    second = np.array(stacks, bool)
    x, y, _ = middles[second].mean(axis=0) - middles[~second].mean(axis=0)
    return math.atan2(y, x)


def _camera(across: float) -> Reals:
    """Unit vectors of the view: right (in the plane of the flat state), up, and towards the viewer."""
    right = np.array([math.cos(across), math.sin(across), 0.0])
    away = np.array([-math.sin(across), math.cos(across), 0.0])
    towards = np.array([0.0, 0.0, math.sin(VIEW_ELEVATION)]) - math.cos(VIEW_ELEVATION) * away
    return np.array([right, np.cross(towards, right), towards])


class MotionPainter:
    """Draws states of a linkage from one viewpoint and in one scale.

    camera : unit vectors to the right, up and towards the viewer, (3, 3). height : of the picture, in its units.
    """

    def __init__(
        self, linkage: Linkage, states: Sequence[list[Reals]], width: int, max_height: int | None = None
    ) -> None:
        """Fit the solids of some states into a picture of a width and, if given, a greatest height."""
        self.camera = _camera(_across(linkage) + VIEW_TURN)
        points = np.concatenate([solid.reshape(-1, 3) for solids in states for solid in solids])
        projected = points @ self.camera[:2].T
        low, high = projected.min(axis=0), projected.max(axis=0)
        scale = (width - 2 * FRAME_MARGIN) / (high[0] - low[0])
        if max_height is not None:
            scale = min(scale, (max_height - 2 * FRAME_MARGIN) / (high[1] - low[1]))
        self._scale = scale
        self._left = 0.5 * (width - scale * (low[0] + high[0]))
        self._top = FRAME_MARGIN + scale * high[1]
        self.height = round(scale * (high[1] - low[1])) + 2 * FRAME_MARGIN
        pattern = linkage.pattern
        stacks = stacks_of(linkage)
        self._colours = ["c" if stacks is None else "ab"[stack] for stack in stacks or [0] * len(pattern.faces)]
        self._hinges: list[list[tuple[int, int, str]]] = [[] for _ in pattern.faces]
        """For each facet, its edges with a hinge: edge, face that carries the hinge (1 top, 0 bottom), kind of line."""
        for pair, crease in pattern.creases.items():
            if crease.face is not None:
                # each facet has the edge on its left: the second one begins it at its end
                for facet, start in zip(pair, pattern.edges[pair], strict=True):
                    edge = pattern.faces[facet].index(start)
                    self._hinges[facet].append((edge, int(crease.face == "top"), crease.fold[0]))

    def marks(self, solids: list[Reals]) -> Iterator[PaintedMark]:
        """Yield the visible faces and hinges of a state, from back to front."""
        for number in painters_order(solids, self.camera[2]):
            yield from self._facet(number, solids[number])

    def _facet(self, number: int, solid: Reals) -> Iterator[PaintedMark]:
        bottom, top = solid
        n = len(bottom)
        faces = [bottom[::-1], top]
        faces += [np.array([bottom[k], bottom[(k + 1) % n], top[(k + 1) % n], top[k]]) for k in range(n)]
        normals = [np.cross(face[1] - face[0], face[2] - face[1]) for face in faces]
        shown = [float(normal @ self.camera[2]) > 1e-9 * float(np.linalg.norm(normal)) for normal in normals]
        for face, normal, visible in zip(faces, normals, shown, strict=True):
            if visible:
                yield PaintedMark(f"{self._colours[number]}{_shade(normal)}", self.projected(face), is_face=True)
        for edge, side, kind in self._hinges[number]:
            if shown[side] or shown[2 + edge]:
                yield PaintedMark(kind, self.projected(solid[side][[edge, (edge + 1) % n]]), is_face=False)

    def projected(self, points: Reals) -> list[tuple[float, float]]:
        """Return points (n, 3) in the picture: x to the right and y down."""
        across = self._scale * (points @ self.camera[:2].T)
        return [(self._left + x, self._top - y) for x, y in across.tolist()]


def _shade(normal: Reals) -> int:
    """Brightness level of a face, 0 to SHADES - 1, from its normal."""
    light = float(normal @ _LIGHT) / float(np.linalg.norm(normal) * np.linalg.norm(_LIGHT))
    return round((SHADE_COUNT - 1) * (0.5 + 0.5 * light))


def _mark_colours() -> dict[str, tuple[int, int, int]]:
    colours = {kind: _rgb(colour) for kind, colour in _LINES.items()}
    for name, light in zip("abc", (*STACK_COLOURS, PANEL_COLOUR), strict=True):
        for shade in range(SHADE_COUNT):
            part = 0.45 + 0.55 * shade / (SHADE_COUNT - 1)
            red, green, blue = (round(part * value) for value in light)
            colours[f"{name}{shade}"] = (red, green, blue)
    return colours


def _rgb(colour: str) -> tuple[int, int, int]:
    """Return the colour of a text `#rrggbb`."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


MARK_COLOURS = _mark_colours()
"""RGB colours: of faces by the letter of their panel and a brightness level, of lines by the letter of their fold."""
OUTLINE_COLOUR = _rgb("#3b404a")
OUTLINE_WIDTH, HINGE_WIDTH = 1.5, 5.0
"""Widths of lines in a picture of `FRAME_WIDTH` units."""


def _style(n_frames: int, looks: Collection[str]) -> str:
    """Return the style sheet of a number of frames with some looks, which are keys of `MARK_COLOURS`."""
    hexes = {look: "#{:02x}{:02x}{:02x}".format(*colour) for look, colour in MARK_COLOURS.items() if look in looks}
    outline = "#{:02x}{:02x}{:02x}".format(*OUTLINE_COLOUR)
    rules = [f"path{{stroke:{outline};stroke-width:{OUTLINE_WIDTH:g};stroke-linejoin:round}}"]
    rules += [f".{look}{{fill:{colour}}}" for look, colour in hexes.items() if look not in _LINES]
    rules += [
        f".{kind}{{stroke:{colour};stroke-width:{HINGE_WIDTH:g};stroke-linecap:round}}"
        for kind, colour in _LINES.items()
        if kind in looks
    ]
    begin, end = 100 * REST_SHARE, 100 * (1 - REST_SHARE)
    last = f"transform:translate(-{(n_frames - 1) * FRAME_WIDTH}px)"
    rules.append(
        f"@keyframes move{{0%{{transform:translate(0)}}"
        f"{begin:g}%{{transform:translate(0);animation-timing-function:steps({n_frames - 1})}}"
        f"{end:g}%,to{{{last}}}}}"
    )
    play = f"animation:move {ANIMATION_SECONDS:g}s step-end infinite alternate"
    rules.append(f"@media(prefers-reduced-motion:no-preference){{.strip{{{play}}}}}")
    return "".join(rules)
