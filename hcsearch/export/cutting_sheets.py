"""Sheets to cut and crease: outlines, slits, fold lines, marks and numbers, in millimetres.

A sheet in one piece has its outline, slits and fold lines. Separate panels have their own outlines, and marks along the
edges that carry hinges. Numbers are drawn as strokes, since cutters have no fonts.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.settings import SheetKind, SheetProfile
from hcsearch.shape.labels import Labels
from hcsearch.shape.mesh import PlanePoint
from hcsearch.shape.pattern import Crease, FacetPair, Pattern

if TYPE_CHECKING:
    from shapely import Polygon

DIGIT_WIDTH_RATIO, DIGIT_SPACE_RATIO, LINE_SPACE_RATIO = 0.5, 0.3, 0.25
"""Width of a digit, space between digits, and space above an underline, over the digit's height."""

# corners of the seven segments, left and right, at heights 1, 1/2 and 0; X, Y of a plus; G, H, I of a 1
_PATHS: dict[str, tuple[str, ...]] = {
    "0": ("ABFEA",),
    "1": ("GHI",),
    "2": ("ABDCEF",),
    "3": ("ABDFE", "CD"),
    "4": ("ACD", "BDF"),
    "5": ("BACDFE",),
    "6": ("BACEFDC",),
    "7": ("ABF",),
    "8": ("ABFEA", "CD"),
    "9": ("DCABFE",),
    "+": ("CD", "XY"),
}
_CORNERS: dict[str, PlanePoint] = {
    "A": (0.0, 1.0),
    "B": (DIGIT_WIDTH_RATIO, 1.0),
    "C": (0.0, 0.5),
    "D": (DIGIT_WIDTH_RATIO, 0.5),
    "E": (0.0, 0.0),
    "F": (DIGIT_WIDTH_RATIO, 0.0),
    "X": (0.5 * DIGIT_WIDTH_RATIO, 0.5 - 0.5 * DIGIT_WIDTH_RATIO),
    "Y": (0.5 * DIGIT_WIDTH_RATIO, 0.5 + 0.5 * DIGIT_WIDTH_RATIO),
    "G": (0.1 * DIGIT_WIDTH_RATIO, 0.8),
    "H": (0.5 * DIGIT_WIDTH_RATIO, 1.0),
    "I": (0.5 * DIGIT_WIDTH_RATIO, 0.0),
}


def digit_strokes(text: str, middle: PlanePoint, height: float, *, underlined: bool = False) -> list[list[PlanePoint]]:
    """Return the polylines of a text of digits and pluses of given height, centred on a point."""
    step = DIGIT_WIDTH_RATIO + DIGIT_SPACE_RATIO
    wide = step * len(text) - DIGIT_SPACE_RATIO
    left, low = middle[0] - 0.5 * height * wide, middle[1] - 0.5 * height
    lines = [
        [(left + height * (k * step + _CORNERS[c][0]), low + height * _CORNERS[c][1]) for c in path]
        for k, mark in enumerate(text)
        for path in _PATHS[mark]
    ]
    below = low - LINE_SPACE_RATIO * height
    return [*lines, [(left, below), (left + height * wide, below)]] if underlined else lines


SHEET_MARGIN, PANEL_SPACE = 5.0, 5.0
"""Margin of a sheet, and space between separate panels, mm."""
_INSET, _NUMBER_INSET, _PANEL_DIGIT, _HINGE_DIGIT = 0.1, 0.28, 0.32, 0.16
"""Distances of hinge marks and hinge numbers from the edge, and heights of panel and hinge numbers, over the facet's
radius."""
_MARK = 0.5
"""Length of a mark over the length of the edge."""
_GRID = 1e-7
"""Grid to which coordinates are rounded when outlines are joined, mm."""

SHEET_LAYERS = ("CUT", "SLIT", "MOUNTAIN", "VALLEY", "HINGE_TOP", "HINGE_BOTTOM", "FACET", "ENGRAVE")

