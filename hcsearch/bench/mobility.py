"""The bench `mobility`: the stage's time for each folding, and which foldings are locked and what would free them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from hcsearch.bench.machine import Machine, this_machine
from hcsearch.bench.tables import Table, save
from hcsearch.enumeration import FoldedSearch
from hcsearch.folding import Folding, fold, folding_at
from hcsearch.grid import grid_named
from hcsearch.kinematics.locks import Lock, lock_at
from hcsearch.linkage import Linkage
from hcsearch.mobility import mobility
from hcsearch.records import CircuitBatch, FoldingBatch
from hcsearch.scenes import PanelSize, default_panel
from hcsearch.twisting import twist_batch

SIZES: dict[str, tuple[int, ...]] = {
    "hex": (6, 8, 10, 12, 14, 16),
    "square": (8, 10, 12, 14, 16, 18, 20),
    "triangle": (10, 14, 18, 22, 26),
}
QUICK: dict[str, tuple[int, ...]] = {"hex": (10, 12), "square": (12,), "triangle": (10, 14)}
MOST_LOCKED = 400  # foldings that are tried in other ways, of one grid and n
THICKNESSES = (0.1, 10.0)


@dataclass(frozen=True)
class SpeedRow:
    """The stage `mobility` over all untwisted designs of n panels; medians of `runs`, one core, warm.

    stage_s : freedoms, merges and locks. folding_us : of one folding, all of it. freedom_us : its freedoms alone, the
    ranks at both ends and at a generic state.
    """

    grid: str
    n: int
    designs: int
    foldings: int
    stage_s: float
    folding_us: float
    freedom_us: float
    runs: int


@dataclass(frozen=True)
class LockRow:
    """Untwisted foldings of n panels that are proved locked with flat pairs rigid, and what becomes of them.

    folded_1, folded_2, flat_1, flat_2 : at which end and by which order. locked : by any. designs_locked : designs
    all untwisted foldings of which are. Of those `tried`: still locked with flat pairs hinged, with panels a tenth and
    ten times as thick. merged : untwisted foldings with a mirror axis that are locked, and still so when merged.
    play_least, play_most : what a gap at every stop lets the freest hinge turn, in gaps, at most and to first order:
    at the tightest and at the loosest first-order lock. margin : the least by which a proof's inequalities hold.
    """

    grid: str
    n: int
    foldings: int
    locked: int
    folded_1: int
    folded_2: int
    flat_1: int
    flat_2: int
    designs: int
    designs_locked: int
    tried: int
    hinged: int
    thin: int
    thick: int
    merged: str
    play_least: float | None
    play_most: float | None
    margin: float | None


@dataclass(frozen=True)
class Report:
    """All that one run of the bench measured."""

    machine: Machine
    speed: list[SpeedRow]
    locks: list[LockRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved."""
        return [
            Table(
                "mobility-speed",
                "The stage mobility",
                "All untwisted designs up to symmetry with all their untwisted foldings, on one core, compiled before, "
                "medians. `folding_us` is the whole stage for one folding (freedoms, merges, proofs of locks), "
                "`freedom_us` the ranks folded, flat and at a generic closed state.",
                self.speed,
            ),
            Table(
                "locks",
                "Locked foldings, and what frees them",
                "Untwisted foldings that are proved locked with flat pairs rigid, in the folded or the flat state, by "
                "first or second order (a folding may be in several columns); of those `tried`, how many are still "
                "proved locked with flat pairs hinged, or with panels a tenth or ten times as thick; `merged`: of "
                "foldings with a mirror axis, how many are locked without and with their panels merged; `play`: the "
                "most a hinge can turn to first order, in multiples of the gap, when every stop has a gap, at the "
                "tightest and the loosest first-order lock; `margin`: the least by which an inequality of a proof "
                "holds, screws and wrench being of about unit length.",
                self.locks,
            ),
        ]


def measure(*, quick: bool = False, repeats: int = 3, say: Callable[[str], None] = print) -> Report:
    """Run the whole bench: some minutes, or seconds when `quick`."""
    machine = this_machine()
    speed, locks = measure_mobility(QUICK if quick else SIZES, repeats=1 if quick else repeats, say=say)
    return Report(machine, speed, locks)


def measure_mobility(
    sizes: Mapping[str, Sequence[int]], *, repeats: int, say: Callable[[str], None]
) -> tuple[list[SpeedRow], list[LockRow]]:
    """A row of each kind for each grid and n."""
    speed, locks = [], []
    for grid, ns in sizes.items():
        _stage_times(*_untwisted(grid, ns[0]), 1)  # load the compiled kernels first
        for n in ns:
            say(f"{grid} n={n}")
            circuits, foldings = _untwisted(grid, n)
            if not len(foldings):
                continue
            stage, freedom = _stage_times(circuits, foldings, repeats)
            each = 1e6 / len(foldings)
            speed.append(SpeedRow(grid, n, len(circuits), len(foldings), stage, stage * each, freedom * each, repeats))
            locks.append(_locks(circuits, foldings))
    return speed, locks


