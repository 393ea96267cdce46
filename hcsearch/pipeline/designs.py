"""From a batch of circuits to the rows that the store keeps."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcsearch import folding, mobility, twisting
from hcsearch.enumeration import STAGE, Search
from hcsearch.grid import Grid
from hcsearch.kernels.circuits.words import array_rows, fingerprint_rows, write_rows
from hcsearch.records import Candidates, CircuitBatch, DesignBatch, FoldingBatch, MobilityBatch, StageResult


class Travelling:
    """A task that goes to other processes."""

    search: Search

    def __getstate__(self) -> dict[str, object]:
        """Without what the search has worked out for itself: it may be large, and the other side makes it anew."""
        return self.__dict__ | {"search": replace(self.search)}


@dataclass(frozen=True)
class Job(Travelling):
    """What is done with every unit of a run.

    stages : name and version of those to run; keep : which designs to keep.
    rows : whether the rows for the store are wanted, or only the fingerprints of the arrays. candidates : whether the
    foldings are wanted whose deployment is to be simulated.
    """

    search: Search
    stages: dict[str, int]
    keep: str
    rows: bool
    candidates: bool = False

    def __call__(self, prefix: str) -> Output:
        """Work on one unit."""
        search = warm(self.search)
        unit = run_unit(search, prefix, self.stages, self.keep)
        rows = design_rows(search, unit) if self.rows else None
        arrays = None if self.rows else array_fingerprints(search, unit.circuits)
        candidates = candidates_of(search, unit) if self.candidates else None
        return Output(unit.results, len(unit.circuits), rows, arrays, candidates)


@lru_cache(maxsize=2)
def warm(search: Search) -> Search:
    """The first search equal to this one that came by, which has its tables ready."""
    return search


@dataclass(frozen=True)
class Output:
    """What a unit gives back: the stages' results, how many designs are kept, and either rows or fingerprints.

    candidates : for deployments; None where none are wanted.
    """

    results: tuple[StageResult, ...]
    kept: int
    rows: DesignBatch | None
    arrays: NDArray[np.uint64] | None
    candidates: Candidates | None


@dataclass(frozen=True)
class UnitResult:
    """What one search unit gave, stage by stage, after the rows not to be kept are dropped.

    twists : None where that stage has not run; foldings and mobility likewise.
    """

    circuits: CircuitBatch
    foldings: FoldingBatch | None
    twists: NDArray[np.int16] | None
    mobility: MobilityBatch | None
    results: tuple[StageResult, ...]


def run_unit(search: Search, prefix: str, stages: dict[str, int], keep: str) -> UnitResult:
    """Run the stages before `deployment` on one unit of a search."""
    clock = time.perf_counter()
    circuits = _joined(search, prefix)
    fixed = search.group_order // circuits.symmetry.astype(np.int64)
    results: list[StageResult] = []

    def finish(stage: str, passed: NDArray[np.bool_]) -> None:
        nonlocal clock
        now = time.perf_counter()
        results.append(StageResult(stage, stages[stage], int(passed.sum()), int(fixed[passed].sum()), now - clock))
        clock = now

    passed = np.ones(len(circuits), bool)
    finish(STAGE, passed)
    foldings = twists = None
    if folding.STAGE in stages:
        foldings = folding.fold(circuits)
        passed = np.zeros(len(circuits), bool)
        passed[foldings.row] = True
        finish(folding.STAGE, passed)
    kept = passed if keep == "two-stack" else np.ones(len(circuits), bool)
    if twisting.STAGE in stages and foldings is not None:
        twists = twisting.twist_batch(circuits, foldings)
        passed = np.zeros(len(circuits), bool)
        passed[foldings.row[twists == 0]] = True
        finish(twisting.STAGE, passed)
        kept = passed if keep == "untwisted" else kept
    if not kept.all():
        stay = kept[foldings.row] if foldings is not None else slice(0)
        if foldings is not None:
            number = np.cumsum(kept, dtype=np.int32) - 1
            foldings = FoldingBatch(number[foldings.row[stay]], foldings.crease[stay])
        circuits, fixed, twists = circuits.take(kept), fixed[kept], None if twists is None else twists[stay]
    found = None
    if mobility.STAGE in stages and foldings is not None and twists is not None:
        found = mobility.mobility(circuits, foldings, twists)
        passed = np.zeros(len(circuits), bool)
        passed[foldings.row[(twists == 0) & ~mobility.locked_with(found, "either")]] = True
        finish(mobility.STAGE, passed)
    return UnitResult(circuits, foldings, twists, found, tuple(results))


def _joined(search: Search, prefix: str) -> CircuitBatch:
    batches = list(search.circuits(prefix))
    if not batches:
        return CircuitBatch(search.grid.name, np.empty((0, search.n), np.int8), np.empty(0, np.int16))
    words = np.concatenate([batch.words for batch in batches])
    return CircuitBatch(search.grid.name, words, np.concatenate([batch.symmetry for batch in batches]))


def design_rows(search: Search, unit: UnitResult) -> DesignBatch:
    """The rows of a unit: notations of circuits and arrays, orders of groups, foldings and twists."""
    circuits, foldings, twists = unit.circuits, unit.foldings, unit.twists
    array, array_symmetry = _array_texts(search, circuits)
    best_crease = folding_status = status = None
    if foldings is not None and twists is not None and unit.mobility is not None:
        best = mobility.best_foldings(len(circuits), foldings, twists, unit.mobility)
        best_crease = np.where(best < 0, -1, foldings.crease[best] if len(foldings) else -1)
        folding_status = _folding_status(unit)
        status = _status(len(circuits), foldings, folding_status)
    n_foldings = n_untwisted = min_twist = None
    if foldings is not None:
        n_foldings = np.bincount(foldings.row, minlength=len(circuits))
    if foldings is not None and twists is not None:
        n_untwisted = np.bincount(foldings.row[twists == 0], minlength=len(circuits))
        min_twist = np.full(len(circuits), np.iinfo(np.int16).max, np.int16)
        np.minimum.at(min_twist, foldings.row, twists)
        min_twist[n_foldings == 0] = -1
    return DesignBatch(
        grid=search.grid.name,
        n=search.n,
        circuit=circuit_texts(search.grid, circuits.words),
        array=array,
        array_symmetry=array_symmetry,
        symmetry=circuits.symmetry,
        n_fixed=len(search.grid.point_group) // circuits.symmetry.astype(np.int64),
        n_foldings=n_foldings,
        folding_row=None if foldings is None else foldings.row,
        folding_crease=None if foldings is None else foldings.crease,
        folding_twist=twists,
        n_untwisted=n_untwisted,
        min_twist=min_twist,
        mobility=unit.mobility,
        best_crease=best_crease,
        folding_status=folding_status,
        status=status,
    )


def candidates_of(search: Search, unit: UnitResult) -> Candidates:
    """The designs of a unit whose motion is to be looked for: those with an untwisted folding."""
    assert unit.foldings is not None
    assert unit.twists is not None
    assert unit.mobility is not None
    plain = unit.twists == 0
    kept = np.zeros(len(unit.circuits), bool)
    kept[unit.foldings.row[plain]] = True
    number = np.cumsum(kept, dtype=np.int32) - 1
    circuits = unit.circuits.take(kept)
    return Candidates(
        circuits,
        search.group_order // circuits.symmetry.astype(np.int64),
        FoldingBatch(number[unit.foldings.row[plain]], unit.foldings.crease[plain]),
        unit.mobility.locked[plain],
        unit.mobility.locked_hinged[plain],
        unit.mobility.dof[plain],
    )


def _folding_status(unit: UnitResult) -> list[str | None]:
    """What is known of each folding before a motion is looked for; None where it is twisted.

    Locked : with rigid, hinged and merged flat pairs.
    """
    assert unit.mobility is not None
    assert unit.twists is not None
    locked = mobility.locked_with(unit.mobility, "either")
    pairs = zip(unit.twists.tolist(), locked.tolist(), strict=True)
    return [None if twist else ("locked" if locked else "undecided") for twist, locked in pairs]


def _status(count: int, foldings: FoldingBatch, words: list[str | None]) -> list[str | None]:
    """What is known of each circuit: undecided where a folding is; None without an untwisted one."""
    found: list[str | None] = [None] * count
    for row, word in zip(foldings.row.tolist(), words, strict=True):
        if word is not None and found[row] != "undecided":
            found[row] = word
    return found


def array_fingerprints(search: Search, circuits: CircuitBatch) -> NDArray[np.uint64]:
    """A 128-bit fingerprint of each circuit's array up to congruence, shape (n_circuits, 2)."""
    if search.target:  # one array, of any width
        return np.ones((min(len(circuits), 1), 2), np.uint64)
    rows, heights, _ = _canonical_arrays(search.grid, circuits)
    found = np.empty((len(circuits), 2), np.uint64)
    fingerprint_rows(rows, heights, found)
    return found