LAYER_COLOURS: dict[SheetProfile, dict[str, tuple[str, int]]] = {
    "laser": {
        "CUT": ("#ff0000", 1),
        "SLIT": ("#ff00ff", 6),
        "MOUNTAIN": ("#00a000", 3),
        "VALLEY": ("#00c0c0", 4),
        "HINGE_TOP": ("#ff8000", 30),
        "HINGE_BOTTOM": ("#808080", 8),
        "ENGRAVE": ("#0000ff", 5),
    },
    "simulator": {
        "CUT": ("#000000", 7),
        "SLIT": ("#00ff00", 3),
        "MOUNTAIN": ("#ff0000", 1),
        "VALLEY": ("#0000ff", 5),
        "HINGE_TOP": ("#ff00ff", 6),
        "HINGE_BOTTOM": ("#ff00ff", 6),
        "FACET": ("#ffff00", 2),
    },
}
"""Colours of layers, and their AutoCAD colour numbers. Origami Simulator expects boundaries black, cuts green,
mountains red, valleys blue, creases that it does not drive magenta, and edges within panels yellow."""


@dataclass(frozen=True)
class SheetLine:
    """A polyline, mm; label : of its panel or hinge, empty for the whole sheet. angle : of a fold line, packed, rad."""

    points: tuple[PlanePoint, ...]
    closed: bool = False
    label: str = ""
    angle: float = math.pi


@dataclass
class CuttingSheet:
    """Lines by layer, between the lower left corner (0, 0) and (width, height), mm."""

    width: float = 0.0
    height: float = 0.0
    lines: dict[str, list[SheetLine]] = field(default_factory=lambda: {name: [] for name in SHEET_LAYERS})

    def add(
        self,
        layer: str,
        points: Sequence[PlanePoint],
        label: str = "",
        *,
        closed: bool = False,
        angle: float = math.pi,
    ) -> None:
        """Add a polyline."""
        self.lines[layer].append(SheetLine(tuple((float(x), float(y)) for x, y in points), closed, label, angle))

    def write(self, text: str, middle: PlanePoint, height: float) -> None:
        """Engrave a number centred on a point; underlined where it could be misread upside down."""
        for stroke in digit_strokes(text, middle, height, underlined=bool({"6", "9"} & set(text))):
            self.add("ENGRAVE", stroke, text)


def cutting_sheet_of(
    pattern: Pattern, labels: Labels, *, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: SheetProfile
) -> CuttingSheet:
    """Draw the sheet for given settings; HcsearchError where they contradict each other."""
    apart = sheet == "panels"
    if profile == "simulator" and (apart or kerf_mm):
        raise HcsearchError("Origami Simulator takes the sheet in one piece, as it is: leave out --sheet and --kerf")
    if hinge_gap_mm and not apart:
        raise HcsearchError("a sheet in one piece has no gaps at hinges: leave out --hinge-gap, or add --sheet panels")
    drawn = _Drawn(pattern, labels, kerf_mm, hinge_gap_mm)
    lines = drawn.draw_panels() if apart else drawn.draw_assembled()
    lines.lines["ENGRAVE" if profile == "simulator" else "FACET"] = []
    return lines


