"""The folded state as a package: its footprint, height, voids and overlaps.

In the folded state every panel lies flat in a layer of one panel thickness. The edges of all panels, seen from above,
divide the footprint into cells, and over each cell stands a column of filled or empty layers.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import PatternError
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

EDGE_GRID_SHARE = 1e-12
"""Grid on which edges are intersected, over a panel's size; a hundred times the rounding of the folded state."""
SLIVER_AREA_SHARE = 1e-8
"""Cells smaller than this share of a panel's area count as rounding errors."""
FLAT_PANEL_TOLERANCE, OPEN_PANEL_TOLERANCE = 1e-10, 1e-5
"""Tolerances of closed loops and level panels: up to the first the state is folded, above the second none exists."""
WHOLE_RATIO_TOLERANCE = 1e-9
"""Relative tolerance for a ratio of areas to count as a ratio of whole numbers."""
MAX_RATIO_DENOMINATOR = 100
"""Greatest denominator of such a ratio."""


@dataclass(frozen=True)
class LayerColumn:
    """All cells of the footprint with the same filled layers.

    layers : the filled layers, counted from 0, the lowest of the package; a layer filled twice is listed twice.
    area : in square metres.
    """

    layers: tuple[int, ...]
    area: float

    @property
    def panels(self) -> int:
        """Number of panels on top of each other."""
        return len(self.layers)

    @property
    def gaps(self) -> int:
        """Number of empty layers between the lowest and the highest panel."""
        return self.layers[-1] - self.layers[0] + 1 - len(set(self.layers))

    @property
    def overlaps(self) -> int:
        """Number of panels that share their layer with another one."""
        return len(self.layers) - len(set(self.layers))


@dataclass(frozen=True)
class Package:
    """A folded pattern (thesis 5.2.2); metres, square and cubic metres.

    flat_area : area of the pattern in the flat state, all panels in one plane.
    columns : the largest area first.
    """

    flat_area: float
    thickness: float
    columns: tuple[LayerColumn, ...]

    @cached_property
    def footprint_area(self) -> float:
        """Area that the package covers, seen along the normal of its panels."""
        return sum(column.area for column in self.columns)

    @property
    def ratio(self) -> float:
        """Deployment ratio, flat area over footprint (thesis 5.2.2)."""
        return self.flat_area / self.footprint_area

    @property
    def whole_ratio(self) -> str | None:
        """The deployment ratio in small whole numbers, such as 7:1; None where it is no such ratio."""
        near = Fraction(self.ratio).limit_denominator(MAX_RATIO_DENOMINATOR)
        if abs(self.ratio - float(near)) > WHOLE_RATIO_TOLERANCE * self.ratio:
            return None
        return f"{near.numerator}:{near.denominator}"

    @property
    def n_layers(self) -> int:
        """Number of layers from the lowest panel to the highest."""
        return 1 + max(column.layers[-1] for column in self.columns)

    @property
    def height(self) -> float:
        """Height of the package, in metres."""
        return self.n_layers * self.thickness

    @property
    def heights(self) -> tuple[int, ...]:
        """Distinct numbers of stacked panels of the columns, in ascending order."""
        return tuple(sorted({column.panels for column in self.columns}))

    @property
    def is_stepped(self) -> bool:
        """Whether the package's top or bottom is not plane."""
        return len({(column.layers[0], column.layers[-1]) for column in self.columns}) > 1

    @property
    def void_volume(self) -> float:
        """Volume between the lowest and the highest panel of each column that no panel fills."""
        return self.thickness * sum(column.gaps * column.area for column in self.columns)

    @property
    def overlap_volume(self) -> float:
        """Volume that panels fill twice; above 0, the pattern cannot be folded."""
        return self.thickness * sum(column.overlaps * column.area for column in self.columns)


def folded_package(pattern: Pattern) -> Package:
    """Compute the geometry of a pattern's folded state; PatternError where it has none."""
    linkage = Linkage(pattern)
    residual, _ = linkage.closure(linkage.folded)
    solids = linkage.solids(linkage.folded)
    lowest = np.array([solid[..., 2].min() for solid in solids])
    highest = np.array([solid[..., 2].max() for solid in solids])
    size, thickness = pattern.size, pattern.thickness
    tilt = float(np.abs(highest - lowest - thickness).max()) / size
    layers = (lowest - lowest.min()) / thickness
    error = max(float(np.abs(residual).max(initial=0.0)), tilt)
    if error > OPEN_PANEL_TOLERANCE:
        raise PatternError("there is no folded state: loops stay open with every hinge closed; alter creases")
    if error > FLAT_PANEL_TOLERANCE or np.abs(layers - layers.round()).max() > 0.01:
        raise PatternError(f"the folded state is lost in rounding, {error:.1e}: give thicker or less slender panels")
    shadows = [solid[0, :, :2] / size for solid in solids]
    areas: dict[tuple[int, ...], float] = {}
    for area, covering in _cells(shadows):
        column = tuple(sorted(int(layers[k].round()) for k in covering))
        areas[column] = areas.get(column, 0.0) + area * size * size
    # areas are rounded, so that the order does not depend on the platform
    ordered = sorted(areas.items(), key=lambda item: (-round(item[1] / (size * size), 6), item[0]))
    return Package(pattern.area, thickness, tuple(LayerColumn(filled, area) for filled, area in ordered))


def _cells(shadows: list[Reals]) -> list[tuple[float, list[int]]]:
    """Divide the plane by the edges of convex polygons; return each covered cell's area and covering polygons."""
    import shapely  # noqa: PLC0415 - takes longer to load than all else here, and few readers ask for a package

    rings = [shapely.LinearRing(shadow) for shadow in shadows]
    lines = shapely.unary_union(rings, grid_size=EDGE_GRID_SHARE)
    polygons = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    polygons = polygons[shapely.area(polygons) > SLIVER_AREA_SHARE]
    inside = shapely.get_coordinates(shapely.point_on_surface(polygons))
    covers = np.array([_contains(shadow, inside) for shadow in shadows])
    cells = zip(shapely.area(polygons).tolist(), covers.T, strict=True)
    return [(area, np.flatnonzero(covering).tolist()) for area, covering in cells if covering.any()]


def _contains(polygon: Reals, points: Reals) -> Flags:
    """Return which points lie in a convex polygon of either orientation."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    away = points[None] - polygon[:, None]
    side = edges[:, None, 0] * away[..., 1] - edges[:, None, 1] * away[..., 0]
    return np.asarray((side > 0).all(axis=0) | (side < 0).all(axis=0))


def flat_overlap(pattern: Pattern) -> float:
    """Return the area covered twice by facets of a flat pattern, in square metres; above 0, it cannot be made."""
    import shapely  # noqa: PLC0415 - as above

    size = pattern.size
    facets = [np.array(facet) / size for facet in pattern.facets]
    union = shapely.unary_union([shapely.Polygon(facet) for facet in facets], grid_size=EDGE_GRID_SHARE)
    overlap = pattern.area - union.area * size * size
    # rotation errors grow with the extent of a pattern
    extent = size * float(np.ptp(np.concatenate(facets), axis=0).max())
    return 0.0 if abs(overlap) < SLIVER_AREA_SHARE * extent * extent else float(overlap)
