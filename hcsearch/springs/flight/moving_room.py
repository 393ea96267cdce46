"""Room of panels that move about a root panel at rest: gaps to the body of the craft, and the box that panels sweep.

Swept boxes: docs/explanation/flight_stowage.md, 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.collision.least_gaps import least_pair_gap
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms, pairs_between
from hcsearch.motion.collision.panel_prisms import TOUCHING_DISTANCE, padded_table, prisms_of, scale_of
from hcsearch.scenes.scene import CraftBox
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import facet_area

SWEPT_RESOLUTION_SHARE = 1e-3
"""Greatest distance of a face of a swept box from the panels that come nearest to it, over the size of a panel."""


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


@dataclass(frozen=True)
class SweptBox:
    """A box that holds all panels at all times, m, along the axes of the flat sheet, and its least corner."""

    corner: tuple[float, float, float]
    sides: tuple[float, float, float]

    @property
    def volume(self) -> float:
        """The volume of the box, m^3."""
        return math.prod(self.sides)


def swept_box(linkage: Linkage, motion: Course, slack: float, root: int) -> SweptBox:
    """Return a box that holds all panels at all times of a motion, with the root panel where it lies when flat.

    slack : m, by which panels may be off their places. No face of the box is farther than the slack and
    `SWEPT_RESOLUTION_SHARE` of the pattern's size from where a panel comes. Steps are halved until the bound of panels
    between two places, by the chord and their accelerations, is as narrow. HcsearchError for a motion without a state.
    """
    if not len(motion.times):
        raise HcsearchError("a motion without a state sweeps nothing: give a state or more")
    panels = _Panels(linkage, root)
    resolution = SWEPT_RESOLUTION_SHARE * linkage.pattern.size
    reached = panels.extents(motion.angles)
    least, greatest = reached[:, 0].min(axis=(0, 1)), reached[:, 1].max(axis=(0, 1))
    low, high = least, greatest
    pieces = _control_points(motion)
    while len(pieces):
        ends = np.stack([panels.extents(pieces[:, 0]), panels.extents(pieces[:, -1])])
        off = panels.chord_errors(pieces)[..., None]
        lows = (ends[:, :, 0].min(axis=0) - off).min(axis=1)
        highs = (ends[:, :, 1].max(axis=0) + off).max(axis=1)
        least = np.minimum(least, ends[:, :, 0].min(axis=(0, 1, 2)))
        greatest = np.maximum(greatest, ends[:, :, 1].max(axis=(0, 1, 2)))
        loose = ((lows < least - resolution) | (highs > greatest + resolution)).any(axis=1)
        low = np.minimum(low, lows[~loose].min(axis=0, initial=math.inf))
        high = np.maximum(high, highs[~loose].max(axis=0, initial=-math.inf))
        pieces = _halved(pieces[loose])
    corner, sides = low - slack, high - low + 2.0 * slack
    return SweptBox(tuple(corner.tolist()), tuple(sides.tolist()))


class _Panels:
    """The prisms of a linkage as seen from its root panel."""

    def __init__(self, linkage: Linkage, root: int) -> None:
        self.linkage, self.root = linkage, root
        prisms = prisms_of(linkage)
        self.panels = prisms.panels
        # padded corners are replaced by the first one
        places = np.arange(prisms.vertices.shape[1])
        chosen = np.where(places < prisms.counts[:, :1], places, 0)
        self.corners = np.take_along_axis(prisms.vertices, chosen[..., None], axis=1)
        ways = pairs_between(linkage.chain, prisms, np.empty((0, 2), np.int64))
        self.ways = [_way(ways, root, int(panel)) for panel in self.panels]
        self.reaches = ways.reaches

    def extents(self, states: Reals) -> Reals:
        """Return the least and the greatest coordinates of each prism at states, (k, 2, n_prisms, 3), m."""
        poses = np.array([self.linkage.poses(state) for state in states])
        root, moved = poses[:, self.root], poses[:, self.panels]
        # rotations relative to the root, then corners turned by them: two products of matrices
        turns = root[:, None, :, :3].swapaxes(2, 3) @ moved[..., :3]
        shifts = (moved[..., 3] - root[:, None, :, 3]) @ root[:, :, :3]
        seen = self.corners @ turns.swapaxes(2, 3) + shifts[:, :, None]
        return np.stack([seen.min(axis=2), seen.max(axis=2)], axis=1)

    def chord_errors(self, pieces: Reals) -> Reals:
        """Return bounds of the distance of points of each prism from the chords of their ways, (n_pieces, n_prisms), m.

        pieces : (n_pieces, degree + 1, n_hinges), control points of the fold angles.
        """
        degree = pieces.shape[1] - 1
        rates = degree * np.abs(np.diff(pieces, axis=1)).max(axis=1)
        bends = degree * (degree - 1) * np.abs(np.diff(pieces, n=2, axis=1)).max(axis=1)
        errors = np.empty((len(pieces), len(self.panels)))
        for prism, way in enumerate(self.ways):
            w, a = rates[:, way], bends[:, way]
            before = np.cumsum(w, axis=1) - w
            errors[:, prism] = 0.125 * (a + w * (w + 2.0 * before)) @ self.reaches[prism, way]
        return errors


def _way(ways: PrismPairs, root: int, panel: int) -> WholeNumbers:
    """Return the hinges from the root panel to another one."""
    hinges, here = [], root
    while here != panel:
        hinges.append(int(ways.hinges[panel, here]))
        here = int(ways.nexts[panel, here])
    return np.array([hinge for hinge in hinges if hinge >= 0], np.int64)


def _control_points(motion: Course) -> Reals:
    """Return the control points of the fold angles in each step, as Bezier curves, (k - 1, 4 or 6, n_hinges)."""
    h = np.diff(motion.times)[:, None]
    start, end = motion.angles[:-1], motion.angles[1:]
    first, last = h * motion.rates[:-1], h * motion.rates[1:]
    if motion.cubic:
        return np.stack([start, start + first / 3.0, end - last / 3.0, end], axis=1)
    bend, last_bend = h * h * motion.accelerations[:-1] / 20.0, h * h * motion.accelerations[1:] / 20.0
    return np.stack(
        [
            *(start, start + first / 5.0, start + 0.4 * first + bend),
            *(end - 0.4 * last + last_bend, end - last / 5.0, end),
        ],
        axis=1,
    )


def _halved(pieces: Reals) -> Reals:
    """Return the control points of both halves of each curve, by the construction of de Casteljau."""
    firsts, lasts, points = [], [], pieces
    while points.shape[1]:
        firsts.append(points[:, 0])
        lasts.append(points[:, -1])
        points = 0.5 * (points[:, 1:] + points[:, :-1])
    return np.concatenate([np.stack(firsts, axis=1), np.stack(lasts[::-1], axis=1)])