class _Drawn:
    """A pattern to be drawn, in millimetres."""

    def __init__(self, pattern: Pattern, labels: Labels, kerf_mm: float, hinge_gap_mm: float) -> None:
        self.pattern, self.labels = pattern, labels
        self.kerf_mm, self.hinge_gap_mm = kerf_mm, hinge_gap_mm
        self.size = 1e3 * self.pattern.size
        self.vertices = [(1e3 * x, 1e3 * y) for x, y in self.pattern.vertices]
        self.radii = [_radius(facet) for facet in self._polygons()]

    def edge(self, pair: FacetPair) -> tuple[PlanePoint, PlanePoint]:
        """Return the shared edge of two facets, with the first on its left."""
        start, end = self.pattern.edges[pair]
        return self.vertices[start], self.vertices[end]

    def draw_assembled(self) -> CuttingSheet:
        """Draw the sheet in one piece."""
        import shapely  # noqa: PLC0415 - takes longer to load than the sheet to draw

        sheet = CuttingSheet()
        outline = shapely.union_all(self._polygons(), grid_size=_GRID)
        for ring in _rings(self._grown(outline)):
            sheet.add("CUT", ring, closed=True)
        slits = []
        for pair in self.pattern.edges:
            crease = self.pattern.creases.get(pair)
            if crease is not None and crease.face is not None:
                hinge = self.pattern.hinge_of(pair)
                sheet.add(_layer(crease), self.edge(pair), self.labels.hinges[hinge], angle=crease.angle)
                self._number_hinge(sheet, hinge, self.edge(pair), self.radii[pair[0]])
            elif self.pattern.panel_of[pair[0]] == self.pattern.panel_of[pair[1]]:
                sheet.add("FACET", self.edge(pair))
            else:
                slits.append(self.edge(pair))
        for chain in chained_edges(slits):
            sheet.add("SLIT", chain)
        for panel, polygon in enumerate(self.panels(self._polygons())):
            self._number_panel(sheet, panel, polygon)
        return _moved_in(sheet)

    def draw_panels(self) -> CuttingSheet:
        """Draw separate panels, arranged in rows in their order."""
        import shapely  # noqa: PLC0415 - as above

        facets = self._trimmed()
        polygons, marks, parts = self.panels(facets), self._marks(facets), []
        for panel, polygon in enumerate(polygons):
            part = CuttingSheet()
            label = self.labels.panels[panel]
            for ring in _rings(self._grown(polygon)):
                part.add("CUT", ring, label, closed=True)
            for layer, hinge, side, radius in marks[panel]:
                part.add(layer, _beside(side, _INSET * radius, _MARK), self.labels.hinges[hinge])
                self._number_hinge(part, hinge, side, radius)
            self._number_panel(part, panel, polygon)
            parts.append(part)
        area = sum(shapely.box(*_bounds(part)).area for part in parts)
        return _in_rows(parts, 1.2 * math.sqrt(area))

    def panels(self, facets: Sequence[Polygon]) -> list[Polygon]:
        """Return the panels' polygons, joined from those of their facets."""
        import shapely  # noqa: PLC0415 - as above

        polygons = [
            shapely.union_all([facets[facet] for facet in panel], grid_size=_GRID) for panel in self.pattern.panels
        ]
        for label, polygon in zip(self.labels.panels, polygons, strict=True):
            if polygon.geom_type != "Polygon" or polygon.is_empty:
                gap = self.hinge_gap_mm
                raise HcsearchError(f"a hinge gap of {gap:g} mm leaves panel {label} not in one piece: give less")
        return polygons

    def _polygons(self) -> list[Polygon]:
        """Return the facets' polygons."""
        import shapely  # noqa: PLC0415 - as above

        return [shapely.Polygon([self.vertices[v] for v in face]) for face in self.pattern.faces]

    def _trimmed(self) -> list[Polygon]:
        """Return the facets' polygons, reduced by half of the hinge gap along hinges."""
        facets, gap = self._polygons(), 0.5 * self.hinge_gap_mm
        if gap:
            for pair, crease in self.pattern.creases.items():
                for facet, (start, end) in zip(pair, (self.edge(pair), self.edge(pair)[::-1]), strict=True):
                    if crease.face is not None:
                        facets[facet] = facets[facet].difference(_strip(start, end, gap, 10 * self.size))
        return facets

    def _grown(self, polygon: Polygon) -> Polygon:
        """Offset a polygon outwards by half of the kerf; HcsearchError where that closes a hole or a notch."""
        kerf = 0.5 * self.kerf_mm
        if not kerf:
            return polygon
        grown = polygon.buffer(kerf, join_style="mitre", mitre_limit=10.0)
        if abs(grown.buffer(-kerf, join_style="mitre", mitre_limit=10.0).area - polygon.area) > 1e-6 * polygon.area:
            raise HcsearchError(f"a kerf of {2 * kerf:g} mm closes a hole or a notch in an outline: give less")
        return grown

    def _marks(
        self, facets: Sequence[Polygon]
    ) -> dict[int, list[tuple[str, int, tuple[PlanePoint, PlanePoint], float]]]:
        """Return each panel's hinge marks: layer, hinge, the facet's side along it (facet on the left), its radius."""
        marks: dict[int, list[tuple[str, int, tuple[PlanePoint, PlanePoint], float]]] = defaultdict(list)
        for pair, crease in self.pattern.creases.items():
            if crease.face is not None:
                layer, hinge = _hinge_layer(crease), self.pattern.hinge_of(pair)
                for facet, edge in zip(pair, (self.edge(pair), self.edge(pair)[::-1]), strict=True):
                    side = _side_along(facets[facet], edge)
                    marks[self.pattern.panel_of[facet]].append((layer, hinge, side, _radius(facets[facet])))
        return marks

    def _number_hinge(
        self, sheet: CuttingSheet, hinge: int, edge: tuple[PlanePoint, PlanePoint], radius: float
    ) -> None:
        """Engrave a hinge's number on the left of its edge, scaled to the facet's radius."""
        (x, y), (to_x, to_y) = _beside(edge, _NUMBER_INSET * radius, 1.0)
        sheet.write(self.labels.hinges[hinge], (0.5 * (x + to_x), 0.5 * (y + to_y)), _HINGE_DIGIT * radius)

    def _number_panel(self, sheet: CuttingSheet, panel: int, polygon: Polygon) -> None:
        """Engrave a panel's number in its middle, as large as its facets and its outline allow."""
        import shapely  # noqa: PLC0415 - as above

        label, middle = self.labels.panels[panel], _middle(polygon)
        reach = max(math.hypot(*point) for stroke in digit_strokes(label, (0.0, 0.0), 1.0) for point in stroke)
        room = polygon.exterior.distance(shapely.Point(middle)) / reach
        radius = max(self.radii[facet] for facet in self.pattern.panels[panel])
        sheet.write(label, middle, min(_PANEL_DIGIT * radius, 0.9 * room))


