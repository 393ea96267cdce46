"""Panels shrunk by a margin, and the hinge paths between them, for proofs that two panels overlap."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.motion.collision.panel_prisms import check_margin, facet_pairs, padded_table, prisms_of
from hcsearch.shape.linkage import Linkage, hinge_tree

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
    """The shortest path between two panels across hinges in loops, and the shortest one without the hinges of that."""
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
