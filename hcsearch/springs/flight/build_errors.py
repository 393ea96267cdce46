"""Errors of a built array, and their effect on its flat state at first order.

An array is built with stops that are off by some angle, hinge axes that are off their places on either panel, and
panels that are too thick or too thin. Every error is one number within plus and minus its tolerance. At first order
the placement of each panel, and the opening of each loop, is linear in them (docs/explanation/flight.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.linkage import Linkage, hinge_tree

DEPENDENT_ROW_SHARE = 1e-10
"""Singular values of the closure rows below this share of the greatest count as zero; rounding is 1e-15."""


@dataclass(frozen=True)
class BuildTolerances:
    """The greatest value of each error of a built array, plus or minus.

    stops : rad for each hinge, of the angle of its stop in the flat state. play : rad for each hinge, by which it turns
    about that angle without resistance. offset : m, of each end of a hinge axis, on each of its two panels, across the
    axis: in the plane of the panel, and out of it. thickness : m, of each panel.
    """

    stops: tuple[float, ...]
    play: tuple[float, ...]
    offset: float = 0.0
    thickness: float = 0.0

    def __post_init__(self) -> None:
        given = (*self.stops, *self.play, self.offset, self.thickness)
        if not all(math.isfinite(tolerance) and tolerance >= 0.0 for tolerance in given):
            raise HcsearchError("tolerances are numbers that are not negative: give 0 for what is exact")
        if len(self.stops) != len(self.play):
            raise HcsearchError(
                f"{len(self.stops)} hinges have tolerances of stops and {len(self.play)} have play: give both for each"
            )

    @property
    def angles(self) -> Reals:
        """How far each hinge may be from flat (rad): the tolerance of its stop and its play."""
        angles: Reals = np.array(self.stops, float) + np.array(self.play, float)
        return angles

    @property
    def are_zero(self) -> bool:
        """Whether an array is built exactly."""
        return not (self.angles.any() or self.offset or self.thickness)


@dataclass(frozen=True, eq=False)
class ErrorMap(ByValue):
    """The flat state of a built array as a linear map of its errors.

    An error is one column. The first n_hinges are the angles (rad); then come, for each hinge, the shifts (m) of the
    axis at the start and at the end of the hinge, in the plane, then out of it: shifts on its first panel less shifts
    on its second; then the thickness of each panel (m).

    bounds : (n_columns,), the greatest of each error. deviations : (n_columns,), its standard deviation where it is
    evenly spread within its tolerance. twists : (n_panels, 6, n_columns), the turn (rad) of each panel relative to the
    root, and its shift at the centre of the array over the `radius`. closure : (6 n_loops, n_columns), the same after
    one turn around each loop, which is 0 where the loop is closed. hinge_twists : (n_hinges, 6, n_columns), of the
    second panel of each hinge relative to its first.
    centre : mean of the vertices of the flat array (m), half way through the panels. radius : m, from there to the
    farthest vertex, seen from above.
    """

    linkage: Linkage
    root: int
    bounds: Reals
    deviations: Reals
    twists: Reals
    closure: Reals
    hinge_twists: Reals
    centre: Reals
    radius: float

    def with_tolerances(self, tolerances: BuildTolerances) -> ErrorMap:
        """Return the map with other tolerances of the same errors."""
        bounds, deviations = _sizes(self.linkage, tolerances)
        return replace(self, bounds=bounds, deviations=deviations)

    def heights(self, points: Reals, panels: WholeNumbers) -> Reals:
        """Return how far points of panels rise for each error, (n_points, n_columns), m per unit.

        points : (n_points, 2), m, seen from above when flat. panels : (n_points,), to which they belong.
        """
        x, y = ((points - self.centre[:2]) / self.radius).T
        turn_x, turn_y, rise = (self.twists[panels, row] for row in (0, 1, 5))
        heights: Reals = self.radius * (rise + y[:, None] * turn_x - x[:, None] * turn_y)
        return heights

    def independent_rows(self, scale: Reals) -> tuple[Reals, Reals]:
        """Return orthonormal rows R with R y = 0 where loops close with errors x = scale * y, and T: R y = T closure x.

        Rows are lost only where closure hardly depends on any error, which leaves more errors possible, not fewer.
        """
        u, values, rows = np.linalg.svd(self.closure * scale, full_matrices=False)
        kept = values > DEPENDENT_ROW_SHARE * values.max(initial=0.0)
        return np.ascontiguousarray(rows[kept]), (u[:, kept] / values[kept]).T

    def second_order(self) -> tuple[Reals, Reals, Reals]:
        """Return bounds of the terms that the linear map leaves out, at the bounds of all errors.

        First for each panel, and then for each loop: turns about level axes and the rise over the radius. Last for each
        loop: the turn about the upright axis and level shifts over the radius.
        """
        odd = np.linalg.norm(self.hinge_twists[:, [0, 1, 5]], axis=1) @ self.bounds
        even = (np.abs(self.hinge_twists[:, 2]) + np.linalg.norm(self.hinge_twists[:, 3:5], axis=1)) @ self.bounds
        tree = hinge_tree(self.linkage.pattern, self.root)
        ways = [[hinge for hinge, _ in tree.way(panel)] for panel in range(self.linkage.n_panels)]
        panels = np.array([_left_out(odd[way].sum(), even[way].sum())[0] for way in ways])
        loops = np.zeros((len(self.linkage.loops), 2))
        for number, loop in enumerate(self.linkage.loops):
            hinges = [hinge for hinge, _ in loop]
            # both ways from the first panel of the loop lead to the same panel, whichever it is
            sums = np.cumsum([odd[hinges], even[hinges]], axis=1)
            loops[number] = (_left_out(*sums) + _left_out(*(sums[:, -1:] - sums))).min(axis=1)
        return panels, loops[:, 0], loops[:, 1]


def _left_out(odd: Reals, even: Reals) -> Reals:
    """Return bounds of the odd and of the even part of a product of motions less the sum of their twists.

    odd, even : sums of the norms of both parts of the twists.
    """
    return np.array([np.sinh(odd) * np.exp(even) - odd, np.cosh(odd) * np.exp(even) - 1.0 - even])


def error_map(linkage: Linkage, tolerances: BuildTolerances, root: int) -> ErrorMap:
    """Return the errors of a built array as a linear map; root : the panel to which places refer.

    HcsearchError where the linkage has another number of hinges than the tolerances, or no such panel.
    """
    pattern = linkage.pattern
    if not 0 <= root < linkage.n_panels:
        raise HcsearchError(f"there is no panel {root} to hold: give 0 to {linkage.n_panels - 1}")
    bounds, deviations = _sizes(linkage, tolerances)
    vertices = np.array(pattern.vertices)
    centre = np.array([*vertices.mean(axis=0), pattern.thickness / 2.0])
    radius = float(np.linalg.norm(vertices - centre[:2], axis=1).max())
    hinge_twists = _hinge_twists(linkage, centre, radius)
    tree = hinge_tree(pattern, root)
    twists = np.zeros((linkage.n_panels, *hinge_twists.shape[1:]))
    for panel in tree.order.tolist():
        if tree.parents[panel] >= 0:
            twists[panel] = twists[tree.parents[panel]] + tree.signs[panel] * hinge_twists[tree.hinges[panel]]
    closure = np.zeros((len(linkage.loops), *hinge_twists.shape[1:]))
    for number, loop in enumerate(linkage.loops):
        for hinge, sign in loop:
            closure[number] += sign * hinge_twists[hinge]
    rows = closure.reshape(linkage.n_rows, len(bounds))
    return ErrorMap(linkage, root, bounds, deviations, twists, rows, hinge_twists, centre, radius)


def _sizes(linkage: Linkage, tolerances: BuildTolerances) -> tuple[Reals, Reals]:
    """Return the greatest value of each error, and its standard deviation.

    A shift of an axis is the difference of two, so that it is at most twice as great, and its variance twice theirs.
    """
    if len(tolerances.stops) != linkage.n_hinges:
        raise HcsearchError(f"tolerances are given for each hinge: give {linkage.n_hinges} of them")
    stops, play = np.array(tolerances.stops, float), np.array(tolerances.play, float)
    shifts, thick = np.full(4 * linkage.n_hinges, tolerances.offset), np.full(linkage.n_panels, tolerances.thickness)
    bounds = np.concatenate([stops + play, 2.0 * shifts, thick])
    deviations = np.concatenate([np.hypot(stops, play), math.sqrt(2.0) * shifts, thick]) / math.sqrt(3.0)
    return bounds, deviations


def _hinge_twists(linkage: Linkage, centre: Reals, radius: float) -> Reals:
    """Return how the second panel of each hinge moves against its first with each error; see `ErrorMap`."""
    n, hinges = linkage.n_hinges, linkage.pattern.hinges
    each = np.arange(n)
    twists = np.zeros((n, 6, 5 * n + linkage.n_panels))
    twists[each, :3, each] = linkage.directions
    twists[each, 3:, each] = np.cross(linkage.points - centre, linkage.directions)
    starts, ends = (
        np.column_stack([np.reshape(corners, (-1, 2)), linkage.points[:, 2]]) - centre
        for corners in ([hinge.start for hinge in hinges], [hinge.end for hinge in hinges])
    )
    lengths = np.linalg.norm(ends - starts, axis=1, keepdims=True)
    along = (ends - starts) / lengths
    upright = np.broadcast_to([0.0, 0.0, 1.0], along.shape)
    for direction, shifts in enumerate((np.cross(upright, along), upright)):
        # the axis turns so that one of its ends is shifted and the other is not
        for end, (fixed, sense) in enumerate(((ends, -1.0), (starts, 1.0))):
            axes = sense / lengths * np.cross(along, shifts)
            columns = n + 4 * each + 2 * direction + end
            twists[each, :3, columns], twists[each, 3:, columns] = axes, np.cross(fixed, axes)
    sides = np.array([0.5 if hinge.face == "top" else -0.5 for hinge in hinges])
    twists[each, 5, [5 * n + hinge.first for hinge in hinges]] = sides
    twists[each, 5, [5 * n + hinge.second for hinge in hinges]] = -sides
    twists[:, 3:] /= radius
    return twists
