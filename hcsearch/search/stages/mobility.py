"""Stage `mobility`: degrees of freedom and locks of whole batches of foldings, in the scene `default`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.grid import Grid, grid_named
from hcsearch.designs.panel_sizes import PanelSize, default_panel
from hcsearch.designs.records import NO_NUMBER, CircuitBatch, FoldingBatch, MobilityBatch, StagedDesigns
from hcsearch.kernels.linkage.cones import END_LOCKED, END_OPEN, END_PASSED, settle_ends
from hcsearch.kernels.linkage.hinge_lines import EdgeTables, survey_ends
from hcsearch.kernels.linkage.loops import generic_states
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL
from hcsearch.motion.kinematics.numerical_rank import MAX_GENERIC_ATTEMPTS, decide_rank, generic_rank, leaving_step
from hcsearch.scenes import Scene
from hcsearch.search.stages.stage import Stage
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import facet_area

_TOGETHER = 4000  # foldings per part: hinge lines and Jacobians take some 3 kB each


@dataclass(frozen=True, eq=False)
class _Lattice(ByValue):
    """A grid for `survey_ends`: its edges, the matrix that maps their units to metres, and lengths in metres."""

    tables: EdgeTables
    basis: Reals
    thickness: float
    size: float


@lru_cache(maxsize=16)
def _lattice(grid: Grid) -> _Lattice:
    length, width, thickness = default_panel(grid.name)
    towards = np.full((grid.kinds, grid.directions), -1)
    edges = []
    for step, (kind, _) in enumerate(grid.step_kinds):
        towards[kind, grid.step_directions[step]] = step
        centre = grid.corner_scale * np.array(grid.point((0, 0, kind)))
        edges.append((np.array(grid.edge_corners((0, 0, kind), step)) - centre).ravel())
    kinds = np.array(grid.step_kinds)[:, 0].copy()
    tables = EdgeTables(
        grid.directions,
        np.array(grid.step_directions),
        kinds,
        towards,
        np.array(grid.steps),
        np.array(edges),
        grid.corner_scale,
    )
    unit = np.array([grid.position((1, 0)), grid.position((0, 1))]).T
    area = facet_area(grid.corners((0, 0, 0)))
    return _Lattice(
        tables, np.diag([length, width]) @ unit / grid.corner_scale, thickness, math.sqrt(area * length * width)
    )


def mobility_of_batch(
    circuits: CircuitBatch, foldings: FoldingBatch, twists: NDArray[np.int16], *, locks: bool = True
) -> MobilityBatch:
    """Compute degrees of freedom and, if `locks`, proofs of locks for a batch of foldings.

    Flat pairs are hinged for the freedoms; `locked` is for rigid and `locked_hinged` for hinged ones. `dof` is the
    least nullity at generic closed states near the folded one. The ranks at the two ends and locks are exact; ranks and
    first-order locks do not depend on the size of panels (docs/explanation/theory.md). Source: thesis 2.3.3, 3.2.2.
    """
    parts = []
    for at in range(0, max(len(foldings), 1), _TOGETHER):
        rows = slice(at, at + _TOGETHER)
        part = FoldingBatch(foldings.row[rows], foldings.crease[rows])
        parts.append(_part(circuits, part, twists[rows] == 0, locks))
    columns: dict[str, Any] = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(MobilityBatch)
        if field.name != "kutzbach"
    }
    return replace(parts[0], **columns)


def locked_in_every_way(batch: MobilityBatch, allowed: Sequence[Way]) -> Flags:
    """Return which foldings are proved locked for every joining of flat pairs that a scene allows.

    Where hinged pairs are allowed they decide, since a folding locked with them is also locked with rigid and merged
    ones.
    """
    return batch.locked_hinged if "hinged" in allowed else batch.locked


def locks_with_panel(
    circuits: CircuitBatch, foldings: FoldingBatch, locks: tuple[Flags, Flags], panel: PanelSize
) -> tuple[Flags, Flags]:
    """Return which foldings locked in the scene `default` are proved locked with panels of another size, too.

    locks : (n_foldings,) each, with rigid and with hinged flat pairs. Locks of first order do not depend on the size of
    panels; locks of second order may.
    """
    if panel == default_panel(circuits.grid):
        return locks
    from hcsearch.motion.locks.end_locks import lock_at  # noqa: PLC0415 - loads slowly

    proved = tuple(np.zeros(len(foldings), bool) for _ in locks)
    for hinged, (known_flags, proved_flags) in enumerate(zip(locks, proved, strict=True)):
        for i in np.flatnonzero(known_flags).tolist():
            linkage = Linkage(folding_at(circuits, foldings, i).pattern(panel, flat_pairs=("rigid", "hinged")[hinged]))
            proved_flags[i] = any(lock_at(linkage, angles).locked for angles in (linkage.folded, linkage.flat))
    return proved[0], proved[1]


def _part(circuits: CircuitBatch, foldings: FoldingBatch, untwisted: NDArray[np.bool_], locks: bool) -> MobilityBatch:
    words, lattice = circuits.words, _lattice(grid_named(circuits.grid))
    count, n = len(foldings), words.shape[1]
    rows, creases = foldings.row.astype(np.int32), foldings.crease.astype(np.int16)
    basis, thickness, size = lattice.basis, lattice.thickness, lattice.size
    ranks, mirrors = np.empty((count, 2), np.int64), np.empty((count, 2), np.int64)
    lines, screws = np.empty((count, 2, n, 5), np.int64), np.empty((count, 2, n, 6))
    survey_ends(words, rows, creases, lattice.tables, basis, thickness, size, ranks, mirrors, lines, screws)
    merged_pairs, joints = mirrors.T
    dof, dof_merged = np.full(count, NO_NUMBER), np.full(count, NO_NUMBER)
    dof[untwisted] = _generic(screws[untwisted, 1])
    for i in np.flatnonzero(untwisted & (merged_pairs > 0)).tolist():
        nullity = generic_rank(_linkage(folding_at(circuits, foldings, i), "merged")).nullity
        dof_merged[i] = NO_NUMBER if nullity is None else nullity
    needed = np.repeat((untwisted & locks)[:, None], 2, axis=1)
    rigid = _ends(circuits, foldings, needed, lines, screws, hinged=False)
    locked = (rigid == END_LOCKED).any(axis=1)
    # a motion with rigid pairs is one with hinged pairs: an end that is not locked with rigid ones is not locked hinged
    needed = locked[:, None] & (rigid != END_PASSED)
    locked_hinged = (_ends(circuits, foldings, needed, lines, screws, hinged=True) == END_LOCKED).any(axis=1)
    return MobilityBatch(
        kutzbach=6 * (n - 1) - 5 * n,
        dof=dof,
        dof_folded=n - ranks[:, 0],
        dof_flat=n - ranks[:, 1],
        merged_panels=merged_pairs,
        kutzbach_merged=np.where(merged_pairs > 0, 6 * (n - merged_pairs - 1) - 5 * (n - 2 - joints), NO_NUMBER),
        dof_merged=dof_merged,
        locked=locked,
        locked_hinged=locked_hinged,
    )


def _ends(
    circuits: CircuitBatch, foldings: FoldingBatch, needed: Flags, lines: WholeNumbers, screws: Reals, *, hinged: bool
) -> NDArray[np.int8]:
    """Return END_LOCKED, END_PASSED or END_OPEN for the ends of foldings, shape (n_foldings, 2).

    needed : ends to be settled, the others are END_PASSED. hinged : whether flat pairs are hinged, else rigid. An end
    stays END_OPEN where the other one is proved locked without long proofs.
    """
    from hcsearch.motion.locks.end_locks import lock_at  # noqa: PLC0415 - loads slowly

    n = lines.shape[2]
    hinged_creases = [i for i in range(n) if hinged or i not in (n // 2 - 1, n - 1)]
    settled = np.empty(int(needed.sum()), np.int8)
    hinge_lines = np.ascontiguousarray(lines[needed][:, hinged_creases])
    settle_ends(hinge_lines, np.ascontiguousarray(screws[needed][:, hinged_creases]), settled)
    verdicts = np.full(needed.shape, END_PASSED, np.int8)
    verdicts[needed] = settled
    for i in np.flatnonzero((verdicts == END_OPEN).any(axis=1) & (verdicts != END_LOCKED).all(axis=1)).tolist():
        linkage = _linkage(folding_at(circuits, foldings, i), "hinged" if hinged else "rigid")
        for end, angles in enumerate((linkage.folded, linkage.flat)):
            if verdicts[i, end] == END_OPEN:
                verdicts[i, end] = END_LOCKED if lock_at(linkage, angles).locked else END_PASSED
            if verdicts[i, end] == END_LOCKED:
                break
    return verdicts


def _linkage(folding: Folding, flat_pairs: Way) -> Linkage:
    return Linkage(folding.pattern(default_panel(folding.circuit.grid.name), flat_pairs=flat_pairs))


def _generic(screws: Reals) -> WholeNumbers:
    """Return the least nullity at closed states near the folded one; NO_NUMBER where no rank is decided.

    screws : shape (n_loops, n, 6), in the flat state, moments divided by the panel's size.
    """
    count, n, _ = screws.shape
    directions = np.ascontiguousarray(screws[:, :, :3])
    points = np.cross(directions, screws[:, :, 3:])
    folded = np.full(n, math.pi)
    folded[[n // 2 - 1, n - 1]] = 0.0
    nullities = np.full(count, NO_NUMBER)
    undecided = np.arange(count)
    for attempt in range(MAX_GENERIC_ATTEMPTS):
        jacobians, residuals = np.empty((len(undecided), 6, n)), np.empty(len(undecided))
        generic_states(
            directions[undecided], points[undecided], folded, leaving_step(folded, attempt), 1.0, jacobians, residuals
        )
        values = np.linalg.svd(jacobians, compute_uv=False)
        for i, singular, residual in zip(undecided, values, residuals, strict=True):
            nullity = decide_rank(singular, n, float(residual)).nullity if residual <= CLOSED_LOOP_RESIDUAL else None
            if nullity is not None and (nullities[i] == NO_NUMBER or nullity < nullities[i]):
                nullities[i] = nullity
        undecided = undecided[
            (nullities[undecided] == NO_NUMBER) | (nullities[undecided] > max(n - 6, 0))
        ]  # no rank is greater than 6
        if not len(undecided):
            break
    return nullities


def _run(designs: StagedDesigns, _scene: Scene) -> StagedDesigns:
    assert designs.twists is not None
    mobility = mobility_of_batch(designs.circuits, designs.folded, designs.twists)
    return designs.with_folding_results(mobility=mobility)


def _passed(designs: StagedDesigns, _scene: Scene) -> Flags:
    """Return which designs have an untwisted folding that is not proved locked for every joining of flat pairs."""
    assert designs.twists is not None
    assert designs.mobility is not None
    return designs.with_folding((designs.twists == 0) & ~locked_in_every_way(designs.mobility, WAYS))


STAGE = Stage("mobility", 2, _run, _passed)
