"""Loops closed by springs with dampers across the welds, in place of exact closure.

Every row counts, so nothing has to be decided where rows say nothing new: what is singular for exact closure is not
for springs. They are stiff, and meant for linearly implicit steps, whose equations are those of exact closure with
rows that yield a little.
"""

from __future__ import annotations

from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.multibody.tree import BodyTree, Work
from hcsearch.kernels.multibody.welds import close_rows, factor_chosen_rows, weld_errors, weld_rates


@lean
def spring_forces(tree: BodyTree, stiffness: float, damping: float, work: Work) -> None:
    """Write the forces of the rows: -k g - c g'; after `place` and `move`."""
    weld_errors(tree, work, work.errors)
    weld_rates(tree, work, work.opening)
    for r in range(len(work.forces)):
        work.forces[r] = -stiffness * work.errors[r] - damping * work.opening[r]


@lean
def forces_ahead(tree: BodyTree, stiffness: float, damping: float, h: float, work: Work) -> None:
    """Write the forces of the rows as they will be after a time h; after `gather` and `load`.

    Then the gap is g + h g' + h^2 g'', its rate g' + h g'': with g'' linear in the forces, a row yields by
    1 / (h^2 k + h c).
    """
    m = len(work.forces)
    stiff = h * (h * stiffness + damping)
    weld_errors(tree, work, work.errors)
    weld_rates(tree, work, work.opening)
    for r in range(m):
        work.chosen[r] = r
        work.delassus[r, r] += 1.0 / stiff
        work.rates[r] += (stiffness * work.errors[r] + (h * stiffness + damping) * work.opening[r]) / stiff
    work.chosen_count[0] = m
    factor_chosen_rows(work, 0.0)
    close_rows(work, work.rates)


@lean
def spring_loss(damping: float, work: Work) -> float:
    """Power lost in the dampers, where `weld_rates` wrote the rates of the rows last."""
    lost = 0.0
    for r in range(len(work.opening)):
        lost += damping * work.opening[r] ** 2
    return lost


@lean
def spring_energy(tree: BodyTree, stiffness: float, damping: float, work: Work) -> tuple[float, float]:
    """Energy in the springs, and power lost in their dampers; after `place` and `move`."""
    stored = lost = 0.0
    if stiffness > 0.0:
        weld_errors(tree, work, work.errors)
        weld_rates(tree, work, work.opening)
        for r in range(len(work.forces)):
            stored += 0.5 * stiffness * work.errors[r] ** 2
        lost = spring_loss(damping, work)
    return stored, lost
