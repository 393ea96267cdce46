"""Proofs that one-sided hinges and contacts of layers lock a linkage in its folded or its flat state.

At an end of the motion every hinge is at a stop and can turn one way only. Let x >= 0 be how far each has turned. The
loops ask A x + bend(x) / 2 + ... = 0, where A holds the screws of the hinges in the sense in which they can turn.

First order: a wrench y with y . A_i > 0 for every hinge i holds them all shut, and no x >= 0 but 0 is possible
(Gordan's theorem). Second order: where some x in the cone K = {x >= 0, A x = 0} are possible to first order, a
wrench with y . A_i >= 0 and y . bend(x) > 0 on all of K but 0 excludes them: along a motion the loops would ask
y . A x + y . bend(x) / 2 = 0 up to third order, but no term of this sum is negative, and one is not zero.
Least squares or a linear program find the wrench, in floating point. Where the linkage is on a tiling the proof is then
checked in whole numbers, with rays computed anew (`lattice`, `exact_checks`), and counts only if it holds there:
`LockVerdict.exact`. Elsewhere it is numerical: its inequalities hold by far more than rounding, but its equations to
rounding. Contacts between layers (`LayerContact`) narrow K by C x >= 0. At first order they push with forces f >= 0,
and the proof is y . A_i > f . C_i for every hinge; at second order they only narrow K, as gaps have second-order
terms and contacts may slide off.
Where hinges are between their stops, they turn both ways, and only one proof is tried: closure of full column rank.
Locked means that the state is isolated: panels, hinges and stops are exact. Other states may lie near it, behind a gap
of micrometres. Nothing here says that a linkage moves: only a path shows that.

In the folded state every panel lies flat in a layer and every hinge is level. So the points of a panel rise, to first
order, by an affine function of their place in the plan: the sum over the hinges between it and the base panel. Two
panels that touch must not approach each other anywhere in the area of contact, for which its corners are sufficient.
Panels of one stack share hinges, and their stops imply this (docs/explanation/theory.md, 26); in general linkages they
need not. Side walls that touch are left out: panels have some clearance there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.kernels.linkage.cones import MAX_EXTREME_RAYS, cone_rays, nonnegative_least_squares
from hcsearch.motion.kinematics.local import bilinear_products
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.motion.locks import exact_checks
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.shape.linkage import Linkage, at_stops, hinge_tree

WRENCH_MARGIN = 1e-7
"""Minimum by which the inequalities of a candidate wrench hold, with screws and wrench of unit length; rounding is
1e-13."""

CONTACT_VIOLATION_TOLERANCE = 1e-7
"""A contact is left out where no first-order motion of sum 1 violates it by more than this."""

ZERO_SCREW_SHARE = 1e-9
"""Singular values of hinges' screws below this share of the greatest are zeros; rounding is 1e-15."""

MAX_PROOF_RAYS = 60
"""Maximum number of rays of a second-order proof, which has an inequality for every two of them."""


