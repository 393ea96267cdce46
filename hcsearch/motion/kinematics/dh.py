"""Loops of hinges in the matrix form of Denavit and Hartenberg (thesis 2.3.1, 5.1.2 and appendix).

z_i lies along hinge i, x_i along the common normal from z_{i-1} to z_i: frame i is fixed in the panel P_{i-1} between
the two, frame 1 in the panel where the walk begins. Link length a_{i(i+1)} and twist alpha_{i(i+1)} lead from z_i to
z_{i+1}, along and about x_{i+1}; offset d_i and variable theta_i lead from x_i to x_{i+1}, along and about z_i.

The thesis writes a_i in its matrices (2.1, 2.2, 5.4, 5.5, A4) for the a_{i(i+1)} of its lists (5.3, 6.2), the length
that stands beside alpha_{i(i+1)}. Taken for a_{(i-1)i} instead, the loop of 6.2 does not close, and A16 does not come
out. Where 2.3.1 has alpha_{i(i+1)} for the twist from z_{i-1} to z_i, 5.1.2 and 6.2.1 have it right: alpha_{(i-1)i}.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage, Walk

SAME_LINE_TOLERANCE = 1e-9
"""Hinges are parallel below this sine, and meet below this distance in metres."""

_TURN = np.zeros((4, 4))
_TURN[0, 1], _TURN[1, 0] = -1.0, 1.0  # derivative of a rotation about z at angle 0


@dataclass(frozen=True, eq=False)
class DHLoop(ByValue):
    """Denavit-Hartenberg parameters of a loop of n hinges, shape (n,) each; entry i - 1 belongs to hinge i.

    lengths, twists : a_{i(i+1)} and alpha_{i(i+1)}, metres and rad.
    offsets, variables : d_i and theta_i, metres and rad; the other three stay when the loop moves.
    """

    lengths: Reals
    twists: Reals
    offsets: Reals
    variables: Reals


class HingeLines(NamedTuple):
    """Hinges of a closed loop as lines in space, in order, shape (n, 3) each.

    directions : z_i, unit vectors.
    points : a point of each line, in metres.
    normals : the side to which x_i points where hinges i - 1 and i meet or are one line.
    """

    directions: Reals
    points: Reals
    normals: Reals


def dh_loop(linkage: Linkage, walk: Walk, angles: Reals, signs: Sequence[int] | None = None) -> DHLoop:
    """Denavit-Hartenberg parameters of one loop of a linkage at any fold angles, closed or not.

    The next panel turns about z_i as the fold angle grows, so that d theta_i / d angle = 1; or `signs`, where given:
    with -1 the hinge's z_i is reversed. x_i points from hinge i - 1 to hinge i. Where they meet, it points into
    their panel from the face that carries both, as in the thesis; where they are parallel, it meets z_i in the
    hinge's middle. With signs -d theta / d phi of 5.2 and 6.3 the parameters agree with 5.3 and 6.2.
    """
    flat = dh_of_lines(flat_hinge_lines(linkage, walk, signs))
    turned = np.array([angles[hinge] for hinge, _ in walk]) * _or_ones(signs, len(walk))
    return replace(flat, variables=_wrapped(flat.variables + turned))


def flat_hinge_lines(linkage: Linkage, walk: Walk, signs: Sequence[int] | None = None) -> HingeLines:
    """The hinge lines of a loop in the flat state, with directions and normals as in `dh_loop`."""
    hinges = [hinge for hinge, _ in walk]
    senses = np.array([sense for _, sense in walk]) * _or_ones(signs, len(walk))
    inward = [1.0 if linkage.pattern.hinges[hinge].face == "bottom" else -1.0 for hinge in hinges]
    normals = np.zeros((len(walk), 3))
    normals[:, 2] = inward
    return HingeLines(linkage.directions[hinges] * senses[:, None], linkage.points[hinges], normals)


def dh_of_lines(lines: HingeLines) -> DHLoop:
    """Denavit-Hartenberg parameters of a closed loop of given hinge lines; lengths >= 0, angles in (-pi, pi].

    The common normal of parallel hinges is the one through the given point of the second.
    """
    x, origins, ends = _common_normals(lines)
    z = lines.directions
    z_next, x_next, origins_next = (np.roll(rows, -1, axis=0) for rows in (z, x, origins))
    return DHLoop(
        lengths=_dots(origins_next - ends, x_next),
        twists=_angles(z, z_next, x_next),
        offsets=_dots(ends - origins, z),
        variables=_angles(x, x_next, z),
    )


def hinge_lines(loop: DHLoop) -> HingeLines:
    """The hinge lines in the coordinates of frame 1; each point is the origin of the hinge's frame."""
    frames = _partial_products(transforms(loop))[:-1]
    return HingeLines(frames[:, :3, 2], frames[:, :3, 3], frames[:, :3, 0])


