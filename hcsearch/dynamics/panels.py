"""Panels and hinges of a linkage as a tree: loops are cut through panels, so that every hinge is a joint of the tree.

The panel at which a breadth-first tree from the held panel closes a loop is cut into two bodies of half its mass that
are welded; of a panel where k loops close there are k + 1. Springs, dampers and stops then act in joints only.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.dynamics.bodies import Body, joined, prism
from hcsearch.dynamics.trees import GROUND, Joint, Weld
from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class PanelTree:
    """The joints, bodies and welds of a linkage.

    joint_of : (n_hinges,), the joint of each hinge; its coordinate is the fold angle.
    body_of : (n_panels,), a body of each panel, GROUND for the held one.
    """

    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    welds: tuple[Weld, ...]
    joint_of: Whole
    body_of: Whole


def panel_bodies(linkage: Linkage, density: float) -> list[Body]:
    """Mass properties of each panel; density in kg/m^3."""
    pattern = linkage.pattern
    return [
        joined(prism(pattern.facets[facet], pattern.thickness, density) for facet in facets)
        for facets in pattern.panels
    ]


def panel_tree(linkage: Linkage, density: float, held: int = 0) -> PanelTree:
    """The tree of a linkage with one panel held."""
    n = linkage.n_panels
    panels = panel_bodies(linkage, density)
    around: list[list[tuple[int, int]]] = [[] for _ in range(n)]
    for k, hinge in enumerate(linkage.pattern.hinges):
        around[hinge.first].append((hinge.second, k))
        around[hinge.second].append((hinge.first, k))
    # (panel before, panel after, hinge) in the order of the tree; hinges that close a loop come where they are met
    steps: list[tuple[int, int, int]] = []
    seen, used = {held}, set()
    waiting = deque([held])
    while waiting:
        panel = waiting.popleft()
        for to, k in around[panel]:
            if k in used:
                continue
            used.add(k)
            steps.append((panel, to, k))
            if to not in seen:
                seen.add(to)
                waiting.append(to)
    copies = np.bincount([to for _, to, _ in steps], minlength=n)
    joints, bodies, welds = [], [], []
    body_of = np.full(n, GROUND)
    joint_of = np.zeros(linkage.n_hinges, np.int64)
    for i, (panel, to, k) in enumerate(steps):
        hinge = linkage.pattern.hinges[k]
        sense = 1.0 if hinge.first == panel else -1.0
        joints.append(Joint(int(body_of[panel]), sense * linkage.directions[k], linkage.points[k]))
        bodies.append(panels[to].share(1.0 / max(copies[to], 1)))
        joint_of[k] = i
        if to != held and body_of[to] == GROUND:
            body_of[to] = i
        else:
            welds.append(Weld(int(body_of[to]), i, panels[to].centre))
    return PanelTree(tuple(joints), tuple(bodies), tuple(welds), joint_of, body_of)