@dataclass(frozen=True, eq=False)
class LockVerdict(ByValue):
    """The verdict on whether a linkage can leave a state.

    order : 1 or 2 where it is proved locked, by first or by second order; None where it is not proved.
    between : whether some hinge is between its stops; then the proof is of first order, and has no wrench.
    second_order_tried : whether a proof by second order was tried; there may be too many first-order motions for that.
    wrench : the wrench of a proof, shape (n_rows,); margin : the least value of its strict inequalities.
    forces : the forces of layers in a proof, shape (n_contacts,), none negative, all 0 by second order.
        The greatest entry of wrench and forces is 1.
    motion : turns of the hinges that stops, loops and contacts allow to first order, summing to 1; None where there
        are none.
    held_hinges : hinges that no motion turns at first order.
    exact : whether it is proved in whole numbers. If not, a lock is proved but for rounding: the linkage is on no
        tiling, or some given contacts are not on its lattice.
    """

    order: Literal[1, 2] | None
    second_order_tried: bool
    wrench: Reals | None
    margin: float
    motion: Reals | None
    held_hinges: tuple[int, ...]
    forces: Reals | None = None
    exact: bool = False
    between: bool = False

    @property
    def locked(self) -> bool:
        """Whether it is proved that no motion leaves the state."""
        return self.order is not None

    @property
    def reason(self) -> str:
        """The verdict in a sentence."""
        if self.between:
            held = "the loops hold every hinge at first order, as closure has full rank there"
            return held if self.locked else "some hinges are between their stops, and the loops leave motions there"
        if self.order == 1 and self.forces is not None and self.forces.any():
            return "a wrench in the loops and layers that push each other load every hinge onto its stop"
        if self.order == 1:
            return "a wrench in the loops loads every hinge onto its stop, so none can open"
        if self.order == 2:
            return "every motion that is possible at first order opens the loops at second order"
        if self.second_order_tried:
            return "the stops allow a motion at first order, and no wrench was found that excludes it at second order"
        return (
            "the stops allow too many motions at first order to search for a wrench that excludes them at second order"
        )


def lock_at(linkage: Linkage, angles: Reals, contacts: Reals | None = None) -> LockVerdict:
    """Search for a proof that one-sided hinges cannot leave a closed state where each is at a stop, 0 or pi.

    In a state between the stops, whose hinges turn both ways, only the rank of closure is a proof.
    contacts : conditions C x >= 0 on turns x >= 0, shape (n_contacts, n_hinges), of about unit length: `contact_rows`
    in the folded state. Two-stack foldings of one circuit need none, as their stops imply them
    (docs/explanation/theory.md, 26).
    Source: thesis 2.3.3 speaks of first-order and finite motions of two-sided hinges only; the one-sided conditions
    are ours (docs/explanation/theory.md).
    """
    if not at_stops(angles).all():
        held = rank_at(linkage, angles).nullity == 0
        hinges = tuple(range(linkage.n_hinges)) if held else ()
        return LockVerdict(1 if held else None, False, None, 0.0, None, hinges, between=True)
    _, jacobian = linkage.closure(angles)
    senses = np.where(angles > 0.5 * np.pi, -1.0, 1.0)
    columns = np.ascontiguousarray((jacobian * senses).T)
    rows = np.zeros((0, len(columns))) if contacts is None else contacts

    def bend(x: Reals) -> Reals:
        return linkage.bend(jacobian, senses * x)

    chosen: list[int] = []
    while True:  # a proof with some contacts holds with all, and few are needed
        lock, motions = _verdict_with(columns, rows[chosen], bend)
        parting = (rows @ motions.T).min(axis=1, initial=0.0)
        parting[chosen] = 0.0
        if lock.locked or parting.min(initial=0.0) > -CONTACT_VIOLATION_TOLERANCE:
            break
        chosen.append(int(parting.argmin()))
    if not lock.locked:
        return lock
    exact = _holds_exactly(linkage, angles, lock, rows[chosen])
    if exact is False:
        return replace(lock, order=None, wrench=None, margin=0.0, forces=None)
    forces = np.zeros(len(rows))
    if lock.forces is not None:
        forces[chosen] = lock.forces
    return replace(lock, forces=forces, exact=exact is not None)


def _holds_exactly(linkage: Linkage, angles: Reals, lock: LockVerdict, contacts: Reals) -> bool | None:
    """Whether a proof holds in whole numbers; None where the linkage or a contact is not on a lattice."""
    assert lock.wrench is not None
    end = whole_end(linkage, angles)
    rows = None if end is None else end.contacts(contacts)
    if end is None or rows is None:
        return None
    if lock.order == 2:
        return exact_checks.proves_second_order(end, rows, lock.wrench)
    forces = np.zeros(len(contacts)) if lock.forces is None else lock.forces
    return exact_checks.proves_first_order(end, rows, lock.wrench, forces)


