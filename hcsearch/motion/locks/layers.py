"""Contacts between the layers of a folded state: where panels lie on each other, and how hinges part them there.

Folded, every panel lies flat in a layer and every hinge is level. So the points of a panel rise, to first order, by an
affine function of their place in the plan: the sum of what the hinges between it and the panel that stays do. Two
panels that touch must not come nearer to each other anywhere where they do; at the corners of that area is enough.
Panels of one stack share hinges and their stops say the same (docs/explanation/theory.md, 26); in general linkages they
need not. Side walls that touch are left out: panels have some clearance there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.equality import ByValue
from hcsearch.shape.hinge_trees import hinge_tree
from hcsearch.shape.linkage import Linkage

TOUCHING_LAYER_SHARE = 1e-3
"""Layers nearer than this share of the thickness touch; folded states have them at whole multiples of it."""
CONTACT_GRID_SHARE = 1e-12
"""Areas in which facets touch are cut on a grid as fine as this share of a panel's size; without one, triangles that
lie beside each other but for rounding are taken for one."""
MIN_CONTACT_SHARE = 1e-8
"""What is shorter or smaller than this share of a panel is rounding, and facets touch there along an edge at most."""
MIN_PARTING_SHARE = 1e-9
"""A hinge parts two panels where, turned by 1 rad, it changes their height by more than this share of their size."""


@dataclass(frozen=True, eq=False)
class LayerContact(ByValue):
    """A facet that lies on a facet of another panel in the folded state.

    corners : of the area in which they touch, seen from above, shape (k, 2), in metres, where the base panel stays.
    """

    below: int
    above: int
    corners: Reals


def layer_contacts(linkage: Linkage) -> list[LayerContact]:
    """All facets that lie on facets of other panels in the folded state, but not across a crease.

    Across a crease a facet lies on one side of the hinge, and the stop keeps it from what it lies on.
    """
    import shapely  # noqa: PLC0415 - takes longer to load than most proofs take

    size, thickness, panel = linkage.pattern.size, linkage.pattern.thickness, np.array(linkage.pattern.panel_of)
    solids = linkage.solids(linkage.folded)
    low, high = (np.array([end(solid, axis=(0, 1)) for solid in solids]) for end in (np.min, np.max))
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    touch = (np.abs(shared[..., 2]) < TOUCHING_LAYER_SHARE * thickness) & (
        shared[..., :2] > MIN_CONTACT_SHARE * size
    ).all(axis=2)
    touch &= (panel[:, None] != panel) & (low[:, None, 2] < low[:, 2])
    for i, j in linkage.pattern.creases:
        touch[i, j] = touch[j, i] = False
    below, above = np.nonzero(touch)
    shadows = np.array([shapely.Polygon(solid[0, :, :2] / size) for solid in solids])
    # convex but for rounding, which may leave lines along edges
    areas = shapely.convex_hull(shapely.intersection(shadows[below], shadows[above], grid_size=CONTACT_GRID_SHARE))
    return [
        LayerContact(i, j, shapely.get_coordinates(area.exterior)[:-1] * size)
        for i, j, area in zip(below.tolist(), above.tolist(), areas, strict=True)
        if area.area > MIN_CONTACT_SHARE
    ]


def parting_rates(linkage: Linkage, touching: list[LayerContact]) -> Reals:
    """How fast hinges that leave their stops by 1 rad a unit of time part panels, at all corners of some contacts.

    Shape (n_corners, n_hinges), as shares of the pattern's size; rows of different corners of one contact follow each
    other. Panels that no hinges join have zeros.
    """
    panel, rise = linkage.pattern.panel_of, _rise(linkage)
    # the shortest way between two panels that share a hinge is that hinge, and their row has no other entry
    trees = {base: hinge_tree(linkage.pattern, base) for base in {panel[contact.below] for contact in touching}}
    rows = [np.zeros((0, linkage.n_hinges))]
    for contact in touching:
        apart = np.zeros((linkage.n_hinges, 3))
        base, other = panel[contact.below], panel[contact.above]
        if trees[base].roots[other] == base:
            for k, sign in trees[base].way(other):
                apart[k] = sign * rise[k]
        corners = contact.corners / linkage.pattern.size
        rows.append(np.c_[corners, np.ones(len(corners))] @ apart.T)
    return np.concatenate(rows)


def _rise(linkage: Linkage) -> Reals:
    """What each hinge does to heights as it leaves its stop in the folded state, shape (n_hinges, 3).

    Seen from its first panel the second rises by a x + b y + c at a point (x, y) of the plan, all in units of size.
    """
    first = [hinge.first for hinge in linkage.pattern.hinges]
    poses = linkage.poses(linkage.folded)[first]
    u = np.einsum("kij,kj->ki", poses[:, :, :3], linkage.directions)
    p = (np.einsum("kij,kj->ki", poses[:, :, :3], linkage.points) + poses[:, :, 3]) / linkage.pattern.size
    senses = np.where(linkage.folded > 0.0, -1.0, 1.0)
    # the third component of u x (r - p)
    rises: Reals = senses[:, None] * np.stack([-u[:, 1], u[:, 0], u[:, 1] * p[:, 0] - u[:, 0] * p[:, 1]], axis=1)
    return rises


def contact_rows(linkage: Linkage) -> Reals:
    """Contacts of the folded state as conditions C x >= 0 on the turns x >= 0 of its hinges, as `lock_at` takes them.

    Shape (n_conditions, n_hinges), as shares of the pattern's size; none twice, and none that x >= 0 implies.
    """
    rows = parting_rates(linkage, layer_contacts(linkage))
    rows[np.abs(rows) < MIN_PARTING_SHARE] = 0.0
    rows = rows[(rows < 0.0).any(axis=1)]
    _, chosen = np.unique(rows.round(9), axis=0, return_index=True)
    distinct: Reals = rows[np.sort(chosen)]
    return distinct
