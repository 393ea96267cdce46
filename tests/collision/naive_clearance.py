"""Obvious twins of certified clearance: motions evaluated by SciPy, prisms shrunk by shapely, and many states."""

import math
from functools import cache
from itertools import combinations, pairwise

import numpy as np
import shapely
from scipy.interpolate import BPoly

from hcsearch.kernels.collision.gjk import hull_gap
from hcsearch.kernels.collision.intervals import Course
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern


def chain(lengths, faces, width=0.03, thickness=0.004):
    """An open chain of rectangles side by side, along x, with hinges on the given faces between them."""
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    facets = tuple(((a, 0.0), (b, 0.0), (b, width), (a, width)) for a, b in pairwise(ends))
    return Linkage(Pattern.from_polygons(facets, {(k, k + 1): Crease(face) for k, face in enumerate(faces)}, thickness))


def fan(sides=(5, 3, 8), radius=0.03, thickness=0.005):
    """Panels with different numbers of corners around one of six, hinged on its bottom, top and bottom."""
    turns = 2 * math.pi * np.arange(6) / 6
    middle = [(radius * math.cos(t), radius * math.sin(t)) for t in turns]
    facets, creases = [tuple(middle)], {}
    for k, n in enumerate(sides):
        (ax, ay), (bx, by) = middle[2 * k], middle[2 * k + 1]
        # a regular polygon on the other side of the edge from a to b
        points, turn = [(bx, by), (ax, ay)], math.atan2(ay - by, ax - bx)
        for _ in range(n - 2):
            turn += 2 * math.pi / n
            points.append((points[-1][0] + radius * math.cos(turn), points[-1][1] + radius * math.sin(turn)))
        facets.append(tuple(points))
        creases[0, k + 1] = Crease("top" if k % 2 else "bottom")
    return Linkage(Pattern.from_polygons(tuple(facets), creases, thickness))


def random_course(rng, linkage, steps, *, size=1.5, cubic=False):
    """States and times of a motion that wanders about the flat state."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.1, steps))])
    shape = (steps + 1, linkage.n_hinges)
    rates, accelerations = 20.0 * size * rng.normal(size=shape), 400.0 * size * rng.normal(size=shape)
    return Course(times, size * rng.normal(size=shape), rates, accelerations * (not cubic), cubic)


def polynomial(course, k):
    """The fold angles in a step, of its time (s)."""
    h = course.times[k + 1] - course.times[k]
    rows = [course.angles, course.rates] + ([] if course.cubic else [course.accelerations])
    return BPoly.from_derivatives([0.0, h], [[row[k] for row in rows], [row[k + 1] for row in rows]])


def moments(course, count):
    """Times and fold angles of a motion, count of them in each step from its state on, and the last state."""
    times, angles = [], []
    for k in range(len(course.times) - 1):
        h = course.times[k + 1] - course.times[k]
        if h > 0.0:
            inside = np.arange(count) / count * h
            times.append(course.times[k] + inside)
            angles.append(polynomial(course, k)(inside))
    return np.concatenate([*times, course.times[-1:]]), np.concatenate([*angles, course.angles[-1:]])


def pairs_looked_at(linkage, apart=()):
    """Pairs of facets whose panels may collide."""
    panel = linkage.pattern.panel_of
    return [
        (f, g)
        for f, g in combinations(range(len(panel)), 2)
        if panel[f] != panel[g] and (min(panel[f], panel[g]), max(panel[f], panel[g])) not in apart
    ]


def hinged(linkage):
    return {(hinge.first, hinge.second) for hinge in linkage.pattern.hinges}


@cache
def shrunk_prism(facet, thickness, margin):
    """Corners of a facet's prism with every face moved inwards, where it lies in the pattern."""
    ring = shapely.Polygon(facet).buffer(-margin, join_style="mitre", mitre_limit=1e6).exterior.coords[:-1]
    return np.array([(x, y, z) for z in (margin, thickness - margin) for x, y in ring])


def shrunk_solids(linkage, angles, margin):
    """Corners of each facet's prism with every face moved inwards."""
    prisms = [shrunk_prism(facet, linkage.pattern.thickness, margin) for facet in linkage.pattern.facets]
    poses = linkage.poses(angles)[list(linkage.pattern.panel_of)]
    return [prism @ pose[:, :3].T + pose[:, 3] for prism, pose in zip(prisms, poses, strict=True)]


def hull_distance(one, two):
    """Distance of two hulls, 0 where they touch or overlap, and the unit direction that certifies it."""
    gap, way, _ = hull_gap(one, len(one), two, len(two), (0.0, 0.0, 0.0), (-1, -1, -1, -1))
    return max(gap, 0.0), *way


def distance(one, two):
    """Distance of two hulls; the direction that comes with it proves that it is no less."""
    least, *way = hull_distance(one, two)
    gap = (two @ way).min() - (one @ way).max()
    assert least == max(gap, 0.0) or abs(least - gap) < 1e-15
    return least


def gaps(linkage, states, pairs, margin=0.0):
    """Distances of pairs of facets at some states, shape (n_states, n_pairs)."""
    gaps = np.empty((len(states), len(pairs)))
    for i, angles in enumerate(states):
        solids = shrunk_solids(linkage, angles, margin)
        gaps[i] = [distance(solids[f], solids[g]) for f, g in pairs]
    return gaps


def smallest_dip(table, marked, rise):
    """The smallest of some gaps, (n_times, n_pairs), with gaps wider by the rise before and after, at marked times."""
    least = math.inf
    for gap in table.T:
        states = np.where(marked, gap, -math.inf)
        before, after = np.maximum.accumulate(states), np.maximum.accumulate(states[::-1])[::-1]
        counted = np.minimum(before, after) >= gap + rise
        least = min(least, gap[counted].min(initial=math.inf))
    return least