def chained_edges(edges: Sequence[tuple[PlanePoint, PlanePoint]]) -> list[list[PlanePoint]]:
    """Join edges into polylines between branch points; closed polylines repeat their first point at the end."""
    adjacent: dict[PlanePoint, list[PlanePoint]] = defaultdict(list)
    for a, b in edges:
        adjacent[a].append(b)
        adjacent[b].append(a)
    unused = {frozenset(edge) for edge in edges}
    polylines = []
    starts = [point for point, neighbours in adjacent.items() if len(neighbours) != 2]
    for start in [*starts, *adjacent]:
        for first in adjacent[start]:
            if frozenset((start, first)) not in unused:
                continue
            chain = [start, first]
            unused.remove(frozenset((start, first)))
            while len(adjacent[chain[-1]]) == 2:
                onward = [point for point in adjacent[chain[-1]] if frozenset((chain[-1], point)) in unused]
                if not onward:
                    break
                unused.remove(frozenset((chain[-1], onward[0])))
                chain.append(onward[0])
            polylines.append(chain)
    return polylines


def _layer(crease: Crease) -> str:
    """Return the layer of a fold line; flat hinges, neither mountain nor valley, are on the layer of their face."""
    return _hinge_layer(crease) if crease.fold == "flat" else crease.fold.upper()


def _hinge_layer(crease: Crease) -> str:
    return "HINGE_TOP" if crease.face == "top" else "HINGE_BOTTOM"


def _strip(start: PlanePoint, end: PlanePoint, width: float, far: float) -> Polygon:
    """Return the strip along a directed line, up to `width` on its left and `far` on its right and beyond both ends."""
    import shapely  # noqa: PLC0415 - as above

    a, b = complex(*start), complex(*end)
    along = (b - a) / abs(b - a)
    corners = [a - far * along + 1j * along * width, a - far * along - 1j * along * far]
    corners += [b + far * along - 1j * along * far, b + far * along + 1j * along * width]
    return shapely.Polygon([(corner.real, corner.imag) for corner in corners])


