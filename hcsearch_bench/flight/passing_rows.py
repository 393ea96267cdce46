"""Rows of the bench `flight` on designs that pass a standard, each with the springs that are chosen for it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.records import FlightNumbers, MotionBatch
from hcsearch.scenes import Scene, panel_of
from hcsearch.search.stages.mobility import mobility_of_batch
from hcsearch.search.stages.motion import motions_of_batch
from hcsearch.springs.flight.flight_figures import figures_of
from hcsearch.springs.flight.review import rule_rows
from hcsearch.springs.flight.rules import read_rules
from hcsearch.springs.flight.spring_choice import springs_that_pass
from hcsearch.springs.flight.travel import Travel, travel_along
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.foldings import packed, search_of, untwisted

SCENE = Scene(
    "flight",
    margin=5e-4,
    spring="linear:0.1+0.02",
    friction=0.002,
    harness=0.001,
    latch_stiffness=50.0,
    stop_tolerance=1e-4,
)
SEARCHES = (("hex", "12"), ("square", "6x5"))
QUICK = (("hex", "8"),)
BEST = 10


@dataclass(frozen=True)
class PassingCount:
    """Designs of a search with a proved path, those for which springs are found, and those that pass all rules."""

    grid: str
    cells: str
    designs: int
    moving: int
    with_springs: int
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
    for grid, cells in QUICK if quick else SEARCHES:
        say(f"{grid} {cells}")
        count, passing = _of_search(grid, cells)
        counts.append(count)
        rows += passing
    return counts, rows


def best_rows(rows: list[PassingRow]) -> list[PassingRow]:
    """The `BEST` of each search by their first frequency."""
    best = []
    for cells in dict.fromkeys(row.cells for row in rows):
        best += sorted((row for row in rows if row.cells == cells), key=lambda row: -row.hz)[:BEST]
    return best


def _of_search(grid: str, cells: str) -> tuple[PassingCount, list[PassingRow]]:
    rows, moving, with_springs, designs, seconds = [], 0, 0, 0, 0.0
    for circuits, foldings in packed(untwisted(search_of(grid, cells))):
        known = mobility_of_batch(circuits, foldings, np.zeros(len(foldings), np.int16))
        moves = motions_of_batch(circuits, foldings, (known.locked, known.locked_hinged), SCENE, threads=2)
        designs += len(circuits)
        begin = time.process_time()
        for k in _best_of_each(foldings.row, moves):
            moving += 1
            row, found = _row(cells, folding_at(circuits, foldings, k), moves, k)
            with_springs += found
            rows += [] if row is None else [row]
        seconds += time.process_time() - begin
    return PassingCount(grid, cells, designs, moving, with_springs, len(rows), round(seconds, 1)), rows


def _best_of_each(row: np.ndarray, moves: MotionBatch) -> list[int]:
    """The folding of each design with a proved path that needs the least play."""
    best: dict[int, int] = {}
    for k in np.flatnonzero(moves.moves).tolist():
        design = int(row[k])
        if design not in best or moves.margin[k] < moves.margin[best[design]]:
            best[design] = k
    return sorted(best.values())


def _row(cells: str, folding: Folding, moves: MotionBatch, k: int) -> tuple[PassingRow | None, bool]:
    """The row of a folding, None where it does not pass; and whether springs were found."""
    way, rules = cast("Way", moves.flat_pairs[k]), read_rules("ecss")
    linkage = folding.linkage(panel_of(SCENE, folding.circuit.grid.name), flat_pairs=way)
    travel: Travel = travel_along(linkage, SCENE, moves.paths[k])
    try:
        chosen = springs_that_pass(travel, rules)
    except HcsearchError:
        return None, False
    with_them = replace(travel, setup=chosen.setup)
    numbers = figures_of(with_them)
    if any(row.verdict != "pass" for row in rule_rows(with_them, rules, numbers)):
        return None, True
    return _passing(
        cells, folding, way, numbers, 1e3 * float(chosen.preloads.sum()), 1e3 * (chosen.lower_bound or 0.0)
    ), True


def _passing(
    cells: str, folding: Folding, way: Way, numbers: FlightNumbers, preload: float, least: float
) -> PassingRow:
    return PassingRow(
        cells,
        folding.notation,
        way,
        round(preload, 3),
        round(least, 3),
        round(float(numbers.torque_margin or 0.0), 3),
        round(float(numbers.torque_margin_failed or 0.0), 3),
        round(float(numbers.deployed_hz or 0.0), 3),
        round(float(numbers.latch_torque or 0.0), 3),
        round(float(numbers.clearance_ratio or 0.0), 3),
        round(float(numbers.flatness or 0.0), 4),
        int(numbers.self_stresses or 0),
    )
