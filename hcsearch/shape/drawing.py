"""Pictures of arrays, circuits and foldings as small inline SVG texts.

Functions take plain data: cells, their tiling, and the fold of each crease. The module imports nothing of the package,
so that values of all higher layers can draw themselves. All coordinates are integers, `DRAWING_SIDE_UNITS` to the
shortest side of a panel, y downwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from itertools import pairwise
from typing import Protocol

DRAWING_SIDE_UNITS = 100
"""Units to the shortest side of a panel: rounding to integers is then half a percent of it."""

DRAWING_SIDE_PIXELS = {3: 64, 4: 48, 6: 40}
"""Screen pixels to the shortest side of a panel in a standalone picture, by its number of sides: about equal areas."""

LINE_PIXELS = 0.48
"""Screen pixels to a unit in widths and dashes of lines in a standalone picture, the same for all shapes of panels."""

DRAWING_STYLES: dict[str, dict[str, str]] = {
    "panel": {"fill": "#f7f5ef", "stroke": "#989da8", "stroke-width": "2", "stroke-linejoin": "round"},
    "outer": {"fill": "#cfd3da", "stroke": "#989da8", "stroke-width": "2", "stroke-linejoin": "round"},
    "circuit": {"fill": "none", "stroke": "#2f8f6b", "stroke-width": "4", "stroke-linejoin": "round"},
    "start": {"fill": "#2f8f6b"},
    "flat": {"stroke": "#6b707b", "stroke-width": "4"},
    "hinge": {"stroke": "#6a4fc0", "stroke-width": "8", "stroke-dasharray": "5 10"},
    "mountain": {"stroke": "#d1202f", "stroke-width": "8", "stroke-dasharray": "25 8 6 8"},
    "valley": {"stroke": "#1c5fd4", "stroke-width": "8", "stroke-dasharray": "14 9"},
    "slit": {"stroke": "#20242e", "stroke-width": "10", "stroke-linecap": "round"},
    "numbers": {
        "fill": "#20242e",
        "font-family": "sans-serif",
        "font-size": "22",
        "text-anchor": "middle",
        "stroke": "#f7f5ef",
        "stroke-width": "6",
        "paint-order": "stroke",
    },
}
"""Style of each class of lines, in drawing order. Mountains and valleys differ in colour and in dashes."""

# A corner-to-corner line of a rim panel is half as wide as its stroke, and slits have round ends.
DRAWING_MARGIN = 8
"""Units between the outermost panels and the rim of a picture."""

DrawnCell = tuple[int, ...]
DrawingPoint = tuple[int, int]
Segment = tuple[DrawingPoint, DrawingPoint]


class DrawnGrid(Protocol):
    """The interface of a grid for pictures; `hcsearch.designs.grid.Grid` implements it."""

    @property
    def name(self) -> str:
        """Name of the grid."""

    @property
    def stretched(self) -> bool:
        """Whether panels have a length and another width."""

    @property
    def is_rectangular(self) -> bool:
        """Whether panels are squares or rectangles, whose lengths and widths are free."""

    def point(self, cell: DrawnCell) -> DrawingPoint:
        """Lattice point of a cell."""

    def neighbours(self, point: DrawingPoint) -> Iterator[tuple[int, DrawingPoint]]:
        """Directions and lattice points of the neighbours of a cell."""

    def position(self, point: tuple[float, float]) -> tuple[float, float]:
        """Cartesian coordinates of a lattice point."""

    def corners(self, cell: DrawnCell) -> list[tuple[float, float]]:
        """Cartesian corners of a panel; corner i begins the edge facing the ith neighbour."""


def draw_array(
    tiling: DrawnGrid,
    cells: Sequence[DrawnCell],
    *,
    size: tuple[float, float] | None = None,
    title: str = "",
    standalone: bool = True,
) -> str:
    """Draw the panels of an array.

    size : length and width of squares and rectangles; only their ratio matters. Default: 1, rectangles 50 x 40.
    standalone : with the style of each line and a size in pixels; else the page styles the classes (`stylesheet`).
    """
    sheet = _Sheet(tiling, cells, size)
    return sheet.svg([svg_path("panel", sheet.panels, closed=True)], title or f"{tiling.name} array", standalone)


def draw_graph(tiling: DrawnGrid, cells: Sequence[DrawnCell], *, title: str = "") -> str:
    """Draw the panels of an array, and over them the graph of its cells, as a standalone picture."""
    sheet = _Sheet(tiling, cells, None)
    lines = [(sheet.centres[i], sheet.centres[j]) for i, j in sheet.edges]
    marks = [svg_path("panel", sheet.panels, closed=True), svg_path("circuit", lines)]
    return sheet.svg(marks, title or f"{tiling.name} tiling and its graph of cells", True)


def draw_circuit(
    tiling: DrawnGrid,
    cells: Sequence[DrawnCell],
    assignment: Sequence[str] | None = None,
    *,
    numbers: bool = False,
    size: tuple[float, float] | None = None,
    title: str = "",
    standalone: bool = True,
    parts: bool = False,
) -> str:
    """Draw a circuit through its panels, with hinges where it crosses an edge and slits where it does not.

    cells : in circuit order; crease k joins panels k and k + 1.
    assignment : shape (n,), `mountain`, `valley` or `flat` for each crease; the panels at flat creases, which are the
        outer layers of a folding, are shaded. None: hinges of no known fold.
    numbers : write the numbers of the creases, and mark panel 0.
    size, standalone : as in `draw_array`. parts : with the shapes of `part_shapes`.
    """
    sheet = _Sheet(tiling, cells, size)
    n = len(cells)
    folds = list(assignment) if assignment is not None else ["hinge"] * n
    creases = [sheet.edges.pop((min(k, (k + 1) % n), max(k, (k + 1) % n))) for k in range(n)]
    outer = {panel for k, fold in enumerate(folds) if fold == "flat" for panel in (k, (k + 1) % n)}
    marks = [
        svg_path("panel", [p for k, p in enumerate(sheet.panels) if k not in outer], closed=True),
        svg_path("outer", [p for k, p in enumerate(sheet.panels) if k in outer], closed=True),
        svg_path("circuit", [sheet.centres], closed=True),
    ]
    for kind in ("flat", "hinge", "mountain", "valley"):
        marks.append(svg_path(kind, [crease for crease, fold in zip(creases, folds, strict=True) if fold == kind]))
    marks.append(svg_path("slit", sheet.edges.values()))
    if numbers:
        marks += [_start(sheet.centres[0]), _numbers(creases)]
    if parts:
        marks.append(part_shapes([[panel] for panel in sheet.panels], [[crease] for crease in creases]))
    return sheet.svg(marks, title or f"{tiling.name} circuit", standalone)


def part_shapes(
    panels: Sequence[Sequence[Sequence[DrawingPoint]]], hinges: Sequence[Sequence[Sequence[DrawingPoint]]]
) -> str:
    """Write a shape over each panel and each hinge, by which the script of a page finds and marks them.

    panels, hinges : the lines of each, by number. The page must make the shapes of class `part` transparent.
    """
    return "".join(
        f'<path class="part" data-{kind}="{number}" d="{"".join(f"M{_by_steps(line)}{end}" for line in lines)}"/>'
        for kind, end, shapes in (("panel", "z", panels), ("hinge", "", hinges))
        for number, lines in enumerate(shapes)
    )


def stylesheet(scope: str = "svg") -> str:
    """Return CSS rules that style embedded pictures like standalone ones."""
    return "\n".join(
        f"{scope} .{kind} {{ {'; '.join(f'{name}: {value}' for name, value in look.items())} }}"
        for kind, look in DRAWING_STYLES.items()
    )


def drawn_size(tiling: DrawnGrid, size: tuple[float, float] | None = None) -> tuple[float, float]:
    """Return the length and width by which coordinates are stretched in a picture: 1 where panels have one shape."""
    if not tiling.is_rectangular:
        return (1, 1)
    return size or ((50, 40) if tiling.stretched else (1, 1))


def shortest_side(corners: Sequence[tuple[float, float]]) -> float:
    """Return the length of a polygon's shortest side."""
    return min(map(math.dist, corners, [*corners[1:], corners[0]]))


