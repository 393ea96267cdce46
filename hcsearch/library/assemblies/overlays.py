"""Overlays of patterns on one another so that hinges coincide, with a test of clashing facets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import PatternError
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.mesh import SAME_POINT_SHARE, Facet, PlanePoint
from hcsearch.shape.pattern import FacetPair, Pattern, overlay


def facets_clash(fixed: Sequence[Facet], moved: Sequence[Facet], tolerance: float) -> bool:
    """Whether facets of two patterns overlap without coinciding. Overlaps up to the tolerance do not count."""
    fixed_corners, moved_corners = _padded(fixed), _padded(moved)
    fixed_centres, moved_centres = fixed_corners.mean(axis=1), moved_corners.mean(axis=1)
    fixed_radii, moved_radii = (
        np.linalg.norm(x - c[:, None], axis=2).max(axis=1)
        for x, c in ((fixed_corners, fixed_centres), (moved_corners, moved_centres))
    )
    distance = np.linalg.norm(fixed_centres[:, None] - moved_centres, axis=2)
    i, j = np.nonzero(distance < fixed_radii[:, None] + moved_radii)
    first, second = fixed_corners[i], moved_corners[j]
    overlapping = ~(_outside(first, second, tolerance) | _outside(second, first, tolerance))
    if first.shape[1] == second.shape[1]:
        gaps = np.linalg.norm(first[:, :, None] - second[:, None], axis=3)
        overlapping &= np.maximum(gaps.min(axis=2).max(axis=1), gaps.min(axis=1).max(axis=1)) > tolerance
    return bool(overlapping.any())


def _padded(facets: Sequence[Facet]) -> Reals:
    """Return corners of all facets, counterclockwise, padded to equal length by repeating the last one."""
    max_corners = max(map(len, facets))
    corners = np.array([[*facet, *[facet[-1]] * (max_corners - len(facet))] for facet in facets])
    x, y = corners[..., 0], corners[..., 1]
    turned = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) < 0
    corners[turned] = corners[turned, ::-1]
    return corners


def _outside(first: Reals, second: Reals, tolerance: float) -> Flags:
    """Whether an edge of the first of two convex polygons separates them, for pairs of polygons, shape (k, n, 2)."""
    edges = np.roll(first, -1, axis=1) - first
    lengths = np.linalg.norm(edges, axis=2)
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=2) / np.where(lengths > 0, lengths, 1.0)[..., None]
    heights = np.einsum("kaj,kbj->kab", normals, second) - np.einsum("kaj,kaj->ka", normals, first)[..., None]
    beyond = heights.min(axis=2) > -tolerance
    return np.asarray((beyond & (lengths > 0)).any(axis=1))


CreaseMatch = tuple[FacetPair, FacetPair]
"""A crease of the fixed pattern, and the crease of the moving pattern that is laid onto it."""


def placements(fixed: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> list[Isometry]:
    """Return the isometries that lay creases of a pattern onto creases of another, on the same faces.

    A reflection turns the sheet over. One crease leaves four isometries at most: either end on either end, the sheet
    turned over or not.
    """
    (fixed_pair, moving_pair), *_ = matches
    chosen = []
    for reflects in (False, True):
        for ends in (moving.segment(moving_pair), moving.segment(moving_pair)[::-1]):
            placement = Isometry.carrying(_ends(ends), _ends(fixed.segment(fixed_pair)), reflects=reflects)
            if all(_coincide(fixed, moving, placement, match) for match in matches):
                chosen.append(placement)
    return chosen


def joinings(fixed: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> list[tuple[Isometry, Pattern]]:
    """Return the placements that add panels and agree in every crease, each with the union of the patterns."""
    candidates = ((placement, _union(fixed, moving, placement)) for placement in placements(fixed, moving, matches))
    return [(placement, union) for placement, union in candidates if union is not None]


def join_patterns(fixed: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> Pattern:
    """Join two patterns where the coinciding creases leave exactly one placement; PatternError otherwise."""
    unions = joinings(fixed, moving, matches)
    if len(unions) != 1:
        raise PatternError(f"{len(unions)} ways lay these creases onto each other: name creases that leave one")
    return unions[0][1]


def neighbouring_facets(fixed: Pattern, moving: Pattern) -> Iterator[tuple[Isometry, list[CreaseMatch], Pattern]]:
    """Yield all placements of a pattern on another one that merge hinges, with the merged creases and the union."""
    merges: list[tuple[Isometry, list[CreaseMatch]]] = []
    for match in _hinge_pairs(fixed, moving):
        for placement in placements(fixed, moving, [match]):
            known = next((merged for other, merged in merges if _same(placement, other, fixed.segment(match[0]))), None)
            if known is None:
                merges.append((placement, [match]))
            else:
                known.append(match)
    for placement, merged in merges:
        union = _union(fixed, moving, placement)
        if union is not None:
            yield placement, merged, union


def _union(fixed: Pattern, moving: Pattern, placement: Isometry) -> Pattern | None:
    """Return the union with a placed pattern; None where they disagree or no facet is added."""
    moved = moving.placed(placement)
    if facets_clash(fixed.facets, moved.facets, SAME_POINT_SHARE * fixed.size):
        return None
    try:
        union = overlay([fixed, moved])
    except PatternError:
        return None
    return union if len(union.facets) > len(fixed.facets) else None


def _ends(segment: tuple[PlanePoint, PlanePoint]) -> tuple[complex, complex]:
    return complex(*segment[0]), complex(*segment[1])


def _same(first: Isometry, second: Isometry, segment: tuple[PlanePoint, PlanePoint]) -> bool:
    """Whether two isometries are equal up to rounding: the same sense, and the same images of a segment."""
    tolerance = 1e-4 * math.dist(*segment)
    return first.reflects == second.reflects and all(
        math.dist(first.image(end), second.image(end)) < tolerance for end in segment
    )


def _coincide(fixed: Pattern, moving: Pattern, placement: Isometry, match: CreaseMatch) -> bool:
    """Whether two creases coincide and are of the same kind."""
    fixed_pair, moving_pair = match
    crease = moving.creases[moving_pair]
    if fixed.creases[fixed_pair] != (crease.inverted if placement.reflects else crease):
        return False
    a, b = fixed.segment(fixed_pair)
    c, d = map(placement.image, moving.segment(moving_pair))
    apart = min(max(math.dist(a, c), math.dist(b, d)), max(math.dist(a, d), math.dist(b, c)))
    return apart < SAME_POINT_SHARE * fixed.size


def _hinge_pairs(fixed: Pattern, moving: Pattern) -> Iterator[CreaseMatch]:
    """Yield pairs of hinged creases of two patterns that have equal length and kind."""
    for fixed_pair, crease in fixed.creases.items():
        length = math.dist(*fixed.segment(fixed_pair))
        for moving_pair, other in moving.creases.items():
            if crease.face is None or other.face is None or crease.closes != other.closes:
                continue
            if abs(length - math.dist(*moving.segment(moving_pair))) < SAME_POINT_SHARE * fixed.size:
                yield fixed_pair, moving_pair
