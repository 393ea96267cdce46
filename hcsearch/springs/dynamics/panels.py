"""Panels and hinges of a linkage as a tree of bodies: loops are cut through panels, so every hinge is a tree joint.

The panel at which a breadth-first tree from the held panel closes a loop is cut into two bodies of half its mass that
are welded; a panel at which k loops close is cut into k + 1 bodies. Springs, dampers and stops then act in joints only.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, joined_body, prism_body
from hcsearch.springs.dynamics.mirror import Mirror


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