def _untwisted(grid: str, n: int) -> tuple[CircuitBatch, FoldingBatch]:
    """All untwisted designs and their untwisted foldings: all foldings of a circuit have one twist."""
    batches = FoldedSearch(grid_named(grid), n, untwisted=True).batches()
    words = np.concatenate([np.empty((0, n), np.int8), *(batch.words for batch in batches)])
    circuits = CircuitBatch(grid, words, np.ones(len(words), np.int16))
    foldings = fold(circuits)
    untwisted = twist_batch(circuits, foldings) == 0
    return circuits, FoldingBatch(foldings.row[untwisted], foldings.crease[untwisted])


def _stage_times(circuits: CircuitBatch, foldings: FoldingBatch, repeats: int) -> tuple[float, float]:
    """Median seconds of the whole stage, and without proofs of locks."""
    twists = np.zeros(len(foldings), np.int16)
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(repeats):
        for into, locks in zip(times, (True, False), strict=True):
            begun = time.perf_counter()
            mobility(circuits, foldings, twists, locks=locks)
            into.append(time.perf_counter() - begun)
    return median(times[0]), median(times[1])


def _locks(circuits: CircuitBatch, foldings: FoldingBatch) -> LockRow:
    grid, n = circuits.grid, circuits.words.shape[1]
    found = mobility(circuits, foldings, np.zeros(len(foldings), np.int16))
    panel = default_panel(grid)
    locked = [folding_at(circuits, foldings, i) for i in np.flatnonzero(found.locked).tolist()]
    ends = [_ends(folding, panel) for folding in locked]
    free = np.bincount(foldings.row[~found.locked], minlength=len(circuits)) > 0
    tried = locked[:MOST_LOCKED]
    mirrored = [folding_at(circuits, foldings, i) for i in np.flatnonzero(found.merged_panels > 0).tolist()]
    before = sum(_is_locked(_ends(folding, panel)) for folding in mirrored)
    after = sum(_is_locked(_ends(folding, panel, merged=True)) for folding in mirrored)
    thin, thick = (
        sum(_is_locked(_ends(folding, (panel[0], panel[1], factor * panel[2]))) for folding in tried)
        for factor in THICKNESSES
    )
    plays = [_play(folding, panel, end) for folding, pair in zip(locked, ends, strict=True) for end in pair.items()]
    known = [play for play in plays if play is not None]
    return LockRow(
        grid=grid,
        n=n,
        foldings=len(foldings),
        locked=len(locked),
        folded_1=sum(pair["folded"].order == 1 for pair in ends),
        folded_2=sum(pair["folded"].order == 2 for pair in ends),
        flat_1=sum(pair["flat"].order == 1 for pair in ends),
        flat_2=sum(pair["flat"].order == 2 for pair in ends),
        designs=len(circuits),
        designs_locked=int((~free).sum()),
        tried=len(tried),
        hinged=sum(_is_locked(_ends(folding, panel, hinged=True)) for folding in tried),
        thin=thin,
        thick=thick,
        merged=f"{before} -> {after} of {len(mirrored)}",
        play_least=min(known, default=None),
        play_most=max(known, default=None),
        margin=min((lock.margin for pair in ends for lock in pair.values() if lock.locked), default=None),
    )


def _ends(folding: Folding, panel: PanelSize, *, hinged: bool = False, merged: bool = False) -> dict[str, Lock]:
    linkage = Linkage(folding.pattern(panel, hinged=hinged, merged=merged))
    return {"folded": lock_at(linkage, linkage.folded), "flat": lock_at(linkage, linkage.flat)}


def _is_locked(ends: dict[str, Lock]) -> bool:
    return any(lock.locked for lock in ends.values())


def _play(folding: Folding, panel: PanelSize, end: tuple[str, Lock]) -> float | None:
    """Turn of the freest hinge in multiples of a gap at all stops, at most, by a first-order lock's own wrench.

    With x_i >= -gap the wrench y bounds every turn: y . A x = 0 makes (y . A_i) x_i at most the sum of the other
    powers times the gap.
    """
    name, lock = end
    if lock.order != 1 or lock.wrench is None:
        return None
    linkage = Linkage(folding.pattern(panel))
    _, jacobian = linkage.closure(getattr(linkage, name))
    powers = np.abs(lock.wrench @ jacobian)
    return float((powers.sum() - powers.min()) / powers.min())


def save_report(report: Report, folder: Path) -> None:
    """Write tables and the machine into a folder."""
    save(report.tables, report.machine, folder, "mobility", "# Bench: mobility")
