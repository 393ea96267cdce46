"""What the stages `mobility` and `motion` settle of sets of foldings, and by how much work, one folding at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcsearch.designs.folding import folding_at
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS
from hcsearch.scenes import SCENES, Scene, panel_of, with_panel
from hcsearch.search.enumeration import Search
from hcsearch.search.stages.mobility import locked_in_every_way, locks_with_panel, mobility_of_batch
from hcsearch.search.stages.motion import motions_of_batch
from hcsearch_bench.run.timing import Stopwatch
from hcsearch_bench.subjects.foldings import search_of, untwisted

SCENE = SCENES["default"]
BUDGETS = (0.03, 0.1, 0.2, 0.5, 1.0, 3.0, 10.0)
"""Processor seconds that a folding may take."""


@dataclass(frozen=True)
class Group:
    """A set of untwisted foldings, up to symmetry: of all arrays of n cells, or of one array.

    cells : n, or an array such as `6x5`. sampled : every so many-th folding is looked at in other thicknesses.
    """

    grid: str
    cells: str
    sampled: int = 1

    @property
    def name(self) -> str:
        """Grid and cells."""
        return f"{self.grid} {self.cells}"

    def search(self) -> Search:
        """The search for its circuits."""
        return search_of(self.grid, self.cells)


@dataclass(frozen=True)
class FoldingRow:
    """What becomes of one folding.

    result : `movable` with a proved path, `locked` with a proof, or `undecided`. flat_pairs : how they are joined in
    the path. margin_mm : least play on every face at which the path is proved; both None without one. seconds :
    processor time, with the folding's share of the stage `mobility`.
    """

    group: str
    folding: str
    thickness_mm: float
    result: str
    flat_pairs: str | None
    margin_mm: float | None
    seconds: float

    @property
    def settled(self) -> bool:
        """Whether there is a proof, either way."""
        return self.result != "undecided"


@dataclass(frozen=True)
class GroupRow:
    """All foldings of a set, with the panels of the scene `default`. Seconds are of processor time."""

    group: str
    foldings: int
    movable: int
    locked: int
    undecided: int
    share: float
    total_s: float
    median_s: float
    most_s: float


@dataclass(frozen=True)
class BudgetRow:
    """What is settled where a folding is given up after some seconds; spent_s : on all foldings of the set."""

    group: str
    budget_s: float
    settled: int
    share: float
    spent_s: float


@dataclass(frozen=True)
class MarginRow:
    """What is settled where panels have no more play than a margin on every face."""

    group: str
    margin_mm: float
    movable: int
    locked: int
    share: float


@dataclass(frozen=True)
class ThicknessRow:
    """What is settled with panels of a thickness; tight : movable ones that need no more than the least margin."""

    group: str
    thickness_mm: float
    foldings: int
    movable: int
    tight: int
    locked: int
    undecided: int
    share: float
    total_s: float


def settle(group: Group, thickness: float | None = None, every: int = 1) -> Iterator[FoldingRow]:
    """Settle every so many-th folding of a set; thickness : m, of its panels, None for the scene's `default`."""
    length, width, own = panel_of(SCENE, group.grid)
    scene = with_panel(SCENE, (length, width, own if thickness is None else thickness), group.grid)
    for circuits, foldings in untwisted(group.search(), every):
        yield from _settle(group, circuits, foldings, scene)


def _settle(group: Group, circuits: CircuitBatch, foldings: FoldingBatch, scene: Scene) -> Iterator[FoldingRow]:
    """Settle foldings in a scene, each timed by itself."""
    before = Stopwatch()
    with before:
        known = mobility_of_batch(circuits, foldings, np.zeros(len(foldings), np.int16))
        locks = locks_with_panel(circuits, foldings, (known.locked, known.locked_hinged), panel_of(scene, group.grid))
    locked = locked_in_every_way(replace(known, locked=locks[0], locked_hinged=locks[1]), scene.flat_pairs)
    for i in range(len(foldings)):
        one = slice(i, i + 1)
        watch = Stopwatch()
        with watch:
            moves = motions_of_batch(
                circuits,
                FoldingBatch(foldings.row[one], foldings.crease[one]),
                (locks[0][one], locks[1][one]),
                scene,
            )
        moving = bool(moves.moves[0])
        yield FoldingRow(
            group=group.name,
            folding=folding_at(circuits, foldings, i).notation,
            thickness_mm=_mm(panel_of(scene, group.grid)[2]),
            result="locked" if locked[i] else "movable" if moving else "undecided",
            flat_pairs=moves.flat_pairs[0],
            margin_mm=_mm(float(moves.margin[0])) if moving else None,
            seconds=watch.cpu + before.cpu / len(foldings),
        )


def group_row(rows: Sequence[FoldingRow]) -> GroupRow:
    """Count the foldings of a set."""
    seconds = [row.seconds for row in rows]
    return GroupRow(**_counts(rows), median_s=float(np.median(seconds)), most_s=max(seconds))


def budget_rows(rows: Sequence[FoldingRow], budgets: Sequence[float] = BUDGETS) -> list[BudgetRow]:
    """What budgets (s) for each folding of a set would have settled, and spent.

    A search does not depend on its budget: one that is cut off is the beginning of the longer one.
    """
    counts = []
    for budget in budgets:
        settled = sum(row.settled and row.seconds <= budget for row in rows)
        spent = sum(min(row.seconds, budget) for row in rows)
        counts.append(BudgetRow(rows[0].group, budget, settled, settled / len(rows), spent))
    return counts


def margin_rows(rows: Sequence[FoldingRow]) -> list[MarginRow]:
    """What is settled of a set within each margin that paths are certified at."""
    counts, locked = [], sum(row.result == "locked" for row in rows)
    for margin in map(_mm, CERTIFIED_MARGINS):
        movable = sum(row.margin_mm is not None and row.margin_mm <= margin for row in rows)
        counts.append(MarginRow(rows[0].group, margin, movable, locked, (movable + locked) / len(rows)))
    return counts


def thickness_row(rows: Sequence[FoldingRow]) -> ThicknessRow:
    """Count the foldings of a set with panels of one thickness."""
    return ThicknessRow(**_counts(rows), thickness_mm=rows[0].thickness_mm, tight=margin_rows(rows)[0].movable)


def _counts(rows: Sequence[FoldingRow]) -> dict[str, Any]:
    """What is settled of the foldings of a set, and in what time."""
    return {
        "group": rows[0].group,
        "foldings": len(rows),
        **{name: sum(row.result == name for row in rows) for name in ("movable", "locked", "undecided")},
        "share": sum(row.settled for row in rows) / len(rows),
        "total_s": sum(row.seconds for row in rows),
    }


def _mm(length: float) -> float:
    """A length (m) in millimetres, without the rounding of the product."""
    return float(f"{1e3 * length:.10g}")