def _verdict_with(columns: Reals, contacts: Reals, bend: Callable[[Reals], Reals]) -> tuple[LockVerdict, Reals]:
    """The verdict with some contacts, and the motions that stops, loops and these contacts allow at first order.

    columns : shape (n, n_rows), screws in the sense in which hinges turn. Motions have the shape (n_motions, n), each
    of sum 1; all extreme ones where there are not too many.
    """
    n, height = columns.shape
    # with s >= 0, the speeds at which contacts part: A x = 0, C x - s = 0
    full = np.block([[columns, contacts.T], [np.zeros((len(contacts), height)), -np.eye(len(contacts))]])
    lengths = np.sqrt((full**2).sum(axis=1))
    free = np.flatnonzero(lengths == 0.0)  # hinges in no loop
    if len(free) or not n:
        motions = np.eye(n)[free]
        return LockVerdict(None, True, None, 0.0, motions.sum(axis=0) / max(len(free), 1), ()), motions
    unit = full / lengths[:, None]
    x, wrench, margin = _first_order(unit)
    if margin > WRENCH_MARGIN:
        lock = LockVerdict(1, True, wrench[:height], margin, None, tuple(range(n)), -wrench[height:])
        return lock, np.zeros((0, n))
    rays = np.empty((MAX_EXTREME_RAYS, len(unit)))
    count = cone_rays(unit, rays)
    motions = np.r_[x[None], rays[: max(count, 0)]][:, :n] / lengths[:n]
    motions /= motions.sum(axis=1)[:, None]
    if not 0 < count <= MAX_PROOF_RAYS:
        return LockVerdict(None, False, None, 0.0, motions[0], ()), motions
    motions = motions[1:]
    proof = excluding_wrench(columns, motions, bilinear_products(motions, bend))
    held_hinges = tuple(int(k) for k in np.flatnonzero(motions.max(axis=0) <= 1e-9))
    motion = motions.mean(axis=0)
    if proof is None:
        return LockVerdict(None, True, None, 0.0, motion, held_hinges), motions
    return LockVerdict(2, True, proof[0], proof[1], motion, held_hinges), motions


def _first_order(columns: Reals) -> tuple[Reals, Reals, float]:
    """The x >= 0 of sum 1 with the least |A x|, the separating wrench of greatest entry 1, and its least power.

    Where the power is positive the wrench holds every hinge shut; else A x is 0 but for rounding.
    """
    n, height = columns.shape
    x, residual = np.empty(n), np.empty(height + 1)
    nonnegative_least_squares(np.c_[columns, np.ones(n)], np.r_[np.zeros(height), 1.0], x, residual)
    wrench = -residual[:height] / max(np.abs(residual[:height]).max(), np.finfo(float).tiny)
    return x, wrench, float((columns @ wrench).min())


def excluding_wrench(columns: Reals, rays: Reals, bends: Reals) -> tuple[Reals, float] | None:
    """A wrench y, of greatest entry 1, that excludes motions at second order, and its margin; None without one.

    columns : shape (n, n_rows), screws in the sense in which hinges turn. rays : of the cone K. bends :
        `bilinear_products` of the rays.
    On hinges that can turn at first order y has no power. It must hold the others shut, with y . bend positive for
    every ray and not negative for every two rays, which suffices for all their sums.
    """
    if not columns.shape[1]:
        return None
    turning = rays.max(axis=0) > 1e-9
    held_columns = columns[~turning & columns.any(axis=1)]  # contacts hold hinges in no loop
    _, sizes, right = np.linalg.svd(columns[turning])
    basis = right[(sizes > ZERO_SCREW_SHARE * sizes.max()).sum() :].T  # shape (n_rows, freedom of y)
    if not basis.shape[1]:
        return None
    squares = bends.diagonal(axis1=0, axis2=1).T
    first, second = np.triu_indices(len(rays), 1)
    positive, crossing = np.r_[held_columns, squares], bends[first, second]
    for candidate in _candidate_wrenches(positive @ basis, crossing @ basis, basis, len(rays)):
        wrench = candidate / np.abs(candidate).max()
        margin = float((positive @ wrench).min())
        # products of two rays may be a little below zero by rounding: products of a ray with itself outweigh them
        if margin > WRENCH_MARGIN and margin > -2 * len(rays) * float((crossing @ wrench).min(initial=0.0)):
            return wrench, margin
    return None


