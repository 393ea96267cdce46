"""Panels as right prisms, as built or shrunk by a margin, and the pairs of them that can meet.

For proofs that two panels overlap, `plates_of` also has the hinge paths between them. The extent of panels
is bounded from their hinges, across the linkage, and by the error of open loops.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms, pairs_between
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.shape.mesh import SAME_POINT_SHARE, Facet
from hcsearch.shape.pattern import Hinge

PrismCorner = tuple[float, float, float]
TableEntry = TypeVar("TableEntry", bound=np.generic)

PARALLEL_SIDES_SINE = 1e-9
"""Directions are parallel where the sine of their angle is no greater."""
FACET_CACHE_SIZE = 4096
"""Number of facets whose sides and insets are cached: arrays of one panel size share their cells."""


def prisms_of(linkage: Linkage, margin: float = 0.0) -> Prisms:
    """Prisms of all facets in the flat state, shrunk by a margin (m) on every face."""
    pattern = linkage.pattern
    upright = (0.0, 0.0, 1.0)
    solids: list[list[PrismCorner]] = []
    edges: list[list[PrismCorner]] = []
    normals: list[list[PrismCorner]] = []
    for facet in pattern.facets:
        sides = _side_directions(facet)
        faces = (margin, pattern.thickness - margin)
        solids.append([(x, y, z) for z in faces for x, y in inset_facet(facet, margin)])
        edges.append([*((x, y, 0.0) for x, y in sides), upright])
        normals.append([*((-y, x, 0.0) for x, y in sides), upright])
    counts = np.array([(len(solid), len(axes)) for solid, axes in zip(solids, edges, strict=True)], np.int64)
    vertices = padded_table([np.array(solid) for solid in solids])
    real = (np.arange(vertices.shape[1]) < counts[:, :1])[..., None]
    middles = vertices.sum(axis=1) / counts[:, :1]
    return Prisms(
        panels=np.array(pattern.panel_of, np.int64),
        counts=counts,
        vertices=vertices,
        middles=middles,
        reaches=np.linalg.norm((vertices - middles[:, None]) * real, axis=2).max(axis=1),
        normals=padded_table([np.array(axes) for axes in normals]),
        edges=padded_table([np.array(axes) for axes in edges]),
    )


def deepest_margin(linkage: Linkage) -> float:
    """The least margin (m) at which a prism, or one of its sides, vanishes."""
    max_margin = 0.5 * linkage.pattern.thickness
    for facet in linkage.pattern.facets:
        inside = inset_facet(facet, 1.0)
        for k in range(len(facet)):
            length = math.dist(facet[k], facet[k - 1])
            across = ((facet[k][c] - facet[k - 1][c]) * (inside[k][c] - inside[k - 1][c]) for c in (0, 1))
            lost = length - sum(across) / length
            if lost > 0.0:
                max_margin = min(max_margin, length / lost)
    return max_margin


def facet_pairs(linkage: Linkage, apart: Collection[tuple[int, int]] = ()) -> WholeNumbers:
    """Pairs of facets of different panels, without the pairs of panels in `apart`, shape (n_pairs, 2)."""
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    selected = low != high
    if apart:
        n = linkage.n_panels
        selected &= ~np.isin(low * n + high, [one * n + two for one, two in apart])
    return np.column_stack([first[selected], second[selected]])


@lru_cache(FACET_CACHE_SIZE)
def inset_facet(facet: Facet, margin: float) -> tuple[tuple[float, float], ...]:
    """The corners of a convex polygon with every side moved inwards by a margin, counterclockwise."""
    corners = []
    for before, (x, y), after in zip((facet[-1], *facet[:-1]), facet, (*facet[1:], facet[0]), strict=True):
        first, second = math.dist(before, (x, y)), math.dist((x, y), after)
        a, b = (before[1] - y) / first, (x - before[0]) / first  # normals of both sides
        c, d = (y - after[1]) / second, (after[0] - x) / second
        share = margin / (1.0 + a * c + b * d)
        corners.append((x + share * (a + c), y + share * (b + d)))
    return tuple(corners)


@lru_cache(FACET_CACHE_SIZE)
def _side_directions(facet: Facet) -> tuple[tuple[float, float], ...]:
    """Unit vectors along the sides of a facet, one for each class of parallel sides."""
    directions: list[tuple[float, float]] = []
    for (x, y), (to_x, to_y) in zip(facet, (*facet[1:], facet[0]), strict=True):
        long = math.hypot(to_x - x, to_y - y)
        u, v = (to_x - x) / long, (to_y - y) / long
        if all(abs(u * b - v * a) > PARALLEL_SIDES_SINE for a, b in directions):
            directions.append((u, v))
    return tuple(directions)


def padded_table(rows: Sequence[NDArray[TableEntry]]) -> NDArray[TableEntry]:
    """Stack tables of different lengths, padded with zeros."""
    table = np.zeros((len(rows), max(map(len, rows)), rows[0].shape[1]), rows[0].dtype)
    for row, entries in zip(table, rows, strict=True):
        row[: len(entries)] = entries
    return table


REFERENCE_EDGE_LENGTH = 0.05
"""Longest edge (m) at which `DEFAULT_PANEL_MARGIN` and `GAP_RESOLUTION` hold; for others they are in proportion."""
DEFAULT_PANEL_MARGIN = 1e-4
"""Panels are shrunk by this on every face (m), unless another margin is given."""
MAX_MARGIN_SHARE = 0.2
"""Default margins are no more than this share of the thickness, so that thin panels keep a core."""
GAP_RESOLUTION = 5e-5
"""Resolution of the smallest gap (m)."""
MIN_PANEL_MARGIN = 1e-5
"""The least margin that is tested (m)."""
TOUCHING_DISTANCE = 1e-6
"""Panels nearer to each other than this, or overlapping by less, touch (m): about the error of closed loops."""


def scale_of(linkage: Linkage) -> float:
    """The longest edge of a linkage's facets over `REFERENCE_EDGE_LENGTH`, rounded to ten digits."""
    facets = linkage.pattern.facets
    longest = max(math.dist(start, end) for facet in facets for start, end in pairwise((*facet, facet[0])))
    return float(f"{longest / REFERENCE_EDGE_LENGTH:.10g}")


