"""Copies of patterns laid onto one another so that hinges coincide, and whether facets clash there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.mesh import SAME_POINT_SHARE, Facet, PlanePoint
from hcsearch.shape.pattern import FacetPair, Pattern, overlay


def facets_clash(still: Sequence[Facet], moved: Sequence[Facet], tolerance: float) -> bool:
    """Whether facets of two patterns overlap without being the same; by no more than the tolerance is not at all."""
    one, two = _padded(still), _padded(moved)
    centres, others = one.mean(axis=1), two.mean(axis=1)
    reach, other = (np.linalg.norm(x - c[:, None], axis=2).max(axis=1) for x, c in ((one, centres), (two, others)))
    distance = np.linalg.norm(centres[:, None] - others, axis=2)
    i, j = np.nonzero(distance < reach[:, None] + other)
    gaps = np.linalg.norm(one[i, :, None] - two[j, None], axis=3) if one.shape[1] == two.shape[1] else None
    overlapping = ~(_outside(one[i], two[j], tolerance) | _outside(two[j], one[i], tolerance))
    if gaps is not None:
        overlapping &= np.maximum(gaps.min(axis=2).max(axis=1), gaps.min(axis=1).max(axis=1)) > tolerance
    return bool(overlapping.any())


def _padded(facets: Sequence[Facet]) -> Reals:
    """Corners of all facets, counterclockwise, with the last one repeated where others have more."""
    most = max(map(len, facets))
    corners = np.array([[*facet, *[facet[-1]] * (most - len(facet))] for facet in facets])
    x, y = corners[..., 0], corners[..., 1]
    turned = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) < 0
    corners[turned] = corners[turned, ::-1]
    return corners


def _outside(one: Reals, two: Reals, tolerance: float) -> NDArray[np.bool_]:
    """Of pairs of convex polygons, shape (k, n, 2), whether an edge of the first has the second on its other side."""
    edges = np.roll(one, -1, axis=1) - one
    lengths = np.linalg.norm(edges, axis=2)
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=2) / np.where(lengths > 0, lengths, 1.0)[..., None]
    heights = np.einsum("kaj,kbj->kab", normals, two) - np.einsum("kaj,kaj->ka", normals, one)[..., None]
    beyond = heights.min(axis=2) > -tolerance
    return np.asarray((beyond & (lengths > 0)).any(axis=1))


CreaseMatch = tuple[FacetPair, FacetPair]
"""A crease of the pattern that lies still, and the crease of the moving pattern that is laid onto it."""


def placements(still: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> list[Isometry]:
    """All ways to lay a pattern so that its creases coincide with those of another one, on the same faces.

    A reflection turns the sheet over.

    One crease leaves four isometries at most: either end on either end, the sheet turned over or not.
    """
    (on, of), *_ = matches
    chosen = []
    for over in (False, True):
        for ends in (moving.segment(of), moving.segment(of)[::-1]):
            placement = Isometry.carrying(_ends(ends), _ends(still.segment(on)), reflects=over)
            if all(_coincide(still, moving, placement, match) for match in matches):
                chosen.append(placement)
    return chosen


def joinings(still: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> list[tuple[Isometry, Pattern]]:
    """The placements that make sense, with the union of the patterns: they add panels and agree about every crease."""
    laid = ((placement, _union(still, moving, placement)) for placement in placements(still, moving, matches))
    return [(placement, union) for placement, union in laid if union is not None]


def join_patterns(still: Pattern, moving: Pattern, matches: Sequence[CreaseMatch]) -> Pattern:
    """The union of two patterns, where the creases to coincide leave exactly one way; PatternError otherwise."""
    unions = joinings(still, moving, matches)
    if len(unions) != 1:
        raise PatternError(f"{len(unions)} ways lay these creases onto each other: name creases that leave one")
    return unions[0][1]


def neighbouring_facets(still: Pattern, moving: Pattern) -> Iterator[tuple[Isometry, list[CreaseMatch], Pattern]]:
    """All ways to lay a pattern onto another one so that hinges merge: what merges, and the union."""
    ways: list[tuple[Isometry, list[CreaseMatch]]] = []
    for match in _hinge_pairs(still, moving):
        for placement in placements(still, moving, [match]):
            known = next((merged for other, merged in ways if _same(placement, other, still.segment(match[0]))), None)
            if known is None:
                ways.append((placement, [match]))
            else:
                known.append(match)
    for placement, merged in ways:
        union = _union(still, moving, placement)
        if union is not None:
            yield placement, merged, union


def _union(still: Pattern, moving: Pattern, placement: Isometry) -> Pattern | None:
    """The union with a pattern that is laid somewhere; None where they disagree, or it adds nothing."""
    moved = moving.placed(placement)
    if facets_clash(still.facets, moved.facets, SAME_POINT_SHARE * still.size):
        return None
    try:
        union = overlay([still, moved])
    except PatternError:
        return None
    return union if len(union.facets) > len(still.facets) else None


def _ends(segment: tuple[PlanePoint, PlanePoint]) -> tuple[complex, complex]:
    return complex(*segment[0]), complex(*segment[1])


def _same(one: Isometry, two: Isometry, segment: tuple[PlanePoint, PlanePoint]) -> bool:
    """Whether two isometries are one up to rounding: alike on both faces, and on a segment."""
    tolerance = 1e-4 * math.dist(*segment)
    return one.reflects == two.reflects and all(
        math.dist(one.image(end), two.image(end)) < tolerance for end in segment
    )


def _coincide(still: Pattern, moving: Pattern, placement: Isometry, match: CreaseMatch) -> bool:
    """Whether two creases lie on each other and are the same."""
    on, of = match
    crease = moving.creases[of]
    if still.creases[on] != (crease.inverted if placement.reflects else crease):
        return False
    a, b = still.segment(on)
    c, d = map(placement.image, moving.segment(of))
    apart = min(max(math.dist(a, c), math.dist(b, d)), max(math.dist(a, d), math.dist(b, c)))
    return apart < SAME_POINT_SHARE * still.size


def _hinge_pairs(still: Pattern, moving: Pattern) -> Iterator[CreaseMatch]:
    """Every hinged crease of one pattern with every one of another that is as long."""
    for on, crease in still.creases.items():
        length = math.dist(*still.segment(on))
        for of, other in moving.creases.items():
            if crease.face is None or other.face is None or crease.closes != other.closes:
                continue
            if abs(length - math.dist(*moving.segment(of))) < SAME_POINT_SHARE * still.size:
                yield on, of
