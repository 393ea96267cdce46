"""Pictures of flat patterns as small SVG texts: panels, valleys, mountains and slits, with the looks of `drawing`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from hcsearch.drawing import MARGIN, SIDE, by_points, svg, svg_path
from hcsearch.drawing import Point as Pixel
from hcsearch.pattern import Facet, Pattern, Point

PIXELS = 48
"""Screen pixels to the side of a square of a panel's mean area."""

_path = partial(svg_path, write=by_points)


def draw_pattern(pattern: Pattern, title: str = "pattern") -> str:
    """Draw a flat pattern seen from above: hinges on the top face are valleys, on the bottom face mountains.

    Hinges that stay flat in the folded state are drawn as hinges, shared edges without a crease as slits.
    """
    scale = SIDE / pattern.size
    points = [point for facet in pattern.facets for point in facet]
    left, top = min(x for x, _ in points), max(y for _, y in points)

    def pixel(point: Point) -> Pixel:
        return round(scale * (point[0] - left)) + MARGIN, round(scale * (top - point[1])) + MARGIN

    kinds: dict[str, list[Sequence[Pixel]]] = {"hinge": [], "mountain": [], "valley": [], "slit": []}
    for pair, ends in pattern.edges.items():
        crease = pattern.creases.get(pair)
        if crease is not None and crease.face is not None:
            kind: str = "hinge" if crease.fold == "flat" else crease.fold
        elif crease is None and pattern.panel_of[pair[0]] != pattern.panel_of[pair[1]]:
            kind = "slit"
        else:
            continue
        kinds[kind].append([pixel(end) for end in ends])
    outlines = [
        [pixel(point) for point in ring]
        for panel in pattern.panels
        for ring in _rings([pattern.facets[facet] for facet in panel], pattern.size)
    ]
    marks = [_path("panel", outlines, closed=True), *(_path(kind, lines) for kind, lines in kinds.items())]
    pixels = [pixel(point) for point in points]
    width, height = (max(values) + MARGIN for values in zip(*pixels, strict=True))
    return svg(marks, title, (width, height), PIXELS) + "\n"


def _rings(facets: Sequence[Facet], size: float) -> list[list[Point]]:
    """Outlines of a panel: its facets' edges without those that two of them share, chained end to start."""

    def key(point: Point) -> tuple[int, int]:
        return round(point[0] / size * 1e5), round(point[1] / size * 1e5)

    edges: dict[tuple[tuple[int, int], tuple[int, int]], Point] = {}
    for facet in facets:
        for a, b in zip(facet, (*facet[1:], facet[0]), strict=True):
            if edges.pop((key(b), key(a)), None) is None:
                edges[key(a), key(b)] = a
    after: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for a, b in edges:
        after.setdefault(a, []).append(b)
    rings = []
    while edges:
        here, to = next(iter(edges))
        ring = []
        while (here, to) in edges:
            ring.append(edges.pop((here, to)))
            after[here].remove(to)
            here, to = to, next(iter(after[to]), here)
        rings.append(ring)
    return rings
