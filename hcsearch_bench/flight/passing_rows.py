"""Rows of the bench `flight` on designs that pass a standard, each with the springs that are chosen for it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.records import FlightNumbers, MotionBatch
from hcsearch.scenes import Scene, panel_of
from hcsearch.search.stages.mobility import mobility_of_batch
from hcsearch.search.stages.motion import motions_of_batch
from hcsearch.springs.flight.flight_figures import figures_of
from hcsearch.springs.flight.rules import JudgedTravel, read_rules
from hcsearch.springs.flight.spring_choice import ChosenSprings, springs_that_pass
from hcsearch.springs.flight.travel import travel_along
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.foldings import packed, search_of, untwisted

SCENE = Scene(
    "flight",
    spring="linear:0.1+0.02",
    friction=0.002,
    harness=0.001,
    latch_stiffness=50.0,
    stop_tolerance=1e-4,
)
SEARCHES = (("hex", "12", 5e-4), ("square", "6x5", 1e-3))
"""Grid, cells, and how much smaller panels are on every face, m: larger arrays turn stops' errors into larger gaps."""
QUICK = (("hex", "8", 5e-4),)
BEST = 10


@dataclass(frozen=True)
class PassingCount:
    """Designs of a search with a proved path, those for which springs are found, and those that pass all rules.

    gap_mm : by which panels are smaller on every face. clear : of those with springs, how many pass on clearance.
    """

    grid: str
    cells: str
    gap_mm: float
    designs: int
    moving: int
    with_springs: int
    clear: int
    passing: int
    seconds: float


@dataclass(frozen=True)
class PassingRow:
    """A folding that passes all rules with its springs.

    preload, least : mN m, of all springs, and below which none pass. margin, failed : torque margins. hz : first
    frequency. latch : N m. clearance : over tolerances. flatness : mm/mrad. stresses : states of self-stress.
    """

    cells: str
    folding: str
    flat_pairs: str
    preload: float
    least: float
    margin: float
    failed: float
    hz: float
    latch: float
    clearance: float
    flatness: float
    stresses: int


def passing_rows(*, quick: bool, say: Say) -> tuple[list[PassingCount], list[PassingRow]]:
    """A row for each search, and one for each design that passes."""
    counts, rows = [], []
    for grid, cells, gap in QUICK if quick else SEARCHES:
        say(f"{grid} {cells}")
        count, passing = _of_search(grid, cells, replace(SCENE, margin=gap))
        counts.append(count)
        rows += passing
    return counts, rows


def best_rows(rows: list[PassingRow]) -> list[PassingRow]:
    """The `BEST` of each search by their first frequency."""
    best = []
    for cells in dict.fromkeys(row.cells for row in rows):
        best += sorted((row for row in rows if row.cells == cells), key=lambda row: -row.hz)[:BEST]
    return best


def _of_search(grid: str, cells: str, scene: Scene) -> tuple[PassingCount, list[PassingRow]]:
    rows, judged, designs, moving, seconds = [], [], 0, 0, 0.0
    for circuits, foldings in packed(untwisted(search_of(grid, cells))):
        known = mobility_of_batch(circuits, foldings, np.zeros(len(foldings), np.int16))
        moves = motions_of_batch(circuits, foldings, (known.locked, known.locked_hinged), scene, threads=2)
        designs += len(circuits)
        begin = time.process_time()
        for k in _best_of_each(foldings.row, moves):
            moving += 1
            path = cast("Reals", moves.paths[k])  # as it moves
            one = _judged(folding_at(circuits, foldings, k), scene, cast("Way", moves.flat_pairs[k]), path)
            if one is not None:
                judged.append(one)
                rows += [_passing(cells, one)] if one.passes else []
        seconds += time.process_time() - begin
    clear = sum(one.clears for one in judged)
    gap = 1e3 * float(scene.margin or 0.0)
    return PassingCount(grid, cells, gap, designs, moving, len(judged), clear, len(rows), round(seconds, 1)), rows


def _best_of_each(row: np.ndarray, moves: MotionBatch) -> list[int]:
    """The folding of each design with a proved path that needs the least play."""
    best: dict[int, int] = {}
    for k in np.flatnonzero(moves.moves).tolist():
        design = int(row[k])
        if design not in best or moves.margin[k] < moves.margin[best[design]]:
            best[design] = k
    return sorted(best.values())


@dataclass(frozen=True)
class _Judged:
    """A folding with springs that pass, its figures, and whether it passes on clearance, and all rules."""

    folding: Folding
    way: Way
    springs: ChosenSprings
    numbers: FlightNumbers
    clears: bool
    passes: bool


def _judged(folding: Folding, scene: Scene, way: Way, path: Reals) -> _Judged | None:
    """Judge a folding along its path with the springs chosen for it; None where none are found."""
    rules = read_rules("ecss")
    linkage = folding.linkage(panel_of(scene, folding.circuit.grid.name), flat_pairs=way)
    travel = travel_along(linkage, scene, path)
    try:
        chosen = springs_that_pass(travel, rules)
    except HcsearchError:
        return None
    with_them = travel.with_values(chosen.setup)
    numbers = figures_of(with_them)
    verdicts = {row.rule: row.verdict for row in JudgedTravel(with_them, rules, numbers).rows()}
    clears = verdicts["clearance over tolerances"] == "pass"
    return _Judged(folding, way, chosen, numbers, clears, set(verdicts.values()) == {"pass"})


def _passing(cells: str, one: _Judged) -> PassingRow:
    numbers = one.numbers
    return PassingRow(
        cells,
        one.folding.notation,
        one.way,
        round(1e3 * float(one.springs.preloads.sum()), 3),
        round(1e3 * (one.springs.lower_bound or 0.0), 3),
        round(float(numbers["torque_margin"] or 0.0), 3),
        round(float(numbers["torque_margin_failed"] or 0.0), 3),
        round(float(numbers["deployed_hz"] or 0.0), 3),
        round(float(numbers["latch_torque"] or 0.0), 3),
        round(float(numbers["clearance_ratio"] or 0.0), 3),
        round(float(numbers["flatness_mm_per_mrad"] or 0.0), 4),
        int(numbers["self_stresses"] or 0),
    )
