"""What a mechanism does next: accelerations with its loops closed, and the projection of a state onto closure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.multibody.hinges import Hinges, Struts, joint_torques, pull_struts
from hcsearch.kernels.multibody.sweeps import gather, load, move, place, release
from hcsearch.kernels.multibody.tree import PULL_COUPLE, PULL_FORCE, Tree, Work
from hcsearch.kernels.multibody.vectors import put
from hcsearch.kernels.multibody.welds import choose, close_rows, factorise, weld_errors, weld_rates

Reals = NDArray[np.float64]
Signs = NDArray[np.int8]


class Mechanism(NamedTuple):
    """Bodies and what acts on them."""

    tree: Tree
    hinges: Hinges
    struts: Struts


class Hold(NamedTuple):
    """The discrete part of a state.

    held : (n,), -1 at the lower stop, 1 at the upper, 0 free. branches : (n,), 0 straight, 1 bent (laws with a snap).
    """

    held: Signs
    branches: Signs


@compiled
def accelerate(
    mechanism: Mechanism, hold: Hold, q: Reals, v: Reals, scale: float, fresh: bool, work: Work, found: Reals
) -> bool:
    """Write the joint accelerations, at held joints what holds them; whether the chosen rows were independent.

    scale : of `choose`. fresh : whether to choose rows anew. The forces of the rows are left in `work.forces`.
    """
    tree = mechanism.tree
    place(tree, q, work)
    move(tree, v, work)
    if len(mechanism.struts.stiffness):
        for i in range(len(q)):
            put(work.bodies, i, PULL_COUPLE, (0.0, 0.0, 0.0))
            put(work.bodies, i, PULL_FORCE, (0.0, 0.0, 0.0))
        pull_struts(mechanism.struts, work)
    gather(tree, hold.held, work)
    joint_torques(mechanism.hinges, hold.branches, q, v, work.torques)
    load(tree, hold.held, work.torques, True, work)
    if fresh:
        choose(work, scale)
    good = factorise(work, scale)
    close_rows(work, work.rates)
    release(tree, hold.held, True, work, found)
    return good


@compiled
def largest_pivot(tree: Tree, q: Reals, work: Work) -> float:
    """Largest diagonal entry of the Delassus matrix with all joints free, which pivots are compared to."""
    n = len(q)
    place(tree, q, work)
    move(tree, np.zeros(n), work)
    gather(tree, np.zeros(n, np.int8), work)
    largest = 0.0
    for r in range(len(tree.rows)):
        largest = max(largest, work.delassus[r, r])
    return largest


@compiled
def project(tree: Tree, held: Signs, q: Reals, v: Reals, closed: float, work: Work) -> tuple[float, float]:
    """Move a state to the nearest closed one, by the metric of the masses; the residual and rate that are left.

    Newton with the factor that `work` holds, so near to the state it was made at. closed : residual (and rate) at which
    to stop; three steps at most.
    """
    n = len(q)
    still, change = np.zeros(n), np.empty(n)
    worst = rate = 0.0
    for k in range(4):
        place(tree, q, work)
        worst = weld_errors(tree, work, work.errors)
        if worst <= closed or k == 3:
            break
        _correct(tree, held, still, change, work)
        q += change
    for k in range(3):
        move(tree, v, work)
        rate = weld_rates(tree, work, work.errors)
        if rate <= closed or k == 2:
            break
        _correct(tree, held, still, change, work)
        v += change
    return worst, rate


@compiled
def _correct(tree: Tree, held: Signs, still: Reals, change: Reals, work: Work) -> None:
    """The change of joint coordinates, or velocities, that takes away the errors."""
    load(tree, held, still, False, work)
    close_rows(work, work.errors)
    release(tree, held, False, work, change)
    for i in range(len(change)):
        if held[i]:
            change[i] = 0.0