def _canonical_arrays(
    grid: Grid, circuits: CircuitBatch
) -> tuple[NDArray[np.uint64], NDArray[np.int64], NDArray[np.int16]]:
    rows = np.empty(circuits.words.shape, np.uint64)
    heights, symmetry = np.empty(len(circuits), np.int64), np.empty(len(circuits), np.int16)
    bits = 2 if grid.is_triangle else 1
    array_rows(circuits.words, np.array(grid.row_moves), bits, rows, heights, symmetry)
    return rows, heights, symmetry


def _array_texts(search: Search, circuits: CircuitBatch) -> tuple[list[str], NDArray[np.int16]]:
    grid = search.grid
    if search.target:  # one array for all of them, of any width
        symmetry = np.full(len(circuits), search.group_order, np.int16)
        return [search.target] * len(circuits), symmetry
    rows, heights, symmetry = _canonical_arrays(grid, circuits)
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    # n cells in connected rows: at most n digits and a dot a row
    text = np.zeros((len(circuits), len(prefix) + 2 * search.n), np.uint8)
    write_rows(rows, heights, prefix, text)
    return _texts(text), symmetry


def circuit_texts(grid: Grid, words: NDArray[np.int8]) -> list[str]:
    """The notations of circuits."""
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    text = np.empty((len(words), len(prefix) + words.shape[1]), np.uint8)
    text[:, : len(prefix)] = prefix
    text[:, len(prefix) :] = words + ord("0")
    return _texts(text)


def _texts(text: NDArray[np.uint8]) -> list[str]:
    """Rows of ASCII codes, ended by zeros, as strings."""
    return text.view(f"S{text.shape[1]}").ravel().astype(str).tolist() if len(text) else []
