"""Pictures of flat patterns as small SVG texts: panels, valleys, mountains and slits, with the looks of `drawing`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from hcsearch.drawing import SIDE, STYLES
from hcsearch.pattern import Facet, Pattern, Point

PIXELS = 48
"""Screen pixels to the side of a square of a panel's mean area."""

_MARGIN = 8

Pixel = tuple[int, int]


def draw_pattern(pattern: Pattern, title: str = "pattern") -> str:
    """Draw a flat pattern seen from above: hinges on the top face are valleys, on the bottom face mountains.

    Hinges that stay flat in the folded state are drawn as hinges, shared edges without a crease as slits.
    """
    scale = SIDE / pattern.size
    points = [point for facet in pattern.facets for point in facet]
    left, top = min(x for x, _ in points), max(y for _, y in points)

    def pixel(point: Point) -> Pixel:
        return round(scale * (point[0] - left)) + _MARGIN, round(scale * (top - point[1])) + _MARGIN

    kinds: dict[str, list[Sequence[Pixel]]] = {"hinge": [], "mountain": [], "valley": [], "slit": []}
    for pair, ends in pattern.edges.items():
        crease = pattern.creases.get(pair)
        if crease is not None and crease.face is not None:
            kind = "hinge" if not crease.closes else "valley" if crease.face == "top" else "mountain"
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
    extent = [max(values) + _MARGIN for values in zip(*pixels, strict=True)]
    return _svg("".join(marks), title, extent)


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
    found = []
    while edges:
        here, to = next(iter(edges))
        ring = []
        while (here, to) in edges:
            ring.append(edges.pop((here, to)))
            after[here].remove(to)
            here, to = to, next(iter(after[to]), here)
        found.append(ring)
    return found


def _svg(body: str, title: str, extent: Sequence[int]) -> str:
    for kind, look in STYLES.items():
        attributes = " ".join(f'{name}="{value}"' for name, value in look.items())
        body = body.replace(f'class="{kind}"', f'class="{kind}" {attributes}')
    width, height = (round(length * PIXELS / SIDE) for length in extent)
    head = f'xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" role="img"'
    return f'<svg {head} viewBox="0 0 {extent[0]} {extent[1]}"><title>{escape(title)}</title>{body}</svg>\n'


def _path(kind: str, lines: Iterable[Sequence[Pixel]], closed: bool = False) -> str:
    """One path element with a subpath for each line; empty without lines."""
    end = "z" if closed else ""
    data = "".join("M" + " ".join(f"{x},{y}" for x, y in line) + end for line in lines)
    return f'<path class="{kind}" d="{data}"/>' if data else ""