def margin_of(linkage: Linkage) -> float:
    """The default margin (m): in proportion to the panels' edges, but at most a share of their thickness."""
    return min(DEFAULT_PANEL_MARGIN * scale_of(linkage), MAX_MARGIN_SHARE * linkage.pattern.thickness)


def resolution_of(linkage: Linkage) -> float:
    """The resolution of the smallest gap (m), in proportion to the panels."""
    return GAP_RESOLUTION * scale_of(linkage)


def check_margin(linkage: Linkage, margin: float) -> float:
    """The least margin (m) at which a panel vanishes; HcsearchError unless the given one is positive and smaller."""
    max_margin = deepest_margin(linkage)
    if not 0.0 < margin < max_margin:
        raise HcsearchError(
            f"a margin of {1e3 * margin:g} mm is not positive or leaves nothing of a panel: "
            f"give more than 0 and less than {1e3 * max_margin:.4g} mm as margin_mm of a scene file, or thicker panels"
        )
    return max_margin


class Solids(NamedTuple):
    """The panels of a linkage for the kernels: prisms as built, prisms shrunk by the margin, and pairs of them.

    margin : panels are shrunk by it on every face, m. max_margin : the margin at which a panel vanishes, m.
    """

    prisms: Prisms
    shrunk: Prisms
    pairs: PrismPairs
    margin: float
    max_margin: float


def collision_solids(linkage: Linkage, margin: float, apart: Collection[tuple[int, int]] = ()) -> Solids:
    """Solids of a linkage with a margin (m). apart : pairs of panels, the lower number first, that are left out."""
    max_margin = check_margin(linkage, margin)
    prisms = prisms_of(linkage)
    return Solids(prisms, prisms_of(linkage, margin), solid_pairs(linkage, prisms, apart), float(margin), max_margin)


def solid_pairs(linkage: Linkage, prisms: Prisms, apart: Collection[tuple[int, int]] = ()) -> PrismPairs:
    """Pairs of facets of different panels, without the pairs in `apart`, with the hinges between their panels.

    prisms : the prisms of all facets, not shrunk.
    """
    return pairs_between(linkage.chain, prisms, facet_pairs(linkage, apart))


