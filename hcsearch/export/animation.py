"""An animated SVG picture: thick panels that move from packed to flat and back, painted from behind, frame by frame.

The frames stand beside each other, and the picture shows one at a time: a CSS animation moves the strip by steps.
Panels are seen from far away, those behind drawn first. A viewer without animations, or a reader who prefers reduced
motion, sees one frame from the middle of the motion.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from html import escape
from itertools import combinations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.cases.replay import Replay, accumulated_turn, stacks_of
from hcsearch.shape.drawing import svg_path

COPLANAR_COSINE = 1e-9
"""Directions are along a face of a solid where their dot product with its unit normal is below this."""


def painters_order(prisms: Sequence[Reals], towards: Reals) -> list[int]:
    """Numbers of prisms, each (2, n_corners, 3), such that none hides one that comes after it.

    towards : unit vector to the viewer, who is far away. Of two prisms that do not overlap, the one on the viewer's
    side of a plane between them is in front. Where some hide each other in a ring, the farthest one is drawn first.
    """
    n = len(prisms)
    points = [prism.reshape(-1, 3) for prism in prisms]
    axes = [_axes(prism) for prism in prisms]
    across = np.linalg.svd(towards[None])[2][1:]  # two directions across the view
    boxes = [(corners @ across.T) for corners in points]
    low, high = np.array([box.min(axis=0) for box in boxes]), np.array([box.max(axis=0) for box in boxes])
    before: list[set[int]] = [set() for _ in range(n)]
    for i, j in combinations(range(n), 2):
        if (low[i] < high[j]).all() and (low[j] < high[i]).all():
            side = _in_front(points[i], points[j], _between(axes[i], axes[j]), towards)
            if side > 0:
                before[i].add(j)
            elif side < 0:
                before[j].add(i)
    depth = [float(corners.mean(axis=0) @ towards) for corners in points]
    return _sorted(before, depth)


def _axes(prism: Reals) -> tuple[Reals, Reals]:
    """Unit normals of a prism's faces, and unit directions of its edges."""
    bottom, top = prism
    up = (top - bottom)[0] / np.linalg.norm((top - bottom)[0])
    edges = np.roll(bottom, -1, axis=0) - bottom
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    return np.vstack([up, np.cross(edges, up)]), np.vstack([up, edges])


def _between(first: tuple[Reals, Reals], second: tuple[Reals, Reals]) -> Reals:
    """Unit normals of the planes of which one separates two prisms, where any does (separating axis theorem)."""
    crossed = np.cross(first[1][:, None], second[1][None]).reshape(-1, 3)
    lengths = np.linalg.norm(crossed, axis=1)
    normals: Reals = np.vstack([first[0], second[0], crossed[lengths > 1e-6] / lengths[lengths > 1e-6][:, None]])
    return normals


def _in_front(one: Reals, other: Reals, normals: Reals, towards: Reals) -> int:
    """1 where the first of two solids may hide the second, -1 where the second may hide the first, else 0."""
    a, b = one @ normals.T, other @ normals.T
    above, below = a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0)
    facing = normals @ towards
    best = int(np.maximum(above, below).argmax())
    if abs(facing[best]) < COPLANAR_COSINE:
        return 0
    return 1 if (facing[best] > 0) == (above[best] > below[best]) else -1


def _sorted(before: list[set[int]], depth: Sequence[float]) -> list[int]:
    """An order in which each comes after those that are before it, the deepest first among those that are free."""
    waiting = [set(own) for own in before]
    ready = [(depth[k], k) for k, own in enumerate(waiting) if not own]
    heapq.heapify(ready)
    left, order = set(range(len(depth))), []
    while left:
        k = heapq.heappop(ready)[1] if ready else min(left, key=lambda k: depth[k])
        if k not in left:
            continue
        left.discard(k)
        order.append(k)
        for other in left:
            if k in waiting[other]:
                waiting[other].discard(k)
                if not waiting[other]:
                    heapq.heappush(ready, (depth[other], other))
    return order


