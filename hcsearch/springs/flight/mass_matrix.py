"""The mass matrix of a linkage in the rates of its hinges, at any state, with a panel clamped or all of them free."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.springs.dynamics.body_trees import Body
from hcsearch.springs.dynamics.panels import panel_bodies


def mass_matrix(linkage: Linkage, angles: Reals, density: float, root: int | None, base: Body | None = None) -> Reals:
    """Return the mass matrix M, (n_hinges, n_hinges), kg m^2: closed rates v have the kinetic energy v' M v / 2.

    angles : a closed state, rad. density : of panels, kg/m^3. root : the panel that is clamped; None for a free array,
    whose rates are those of relative motion with the least kinetic energy: its momenta are 0. base : a body that is
    fixed to panel 0 of a free array, in the axes of the flat state.
    Of rates that do not close the loops it is the energy of the tree from the root.
    """
    moved, inertias = _moved(linkage, angles, 0 if root is None else root), _inertias(linkage, angles, density)
    if base is not None:
        inertias[0] += _spatial(base, linkage.poses(angles)[0])
    if root is not None:
        clamped: Reals = np.einsum("pin,pij,pjm->nm", moved, inertias, moved)
        return clamped
    free = np.concatenate([moved, np.broadcast_to(np.eye(6), (len(moved), 6, 6))], axis=2)
    whole = np.einsum("pin,pij,pjm->nm", free, inertias, free)
    n = linkage.n_hinges
    reduced: Reals = whole[:n, :n] - whole[:n, n:] @ np.linalg.solve(whole[n:, n:], whole[n:, :n])
    return reduced


def _moved(linkage: Linkage, angles: Reals, root: int) -> Reals:
    """Return the twist of each panel, turn and shift of the origin, for unit rates of hinges, (n_panels, 6, n_hinges).

    Opening and closing have the sign of the rate of the fold angle.
    """
    poses, tree = linkage.poses(angles), hinge_tree(linkage.pattern, root)
    firsts = np.array([hinge.first for hinge in linkage.pattern.hinges], np.int64)
    axes = np.einsum("hij,hj->hi", poses[firsts, :, :3], linkage.directions)
    points = np.einsum("hij,hj->hi", poses[firsts, :, :3], linkage.points) + poses[firsts, :, 3]
    screws = np.concatenate([axes, np.cross(points, axes)], axis=1)
    moved = np.zeros((linkage.n_panels, 6, linkage.n_hinges))
    for panel in tree.order.tolist():
        parent, hinge = int(tree.parents[panel]), int(tree.hinges[panel])
        if parent >= 0:
            moved[panel] = moved[parent]
            moved[panel, :, hinge] += tree.signs[panel] * screws[hinge]
    return moved


def _inertias(linkage: Linkage, angles: Reals, density: float) -> Reals:
    """Return the spatial inertia of each panel about the origin, (n_panels, 6, 6)."""
    poses = linkage.poses(angles)
    return np.array([_spatial(body, pose) for body, pose in zip(panel_bodies(linkage, density), poses, strict=True)])


def _spatial(body: Body, pose: Reals) -> Reals:
    """Return the spatial inertia about the origin of a body with a pose, (6, 6): (turn, shift of the origin)."""
    turn, (x, y, z) = pose[:, :3], pose[:, :3] @ body.centre + pose[:, 3]
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    spatial = np.zeros((6, 6))
    spatial[:3, :3] = turn @ body.inertia @ turn.T - body.mass * across @ across
    spatial[:3, 3:], spatial[3:, :3] = body.mass * across, -body.mass * across
    spatial[3:, 3:] = body.mass * np.eye(3)
    return spatial