def kept_apart(linkage: Linkage) -> frozenset[tuple[int, int]]:
    """Pairs of panels, the lower first, that cannot overlap while a hinge between them is within its stops.

    Each panel lies on one side of the hinge's line in the flat pattern, so both lie in quarter spaces about that line,
    which only touch at fold angles from 0 to pi (docs/explanation/collision.md). Pairs with a panel that extends across
    the line are not included.
    """
    pattern, pairs = linkage.pattern, set()
    tolerance = SAME_POINT_SHARE * pattern.size

    def offsets_from(panel: int, hinge: Hinge) -> Reals:
        """Signed distances of the corners of a panel to the left of a hinge's line."""
        start = np.array(hinge.start)
        along = (np.array(hinge.end) - start) / math.dist(hinge.start, hinge.end)
        corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]]) - start
        offsets: Reals = along[0] * corners[:, 1] - along[1] * corners[:, 0]
        return offsets

    for hinge in pattern.hinges:
        left, right = offsets_from(hinge.first, hinge), offsets_from(hinge.second, hinge)
        if left.min() >= -tolerance and right.max() <= tolerance:
            pairs.add((min(hinge.first, hinge.second), max(hinge.first, hinge.second)))
    return frozenset(pairs)


HingeCrossings = list[tuple[int, int]]
"""Pairs of a hinge and the sense in which it is crossed."""


def plates_of(linkage: Linkage, margin: float) -> Plates:
    """The facets of a linkage shrunk by a margin (m), and the pairs of them whose panels no hinge joins.

    Hinges are numbered by their places in `linkage.looped`. Pairs are left out if every path between their panels
    crosses a hinge that is in no loop.
    """
    check_margin(linkage, margin)
    pattern, prisms = linkage.pattern, prisms_of(linkage, margin)
    middle = prisms.middles.mean(axis=0)
    joined = [(min(hinge.first, hinge.second), max(hinge.first, hinge.second)) for hinge in pattern.hinges]
    number = {int(hinge): k for k, hinge in enumerate(linkage.looped)}
    pairs, starts, steps = [], [0], HingeCrossings()
    for first, second in facet_pairs(linkage, joined).tolist():
        paths = two_ways(linkage, pattern.panel_of[first], pattern.panel_of[second])
        if any(paths):
            pairs.append((first, second))
            for path in paths:
                steps += path
                starts.append(len(steps))
    hinges = [hinge for hinge, _ in steps]
    signs = np.array([sign for _, sign in steps], float).reshape(-1, 1)
    corners = prisms.counts[:, 0] // 2
    outlines = [(prisms.vertices[f, : 2 * m] - middle) / pattern.size for f, m in enumerate(corners)]
    samples, sides = [_samples(outline) for outline in outlines], [_sides(outline) for outline in outlines]
    segments = [_segments(outline) for outline in outlines]
    counts = [list(map(len, tables)) for tables in zip(samples, segments, sides, strict=True)]
    return Plates(
        np.array(pairs, np.int64).reshape(-1, 2),
        np.array(starts, np.int64),
        np.array([number[hinge] for hinge in hinges], np.int64),
        signs * linkage.directions[hinges].reshape(-1, 3),
        (linkage.points[hinges].reshape(-1, 3) - middle) / pattern.size,
        padded_table(samples),
        padded_table(segments),
        padded_table(sides),
        np.array(counts, np.int64).reshape(-1, 3),
        np.array([(outline[0, 2], outline[-1, 2]) for outline in outlines]),
        (prisms.middles - middle) / pattern.size,
        prisms.reaches / pattern.size,
        float(margin),
    )


def two_ways(linkage: Linkage, start: int, end: int) -> tuple[HingeCrossings, HingeCrossings]:
    """The shortest path between two panels across hinges in loops, and the shortest one that avoids its hinges."""
    bridges = set(range(linkage.n_hinges)) - set(linkage.looped.tolist())
    first = _way(linkage, start, end, bridges)
    return first, _way(linkage, start, end, bridges | {hinge for hinge, _ in first})


def _way(linkage: Linkage, start: int, end: int, excluded: set[int]) -> HingeCrossings:
    """The shortest path of hinges between two panels that avoids some hinges; empty if there is none."""
    tree = hinge_tree(linkage.pattern, start, excluded)
    return tree.way(end) if tree.roots[end] == start else []


def _samples(corners: Reals) -> Reals:
    """Samples of a prism, (4 m + 2, 3): bottom corners, points half-way to their middle, the middle; then above."""
    points = []
    for ring in np.split(corners, 2):
        middle = ring.mean(axis=0)
        points += [*ring, *(0.5 * (ring + middle)), middle]
    return np.array(points)


