"""Obvious twins of the search for distances: all features of two hulls against each other."""

import itertools

import numpy as np


def feature_distance(one, two):
    """Distance of two hulls that do not overlap: points to triangles of three points, and edges to edges."""
    least = np.inf
    for a, b in ((one, two), (two, one)):
        corners = np.array(list(itertools.combinations_with_replacement(b, 3)))
        points = np.repeat(a, len(corners), axis=0)
        least = min(least, points_to_triangles(points, np.tile(corners, (len(a), 1, 1))).min())
    edges = [np.array(list(itertools.combinations_with_replacement(solid, 2))) for solid in (one, two)]
    first, second = np.repeat(edges[0], len(edges[1]), axis=0), np.tile(edges[1], (len(edges[0]), 1, 1))
    return min(least, edges_to_edges(first, second).min())


def points_to_triangles(points, triangles):
    """Distances: to the foot on the plane where that lies within, else to the nearest side.

    The distance to a foot that is a little off is off by its square; the height along a normal is not, and normals of
    thin triangles are rounded most.
    """
    least = np.full(len(points), np.inf)
    for i in range(3):
        least = np.minimum(least, points_to_edges(points, triangles[:, [i, (i + 1) % 3]]))
    a, e, f = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(e, f)
    area = (normal**2).sum(1)
    fat = area > 1e-24 * (e**2).sum(1) * (f**2).sum(1)
    r, area = points - a, np.where(fat, area, 1.0)
    s = (np.cross(r, f) * normal).sum(1) / area
    t = (np.cross(e, r) * normal).sum(1) / area
    inside = fat & (s >= 0) & (t >= 0) & (s + t <= 1)
    ways = r - s[:, None] * e - t[:, None] * f
    return np.where(inside, np.minimum(least, np.linalg.norm(ways, axis=1)), least)


def points_to_edges(points, edges):
    e = edges[:, 1] - edges[:, 0]
    long = (e**2).sum(1)
    t = ((points - edges[:, 0]) * e).sum(1) / np.where(long > 0, long, 1.0)
    return np.linalg.norm(points - edges[:, 0] - np.clip(t, 0, 1)[:, None] * e, axis=1)


def edges_to_edges(one, two):
    """Distances: between the feet on both lines where they lie within, else from an end."""
    least = np.full(len(one), np.inf)
    for a, b in ((one, two), (two, one)):
        for k in range(2):
            least = np.minimum(least, points_to_edges(a[:, k], b))
    e, f, r = one[:, 1] - one[:, 0], two[:, 1] - two[:, 0], two[:, 0] - one[:, 0]
    normal = np.cross(e, f)
    area = (normal**2).sum(1)
    skew = area > 1e-24 * (e**2).sum(1) * (f**2).sum(1)
    area = np.where(skew, area, 1.0)
    s = (np.cross(r, f) * normal).sum(1) / area
    t = (np.cross(r, e) * normal).sum(1) / area
    inside = skew & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    ways = r + t[:, None] * f - s[:, None] * e
    return np.where(inside, np.minimum(least, np.linalg.norm(ways, axis=1)), least)


def overlap_along_all(one, two):
    """Least overlap of two hulls along the normals of all triangles, across all pairs of edges and all pairs of points.

    Below 0 where they are apart.
    """
    axes = [np.array([b - a for a in one for b in two])]
    spans = [np.array([q - p for p, q in itertools.combinations(solid, 2)]).reshape(-1, 3) for solid in (one, two)]
    for e, f in ((spans[0], spans[0]), (spans[1], spans[1]), (spans[0], spans[1])):
        axes.append(np.cross(e[:, None], f[None]).reshape(-1, 3))
    axes = np.concatenate(axes)
    size = np.linalg.norm(axes, axis=1)
    axes = axes[size > 1e-9 * size.max()]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    a, b = axes @ one.T, axes @ two.T
    return float(np.minimum(a.max(1) - b.min(1), b.max(1) - a.min(1)).min())
