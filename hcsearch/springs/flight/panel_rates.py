"""Motions of panels by rates of hinges, and the kinetic energy of closed rates, with a root that is held or floats.

Rates of hinges that keep loops closed give each panel one twist, whichever way to it is taken. So the kinetic energy
needs no cut loops: it is a quadratic form on the closed rates, by any tree of hinges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.springs.dynamics.body_trees import Body, joined_body
from hcsearch.springs.dynamics.panels import panel_bodies


@dataclass(frozen=True)
class FloatingBase:
    """What floats with the root panel, at its centre of mass: kg, and moments about the axes of the flat state, kg m^2.

    Without anything, the array floats by itself.
    """

    mass: float = 0.0
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class PanelRates(ByValue):
    """How panels move with the rates of hinges at one closed state, relative to the root or in space.

    root : the panel that is held, or that belongs to the floating base. maps : (n_panels, 6, n_hinges), the angular
    velocity of each panel (rad/s) and the velocity of its centre of mass (m/s) for unit rates, in the axes of the base
    of the linkage. centres : (n_panels, 3), m. inertias : (n_panels, 6, 6), of angular velocities and velocities.
    """

    root: int
    maps: Reals
    centres: Reals
    inertias: Reals

    @property
    def mass_matrix(self) -> Reals:
        """The matrix M of the kinetic energy v' M v / 2 of closed rates v, (n_hinges, n_hinges), kg m^2."""
        momenta = self.inertias @ self.maps
        matrix: Reals = np.tensordot(self.maps, momenta, ([0, 1], [0, 1]))
        return matrix

    def root_momenta(self, rates: Reals) -> Reals:
        """Return what the root gives or takes at rates (n_hinges,): momentum (N s), moment about its centre (N m s).

        Shape (6,), the moment first. These are of all other panels together.
        """
        momenta = self.inertias @ (self.maps @ rates)[:, :, None]
        angular, linear = momenta[:, :3, 0], momenta[:, 3:, 0]
        arms = self.centres - self.centres[self.root]
        others = np.arange(len(arms)) != self.root
        return np.concatenate([(angular + np.cross(arms, linear))[others].sum(axis=0), linear[others].sum(axis=0)])


def panel_rates(
    linkage: Linkage, density: float, root: int, angles: Reals, base: FloatingBase | None = None
) -> PanelRates:
    """Return how panels move at a closed state with the root held, or floating with a base without total momentum.

    density : kg/m^3. angles : (n_hinges,), fold angles, rad. HcsearchError where there is no such panel.
    """
    if not 0 <= root < linkage.n_panels:
        raise HcsearchError(f"there is no panel {root} to hold: give 0 to {linkage.n_panels - 1}")
    poses = linkage.poses(angles)
    bodies = panel_bodies(linkage, density)
    if base is not None:
        bodies[root] = joined_body([bodies[root], Body(base.mass, bodies[root].centre, np.diag(base.inertia))])
    centres = np.array([pose[:, :3] @ body.centre + pose[:, 3] for pose, body in zip(poses, bodies, strict=True)])
    inertias = _inertias(bodies, poses)
    maps = _relative_maps(linkage, root, poses, centres)
    if base is not None:
        maps = _without_momentum(maps, centres, inertias, root)
    return PanelRates(root, maps, centres, inertias)


def _inertias(bodies: Sequence[Body], poses: Reals) -> Reals:
    inertias = np.zeros((len(bodies), 6, 6))
    turns = poses[:, :, :3]
    inertias[:, :3, :3] = turns @ np.array([body.inertia for body in bodies]) @ turns.transpose(0, 2, 1)
    inertias[:, 3:, 3:] = np.array([body.mass for body in bodies])[:, None, None] * np.eye(3)
    return inertias


def _relative_maps(linkage: Linkage, root: int, poses: Reals, centres: Reals) -> Reals:
    """Return the maps from rates of hinges to motions of panels relative to the root."""
    firsts = poses[[hinge.first for hinge in linkage.pattern.hinges]]
    axes = np.einsum("hij,hj->hi", firsts[:, :, :3], linkage.directions)
    points = np.einsum("hij,hj->hi", firsts[:, :, :3], linkage.points) + firsts[:, :, 3]
    tree = hinge_tree(linkage.pattern, root)
    signs = np.zeros((linkage.n_panels, linkage.n_hinges))
    for panel in tree.order.tolist():
        if tree.parents[panel] >= 0:
            signs[panel] = signs[tree.parents[panel]]
            signs[panel, tree.hinges[panel]] = tree.signs[panel]
    velocities = np.cross(axes, centres[:, None] - points)
    maps: Reals = signs[:, None, :] * np.concatenate(
        [np.broadcast_to(axes, velocities.shape), velocities], axis=2
    ).transpose(0, 2, 1)
    return maps


def _without_momentum(maps: Reals, centres: Reals, inertias: Reals, root: int) -> Reals:
    """Add the motion of the root in space that leaves no momentum and no moment of momentum."""
    rigid = np.zeros((len(centres), 6, 6))
    rigid[:] = np.eye(6)
    arms = centres - centres[root]
    rigid[:, 3:, :3] = -np.cross(arms[:, None], np.eye(3)).transpose(0, 2, 1)
    momenta = inertias @ rigid
    total = np.tensordot(rigid, momenta, ([0, 1], [0, 1]))
    coupled = np.tensordot(momenta, maps, ([0, 1], [0, 1]))
    moved: Reals = maps - rigid @ np.linalg.solve(total, coupled)
    return moved
