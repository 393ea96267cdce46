"""Layers of the panels of a packed state: each hinge joins panels in adjacent layers, and no layer is filled twice."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.search.own_patterns.drawn_linkages import overlapping_polygons
from hcsearch.shape.linkage import hinge_tree
from hcsearch.shape.pattern import PanelFace, Pattern

MAX_LAYER_STEPS = 200_000
"""Greatest number of panels that are placed in the search for layers."""


class LayerSearch:
    """The search for the layers of panels whose places are known.

    free : hinges that may be on either face. below : for each panel, the others that it lies on, seen from above.
    """

    def __init__(
        self, pattern: Pattern, closing: Sequence[bool], free: set[int], below: Sequence[Collection[int]]
    ) -> None:
        self.pattern, self.closing, self.free = pattern, closing, free
        self.tree = hinge_tree(pattern, 0)
        self.order = self.tree.order.tolist()
        self.ups = self._ups()
        self.below = below
        self.hinges_of: list[list[int]] = [[] for _ in pattern.panels]
        for k, hinge in enumerate(pattern.hinges):
            self.hinges_of[hinge.first].append(k)
            self.hinges_of[hinge.second].append(k)

    def _ups(self) -> list[int]:
        """Return 1 for panels whose top face is up in the packed state, else -1."""
        ups = [1] * len(self.pattern.panels)
        for panel in self.order[1:]:
            ups[panel] = ups[int(self.tree.parents[panel])] * (-1 if self.closing[int(self.tree.hinges[panel])] else 1)
        return ups

    def found(self) -> list[PanelFace] | str:
        """Return the faces of all hinges; where no layers are found, a clause on the panels that lie in none."""
        layers: dict[int, int] = {self.order[0]: 0}
        waiting = [self._options(self.order[1])]
        fault, deepest = "panels have no layers", 0
        for _ in range(MAX_LAYER_STEPS):
            depth = len(waiting)
            panel = self.order[depth]
            layers.pop(panel, None)
            if not waiting[-1]:
                waiting.pop()
                if not waiting:
                    return fault
                continue
            parent = int(self.tree.parents[panel])
            layer = layers[parent] + waiting[-1].pop()
            hindrance = self._hindrance(panel, layer, layers)
            if hindrance:
                if depth > deepest:
                    fault, deepest = hindrance, depth
                continue
            layers[panel] = layer
            if len(layers) == len(self.order):
                return [self._face(k, layers) for k in range(len(self.pattern.hinges))]
            waiting.append(self._options(self.order[depth + 1]))
        return f"no layers of the panels were found in {MAX_LAYER_STEPS:,} steps"

    def _options(self, panel: int) -> list[int]:
        """Return the steps in layers by which a panel may lie off its parent in the tree, the first choice last."""
        hinge = int(self.tree.hinges[panel])
        if not self.closing[hinge]:
            return [0]
        return [1, -1] if hinge in self.free else [self._step(hinge) * int(self.tree.signs[panel])]

    def _step(self, hinge: int) -> int:
        """Return the step in layers from the first panel of a closed hinge to its second."""
        joint = self.pattern.hinges[hinge]
        return self.ups[joint.first] * (1 if joint.face == "top" else -1)

    def _hindrance(self, panel: int, layer: int, layers: Mapping[int, int]) -> str:
        """Say what keeps a panel from a layer; empty where nothing does."""
        for k in self.hinges_of[panel]:
            joint = self.pattern.hinges[k]
            other = joint.second if joint.first == panel else joint.first
            if other not in layers:
                continue
            step = (layer - layers[other]) * (1 if joint.second == panel else -1)
            wanted = self._step(k) if self.closing[k] else 0
            fits = abs(step) == 1 if k in self.free and self.closing[k] else step == wanted
            if not fits:
                pair = f"panels {min(panel, other)} and {max(panel, other)}"
                if abs(step) == abs(wanted):
                    return f"{pair} would lie on the wrong side of each other for the face of their hinge"
                return f"{pair}, which a hinge joins, would lie {abs(step)} layers apart"
        for other in self.below[panel]:
            if layers.get(other) == layer:
                return f"panels {min(panel, other)} and {max(panel, other)} would share a layer"
        return ""

    def _face(self, hinge: int, layers: Mapping[int, int]) -> PanelFace:
        """Return the face of a hinge: the given one, or the one that leads from layer to layer."""
        joint = self.pattern.hinges[hinge]
        if hinge not in self.free:
            return joint.face
        return "bottom" if (layers[joint.second] - layers[joint.first]) * self.ups[joint.first] < 0 else "top"


def overlapping_panels(pattern: Pattern, shadows: Sequence[Reals], allowed: float) -> list[set[int]]:
    """Return for each panel the others whose shadows overlap its own by more than a share of the smaller facet."""
    overlapping: list[set[int]] = [set() for _ in pattern.panels]
    corners = [np.column_stack([shadow.real, shadow.imag]) for shadow in shadows]
    for facets in overlapping_polygons(corners, allowed):
        one, two = (pattern.panel_of[facet] for facet in facets)
        if one != two:
            overlapping[one].add(two)
            overlapping[two].add(one)
    return overlapping
