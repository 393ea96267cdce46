"""Mirror symmetry of a pattern about a line through its held panel: one half of a symmetric motion gives the other.

A reflection of the drawing that maps facets, creases and faces onto themselves maps top faces to top faces, so it is a
reflection of space in a vertical plane. A motion that begins symmetric, with equal springs at mirror hinges, stays so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True, eq=False)
class Mirror(ByValue):
    """A vertical mirror plane of a pattern.

    normal : unit vector in the plane of the drawing. point : on the mirror plane, m. panels, hinges : the image of
    each. beyond : whether each panel lies on the side opposite to the normal.
    """

    normal: Reals
    point: Reals
    panels: tuple[int, ...]
    hinges: tuple[int, ...]
    beyond: tuple[bool, ...]

    @property
    def frame(self) -> Reals:
        """The normal, and two directions in the plane, of which the second is up; unit vectors, (3, 3)."""
        upright = np.array([0.0, 0.0, 1.0])
        return np.array([self.normal, np.cross(upright, self.normal), upright])


def mirror_of(linkage: Linkage, held: int) -> Mirror | None:
    """Find a mirror plane of the pattern that maps the held panel onto itself; None where there is none.

    Mirrors of patterns with a hinge between a panel and its image are rejected, as that hinge lies in the plane.
    """
    centres = _centres(linkage)
    middle = centres.mean(axis=0)
    spread = np.linalg.norm(centres - middle, axis=1)
    farthest = int(spread.argmax())
    for k in np.flatnonzero(np.abs(spread - spread[farthest]) < 1e-6 * linkage.pattern.size):
        normal = centres[k] - centres[farthest]
        if k == farthest:  # the farthest facet maps onto itself: the line runs through it
            normal = np.array([-(centres[k] - middle)[1], (centres[k] - middle)[0]])
        if np.linalg.norm(normal) < 1e-9 * linkage.pattern.size:
            continue
        mirror = _checked(linkage, held, normal / np.linalg.norm(normal), middle)
        if mirror is not None:
            return mirror
    return None


def _centres(linkage: Linkage) -> Reals:
    return np.array([np.mean(facet, axis=0) for facet in linkage.pattern.facets])


def _checked(linkage: Linkage, held: int, normal: Reals, middle: Reals) -> Mirror | None:
    """Return the mirror with this normal if it maps the pattern and the held panel onto themselves, else None."""
    pattern = linkage.pattern
    step = 1e-4 * math.sqrt(pattern.area / len(pattern.facets))

    mirror = Isometry.mirror(complex(*middle), complex(*normal))

    def reflected(points: Reals) -> Reals:
        images = mirror(points[:, 0] + 1j * points[:, 1])
        return np.column_stack([images.real, images.imag])

    facets = _matched(_centres(linkage), reflected(_centres(linkage)), step)
    if facets is None or any(
        (image_crease := pattern.creases.get((min(facets[i], facets[j]), max(facets[i], facets[j])))) is None
        or image_crease != crease
        for (i, j), crease in pattern.creases.items()
    ):
        return None
    for facet, image in enumerate(facets):
        corners = reflected(np.array(pattern.facets[facet]))
        if _matched(np.array(pattern.facets[image]), corners, step) is None:
            return None
    panels = tuple(pattern.panel_of[facets[parts[0]]] for parts in pattern.panels)
    hinges = _matched(linkage.points[:, :2], reflected(linkage.points[:, :2]), step)
    if panels[held] != held or hinges is None:
        return None
    if any(panels[hinge.first] == hinge.second for hinge in pattern.hinges):
        return None
    sides = (_centres(linkage) - middle) @ normal
    beyond = tuple(
        panels[panel] != panel and float(sides[list(parts)].mean()) < 0.0 for panel, parts in enumerate(pattern.panels)
    )
    return Mirror(np.array([*normal, 0.0]), np.array([*middle, 0.0]), panels, tuple(hinges), beyond)


def _matched(points: Reals, images: Reals, step: float) -> Sequence[int] | None:
    """Match each image to the nearest point; None unless the match is one-to-one and within `step`."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - takes longer to load than a deployment to compute

    distances, nearest = cKDTree(points).query(images)
    if not len(images) or distances.max() > step or len(set(nearest.tolist())) < len(images):
        return None
    return [int(k) for k in nearest]