def _candidate_wrenches(positive: Reals, nonnegative: Reals, basis: Reals, n_rays: int) -> Iterator[Reals]:
    """Wrenches that may exclude all motions: from least squares, with positive powers only, or from a linear program.

    Where least squares prove that no wrench has the margin, the linear program is left out: rows that sum to r with
    weights >= 0 have powers that sum to r . y, at most |r| |y|, and |y| is bounded, as its greatest entry is 1.
    """
    rows = np.r_[positive, nonnegative]
    lengths = np.sqrt((rows**2).sum(axis=1))
    if (lengths[: len(positive)] < ZERO_SCREW_SHARE).any():
        return
    nonzero = lengths > ZERO_SCREW_SHARE
    turns, wrench, margin = _first_order(np.ascontiguousarray(rows[nonzero] / lengths[nonzero, None]))
    if margin > 0.0:
        yield basis @ wrench
    weights = np.zeros(len(rows))
    weights[nonzero] = turns / lengths[nonzero]
    power = np.sqrt(len(basis)) * np.linalg.norm(weights @ rows)
    if power > WRENCH_MARGIN * (weights[: len(positive)].sum() - weights[len(positive) :].sum() / (2 * n_rays)):
        best = _best_wrench(positive, nonnegative, basis)
        if best is not None:
            yield best


def _best_wrench(positive: Reals, nonnegative: Reals, basis: Reals) -> Reals | None:
    """The wrench of the greatest margin, by a linear program; None where that fails."""
    from scipy.optimize import linprog  # noqa: PLC0415 - takes longer to load than most runs of the stage

    # bound the wrench's entries, not its coordinates, so that its margin does not depend on the basis
    upper = np.r_[-positive, -nonnegative, basis, -basis]
    margin_column = np.r_[np.ones(len(positive)), np.zeros(len(upper) - len(positive))]
    upper_bounds = np.r_[np.zeros(len(positive) + len(nonnegative)), np.ones(2 * len(basis))]
    bounds = [(None, None)] * basis.shape[1] + [(None, 1.0)]
    objective = np.r_[np.zeros(basis.shape[1]), -1.0]
    result = linprog(objective, A_ub=np.c_[upper, margin_column], b_ub=upper_bounds, bounds=bounds, method="highs")
    if result.status != 0 or not result.x[:-1].any():
        return None
    wrench: Reals = basis @ result.x[:-1]
    return wrench


TOUCHING_LAYER_SHARE = 1e-3
"""Layers nearer than this share of the thickness touch; folded states have them at whole multiples of the thickness."""
CONTACT_GRID_SHARE = 1e-12
"""Grid of areas of contact, as a share of a panel's size; without a grid, rounding merges triangles that lie beside
each other."""
MIN_CONTACT_SHARE = 1e-8
"""Lengths and areas of contact below this share of a panel are due to rounding: facets touch along an edge at most."""
MIN_PARTING_SHARE = 1e-9
"""A hinge parts two panels if a turn by 1 rad changes their vertical distance by more than this share of their size."""


@dataclass(frozen=True, eq=False)
class LayerContact(ByValue):
    """The contact of two facets of different panels, one on the other, in the folded state.

    corners : of the area of contact, seen from above, shape (k, 2), in metres, in the frame of the base panel.
    """

    below: int
    above: int
    corners: Reals