FRAME_COUNT = 48
ANIMATION_SECONDS = 5.0
"""From packed to flat, with the rests at both ends; the way back takes as long."""
REST_SHARE = 0.14
"""Share of the time in which the picture rests, at each end."""
STILL_FRAME_SHARE = 0.55
"""The share of the motion at which a viewer without animations sees the panels."""
FRAME_WIDTH, FRAME_PIXELS = 960, 480
"""Width of a frame in units, and on a screen."""
FRAME_MARGIN = 14
VIEW_TURN, VIEW_ELEVATION = math.radians(14.0), math.radians(42.0)
"""Where the viewer is: a turn from where the stacks are seen side by side, and the height above the flat state."""
SHADE_COUNT = 16
STACK_COLOURS = ((238, 214, 160), (158, 190, 222))
"""Red, green and blue of the two stacks in full light."""
PANEL_COLOUR = (222, 218, 206)
"""Of the panels of linkages without two stacks."""

_LIGHT = np.array([0.25, -0.45, 0.86])
_LINES = {"m": "#d1202f", "v": "#1c5fd4", "f": "#6a4fc0"}
"""Mountain and valley hinges, and those that stay flat, by the first letter of their fold."""


def animation_of(replay: Replay) -> str:
    """A replay as an animated picture, between whose frames hinges turn by equal angles in sum."""
    moving = [_centred(replay.linkage.solids(angles)) for angles in _even_steps(replay)]
    camera = _camera(_across(replay) + VIEW_TURN)
    seen = np.concatenate([solid.reshape(-1, 3) for solids in moving for solid in solids]) @ camera[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = (FRAME_WIDTH - 2 * FRAME_MARGIN) / (high[0] - low[0])
    height = round(scale * (high[1] - low[1])) + 2 * FRAME_MARGIN
    painter = _Painter(replay, camera, scale, FRAME_MARGIN - scale * low[0], FRAME_MARGIN + scale * high[1])
    strip = "".join(
        f'<g transform="translate({k * FRAME_WIDTH})">{painter.frame(solids)}</g>' for k, solids in enumerate(moving)
    )
    still = round(STILL_FRAME_SHARE * (FRAME_COUNT - 1)) * FRAME_WIDTH
    pixels = round(height * FRAME_PIXELS / FRAME_WIDTH)
    size = f'width="{FRAME_PIXELS}" height="{pixels}" viewBox="0 0 {FRAME_WIDTH} {height}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {size}>'
        f"<title>{escape(replay.title)}, {escape(replay.source)}</title><style>{_style()}</style>"
        f'<g class="strip" transform="translate(-{still})">{strip}</g></svg>\n'
    )


def _even_steps(replay: Replay) -> Reals:
    """Fold angles of the frames, (FRAMES, n_hinges): springs are fast first, and long in coming to rest."""
    length = accumulated_turn(replay.angles)
    return replay.at_time(np.interp(np.linspace(0.0, length[-1], FRAME_COUNT), length, replay.at))


def _centred(solids: list[Reals]) -> list[Reals]:
    """Solids with their common middle in the origin, so that the whole stays in the picture."""
    middle = np.mean([solid.mean(axis=(0, 1)) for solid in solids], axis=0)
    return [solid - middle for solid in solids]


def _across(replay: Replay) -> float:
    """Direction from the first stack to the second, rad from the x axis; that axis where there are no two stacks."""
    stacks = stacks_of(replay.linkage)
    if stacks is None:
        return 0.0
    middles = np.array([solid.mean(axis=(0, 1)) for solid in replay.linkage.solids(replay.linkage.folded)])
    second = np.array(stacks, bool)
    x, y, _ = middles[second].mean(axis=0) - middles[~second].mean(axis=0)
    return math.atan2(y, x)


def _camera(across: float) -> Reals:
    """Unit vectors to the right, which lies in the plane of the flat state, upwards, and towards the viewer."""
    right = np.array([math.cos(across), math.sin(across), 0.0])
    away = np.array([-math.sin(across), math.cos(across), 0.0])
    towards = np.array([0.0, 0.0, math.sin(VIEW_ELEVATION)]) - math.cos(VIEW_ELEVATION) * away
    return np.array([right, np.cross(towards, right), towards])