def _side_along(facet: Polygon, edge: tuple[PlanePoint, PlanePoint]) -> tuple[PlanePoint, PlanePoint]:
    """Return the side of a convex facet that is nearest and parallel to an edge on the facet's right."""
    a, b = complex(*edge[0]), complex(*edge[1])
    along = (b - a) / abs(b - a)
    places = [(complex(*point) - a) / along for point in facet.exterior.coords]
    gap = min(place.imag for place in places)
    near = [place.real for place in places if place.imag - gap <= 1e-6 * abs(b - a)]
    start, end = (a + along * (x + 1j * gap) for x in (min(near), max(near)))
    return (start.real, start.imag), (end.real, end.imag)


def _beside(edge: tuple[PlanePoint, PlanePoint], inset: float, share: float) -> tuple[PlanePoint, PlanePoint]:
    """Return the middle `share` of an edge, moved to its left by `inset`."""
    a, b = complex(*edge[0]), complex(*edge[1])
    along = (b - a) / abs(b - a)
    middle, half = 0.5 * (a + b) + 1j * along * inset, 0.5 * share * (b - a)
    return ((middle - half).real, (middle - half).imag), ((middle + half).real, (middle + half).imag)


def _radius(facet: Polygon) -> float:
    """Return the inradius of a facet: twice area over perimeter, approximate where no circle touches all sides."""
    return 2.0 * float(facet.area) / float(facet.length)


def _middle(polygon: Polygon) -> PlanePoint:
    point = polygon.centroid if polygon.covers(polygon.centroid) else polygon.representative_point()
    return point.x, point.y


def _rings(polygons: Polygon) -> list[list[PlanePoint]]:
    """Return outer rings and holes of polygons, without straight corners, the first point not repeated."""
    import shapely  # noqa: PLC0415 - as above

    parts = shapely.get_parts(polygons.simplify(1e-6))
    return [list(ring.coords)[:-1] for part in parts for ring in (part.exterior, *part.interiors)]


def _bounds(sheet: CuttingSheet) -> tuple[float, float, float, float]:
    table = np.array([point for lines in sheet.lines.values() for line in lines for point in line.points])
    low, high = table.min(axis=0), table.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _moved_in(sheet: CuttingSheet) -> CuttingSheet:
    """Translate a sheet to the margin from the origin, and set its size."""
    return _in_rows([sheet], math.inf)


def _in_rows(parts: Sequence[CuttingSheet], width: float) -> CuttingSheet:
    """Arrange parts in rows from the top, no wider than `width` unless a single part is wider."""
    sheet = CuttingSheet()
    rows: list[list[tuple[CuttingSheet, float, float, float]]] = []
    row: list[tuple[CuttingSheet, float, float, float]] = []
    x = 0.0
    for part in parts:
        left, low, right, high = _bounds(part)
        if row and x + right - left > width:
            rows.append(row)
            x, row = 0.0, []
        row.append((part, x - left, low, high))
        x += right - left + PANEL_SPACE
    rows.append(row)
    total = sum(max(high - low for _, _, low, high in row) for row in rows) + PANEL_SPACE * (len(rows) - 1)
    y = SHEET_MARGIN + total
    for row in rows:
        y -= max(high - low for _, _, low, high in row)
        for part, shift, low, _ in row:
            for layer, lines in part.lines.items():
                for line in lines:
                    points = [(px + shift + SHEET_MARGIN, py - low + y) for px, py in line.points]
                    sheet.add(layer, points, line.label, closed=line.closed, angle=line.angle)
        y -= PANEL_SPACE
    _, _, right, _ = _bounds(sheet)
    sheet.width, sheet.height = right + SHEET_MARGIN, total + 2 * SHEET_MARGIN
    return sheet
