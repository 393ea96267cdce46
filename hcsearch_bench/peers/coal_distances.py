"""Distances by coal: one pair after the other from Python, and all pairs of a scene at once through Pinocchio."""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers

TOLERANCE, ROUNDS = 1e-10, 1000
"""Of its search, m: its distances are too great by up to that. They take as long with any, but some get worse below:
in a deployment of thesis-4x4 by 3e-7 m at 1e-12. With its criterion `DualityGap` distances are wrong from 1e-10 on."""


def installed() -> bool:
    """Whether coal and Pinocchio are there."""
    try:
        import coal  # noqa: F401
        import pinocchio  # noqa: F401
    except ImportError:
        return False
    return True


def convex(vertices: Reals) -> Any:
    """A prism; vertices as in `Sample.shapes`."""
    import coal

    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(vertices))
    m = len(vertices) // 2
    for i in range(1, m - 1):
        triangles.append(coal.Triangle(0, i + 1, i))
        triangles.append(coal.Triangle(m, m + i, m + i + 1))
    for i in range(m):
        j = (i + 1) % m
        triangles.append(coal.Triangle(i, j, m + i))
        triangles.append(coal.Triangle(j, m + j, m + i))
    return coal.Convex(points, triangles)


def _set(request: Any, *, warm: bool) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # one of its own properties is deprecated
        request.gjk_tolerance = TOLERANCE
        request.gjk_max_iterations = ROUNDS
        request.enable_signed_distance = False
        request.enable_cached_gjk_guess = warm


def one_by_one(shapes: list[Reals], which: WholeNumbers, turns: Reals, shifts: Reals) -> tuple[Reals, float]:
    """Distances of pairs, 0 where they meet, and the processor seconds of the calls alone."""
    import coal

    solids = [convex(shape) for shape in shapes]
    calls = {(i, j): coal.ComputeDistance(solids[i], solids[j]) for i, j in {(int(i), int(j)) for i, j in which}}
    chosen = [calls[int(i), int(j)] for i, j in which]
    places = [[coal.Transform3s(r, t) for r, t in zip(turns[:, k], shifts[:, k], strict=True)] for k in range(2)]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    _set(request, warm=False)
    distances = np.empty(len(which))
    begin = time.process_time()
    for k, (call, one, two) in enumerate(zip(chosen, *places, strict=True)):
        result.clear()
        distances[k] = call(one, two, request, result)
    seconds = time.process_time() - begin
    return np.maximum(distances, 0.0), seconds


class CoalScene:
    """Solids that are placed freely, and pairs of them whose distances are all computed at once."""

    def __init__(self, solids: list[Reals], pairs: WholeNumbers, *, moving: bool) -> None:
        import pinocchio as pin

        self.pin, self.model, self.shapes = pin, pin.Model(), pin.GeometryModel()
        for k, solid in enumerate(solids):
            joint = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), f"j{k}") if moving else 0
            self.shapes.addGeometryObject(pin.GeometryObject(f"s{k}", joint, joint, pin.SE3.Identity(), convex(solid)))
        for i, j in pairs:
            self.shapes.addCollisionPair(pin.CollisionPair(int(i), int(j)))
        self.data, self.geometry = self.model.createData(), self.shapes.createData()

    def place(self, turns: Reals, shifts: Reals) -> None:
        """Where the solids are, of a scene that does not move: (k, 3, 3), (k, 3)."""
        for shape, turn, shift in zip(self.shapes.geometryObjects, turns, shifts, strict=True):
            shape.placement = self.pin.SE3(turn, shift)
        self.pin.updateGeometryPlacements(self.model, self.data, self.shapes, self.geometry, np.zeros(0))

    def coordinates(self, turns: Reals, shifts: Reals) -> Reals:
        """Coordinates that place the solids of a scene that moves."""
        places = [self.pin.SE3(turn, shift) for turn, shift in zip(turns, shifts, strict=True)]
        return np.concatenate([self.pin.SE3ToXYZQUAT(place) for place in places])

    def seconds(self, *, warm: bool) -> float:
        """Processor seconds of computing all distances; warm : each search begins where the last one ended."""
        for request in self.geometry.distanceRequests:
            _set(request, warm=warm)
        begin = time.process_time()
        self.pin.computeDistances(self.shapes, self.geometry)
        return time.process_time() - begin

    def follow(self, states: list[Reals]) -> float:
        """Processor seconds of placing the solids and computing all distances at one state after the other, warm."""
        for request in self.geometry.distanceRequests:
            _set(request, warm=True)
        begin = time.process_time()
        for state in states:
            self.pin.computeDistances(self.model, self.data, self.shapes, self.geometry, state)
        return time.process_time() - begin

    def distances(self) -> Reals:
        """The distances of the last computation, 0 where solids meet."""
        return np.maximum([result.min_distance for result in self.geometry.distanceResults], 0.0)