class _Sheet:
    """Panels in integer coordinates, and the edges between neighbouring ones.

    edges : for panels (i, j), i < j, that share an edge, its two ends.
    """

    def __init__(self, tiling: DrawnGrid, cells: Sequence[DrawnCell], size: tuple[float, float] | None) -> None:
        length, width = drawn_size(tiling, size)
        scale = DRAWING_SIDE_UNITS / (min(length, width) * shortest_side(tiling.corners(cells[0])))
        corners = [[(scale * length * x, -scale * width * y) for x, y in tiling.corners(cell)] for cell in cells]
        left = min(x for panel in corners for x, _ in panel) - DRAWING_MARGIN
        top = min(y for panel in corners for _, y in panel) - DRAWING_MARGIN

        def pixel(x: float, y: float) -> DrawingPoint:
            # halves that are not exact are rounded as the script of pages does, which sums in another order
            return round(round(x - left, 6)), round(round(y - top, 6))

        self.pixels = 44 if tiling.stretched else DRAWING_SIDE_PIXELS[len(corners[0])]
        self.panels = [[pixel(x, y) for x, y in panel] for panel in corners]
        points = [tiling.point(cell) for cell in cells]
        places = [tiling.position(point) for point in points]
        self.centres = [pixel(scale * length * x, -scale * width * y) for x, y in places]
        self.width = max(x for panel in self.panels for x, _ in panel) + DRAWING_MARGIN
        self.height = max(y for panel in self.panels for _, y in panel) + DRAWING_MARGIN
        self.edges: dict[tuple[int, int], Segment] = {}
        index = {point: k for k, point in enumerate(points)}
        for k, point in enumerate(points):
            panel = self.panels[k]
            for side, (_, to) in enumerate(tiling.neighbours(point)):
                if index.get(to, -1) > k:
                    self.edges[k, index[to]] = (panel[side], panel[(side + 1) % len(panel)])

    def svg(self, marks: Sequence[str], title: str, standalone: bool) -> str:
        """Write the whole picture."""
        return svg(marks, title, (self.width, self.height), self.pixels if standalone else None)


