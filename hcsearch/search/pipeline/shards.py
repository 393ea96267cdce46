"""The work on a shard, the unit of a search that is stored as a whole, and its rows for the store."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.designs.grid import Grid, grid_named
from hcsearch.designs.grid.step_names import step_digits
from hcsearch.designs.records import (
    NO_NUMBER,
    CircuitBatch,
    Columns,
    DesignBatch,
    StagedDesigns,
    StageResult,
    VerdictBatch,
)
from hcsearch.kernels.circuits.words import array_rows, fingerprint_rows, write_rows
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, Scene
from hcsearch.search.enumeration import Search
from hcsearch.search.stages.circuits import list_shard_circuits
from hcsearch.search.stages.stage import Stage, run_stages
from hcsearch.search.stages.statuses import best_foldings, folding_statuses
from hcsearch.store.columns import stored_quantities

SMALL_CIRCUIT_COUNT = 5_000_000
"""Circuits that one process lists in seconds."""


def design_rows(search: Search, designs: StagedDesigns) -> DesignBatch:
    """Return the rows of a shard: notations of circuits and arrays, orders of groups, and the results of its stages."""
    circuits, foldings, twists = designs.circuits, designs.foldings, designs.twists
    array, array_symmetry = _array_texts(search, circuits)
    columns: dict[str, Any] = {
        "grid": search.grid.name,
        "n": search.n,
        "circuit": circuit_texts(search.grid, circuits.words),
        "array": array,
        "array_symmetry": array_symmetry,
        "symmetry": circuits.symmetry,
        "n_fixed": len(search.grid.point_group) // circuits.symmetry.astype(np.int64),
        **_stored("design", designs.of_designs),
    }
    if foldings is None:
        return DesignBatch(columns)
    of_foldings = {"row": foldings.row, "crease": foldings.crease, **_stored("folding", designs.of_foldings)}
    columns["n_foldings"] = np.bincount(foldings.row, minlength=len(circuits))
    if twists is not None:
        columns["n_untwisted"] = np.bincount(foldings.row[twists == 0], minlength=len(circuits))
        min_twist = np.full(len(circuits), np.iinfo(np.int16).max, np.int32)
        np.minimum.at(min_twist, foldings.row, twists)
        columns["min_twist"] = np.where(columns["n_foldings"] == 0, NO_NUMBER, min_twist)
    if designs.mobility is not None:
        best = best_foldings(designs)
        columns["best_crease"] = np.full(len(circuits), NO_NUMBER)
        columns["best_crease"][best >= 0] = foldings.crease[best[best >= 0]]
        statuses = folding_statuses(designs)
        of_foldings["status"] = statuses
        first = best_foldings(designs, statuses).tolist()
        columns["status"] = [None if k < 0 else statuses[k] for k in first]
    return DesignBatch(columns, of_foldings)


def _stored(table: str, results: Columns) -> dict[str, Any]:
    """Return the columns of a table among results of stages."""
    stored = stored_quantities(table)
    columns: dict[str, Any] = {}
    for name, result in results.items():
        fields = {name: result} if isinstance(result, np.ndarray) else vars(result)
        columns |= {field: values for field, values in fields.items() if field in stored}
    return columns


def verdict_rows(designs: StagedDesigns, scene: Scene) -> VerdictBatch:
    """Return the rows of verdicts in a scene on designs whose foldings are all untwisted."""
    foldings, statuses = designs.folded, folding_statuses(designs, scene)
    best = best_foldings(designs, statuses)
    return VerdictBatch(
        circuit=circuit_texts(grid_named(designs.circuits.grid), designs.circuits.words),
        best_crease=foldings.crease[best].tolist(),
        status=[str(statuses[k]) for k in best.tolist()],
        folding_row=foldings.row,
        folding_crease=foldings.crease,
        folding_status=[str(word) for word in statuses],
        of_foldings=designs.of_foldings,
    )


def array_fingerprints(search: Search, circuits: CircuitBatch) -> NDArray[np.uint64]:
    """Return a 128-bit fingerprint of each circuit's array up to congruence, shape (n_circuits, 2)."""
    if search.target:  # one array, of any width
        return np.ones((min(len(circuits), 1), 2), np.uint64)
    rows, heights, _ = _canonical_arrays(search.grid, circuits)
    prints = np.empty((len(circuits), 2), np.uint64)
    fingerprint_rows(rows, heights, prints)
    return prints


