"""Motions of panels by rates of hinges, and frequencies and modes of a flat array of rigid panels on latched hinges.

Rates of hinges that keep loops closed give each panel one twist, whichever way to it is taken. So the kinetic energy
needs no cut loops: it is a quadratic form on the closed rates, by any tree of hinges.

With closure Jacobian A in the flat state and a basis B of its kernel, modes are the solutions x, w of

    B' (K + G) B x = w^2 B' M B x,

with latches K, the mass matrix M, and the geometric stiffness G of moments in hinges, if there are any. In the flat
state more rates close the loops at first order than true motions have, so each eigenvalue is a lower bound of the rigid
model's. Proofs: docs/explanation/flight_modes.md, 1 to 4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import Law
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.springs.dynamics.body_trees import Body, joined_body
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.flight.torque_margin import closed_rates

SOFT_EIGENVALUE_SHARE = 1e-10
"""Modes with eigenvalues below this share of the greatest count as modes without stiffness; rounding is 1e-14."""
BALANCE_TOLERANCE = 1e-6
"""Share of moments of hinges (of their norm) that loops may leave without balance."""


@dataclass(frozen=True)
class FloatingBase:
    """A body on the root panel, at its centre of mass: mass (kg), moments about the axes of the flat state (kg m^2).

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
        """Return the momentum (N s) of all other panels at rates (n_hinges,), and its moment about the root's centre.

        Shape (6,), the moment (N m s) first. The root gives or takes them.
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


@dataclass(frozen=True, eq=False)
class DeployedModes(ByValue):
    """Modes of the flat array, from the lowest eigenvalue.

    eigenvalues : (m,), w^2, 1/s^2; 0 for soft modes up to rounding, or negative where moments in hinges make the flat
    state unstable. rates : (m, n_hinges), fold angles of each mode, with kinetic energy 1/2 at unit speed.
    panels : (m, n_panels, 6), turn (rad) and displacement of the centre (m) of each panel, in the axes of the base of
    the linkage. soft_modes : number of modes without stiffness.
    """

    eigenvalues: Reals
    rates: Reals
    panels: Reals
    soft_modes: int

    @property
    def frequencies(self) -> Reals:
        """Frequencies of the modes that are not soft, Hz, in rising order."""
        frequencies: Reals = np.sqrt(self.eigenvalues[self.soft_modes :]) / (2.0 * math.pi)
        return frequencies

    @property
    def deployed_hz(self) -> float | None:
        """The first frequency of a mode that is not soft, Hz; None where nothing has stiffness or can move.

        A lower bound if there are no soft modes; with some, only if each of them belongs to a true motion.
        """
        return float(self.frequencies[0]) if len(self.frequencies) else None

    @property
    def gap(self) -> float | None:
        """The ratio of the second eigenvalue to the first, of modes that are not soft; None where there is none."""
        stiff = self.eigenvalues[self.soft_modes :]
        return float(stiff[1] / stiff[0]) if len(stiff) > 1 else None


def flat_stiffness(laws: Sequence[Law], latch_stiffness: Reals) -> Reals:
    """Return the stiffness of each hinge in the flat state, (n_hinges,), N m/rad, of its latch and its spring."""
    slopes = [_slope(law) for law in laws]
    if latch_stiffness.shape != (len(slopes),) or not (np.isfinite(latch_stiffness).all()):
        raise HcsearchError(f"stiffnesses of latches are one number for each hinge: give {len(slopes)} finite ones")
    if (latch_stiffness < 0.0).any():
        raise HcsearchError("the stiffness of a latch is negative: give 0 where a hinge has no latch")
    stiffness: Reals = latch_stiffness + np.array(slopes)
    return stiffness


def _slope(law: Law) -> float:
    """Return the slope of a law at the flat state, as the hinge begins to fold, N m/rad."""
    branch = law.straight
    piece = max((k for k, start in enumerate(branch.breaks) if start <= 0.0), default=0)
    _, b, c, d = branch.cubics[piece]
    x = -branch.breaks[piece]
    return b + x * (2.0 * c + x * 3.0 * d)


def deployed_modes(
    linkage: Linkage,
    stiffness: Reals,
    density: float,
    root: int,
    *,
    base: FloatingBase | None = None,
    moments: Reals | None = None,
) -> DeployedModes:
    """Compute the modes of a flat array.

    stiffness : (n_hinges,), N m/rad, from `flat_stiffness`. density : of the panels, kg/m^3. root : the panel that is
    held, or that floats with a base. base : None where the root is held. moments : (n_hinges,), N m, that hinges have
    in the flat state and that loops balance, see `geometric_stiffness`; none unless given.
    HcsearchError for numbers of hinges that differ, and for moments without balance.
    """
    if np.shape(stiffness) != (linkage.n_hinges,) or not np.isfinite(stiffness).all():
        raise HcsearchError(f"stiffnesses are one number for each hinge: give {linkage.n_hinges} finite ones")
    motions = panel_rates(linkage, density, root, linkage.flat, base)
    basis = flat_rates(linkage)
    stiff = np.diag(stiffness)
    if moments is not None:
        stiff = stiff + geometric_stiffness(linkage, moments)
    if not basis.shape[1]:
        return DeployedModes(np.zeros(0), np.zeros((0, linkage.n_hinges)), np.zeros((0, linkage.n_panels, 6)), 0)
    from scipy.linalg import eigh  # noqa: PLC0415 - loads slowly

    eigenvalues, shapes = eigh(_symmetric(basis.T @ stiff @ basis), _symmetric(basis.T @ motions.mass_matrix @ basis))
    rates = (basis @ shapes).T
    soft = int((eigenvalues <= SOFT_EIGENVALUE_SHARE * np.abs(eigenvalues).max()).sum())
    panels = np.einsum("pij,mj->mpi", motions.maps, rates)
    return DeployedModes(eigenvalues, rates, panels, soft)


def flat_rates(linkage: Linkage) -> Reals:
    """Return an orthonormal basis of the rates that close the loops of the flat array at first order, (n_hinges, m)."""
    rates = closed_rates(linkage.closure(linkage.flat)[1][None])
    basis: Reals = rates.bases(np.array([0]), int(rates.ranks[0]))[0]
    return basis


def geometric_stiffness(linkage: Linkage, moments: Reals) -> Reals:
    """Return the stiffness G of moments that hinges have in the flat state, (n_hinges, n_hinges), N m/rad.

    moments : (n_hinges,), N m, derivatives of the energy by the fold angles: positive where the hinge is driven to open
    beyond flat, as by springs, less what its own stop bears. Loops must balance them: moments = A' y for a wrench y in
    the loops. A motion with rates v then changes the energy by v' G v / 2 = -y . bend(v) / 2 at second order; this
    raises frequencies or lowers them. y is the wrench of least norm: others differ by self-stresses, which true motions
    do not feel. HcsearchError for moments that are not balanced.
    """
    moments = np.asarray(moments, float)
    if moments.shape != (linkage.n_hinges,) or not np.isfinite(moments).all():
        raise HcsearchError(f"moments are one number for each hinge: give {linkage.n_hinges} finite ones")
    jacobian = linkage.closure(linkage.flat)[1]
    wrench = np.linalg.lstsq(jacobian.T, moments, rcond=1e-9)[0]
    left = np.linalg.norm(moments - jacobian.T @ wrench)
    if left > BALANCE_TOLERANCE * np.linalg.norm(moments):
        raise HcsearchError(
            f"moments of hinges leave {left:.3g} N m without balance in the flat state: give what remains when stops "
            "bear their share, or none"
        )
    n = linkage.n_hinges
    stiffness, rows = np.empty((n, n)), np.eye(n)
    own = np.array([wrench @ linkage.bend(jacobian, row) for row in rows])
    for i in range(n):
        for j in range(i, n):
            both = own[i] if i == j else wrench @ linkage.bend(jacobian, rows[i] + rows[j])
            stiffness[i, j] = stiffness[j, i] = -own[i] if i == j else -0.5 * (both - own[i] - own[j])
    return stiffness


def _symmetric(matrix: Reals) -> Reals:
    symmetric: Reals = 0.5 * (matrix + matrix.T)
    return symmetric