def _segments(corners: Reals) -> WholeNumbers:
    """Segments as pairs of samples, (t, 2): all vertical ones, and all between corners."""
    m = len(corners) // 2
    per = 2 * m + 1
    outer = [*range(m), *range(per, per + m)]
    upright = [(k, per + k) for k in range(per)]
    return np.array(upright + [(i, j) for i in outer for j in outer if i < j and j != per + i], np.int64)


def _sides(corners: Reals) -> Reals:
    """The sides of the outline of a prism, (m, 3): outward normals and the offsets along them."""
    ring = corners[: len(corners) // 2, :2]
    along = np.roll(ring, -1, axis=0) - ring
    normals = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.column_stack([normals, (normals * ring).sum(axis=1)])


def slack_of(linkage: Linkage, gap: float) -> float:
    """Bound of the displacement of panels (m) by a closure residual (rad, or gap over the pattern's size).

    A panel that is reached the other way around a loop is rotated by up to sqrt(3) residuals about a point of the loop,
    from which no panel is further than the longest way, and translated by as much times the size. The rest of the
    factor covers panels between the places at which residuals are computed.
    """
    if not linkage.loops:
        return 0.0
    return 2.0 * len(linkage.loops) * (longest_way(linkage) + linkage.pattern.size) * gap


@lru_cache(maxsize=32)  # each of the motions of a linkage asks for it again
def longest_way(linkage: Linkage) -> float:
    """An upper bound (m) of the distance between any two corners, however the hinges are folded.

    It is the greatest of the shortest paths between corners that are straight in each panel and pass from one panel to
    the next at an end of their hinge: panels are rigid, so such a path keeps its length.
    """
    pattern = linkage.pattern
    ends, panels = [], []
    for hinge, point in zip(pattern.hinges, linkage.points, strict=True):
        ends += [(*hinge.start, point[2]), (*hinge.end, point[2])]
        panels += 2 * [(hinge.first, hinge.second)]
    points = np.array(ends)
    distances = np.full((len(points), len(points)), np.inf)
    ends_of: list[list[int]] = [[] for _ in pattern.panels]  # ends of the hinges of each panel
    for k, pair in enumerate(panels):
        for panel in set(pair):
            ends_of[panel].append(k)
    for k, pair in enumerate(panels):
        neighbours = sorted({end for panel in pair for end in ends_of[panel]})
        distances[k, neighbours] = np.linalg.norm(points[k] - points[neighbours], axis=1)
    detours = np.empty_like(distances)
    for k in range(len(points)):  # Floyd and Warshall's shortest paths
        np.add(distances[:, k, None], distances[k], out=detours)
        np.minimum(distances, detours, out=distances)
    corners, owners = [], []
    for panel, facets in enumerate(pattern.panels):
        for x, y in (corner for facet in facets for corner in pattern.facets[facet]):
            corners += [(x, y, 0.0), (x, y, pattern.thickness)]
            owners += 2 * [panel]
    # from each corner to the ends of its panel's hinges: most panels have four
    max_ends = max(map(len, ends_of))
    end_indices = np.array([[*ends_of[panel], *[0] * (max_ends - len(ends_of[panel]))] for panel in owners])
    is_end = np.arange(max_ends) < np.array([[len(ends_of[panel])] for panel in owners])
    to_ends = np.where(is_end, np.linalg.norm(np.array(corners)[:, None] - points[end_indices], axis=2), np.inf)
    longest = 0.0
    for k in range(len(corners)):  # a corner at a time: all pairs at once would take gigabytes
        from_corner = (to_ends[k][:, None] + distances[end_indices[k]]).min(axis=0)
        longest = max(longest, float((from_corner[end_indices] + to_ends).min(axis=1).max()))
    return longest


def reaches(linkage: Linkage) -> Reals:
    """The greatest distance of the corners of a hinge's two panels from its line (m), for each hinge, (n_hinges,)."""
    pattern, farthest = linkage.pattern, np.zeros(linkage.n_hinges)
    for k, hinge in enumerate(pattern.hinges):
        for panel in (hinge.first, hinge.second):
            corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]])
            offsets = corners - linkage.points[k, :2]
            across = linkage.directions[k, 0] * offsets[:, 1] - linkage.directions[k, 1] * offsets[:, 0]
            farthest[k] = max(farthest[k], math.hypot(float(np.abs(across).max()), pattern.thickness))
    return farthest
