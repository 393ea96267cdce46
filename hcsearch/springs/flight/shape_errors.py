"""Shape of the deployed array as built: flatness, tilt, and how far errors bind its loops.

Errors are those of `build_errors`. A built array is flat where its loops close with every hinge within the tolerance of
its stop and its play. The greatest deviation over all such arrays is a linear program, as deviations and closure are
linear at first order; root mean squares take errors as independent, given that the loops close. Proofs, and in
which direction each number is a bound: docs/explanation/flight.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.linkage.boxed_programs import farthest_in_box, greatest_in_box
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.build_errors import DEPENDENT_ROW_SHARE, BuildTolerances, ErrorMap, error_map


@dataclass(frozen=True)
class ShapeErrors:
    """The shape of a flat array as built, at first order.

    self_stresses : number of dependent rows of closure in the flat state: so many conditions on the places of hinges
        that no turn of a hinge can meet. Exact on tilings; None where the rank is not decided.
    flatness_per_rad : m/rad, greatest distance of a corner from the plane fitted to the array, where each hinge may be
        1 rad off and nothing else is; the same number in mm/mrad. tilt_per_rad : greatest tilt of a panel against that
        plane (rad/rad). root_tilt_per_rad : the same against the root panel. rms_flatness_per_rad : m/rad, root mean
        square over area and over arrays.
    flatness, rms_flatness, tilt, root_tilt : the same with the given tolerances (m, m, rad, rad).
    second_order : m, by which a built array may exceed `flatness`, as the map of errors is linear.
    angle_shares, offset_share, thickness_share : m, the parts of `flatness` that are due to the angle of each hinge, to
        offsets of axes and to thickness. With tolerances that are changed in some ratios, the parts changed in the same
        ratios bound the deviation of that corner from above.
    needed_play : rad, root mean square over arrays of the angle by which a hinge must leave its stop for the loops to
        close, for the hinge that leaves it most. misfit : m, root mean square of the gap of loops in the nearest state,
        by which axes must yield: 0 without self-stresses. Turns count as shifts at `ErrorMap.radius`.
    """

    self_stresses: int | None
    flatness_per_rad: float
    rms_flatness_per_rad: float
    tilt_per_rad: float
    root_tilt_per_rad: float
    flatness: float
    rms_flatness: float
    tilt: float
    root_tilt: float
    second_order: float
    angle_shares: tuple[float, ...]
    offset_share: float
    thickness_share: float
    needed_play: float
    misfit: float


def shape_errors(linkage: Linkage, tolerances: BuildTolerances, root: int) -> ShapeErrors:
    """Return the shape of a flat array as built; root : the panel against which `root_tilt` is.

    HcsearchError where the linkage has another number of hinges than the tolerances, or no such panel.
    """
    built = error_map(linkage, tolerances, root)
    survey = _Survey(built)
    nothing = (0.0,) * linkage.n_hinges
    angles_alone = built.with_tolerances(BuildTolerances((1.0,) * linkage.n_hinges, nothing))
    worst = survey.deviations(built)
    shares, n = worst.shares[worst.values.argmax()], linkage.n_hinges
    flatness = float(worst.values.max())
    exceeded = float((worst.values + survey.excess(built, worst.wrenches)).max())
    return ShapeErrors(
        self_stresses_when_flat(linkage),
        float(survey.deviations(angles_alone).values.max()),
        survey.rms_flatness(angles_alone),
        *survey.tilts(angles_alone),
        flatness,
        survey.rms_flatness(built),
        *survey.tilts(built),
        exceeded - flatness,
        tuple(shares[:n].tolist()),
        float(shares[n : 5 * n].sum()),
        float(shares[5 * n :].sum()),
        *binding(built.with_tolerances(replace(tolerances, play=nothing))),
    )


def self_stresses_when_flat(linkage: Linkage) -> int | None:
    """Return the number of dependent rows of closure in the flat state; None where the rank is not decided.

    It is exact where the linkage lies on a tiling. A chain without a loop has none.
    """
    end = whole_end(linkage, linkage.flat)
    rank = rank_at(linkage, linkage.flat).rank if end is None else end.rank
    return None if rank is None else linkage.n_rows - rank


def binding(built: ErrorMap) -> tuple[float, float]:
    """Return the play that loops need to close as built, and their gap without it (rad, m).

    Both are root mean squares over arrays, for the nearest state with hinges of equal stiffness; see `ShapeErrors`.
    """
    turns = built.closure[:, : built.linkage.n_hinges]
    opened = built.closure * built.deviations
    closing = np.linalg.pinv(turns, rcond=DEPENDENT_ROW_SHARE) @ opened
    left = opened - turns @ closing
    return float(np.linalg.norm(closing, axis=1).max(initial=0.0)), float(np.linalg.norm(left) * built.radius)


class _Deviations(NamedTuple):
    """The greatest distance of each corner from the plane.

    values : (n_corners,), m. shares : (n_corners, n_columns), m, the parts of the values that are due to each error.
    wrenches : (n_corners, n_loops, 6), m, by which a value rises for each unit that a row of closure is not 0.
    """

    values: Reals
    shares: Reals
    wrenches: Reals


class _Survey:
    """Points of an array at which its shape is measured, and the plane fitted to it.

    The plane has the least mean square distance over the area of the panels, as seen from above.
    """

    def __init__(self, built: ErrorMap) -> None:
        corners, corner_panels, points, panels, self.weights = _points_of(built.linkage)
        heights, area_heights = built.heights(corners, corner_panels), built.heights(points, panels)
        terms = _plane_terms(built, points)
        fit = np.linalg.solve(terms.T @ (self.weights[:, None] * terms), terms.T * self.weights)
        self.planes = fit @ area_heights
        self.fit_of_corners = _plane_terms(built, corners) @ fit
        self.heights = heights - _plane_terms(built, corners) @ self.planes
        self.area_heights = area_heights - terms @ self.planes
        self.slopes = np.stack([-built.twists[:, 1], built.twists[:, 0]], axis=1)
        self.corner_panels, self.panels = corner_panels, panels

    def deviations(self, built: ErrorMap) -> _Deviations:
        """Return for each corner its greatest distance from the plane."""
        goals, rows, inverse = _scaled(built, self.heights)
        values, multipliers = np.empty(len(goals)), np.empty((len(goals), len(rows)))
        greatest_in_box(rows, goals, values, multipliers, np.empty_like(goals))
        shares = np.zeros_like(self.heights)
        shares[:, built.bounds > 0.0] = np.abs(goals - multipliers @ rows)
        wrenches = (multipliers @ inverse).reshape(len(goals), len(built.linkage.loops), 6)
        return _Deviations(values, shares, wrenches)

    def excess(self, built: ErrorMap, wrenches: Reals) -> Reals:
        """Return by how much a built array may exceed the greatest distance of each corner, (n_corners,), m."""
        panel_odd, loop_odd, loop_even = built.second_order()
        moved = math.sqrt(2.0) * built.radius * panel_odd
        of_panels = moved[self.corner_panels] + np.abs(self.fit_of_corners) @ moved[self.panels]
        odd = np.linalg.norm(wrenches[:, :, [0, 1, 5]], axis=2)
        even = np.abs(wrenches[:, :, 2]) + np.linalg.norm(wrenches[:, :, 3:5], axis=2)
        excess: Reals = of_panels + odd @ loop_odd + even @ loop_even
        return excess

    def tilts(self, built: ErrorMap) -> tuple[float, float]:
        """Return the greatest tilt of a panel against the plane, and against the root (rad)."""
        n = len(self.slopes)
        images = np.concatenate([self.slopes - self.planes[1:] / built.radius, self.slopes])
        goals, rows, _ = _scaled(built, images.reshape(4 * n, -1))
        distances = np.empty(2 * n)
        farthest_in_box(rows, goals.reshape(2 * n, 2, -1), distances)
        return float(distances[:n].max()), float(distances[n:].max())

    def rms_flatness(self, built: ErrorMap) -> float:
        """Return the root mean square distance from the plane over area and over arrays whose loops close (m)."""
        spread = self.area_heights * built.deviations
        rows, _ = built.independent_rows(built.deviations)
        spread = spread - spread @ rows.T @ rows
        return math.sqrt(float(self.weights @ (spread**2).sum(axis=1) / self.weights.sum()))


def _scaled(built: ErrorMap, goals: Reals) -> tuple[Reals, Reals, Reals]:
    """Return goals and rows of closure for errors over their bounds, without errors that are 0, and T of the rows."""
    rows, inverse = built.independent_rows(built.bounds)
    some = built.bounds > 0.0
    return np.ascontiguousarray(goals[:, some] * built.bounds[some]), np.ascontiguousarray(rows[:, some]), inverse


def _plane_terms(built: ErrorMap, points: Reals) -> Reals:
    """Return the terms of a plane, a height and two slopes times the radius, at points, (n_points, 3)."""
    return np.column_stack([np.ones(len(points)), (points - built.centre[:2]) / built.radius])


def _points_of(linkage: Linkage) -> tuple[Reals, WholeNumbers, Reals, WholeNumbers, Reals]:
    """Return the corners of facets with their panels, and points with panels and weights that integrate over area.

    Facets are fans of triangles; the mean of a square of heights over a triangle is that at the middles of its sides.
    """
    corners, points, weights = [], [], []
    for facet in linkage.pattern.facets:
        polygon = np.array(facet)
        corners.append(polygon)
        fan = np.stack([np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1], polygon[2:]], axis=1)
        sides = fan[:, 1:] - fan[:, :1]
        area = 0.5 * (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
        points.append((0.5 * (fan + np.roll(fan, 1, axis=1))).reshape(-1, 2))
        weights.append(np.repeat(area / 3.0, 3))
    of_facets = np.array(linkage.pattern.panel_of)
    panels = (np.repeat(of_facets, [len(part) for part in parts]) for parts in (corners, points))
    corner_panels, point_panels = panels
    return np.concatenate(corners), corner_panels, np.concatenate(points), point_panels, np.concatenate(weights)
