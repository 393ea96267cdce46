"""The folded state as a package: how much of the plane it covers, how high it is, and whether it is full.

In the folded state every panel lies flat in a layer of its own thickness. The edges of all panels, seen from above, cut
the footprint into cells, and over each cell stands a column of layers, filled or empty.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

EDGE_GRID_SHARE = 1e-12
"""Edges are cut on a grid as fine as this share of a panel's size; rounding of the folded state is a hundredth."""
SLIVER_AREA_SHARE = 1e-8
"""Cells smaller than this share of a panel's area are rounding."""
FLAT_PANEL_TOLERANCE, OPEN_PANEL_TOLERANCE = 1e-10, 1e-5
"""Loops of a folded state close, and panels lie flat, up to the first; above the second there is no such state."""
WHOLE_RATIO_TOLERANCE = 1e-9
"""Areas are in a ratio of whole numbers up to this."""
MAX_RATIO_DENOMINATOR = 100
"""Greatest second number of such a ratio."""


@dataclass(frozen=True)
class LayerColumn:
    """All cells of the footprint whose layers are filled alike.

    layers : those that are filled, from the lowest of the package, 0; one that is filled twice comes twice.
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
        """Number of panels that share their layer with one before."""
        return len(self.layers) - len(set(self.layers))


@dataclass(frozen=True)
class Package:
    """A folded pattern (thesis 5.2.2); metres, square and cubic metres.

    flat_area : of the pattern in the flat state, all panels in one plane.
    columns : those that occur, the largest area first.
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
        """The deployment ratio as whole numbers, such as 7:1, where it is one of small numbers; else None."""
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
        """Numbers of panels on top of each other that occur, the least first."""
        return tuple(sorted({column.panels for column in self.columns}))

    @property
    def stepped(self) -> bool:
        """Whether the package's top or bottom is no plane."""
        return len({(column.layers[0], column.layers[-1]) for column in self.columns}) > 1

    @property
    def void_volume(self) -> float:
        """Volume between the lowest and the highest panel of each column that no panel fills."""
        return self.thickness * sum(column.gaps * column.area for column in self.columns)

    @property
    def overlap_volume(self) -> float:
        """Volume that panels fill twice: above 0, the pattern cannot be folded so."""
        return self.thickness * sum(column.overlaps * column.area for column in self.columns)


def folded_package(pattern: Pattern) -> Package:
    """Geometry of the folded state of any pattern; PatternError where it has none."""
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
    for area, over in _cells(shadows):
        column = tuple(sorted(int(layers[k].round()) for k in over))
        areas[column] = areas.get(column, 0.0) + area * size * size
    # areas that differ by rounding are one, so that the order is the same everywhere
    ordered = sorted(areas.items(), key=lambda item: (-round(item[1] / (size * size), 6), item[0]))
    return Package(pattern.area, thickness, tuple(LayerColumn(filled, area) for filled, area in ordered))


def _cells(shadows: list[Reals]) -> list[tuple[float, list[int]]]:
    """Cells into which the edges of convex polygons cut the plane: area, and the polygons that cover it, if any."""
    rings = [shapely.LinearRing(shadow) for shadow in shadows]
    lines = shapely.unary_union(rings, grid_size=EDGE_GRID_SHARE)
    polygons = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    polygons = polygons[shapely.area(polygons) > SLIVER_AREA_SHARE]
    inside = shapely.get_coordinates(shapely.point_on_surface(polygons))
    covers = np.array([_contains(shadow, inside) for shadow in shadows])
    cells = zip(shapely.area(polygons).tolist(), covers.T, strict=True)
    return [(area, np.flatnonzero(over).tolist()) for area, over in cells if over.any()]


def _contains(polygon: Reals, points: Reals) -> NDArray[np.bool_]:
    """Which points lie in a convex polygon, whichever way its corners run."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    away = points[None] - polygon[:, None]
    side = edges[:, None, 0] * away[..., 1] - edges[:, None, 1] * away[..., 0]
    return np.asarray((side > 0).all(axis=0) | (side < 0).all(axis=0))


def flat_overlap(pattern: Pattern) -> float:
    """Area that facets of a flat pattern cover twice, in square metres: 0, or the pattern cannot be made."""
    size = pattern.size
    facets = [np.array(facet) / size for facet in pattern.facets]
    union = shapely.unary_union([shapely.Polygon(facet) for facet in facets], grid_size=EDGE_GRID_SHARE)
    overlap = pattern.area - union.area * size * size
    # turning a long pattern moves its far end more
    extent = size * float(np.ptp(np.concatenate(facets), axis=0).max())
    return 0.0 if abs(overlap) < SLIVER_AREA_SHARE * extent * extent else float(overlap)
