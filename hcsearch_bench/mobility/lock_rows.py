"""What the bench `mobility` measures: the stage's time for each folding, locks, and what would release them."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import PanelSize, default_panel
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.motion.locks.end_locks import LockVerdict, lock_at
from hcsearch.motion.locks.tightness import Tightness, tightness
from hcsearch.search.enumeration import FoldedSearch
from hcsearch.search.stages.mobility import mobility_of_batch
from hcsearch.shape.linkage import Linkage
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.foldings import packed, untwisted

SIZES: dict[str, tuple[int, ...]] = {
    "hex": (6, 8, 10, 12, 14, 16),
    "square": (8, 10, 12, 14, 16, 18, 20),
    "triangle": (10, 14, 18, 22, 26),
}
QUICK: dict[str, tuple[int, ...]] = {"hex": (10, 12), "square": (12,), "triangle": (10, 14)}
MOST_LOCKED = 400  # foldings that are tried in other ways, of one grid and n
LISTED = 20  # locked foldings of one grid and n that are listed one by one
HAIR = 1e-4  # m: a lock that a smaller opening of its loops undoes holds by a hair
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
    ten times as thick. exact : of the locked ends, how many proofs are in whole numbers, as "10 of 10". hair, held :
    ends that less than 0.1 mm of opening undo, and that more than a panel's thickness does not; gives : the least
    opening (mm) that undoes one, measured. merged : untwisted foldings with a mirror axis that are locked, and still so
    when merged.
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
    exact: str
    gives: float | None
    hair: int
    held: int
    merged: str
    play_least: float | None
    play_most: float | None
    margin: float | None


@dataclass(frozen=True)
class TightRow:
    """One end that is proved locked, with `pairs` rigid or hinged, and by how much its loops must give way.

    order, proof : of the proof. opening_mm : the greatest on the best way out that was found, or the panels' thickness
    where more is needed. least_mm : what other ways need at least. turn, closed : sums of turns (rad) where that is,
    and where the loops are closed again.
    """

    folding: str
    end: str
    pairs: str
    order: int
    proof: str
    opening_mm: float
    least_mm: float
    turn: float
    closed: float | None


def measure_mobility(
    sizes: Mapping[str, Sequence[int]], *, repeats: int, say: Say
) -> tuple[list[SpeedRow], list[LockRow], list[TightRow]]:
    """A row of each kind for each grid and n; of locked ends one each where they are not many."""
    speed, locks, tight = [], [], []
    for grid, ns in sizes.items():
        for batch in _all_untwisted(grid, ns[0]):
            _stage_times(*batch, 1)  # load the compiled kernels first
        for n in ns:
            say(f"{grid} n={n}")
            for circuits, foldings in _all_untwisted(grid, n):
                stage, freedom = _stage_times(circuits, foldings, repeats)
                each, counts = 1e6 / len(foldings), (len(circuits), len(foldings))
                speed.append(SpeedRow(grid, n, *counts, stage, stage * each, freedom * each, repeats))
                row, ends = _locks(circuits, foldings)
                locks.append(row)
                tight += ends if row.locked <= LISTED else []
    return speed, locks, tight


def _all_untwisted(grid: str, n: int) -> list[tuple[CircuitBatch, FoldingBatch]]:
    """All untwisted designs with their untwisted foldings in one batch; empty where there are none."""
    return list(packed(untwisted(FoldedSearch(grid_named(grid), n, untwisted=True))))


def _stage_times(circuits: CircuitBatch, foldings: FoldingBatch, repeats: int) -> tuple[float, float]:
    """Median seconds of the whole stage, and without proofs of locks."""
    twists = np.zeros(len(foldings), np.int16)
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(repeats):
        for into, locks in zip(times, (True, False), strict=True):
            begun = time.perf_counter()
            mobility_of_batch(circuits, foldings, twists, locks=locks)
            into.append(time.perf_counter() - begun)
    return median(times[0]), median(times[1])


def _locks(circuits: CircuitBatch, foldings: FoldingBatch) -> tuple[LockRow, list[TightRow]]:
    grid, n = circuits.grid, circuits.words.shape[1]
    stage = mobility_of_batch(circuits, foldings, np.zeros(len(foldings), np.int16))
    panel = default_panel(grid)
    locked = [folding_at(circuits, foldings, i) for i in np.flatnonzero(stage.locked).tolist()]
    ends = [_ends(folding, panel) for folding in locked]
    free = np.bincount(foldings.row[~stage.locked], minlength=len(circuits)) > 0
    tried = locked[:MOST_LOCKED]
    mirrored = [folding_at(circuits, foldings, i) for i in np.flatnonzero(stage.merged_panels > 0).tolist()]
    thin, thick = (
        sum(_is_locked(_ends(folding, (panel[0], panel[1], factor * panel[2]))) for folding in tried)
        for factor in THICKNESSES
    )
    plays = [_play(folding, panel, end) for folding, pair in zip(locked, ends, strict=True) for end in pair.items()]
    known = [play for play in plays if play is not None]
    proved = [lock for pair in ends for lock in pair.values() if lock.locked]
    tight = [row for folding in tried for way in ("rigid", "hinged") for row in _tight(folding, panel, way)]
    rigid = [row for row in tight if row.pairs == "rigid"]
    openings = [row.opening_mm for row in rigid if row.closed is not None]
    row = LockRow(
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
        hinged=sum(_is_locked(_ends(folding, panel, "hinged")) for folding in tried),
        thin=thin,
        thick=thick,
        exact=f"{sum(lock.exact for lock in proved)} of {len(proved)}",
        gives=min(openings, default=None),
        hair=sum(opening < 1e3 * HAIR for opening in openings),
        held=len(rigid) - len(openings),
        merged=_merged(mirrored, panel),
        play_least=min(known, default=None),
        play_most=max(known, default=None),
        margin=min((lock.margin for lock in proved), default=None),
    )
    return row, tight


def _merged(mirrored: list[Folding], panel: PanelSize) -> str:
    """How many foldings are locked as they are, and with panels on their mirror axis merged."""
    before = sum(_is_locked(_ends(folding, panel)) for folding in mirrored)
    after = sum(_is_locked(_ends(folding, panel, "merged")) for folding in mirrored)
    return f"{before} -> {after} of {len(mirrored)}"


def _tight(folding: Folding, panel: PanelSize, flat_pairs: Way) -> list[TightRow]:
    """The locked ends of a folding, and how tight they are."""
    linkage = Linkage(folding.pattern(panel, flat_pairs=flat_pairs))
    rows = []
    for end, lock in _ends(folding, panel, flat_pairs).items():
        measured = tightness(linkage, getattr(linkage, end)) if lock.order is not None else None
        if lock.order is not None and measured is not None:
            rows.append(_tight_row(folding, end, flat_pairs, lock, measured))
    return rows


def _tight_row(folding: Folding, end: str, pairs: str, lock: LockVerdict, measured: Tightness) -> TightRow:
    assert lock.order is not None
    return TightRow(
        folding=folding.notation,
        end=end,
        pairs=pairs,
        order=lock.order,
        proof="exact" if lock.exact else "numerical",
        opening_mm=1e3 * measured.opening,
        least_mm=1e3 * measured.least,
        turn=measured.turn,
        closed=measured.closed,
    )


def _ends(folding: Folding, panel: PanelSize, flat_pairs: Way = "rigid") -> dict[str, LockVerdict]:
    linkage = Linkage(folding.pattern(panel, flat_pairs=flat_pairs))
    return {"folded": lock_at(linkage, linkage.folded), "flat": lock_at(linkage, linkage.flat)}


def _is_locked(ends: dict[str, LockVerdict]) -> bool:
    return any(lock.locked for lock in ends.values())


def _play(folding: Folding, panel: PanelSize, end: tuple[str, LockVerdict]) -> float | None:
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
