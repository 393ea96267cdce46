"""Panels and hinges of a linkage as a tree of bodies: loops are cut through panels, so every hinge is a tree joint.

The panel at which a breadth-first tree from the held panel closes a loop is cut into two bodies of half its mass that
are welded; a panel at which k loops close is cut into k + 1 bodies. Springs, dampers and stops then act in joints only.
Air acts on the facets of panels.

A pattern may be symmetric about a line through its held panel, so that one half of a symmetric motion gives the other:
a reflection of the drawing that maps facets, creases and faces onto themselves maps top faces to top faces, so it is a
reflection of space in a vertical plane. A motion that begins symmetric, with equal springs at mirror hinges, stays so.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, joined_body, prism_body
from hcsearch.springs.dynamics.system import FacetDrag


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
        """The normal and two directions in the plane, the second one up; unit vectors, (3, 3)."""
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


@dataclass(frozen=True, eq=False)
class PanelTree(ByValue):
    """The joints, bodies and welds of a linkage.

    joint_of : (n_hinges,), the joint of each hinge, whose coordinate is the fold angle; -1 where the hinge is cut.
    body_of : (n_panels,), a body of each panel, GROUND for the held one.
    cuts : hinges that are cut (instead of panels), with the bodies of their first and second panels.
    shares : (n_joints,), 1/2 where the mirror plane halves the joint, else 1.
    hinge_of : (n_joints,), a hinge of each joint.
    """

    joints: tuple[TreeJoint, ...]
    bodies: tuple[Body, ...]
    welds: tuple[Weld, ...]
    joint_of: WholeNumbers
    body_of: WholeNumbers
    cuts: tuple[tuple[int, int, int], ...]
    shares: Reals
    hinge_of: WholeNumbers


def panel_bodies(linkage: Linkage, density: float) -> list[Body]:
    """Return the mass properties of each panel; density in kg/m^3."""
    pattern = linkage.pattern
    return [
        joined_body(prism_body(pattern.facets[facet], pattern.thickness, density) for facet in facets)
        for facets in pattern.panels
    ]


def panel_tree(
    linkage: Linkage,
    density: float,
    held: int = 0,
    *,
    cut_hinges: bool = False,
    mirror: Mirror | None = None,
    halved_leaf: bool = False,
) -> PanelTree:
    """Build the tree of a linkage with one panel held.

    cut_hinges : whether loops are cut at hinges, as in the thesis (4.1.2), and not through panels.
    halved_leaf : whether the last panel is cut into two halves on the same hinge, which are welded.
    mirror : if given, only one half is modelled: panels across the mirror are halved and stay in its plane, and mirror
    hinges share a joint.
    """
    panels = panel_bodies(linkage, density)
    hinges = linkage.pattern.hinges
    steps = _steps(linkage, held, mirror)
    if halved_leaf and steps:
        steps.append(steps[-1]._replace(closes=True))
    cuts = [step.hinge for step in steps if step.closes and cut_hinges]
    steps = [step for step in steps if not (step.closes and cut_hinges)]
    copies = np.bincount([step.after for step in steps], minlength=len(panels))
    joints, bodies, welds = [], [], []
    body_of = np.full(len(panels), GROUND)
    joint_of = np.full(len(hinges), -1)
    shares = np.ones(len(steps))
    for i, step in enumerate(steps):
        sense = 1.0 if hinges[step.hinge].first == step.before else -1.0
        axis, point = sense * linkage.directions[step.hinge], linkage.points[step.hinge]
        joints.append(TreeJoint(int(body_of[step.before]), axis, point))
        across = mirror is not None and mirror.panels[step.after] == step.after
        bodies.append(panels[step.after].share((0.5 if across else 1.0) / copies[step.after]))
        joint_of[step.hinge] = i
        if mirror is not None:
            joint_of[mirror.hinges[step.hinge]] = i
            shares[i] = 0.5 if mirror.hinges[step.hinge] == step.hinge else 1.0
        if step.closes:
            welds.append(Weld(int(body_of[step.after]), i, panels[step.after].centre))
        else:
            body_of[step.after] = i
            if mirror is not None and across and shares[i] == 1.0:
                welds.append(_kept_in(mirror, i))
    ends = tuple((k, int(body_of[hinges[k].first]), int(body_of[hinges[k].second])) for k in cuts)
    hinge_of = np.array([step.hinge for step in steps], np.int64)
    return PanelTree(tuple(joints), tuple(bodies), tuple(welds), joint_of, body_of, ends, shares, hinge_of)


def _kept_in(mirror: Mirror, body: int) -> Weld:
    """Return a weld that keeps a body in the mirror plane: no gap along its normal, no turn about directions in it."""
    return Weld(GROUND, body, mirror.point, (1, 2, 3), mirror.frame)


class _Step(NamedTuple):
    """A hinge visited from one panel to another in a traversal; the step closes a loop where the latter is visited."""

    before: int
    after: int
    hinge: int
    closes: bool


def _steps(linkage: Linkage, held: int, mirror: Mirror | None) -> list[_Step]:
    """Return all hinges in the order of a breadth-first traversal; with a mirror, one of each pair."""
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(linkage.n_panels)]
    for k, hinge in enumerate(linkage.pattern.hinges):
        neighbours[hinge.first].append((hinge.second, k))
        neighbours[hinge.second].append((hinge.first, k))
    steps: list[_Step] = []
    visited, used_hinges = {held}, set()
    queue = deque([held])
    while queue:
        panel = queue.popleft()
        for neighbour, hinge_between in neighbours[panel]:
            target, k = neighbour, hinge_between
            if mirror is not None and mirror.beyond[target]:
                target, k = mirror.panels[target], mirror.hinges[k]
            if k in used_hinges:
                continue
            used_hinges.add(k)
            steps.append(_Step(panel, target, k, target in visited))
            if target not in visited:
                visited.add(target)
                queue.append(target)
    return steps


def _radon_rule() -> tuple[Reals, Reals]:
    """Return barycentric coordinates, (7, 3), and weights, (7,), whose sum is 1 (Radon 1948)."""
    points, weights = [(1 / 3, 1 / 3, 1 / 3)], [9 / 40]
    for sign in (1.0, -1.0):
        near, weight = (6.0 + sign * math.sqrt(15.0)) / 21.0, (155.0 + sign * math.sqrt(15.0)) / 1200.0
        far = 1.0 - 2.0 * near
        points += [(far, near, near), (near, far, near), (near, near, far)]
        weights += [weight] * 3
    return np.array(points), np.array(weights)


_POINTS, _WEIGHTS = _radon_rule()


def facet_drag(body: int, corners: Sequence[tuple[float, float]], thickness: float, drag: float) -> FacetDrag:
    """Return the drag on the middle plane of a facet with counterclockwise corners, m.

    The facet is divided into triangles from its middle to its edges, with Radon's rule of seven points in each, which
    is exact up to the fifth degree: for force and moment of all motions in which the whole facet moves to one side of
    its plane, and to 2 % where it does not. Mirror images of facets have the mirror images of the points, so that
    symmetric motions stay symmetric.
    drag : density of the air times drag coefficient, kg/m^3.
    """
    ring = np.array(corners, float)
    middle, following = ring.mean(axis=0), np.roll(ring, -1, axis=0)
    triangles = np.stack([np.broadcast_to(middle, ring.shape), ring, following], axis=1)  # (k, 3, 2)
    first, second = ring - middle, following - middle
    areas = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    flat = np.einsum("pc,kcx->kpx", _POINTS, triangles).reshape(-1, 2)
    points = np.column_stack([flat, np.full(len(flat), 0.5 * thickness)])
    return FacetDrag(body, np.array([0.0, 0.0, 1.0]), points, 0.5 * drag * np.outer(areas, _WEIGHTS).ravel())