class _Painter:
    """Draws one frame after the other."""

    def __init__(self, replay: Replay, camera: Reals, scale: float, left: float, top: float) -> None:
        self.camera, self.scale, self.left, self.top = camera, scale, left, top
        pattern = replay.linkage.pattern
        stacks = stacks_of(replay.linkage)
        self.colours = ["c" if stacks is None else "ab"[stack] for stack in stacks or [0] * len(pattern.faces)]
        self.hinges: list[list[tuple[int, int, str]]] = [[] for _ in pattern.faces]
        """Of each facet: edges with a hinge, the face that carries it, and the kind of line."""
        for pair, crease in pattern.creases.items():
            if crease.face is not None:
                # each facet has the edge on its left: the second one begins it at its end
                for facet, start in zip(pair, pattern.edges[pair], strict=True):
                    edge = pattern.faces[facet].index(start)
                    self.hinges[facet].append((edge, int(crease.face == "top"), crease.fold[0]))

    def frame(self, solids: list[Reals]) -> str:
        """The panels that face the viewer, those behind first."""
        return "".join(self._facet(k, solids[k]) for k in painters_order(solids, self.camera[2]))

    def _facet(self, number: int, solid: Reals) -> str:
        bottom, top = solid
        n = len(bottom)
        faces = [bottom[::-1], top]
        faces += [np.array([bottom[k], bottom[(k + 1) % n], top[(k + 1) % n], top[k]]) for k in range(n)]
        normals = [np.cross(face[1] - face[0], face[2] - face[1]) for face in faces]
        shown = [float(normal @ self.camera[2]) > 1e-9 * float(np.linalg.norm(normal)) for normal in normals]
        marks = [
            svg_path(f"{self.colours[number]}{_shade(normal)}", [self._seen(face)], closed=True)
            for face, normal, visible in zip(faces, normals, shown, strict=True)
            if visible
        ]
        for edge, side, kind in self.hinges[number]:
            if shown[side] or shown[2 + edge]:
                marks.append(svg_path(kind, [self._seen(solid[side][[edge, (edge + 1) % n]])]))
        return "".join(marks)

    def _seen(self, points: Reals) -> list[tuple[int, int]]:
        across = self.scale * (points @ self.camera[:2].T)
        return [(round(self.left + x), round(self.top - y)) for x, y in across.tolist()]


def _shade(normal: Reals) -> int:
    """How much light a face has, 0 to SHADES - 1."""
    light = float(normal @ _LIGHT) / float(np.linalg.norm(normal) * np.linalg.norm(_LIGHT))
    return round((SHADE_COUNT - 1) * (0.5 + 0.5 * light))


def _style() -> str:
    rules = ["path{stroke:#3b404a;stroke-width:1.5;stroke-linejoin:round}"]
    for name, colour in zip("abc", (*STACK_COLOURS, PANEL_COLOUR), strict=True):
        for shade in range(SHADE_COUNT):
            part = 0.45 + 0.55 * shade / (SHADE_COUNT - 1)
            red, green, blue = (round(part * value) for value in colour)
            rules.append(f".{name}{shade}{{fill:#{red:02x}{green:02x}{blue:02x}}}")
    rules += [f".{kind}{{stroke:{colour};stroke-width:5;stroke-linecap:round}}" for kind, colour in _LINES.items()]
    begin, end = 100 * REST_SHARE, 100 * (1 - REST_SHARE)
    last = f"transform:translate(-{(FRAME_COUNT - 1) * FRAME_WIDTH}px)"
    rules.append(
        f"@keyframes move{{0%{{transform:translate(0)}}"
        f"{begin:g}%{{transform:translate(0);animation-timing-function:steps({FRAME_COUNT - 1})}}"
        f"{end:g}%,to{{{last}}}}}"
    )
    play = f"animation:move {ANIMATION_SECONDS:g}s step-end infinite alternate"
    rules.append(f"@media(prefers-reduced-motion:no-preference){{.strip{{{play}}}}}")
    return "".join(rules)