def svg(marks: Iterable[str], title: str, extent: tuple[int, int], pixels: int | None) -> str:
    """Write a picture of an extent (width, height) in units.

    pixels : screen pixels to `DRAWING_SIDE_UNITS` units in a standalone picture, with its own size and the style of
        each line, whose width stays as the picture is enlarged or reduced; None where the page gives both. Widths do
        not depend on `pixels`, so that pictures beside each other have equal lines.
    """
    body = "".join(marks)
    head = f'role="img" viewBox="0 0 {extent[0]} {extent[1]}"'
    if pixels is not None:
        width, height = (round(length * pixels / DRAWING_SIDE_UNITS) for length in extent)
        head = f'xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" {head}'
        for kind, look in DRAWING_STYLES.items():
            scaled = _in_pixels(look)
            attributes = " ".join(f'{name}="{value}"' for name, value in scaled.items())
            body = body.replace(f'class="{kind}"', f'class="{kind}" {attributes}')
    return f"<svg {head}><title>{escape(title)}</title>{body}</svg>"


def _in_pixels(look: Mapping[str, str]) -> dict[str, str]:
    """Return the style of lines with widths and dashes in pixels, which an enlarged picture keeps.

    Outlines of texts grow with the texts.
    """
    if "stroke" not in look or "font-size" in look:
        return dict(look)
    lengths = {name: look[name].split() for name in ("stroke-width", "stroke-dasharray") if name in look}
    scaled = {
        name: " ".join(f"{LINE_PIXELS * float(value):.3g}" for value in values) for name, values in lengths.items()
    }
    return {**look, **scaled, "vector-effect": "non-scaling-stroke"}


def _by_steps(line: Sequence[DrawingPoint]) -> str:
    """Write a line as its first point and relative steps, with as few separators as SVG allows."""
    numbers = [line[0], *((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(line))]
    first, *steps = ["".join(f" {v}" if v >= 0 else f"{v}" for v in pair) for pair in numbers]
    return f"{first.lstrip()}l{''.join(steps).lstrip()}"


def by_points(line: Sequence[DrawingPoint]) -> str:
    """Write a line as the absolute coordinates of its points."""
    return " ".join(f"{x},{y}" for x, y in line)


def svg_path(
    kind: str,
    lines: Iterable[Sequence[DrawingPoint]],
    *,
    closed: bool = False,
    write: Callable[[Sequence[DrawingPoint]], str] = _by_steps,
) -> str:
    """Write one path element with a subpath for each line; empty without lines."""
    data = "".join(f"M{write(line)}{'z' if closed else ''}" for line in lines)
    return f'<path class="{kind}" d="{data}"/>' if data else ""


def _start(centre: DrawingPoint) -> str:
    """Mark panel 0 with a dot."""
    return f'<circle class="start" cx="{centre[0]}" cy="{centre[1]}" r="9"/>'


def _numbers(creases: Sequence[Segment]) -> str:
    """Write the number of each crease on its line, beside the circuit, which crosses it near the middle."""
    texts = (
        f'<text x="{round(0.72 * a[0] + 0.28 * b[0])}" y="{round(0.72 * a[1] + 0.28 * b[1]) + 7}">{k}</text>'
        for k, (a, b) in enumerate(creases)
    )
    return f'<g class="numbers">{"".join(texts)}</g>'