def layer_contacts(linkage: Linkage) -> list[LayerContact]:
    """All contacts between facets of different panels in the folded state, except across a crease.

    Two facets that share a crease lie on one side of its hinge, whose stop keeps them apart.
    """
    import shapely  # noqa: PLC0415 - takes longer to load than most proofs take

    size, thickness, panel = linkage.pattern.size, linkage.pattern.thickness, np.array(linkage.pattern.panel_of)
    solids = linkage.solids(linkage.folded)
    low, high = (np.array([end(solid, axis=(0, 1)) for solid in solids]) for end in (np.min, np.max))
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    touch = (np.abs(shared[..., 2]) < TOUCHING_LAYER_SHARE * thickness) & (
        shared[..., :2] > MIN_CONTACT_SHARE * size
    ).all(axis=2)
    touch &= (panel[:, None] != panel) & (low[:, None, 2] < low[:, 2])
    for i, j in linkage.pattern.creases:
        touch[i, j] = touch[j, i] = False
    below, above = np.nonzero(touch)
    shadows = np.array([shapely.Polygon(solid[0, :, :2] / size) for solid in solids])
    # convex but for rounding, which may leave lines along edges
    areas = shapely.convex_hull(shapely.intersection(shadows[below], shadows[above], grid_size=CONTACT_GRID_SHARE))
    return [
        LayerContact(i, j, shapely.get_coordinates(area.exterior)[:-1] * size)
        for i, j, area in zip(below.tolist(), above.tolist(), areas, strict=True)
        if area.area > MIN_CONTACT_SHARE
    ]


def parting_rates(linkage: Linkage, touching: list[LayerContact]) -> Reals:
    """Speeds at which panels part at the corners of contacts, for each hinge that leaves its stop at unit rate.

    Shape (n_corners, n_hinges), as shares of the pattern's size; the corners of one contact are consecutive rows.
    Panels that no hinges connect have zeros.
    """
    panel, rise = linkage.pattern.panel_of, _rise(linkage)
    # the shortest path between two panels that share a hinge is that hinge, and their row has no other entry
    trees = {base: hinge_tree(linkage.pattern, base) for base in {panel[contact.below] for contact in touching}}
    rows = [np.zeros((0, linkage.n_hinges))]
    for contact in touching:
        coefficients = np.zeros((linkage.n_hinges, 3))
        base, panel_above = panel[contact.below], panel[contact.above]
        if trees[base].roots[panel_above] == base:
            for k, sign in trees[base].way(panel_above):
                coefficients[k] = sign * rise[k]
        corners = contact.corners / linkage.pattern.size
        rows.append(np.c_[corners, np.ones(len(corners))] @ coefficients.T)
    return np.concatenate(rows)


def _rise(linkage: Linkage) -> Reals:
    """Coefficients of the rise that each hinge causes as it leaves its stop in the folded state, shape (n_hinges, 3).

    Relative to its first panel the second rises by a x + b y + c at a point (x, y) of the plan, in units of size.
    """
    first = [hinge.first for hinge in linkage.pattern.hinges]
    poses = linkage.poses(linkage.folded)[first]
    u = np.einsum("kij,kj->ki", poses[:, :, :3], linkage.directions)
    p = (np.einsum("kij,kj->ki", poses[:, :, :3], linkage.points) + poses[:, :, 3]) / linkage.pattern.size
    senses = np.where(linkage.folded > 0.0, -1.0, 1.0)
    # the third component of u x (r - p)
    rises: Reals = senses[:, None] * np.stack([-u[:, 1], u[:, 0], u[:, 1] * p[:, 0] - u[:, 0] * p[:, 1]], axis=1)
    return rises


def contact_rows(linkage: Linkage) -> Reals:
    """Contacts of the folded state as conditions C x >= 0 on the turns x >= 0 of its hinges, for `lock_at`.

    Shape (n_conditions, n_hinges), as shares of the pattern's size; without duplicates and conditions that x >= 0
    implies.
    """
    rows = parting_rates(linkage, layer_contacts(linkage))
    rows[np.abs(rows) < MIN_PARTING_SHARE] = 0.0
    rows = rows[(rows < 0.0).any(axis=1)]
    _, chosen = np.unique(rows.round(9), axis=0, return_index=True)
    distinct: Reals = rows[np.sort(chosen)]
    return distinct
