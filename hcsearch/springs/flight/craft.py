"""Gaps between panels and the body of the craft along a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.collision.least_gaps import least_pair_gap
from hcsearch.kernels.linkage.prisms import Prisms, pairs_between
from hcsearch.motion.collision.panel_prisms import TOUCHING_DISTANCE, padded_table, prisms_of, scale_of
from hcsearch.scenes.scene import CraftBox
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import facet_area


def craft_clearance(linkage: Linkage, motion: Course, slack: float, craft: Sequence[CraftBox], root: int) -> float:
    """Return a lower bound of the gaps between panels and the craft at all times of a motion, m; negative for overlap.

    slack : m, by which panels may be off their places. craft : boxes, fixed to the root panel, which is left out.
    HcsearchError without boxes, and for an array of one panel.
    """
    if not craft or linkage.n_panels < 2:
        raise HcsearchError("there is nothing to keep apart: give boxes of the craft, and two panels or more")
    panels = prisms_of(linkage)
    solids = _with_boxes(panels, _placed(linkage, craft, root), root)
    first = len(panels.panels)
    moving = np.flatnonzero(panels.panels != root)
    pairs = np.array([(facet, first + k) for k in range(len(craft)) for facet in moving.tolist()], np.int64)
    resolution = TOUCHING_DISTANCE * scale_of(linkage)
    least = least_pair_gap(linkage.chain, solids, pairs_between(linkage.chain, solids, pairs), motion, resolution)
    return float(least) - resolution - 2.0 * slack


def placed_solids(linkage: Linkage, state: Reals, root: int) -> list[Reals]:
    """Return the corners of each facet's prism, (n_corners, 3), m, with the root panel where it lies when flat."""
    pose = linkage.poses(state)[root]
    return [(solid.reshape(-1, 3) - pose[:, 3]) @ pose[:, :3] for solid in linkage.solids(state)]


def craft_corners(linkage: Linkage, craft: Sequence[CraftBox], root: int) -> list[Reals]:
    """Return the corners of each box of the craft in the axes of the flat sheet, (8, 3), m."""
    boxes = _placed(linkage, craft, root)
    return [np.array([(box[i, 0], box[j, 1], box[k, 2]) for i, j, k in np.ndindex(2, 2, 2)]) for box in boxes]


def _placed(linkage: Linkage, craft: Sequence[CraftBox], root: int) -> Reals:
    """Return the least and the greatest corner of each box in the axes of the flat sheet, (n_boxes, 2, 3), m."""
    facets = [linkage.pattern.facets[k] for k in linkage.pattern.panels[root]]
    areas = np.array([facet_area(facet) for facet in facets])
    middles = np.array([_centroid(np.array(facet)) for facet in facets])
    origin = np.array([*(areas @ middles / areas.sum()), 0.0])
    corners = np.array(craft, float).reshape(-1, 2, 3)
    least: Reals = origin + corners[:, 0]
    return np.stack([least, least + corners[:, 1]], axis=1)


def _centroid(corners: Reals) -> Reals:
    """Return the centroid of a polygon, (2,)."""
    x, y = corners.T
    after = np.roll(corners, -1, axis=0).T
    crossed = x * after[1] - after[0] * y
    centroid: Reals = ((corners + after.T) * crossed[:, None]).sum(axis=0) / (3.0 * crossed.sum())
    return centroid


def _with_boxes(panels: Prisms, boxes: Reals, root: int) -> Prisms:
    """Return the prisms of panels, and after them the boxes, which move with the root panel."""
    base = ((0, 0), (1, 0), (1, 1), (0, 1))
    corners = [np.array([(box[i, 0], box[j, 1], box[k, 2]) for k in (0, 1) for i, j in base]) for box in boxes]
    count, axes = len(boxes), np.eye(3)
    middles = boxes.mean(axis=1)

    def joined(table: Reals, rows: list[Reals]) -> Reals:
        return padded_table([*table, *rows])

    return Prisms(
        panels=np.concatenate([panels.panels, np.full(count, root, np.int64)]),
        counts=np.concatenate([panels.counts, np.tile(np.array([[8, 3]], np.int64), (count, 1))]),
        vertices=joined(panels.vertices, corners),
        middles=np.concatenate([panels.middles, middles]),
        reaches=np.concatenate([panels.reaches, np.linalg.norm(boxes[:, 1] - middles, axis=1)]),
        normals=joined(panels.normals, [axes] * count),
        edges=joined(panels.edges, [axes] * count),
    )