def _canonical_arrays(
    grid: Grid, circuits: CircuitBatch
) -> tuple[NDArray[np.uint64], NDArray[np.int64], NDArray[np.int16]]:
    # a connected array of n cells that a circuit runs through reaches less than n / 2 cells from any of them
    height = grid.rows_per_cell * (circuits.words.shape[1] // 2 + 2)
    rows = np.empty((len(circuits), height), np.uint64)
    heights, symmetry = np.empty(len(circuits), np.int64), np.empty(len(circuits), np.int16)
    block = (grid.columns_per_cell, grid.rows_per_cell)
    array_rows(circuits.words, np.array(grid.row_moves), block, rows, heights, symmetry)
    return rows, heights, symmetry


def _array_texts(search: Search, circuits: CircuitBatch) -> tuple[list[str], NDArray[np.int16]]:
    grid = search.grid
    if search.target:  # one array for all of them, of any width
        symmetry = np.full(len(circuits), search.group_order, np.int16)
        return [search.target] * len(circuits), symmetry
    rows, heights, symmetry = _canonical_arrays(grid, circuits)
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    # n cells in connected rows: at most n digits and a dot a row, and a zero and a dot for each row without cells
    text = np.zeros((len(circuits), len(prefix) + 2 * (search.n + rows.shape[1])), np.uint8)
    write_rows(rows, heights, prefix, text)
    return _texts(text), symmetry


def circuit_texts(grid: Grid, words: NDArray[np.int8]) -> list[str]:
    """Return the notations of circuits."""
    prefix = np.frombuffer(f"{grid.name}:".encode(), np.uint8)
    text = np.empty((len(words), len(prefix) + words.shape[1]), np.uint8)
    text[:, : len(prefix)] = prefix
    text[:, len(prefix) :] = step_digits(grid, words)
    return _texts(text)


def _texts(text: NDArray[np.uint8]) -> list[str]:
    """Convert rows of ASCII codes, padded with zeros, to strings."""
    return text.view(f"S{text.shape[1]}").ravel().astype(str).tolist() if len(text) else []


class TransferableTask:
    """A task that is pickled for other processes."""

    search: Search

    def __getstate__(self) -> dict[str, object]:
        """Drop the cached tables of the search, which may be large and are recomputed by the other process."""
        return self.__dict__ | {"search": replace(self.search)}


@dataclass(frozen=True)
class ShardJob(TransferableTask):
    """Task that processes a shard.

    stages : to run. keep : which designs to keep. with_rows : whether to return rows for the store, else only
    fingerprints of arrays. with_candidates : whether to return the designs whose motion is to be searched for.
    """

    search: Search
    stages: tuple[Stage, ...]
    keep: str
    with_rows: bool
    with_candidates: bool = False

    def __call__(self, prefix: str) -> ShardOutput:
        """Process one shard."""
        search = cached_search(self.search)
        designs, results = run_shard(search, prefix, self.stages, self.keep)
        rows = design_rows(search, designs) if self.with_rows else None
        arrays = None if self.with_rows else array_fingerprints(search, designs.circuits)
        candidates = candidates_of(designs) if self.with_candidates else None
        return ShardOutput(results, len(designs), rows, arrays, candidates)


@lru_cache(maxsize=2)
def cached_search(search: Search) -> Search:
    """Return an equal search from the cache, whose tables are computed already."""
    return search


@dataclass(frozen=True, eq=False)
class ShardOutput(ByValue):
    """The result of a shard: the stages' results, the number of kept designs, and either rows or fingerprints.

    candidates : for motions and deployments; None unless requested.
    """

    results: tuple[StageResult, ...]
    kept_count: int
    rows: DesignBatch | None
    arrays: NDArray[np.uint64] | None
    candidates: StagedDesigns | None


def run_shard(
    search: Search, prefix: str, stages: tuple[Stage, ...], keep: str
) -> tuple[StagedDesigns, tuple[StageResult, ...]]:
    """Run stages on one shard of a search; designs that are not kept are dropped on the way."""
    start_time = time.perf_counter()
    return run_stages(list_shard_circuits(search, prefix), stages, SCENES[DEFAULT_SCENE_NAME], keep, start_time)


def candidates_of(designs: StagedDesigns) -> StagedDesigns:
    """Return the designs whose motion is to be searched for, with their untwisted foldings alone."""
    assert designs.twists is not None
    is_untwisted = designs.twists == 0
    return designs.take(designs.with_folding(is_untwisted), is_untwisted)