def transforms(loop: DHLoop) -> Reals:
    """T_{(i+1)i}, the pose of frame i + 1 in frame i, for each hinge, shape (n, 4, 4) (thesis eqs. 2.2 and 5.5)."""
    a, d = loop.lengths, loop.offsets
    c, s = np.cos(loop.variables), np.sin(loop.variables)
    cos_twist, sin_twist = np.cos(loop.twists), np.sin(loop.twists)
    zero, one = np.zeros(len(a)), np.ones(len(a))
    rows = (
        (c, -cos_twist * s, sin_twist * s, a * c),
        (s, cos_twist * c, -sin_twist * c, a * s),
        (zero, sin_twist, cos_twist, d),
        (zero, zero, zero, one),
    )
    return np.moveaxis(np.array(rows), 2, 0)


def dh_jacobian(loop: DHLoop) -> Reals:
    """Derivative of the closure matrix by each theta, shape (12, n): M of thesis eqs. A7 to A9, in metres.

    Column k holds the first three rows of C_k, one after the other.
    """
    steps = transforms(loop)
    before = _partial_products(steps)
    after = np.eye(4)
    jacobian = np.empty((12, len(steps)))
    for k in reversed(range(len(steps))):
        after = steps[k] @ after
        jacobian[:, k] = (before[k] @ _TURN @ after)[:3].ravel()  # T' = turn T
    return jacobian


def stacked_jacobian(loops: Sequence[DHLoop], walks: Sequence[Walk], n_hinges: int) -> Reals:
    """Jacobian of several loops that share hinges, shape (12 n_loops, n_hinges) (thesis eqs. A10 to A12).

    walks : for each loop, the hinge that each theta turns, and the derivative of theta by its column's variable, +1 or
    -1; the singular values do not depend on these signs.
    """
    jacobian = np.zeros((12 * len(loops), n_hinges))
    for k, (loop, walk) in enumerate(zip(loops, walks, strict=True)):
        for column, (hinge, sign) in zip(dh_jacobian(loop).T, walk, strict=True):
            jacobian[12 * k : 12 * k + 12, hinge] += sign * column
    return jacobian


def dh_closure_jacobian(linkage: Linkage, angles: Reals) -> Reals:
    """Jacobian of all loops of a linkage with respect to its fold angles, shape (12 n_loops, n_hinges), in metres."""
    loops = [dh_loop(linkage, walk, angles) for walk in linkage.loops]
    walks = [tuple((hinge, 1) for hinge, _ in walk) for walk in linkage.loops]
    return stacked_jacobian(loops, walks, linkage.n_hinges)


def _common_normals(lines: HingeLines) -> tuple[Reals, Reals, Reals]:
    """For each hinge i: x_i, its intersection with z_i, and the intersection of x_{i+1} with z_i; shape (n, 3) each."""
    n = len(lines.points)
    x, origins, ends = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        z, z_next = lines.directions[i - 1], lines.directions[i]
        gap = lines.points[i] - lines.points[i - 1]
        normal = np.cross(z, z_next)
        sine = math.sqrt(normal @ normal)
        if sine < SAME_LINE_TOLERANCE:
            along, along_next = float(gap @ z), 0.0  # choose the common normal through the second point
            normal = gap - along * z
            if math.sqrt(normal @ normal) <= SAME_LINE_TOLERANCE:
                normal = lines.normals[i] - (lines.normals[i] @ z) * z
        else:
            along = float(np.cross(gap, z_next) @ normal) / sine**2
            along_next = float(np.cross(gap, z) @ normal) / sine**2
            meet = abs(gap @ normal) <= SAME_LINE_TOLERANCE * sine
            normal *= math.copysign(1.0, normal @ (lines.normals[i] if meet else gap))
        x[i] = normal / math.sqrt(normal @ normal)
        ends[i - 1] = lines.points[i - 1] + along * z
        origins[i] = lines.points[i] + along_next * z_next
    return x, origins, ends


def _partial_products(steps: Reals) -> Reals:
    """Partial products of the matrices, from the identity to the product of all, shape (n + 1, 4, 4)."""
    products = np.empty((len(steps) + 1, 4, 4))
    products[0] = np.eye(4)
    for k, step in enumerate(steps):
        products[k + 1] = products[k] @ step
    return products


def _dots(first: Reals, second: Reals) -> Reals:
    return np.asarray(np.einsum("ij,ij->i", first, second), float)


def _angles(first: Reals, second: Reals, axes: Reals) -> Reals:
    """Signed angles between pairs of vectors about unit vectors perpendicular to both."""
    return _wrapped(np.arctan2(_dots(np.cross(first, second), axes), _dots(first, second)))


def _wrapped(angles: Reals) -> Reals:
    """Angles wrapped to (-pi, pi]; angles at -pi but for rounding become pi."""
    turns = np.ceil((angles - math.pi) / (2 * math.pi) - SAME_LINE_TOLERANCE)
    return np.asarray(angles - 2 * math.pi * turns, float)


def _or_ones(signs: Sequence[int] | None, n: int) -> Reals:
    return np.ones(n) if signs is None else np.asarray(signs, float)
