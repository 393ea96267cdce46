"""Pictures of flat patterns as small SVG texts: panels, valleys, mountains and slits, in the style of `drawing`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from hcsearch.shape.drawing import (
    DRAWING_MARGIN,
    DRAWING_SIDE_UNITS,
    DrawingPoint,
    by_points,
    part_shapes,
    svg,
    svg_path,
)
from hcsearch.shape.mesh import PlanePoint
from hcsearch.shape.pattern import Pattern

PATTERN_SIDE_PIXELS = 48
"""Screen pixels to the side of a square of a panel's mean area."""

_path = partial(svg_path, write=by_points)


def draw_pattern(pattern: Pattern, title: str = "pattern", *, standalone: bool = True) -> str:
    """Draw a flat pattern seen from above: hinges on the top face are valleys, on the bottom face mountains.

    Hinges that stay flat in the folded state are drawn as hinges, shared edges without a crease as slits.
    standalone : with the style of each line and a size in pixels; else the page styles the classes, and there is a
    shape over each panel and hinge (`part_shapes`).
    """
    scale = DRAWING_SIDE_UNITS / pattern.size
    left, top = min(x for x, _ in pattern.vertices), max(y for _, y in pattern.vertices)

    def pixel(point: PlanePoint) -> DrawingPoint:
        return round(scale * (point[0] - left)) + DRAWING_MARGIN, round(scale * (top - point[1])) + DRAWING_MARGIN

    pixels = [pixel(point) for point in pattern.vertices]
    kinds: dict[str, list[Sequence[DrawingPoint]]] = {"hinge": [], "mountain": [], "valley": [], "slit": []}
    for pair, ends in pattern.edges.items():
        crease = pattern.creases.get(pair)
        if crease is not None and crease.face is not None:
            kind: str = "hinge" if crease.fold == "flat" else crease.fold
        elif crease is None and pattern.panel_of[pair[0]] != pattern.panel_of[pair[1]]:
            kind = "slit"
        else:
            continue
        kinds[kind].append([pixels[end] for end in ends])
    outlines = [[[pixels[v] for v in walk] for walk in outline] for outline in pattern.outlines]
    marks = [
        _path("panel", [walk for outline in outlines for walk in outline], closed=True),
        *(_path(kind, lines) for kind, lines in kinds.items()),
    ]
    if not standalone:
        hinges = [[[pixel(hinge.start), pixel(hinge.end)]] for hinge in pattern.hinges]
        marks.append(part_shapes(outlines, hinges))
    width, height = (max(values) + DRAWING_MARGIN for values in zip(*pixels, strict=True))
    return svg(marks, title, (width, height), PATTERN_SIDE_PIXELS if standalone else None) + "\n"
