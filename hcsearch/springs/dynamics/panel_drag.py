"""Drag of the facets of panels: points and weights over which it is summed.

Each facet is divided into triangles from its middle to its edges, with Radon's rule of seven points in each, which is
exact up to the fifth degree: for force and moment of all motions in which the whole facet moves to one side of its
plane, and to 2 % where it does not. Mirror images of facets have the mirror images of the points, so that symmetric
motions stay symmetric.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.system import FacetDrag


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
