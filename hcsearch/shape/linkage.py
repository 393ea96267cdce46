"""Linkages: the panels and hinges of a flat pattern in space, their trees and loops, closure and its derivatives.

The flat state is the reference: every fold angle is 0 there and pi where a hinge is closed, so the dihedral angle of
the thesis is phi = pi - angle. Positive angles close the face that carries the hinge. Top faces of the flat state lie
at z = thickness, bottom faces at z = 0.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError, expect_kind
from hcsearch.kernels.linkage.loops import Chain, bend_loops, close_loops, place_panels
from hcsearch.shape.pattern import Pattern


def at_stops(angles: Reals) -> Flags:
    """Flags of the hinges that are at a stop, 0 or pi, exactly."""
    flags: Flags = (angles == 0.0) | (angles == math.pi)
    return flags


class HingeTree(NamedTuple):
    """A breadth-first forest of a pattern's panels, with one tree for each connected part.

    order : of panels, breadth-first. roots : (n_panels,), the root of each panel's tree. parents, hinges, signs :
        (n_panels,), the parent of each panel, the hinge between them, and 1 where the panel is the hinge's second one,
        else -1; -1, -1 and 0 for a root.
    """

    order: WholeNumbers
    roots: WholeNumbers
    parents: WholeNumbers
    hinges: WholeNumbers
    signs: WholeNumbers

    def way(self, panel: int) -> list[tuple[int, int]]:
        """The path of hinges from the root to a panel, with their signs."""
        steps = []
        while self.parents[panel] >= 0:
            steps.append((int(self.hinges[panel]), int(self.signs[panel])))
            panel = int(self.parents[panel])
        return steps[::-1]


def hinge_tree(pattern: Pattern, base: int, without: Container[int] = ()) -> HingeTree:
    """The breadth-first tree from a base panel, and of other parts, across hinges other than those of `without`."""
    n = len(pattern.panels)
    joined: list[list[tuple[int, int, int]]] = [[] for _ in range(n)]
    for k, hinge in enumerate(pattern.hinges):
        if k in without:
            continue
        joined[hinge.first].append((hinge.second, k, 1))
        joined[hinge.second].append((hinge.first, k, -1))
    parents, hinges, signs = np.full(n, -2), np.full(n, -1), np.zeros(n, np.int64)
    roots = np.zeros(n, np.int64)
    order: list[int] = []
    for root in (base, *range(n)):  # one tree for each connected part
        if parents[root] != -2:
            continue
        parents[root] = -1
        waiting = deque([root])
        while waiting:
            panel = waiting.popleft()
            order.append(panel)
            roots[panel] = root
            for to, hinge, sign in joined[panel]:
                if parents[to] == -2:
                    parents[to], hinges[to], signs[to] = panel, hinge, sign
                    waiting.append(to)
    return HingeTree(np.array(order), roots, parents, hinges, signs)


Walk = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class CongruentLinkage(ByValue):
    """A linkage that is congruent to another one, and the congruence: a rotation, reflection or half turn.

    panels, hinges : the corresponding panel and hinge for each one of the other linkage. turn : shape (3, 3), the
    matrix that maps directions in space from the other linkage to this one.
    """

    linkage: Linkage
    panels: tuple[int, ...]
    hinges: tuple[int, ...]
    turn: Reals

    @staticmethod
    def of(pattern: Pattern, linkage: Linkage, facets: Sequence[int], turn: Reals) -> CongruentLinkage:
        """The congruence of a pattern's linkage to another linkage. facets : the other's facet for each facet."""
        other = linkage.pattern
        panels, hinges = [0] * len(pattern.panels), [0] * len(pattern.hinges)
        for facet, image in enumerate(facets):
            panels[pattern.panel_of[facet]] = other.panel_of[image]
        for pair, crease in pattern.creases.items():
            if crease.face is not None:
                first, second = sorted(facets[facet] for facet in pair)
                hinges[pattern.hinge_of(pair)] = other.hinge_of((first, second))
        return CongruentLinkage(linkage, tuple(panels), tuple(hinges), turn)


@dataclass(frozen=True, repr=False)
class Linkage:
    """The panels and hinges of a pattern in space; fold angles are in rad, lengths in metres.

    Parameters
    ----------
    pattern
        The flat pattern, with its hinges.
    base
        The panel that is fixed in space.
    made_by
        A Python expression that gives an equal linkage, or empty.
    twin
        The congruent linkage that is simulated in place of this one, so that no verdict depends on how a circuit is
        written; None where this one is simulated itself.
    """

    pattern: Pattern
    base: int = 0
    made_by: str = field(default="", compare=False)
    twin: CongruentLinkage | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        expect_kind("the pattern of a linkage", self.pattern, Pattern, "a Pattern, or use Folding.linkage")
        if not 0 <= self.base < self.n_panels:
            raise HcsearchError(f"there is no panel {self.base} to stand on: give 0 to {self.n_panels - 1}")

    def __repr__(self) -> str:
        return self.made_by or f"<Linkage of {self.n_panels} panels and {self.n_hinges} hinges, base {self.base}>"

    @property
    def n_panels(self) -> int:
        """Number of panels."""
        return len(self.pattern.panels)

    @property
    def n_hinges(self) -> int:
        """Number of hinges, which is the number of fold angles."""
        return len(self.pattern.hinges)

    @cached_property
    def directions(self) -> Reals:
        """Unit directions of the hinge lines in the flat state, shape (n_hinges, 3).

        The second panel of a hinge turns about it by the fold angle, right-handed, relative to the first.
        """
        directions = np.zeros((self.n_hinges, 3))
        for k, hinge in enumerate(self.pattern.hinges):
            # the second panel lies on the right from start to end: it turns down, which closes the bottom face
            sign = -1.0 if hinge.face == "top" else 1.0
            dx, dy = hinge.end[0] - hinge.start[0], hinge.end[1] - hinge.start[1]
            length = math.hypot(dx, dy)
            directions[k, :2] = sign * dx / length, sign * dy / length
        return directions

    @cached_property
    def points(self) -> Reals:
        """A point of each hinge line in the flat state: the middle of the hinge, shape (n_hinges, 3)."""
        height = {"top": self.pattern.thickness, "bottom": 0.0}
        return np.array(
            [
                (0.5 * (h.start[0] + h.end[0]), 0.5 * (h.start[1] + h.end[1]), height[h.face])
                for h in self.pattern.hinges
            ]
        ).reshape(-1, 3)

    @cached_property
    def flat(self) -> Reals:
        """Fold angles of the flat state: all 0."""
        return np.zeros(self.n_hinges)

    @cached_property
    def folded(self) -> Reals:
        """Fold angles of the folded state: pi, 0 where a hinge stays flat, or between where a pattern states that."""
        return np.array([hinge.folded_angle for hinge in self.pattern.hinges])

    @property
    def folds_flat(self) -> bool:
        """Whether every hinge is at a stop in the folded state."""
        return bool(at_stops(self.folded).all())

    @cached_property
    def _tree(self) -> HingeTree:
        return hinge_tree(self.pattern, self.base)

    @cached_property
    def loops(self) -> tuple[Walk, ...]:
        """Independent loops, as closed walks of pairs (hinge, sense); sense 1 leads from its first panel to its second.

        These are the loops that the pattern names, if they form a basis, else one for each hinge outside the tree.
        """
        in_tree = {int(h) for h in self._tree.hinges if h >= 0}
        named = tuple(self.walk([self.pattern.hinge_of(pair) for pair in loop]) for loop in self.pattern.loops)
        if len(named) == self.n_hinges - len(in_tree) and self._independent(named):
            return named
        walks = []
        for k, hinge in enumerate(self.pattern.hinges):
            if k in in_tree:
                continue
            to_first, to_second = self._tree.way(hinge.first), self._tree.way(hinge.second)
            common = next((i for i, (a, b) in enumerate(zip(to_first, to_second, strict=False)) if a != b), None)
            shared = min(len(to_first), len(to_second)) if common is None else common
            walks.append((*to_first[shared:], (k, 1), *((h, -s) for h, s in reversed(to_second[shared:]))))
        return tuple(walks)

    def _independent(self, walks: Sequence[Walk]) -> bool:
        """Whether closed walks are linearly independent as combinations of hinges."""
        crossed = np.zeros((len(walks), self.n_hinges))
        for row, walk in enumerate(walks):
            for hinge, sign in walk:
                crossed[row, hinge] += sign
        return int(np.linalg.matrix_rank(crossed)) == len(walks) if walks else True

    def walk(self, hinges: Sequence[int]) -> Walk:
        """The closed walk across hinges in a given order, with the sense in which each is crossed.

        It begins at the panel before the first hinge.
        """
        joints = [self.pattern.hinges[h] for h in hinges]
        after = {joints[1].first, joints[1].second}
        # of two panels joined twice, the walk goes from the first to the second and back
        panel = joints[0].first if joints[0].second in after else joints[0].second
        steps = []
        for h, joint in zip(hinges, joints, strict=True):
            sign = 1 if joint.first == panel else -1
            panel = joint.second if sign == 1 else joint.first
            steps.append((h, sign))
        return tuple(steps)

    @cached_property
    def loop_arrays(self) -> tuple[WholeNumbers, WholeNumbers, WholeNumbers]:
        """The loops as three arrays: start indices, then the hinges and the senses of all loops, concatenated."""
        starts = np.cumsum([0, *map(len, self.loops)])
        steps = np.array([step for loop in self.loops for step in loop], np.int64).reshape(-1, 2)
        return starts, steps[:, 0].copy(), steps[:, 1].copy()

    @cached_property
    def looped(self) -> WholeNumbers:
        """The hinges that are in a loop, in rising order."""
        return np.array(sorted({hinge for loop in self.loops for hinge, _ in loop}), np.int64)

    @property
    def n_rows(self) -> int:
        """Number of closure equations: six for each loop."""
        return 6 * len(self.loops)

    def closure(self, angles: Reals) -> tuple[Reals, Reals]:
        """The closure residual, shape (n_rows,), and its Jacobian in screw form, shape (n_rows, n_hinges).

        For each loop the residual is the rotation (rad) and the gap, divided by the pattern's size, after one turn
        around it; the Jacobian's columns are the screws of the hinges in the frame of the loop's first panel.
        """
        residual, jacobian = np.empty(self.n_rows), np.empty((self.n_rows, self.n_hinges))
        angles = self._of_hinges("fold angles", angles)
        lines = (self.directions, self.points)
        close_loops(*lines, *self.loop_arrays, angles, self.pattern.size, residual, jacobian, np.empty((3, 4)))
        return residual, jacobian

    def bend(self, jacobian: Reals, velocity: Reals) -> Reals:
        """The second-order closure error of rates of the fold angles, shape (n_rows,).

        Moving by t v + t^2 w / 2 keeps the loops closed to second order when J v = 0 and J w + bend = 0.
        """
        velocity = self._of_hinges("rates of the fold angles", velocity)
        bend = np.empty(self.n_rows)
        starts, hinges, _ = self.loop_arrays
        bend_loops(starts, hinges, jacobian, velocity, bend)
        return bend

    @property
    def chain(self) -> Chain:
        """The hinge lines and the tree of panels from the base, for compiled functions."""
        tree = self._tree
        return Chain(self.directions, self.points, tree.order, tree.parents, tree.hinges, tree.signs)

    def poses(self, angles: Reals) -> Reals:
        """The rotation and translation of each panel from the flat state, shape (n_panels, 3, 4)."""
        poses = np.empty((self.n_panels, 3, 4))
        place_panels(self.chain, self._of_hinges("fold angles", angles), poses)
        return poses

    def _of_hinges(self, name: str, values: Reals) -> Reals:
        """Values of the hinges as a contiguous array of checked shape, as kernels do not check bounds."""
        if isinstance(values, np.ndarray) and values.shape == self.flat.shape and values.dtype == np.float64:
            return values
        try:
            array = np.ascontiguousarray(values, float)
        except (TypeError, ValueError):
            array = np.empty(())
        if array.shape != (self.n_hinges,):
            raise HcsearchError(f"{name} are one number for each hinge: give {self.n_hinges} of them")
        return array

    def solids(self, angles: Reals) -> list[Reals]:
        """The corners of each facet's prism in space, shape (2, n_corners, 3): the bottom face, then the top face."""
        poses = self.poses(angles)
        solids = []
        for facet, panel in zip(self.pattern.facets, self.pattern.panel_of, strict=True):
            flat = np.array([[(x, y, z) for x, y in facet] for z in (0.0, self.pattern.thickness)])
            pose = poses[panel]
            solids.append(flat @ pose[:, :3].T + pose[:, 3])
        return solids
