"""Counting the circuits of square arrays without listing them: ours against Graphillion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hcsearch_bench.enumeration.arrays import ArrayRow, measure_arrays
from hcsearch_bench.peers.engines import ENGINES
from hcsearch_bench.run.bench import Say
from hcsearch_bench.run.job import OWN_LIMIT, run_job
from hcsearch_bench.run.timing import Row

SIZES = ("8x8", "10x10", "12x12", "14x14")
QUICK = ("8x8",)


@dataclass(frozen=True)
class CountRow:
    """Exact numbers for one array; `states` is the number of frontier states of ours, up to the last edge."""

    array: str
    engine: str
    circuits: int | None
    classes: int | None
    states: int | None
    seconds: float | None
    peak_mib: float | None
    runs: int | None
    times_ours: float | None
    note: str


def count_states(spec: str) -> Row:
    """Frontier states of a square array, all steps of the sweep together."""
    from hcsearch.designs.grid import GRIDS, parse_array
    from hcsearch.search.enumeration.array_circuits import array_sweep, frontier_layers

    sweep = array_sweep(parse_array(GRIDS["square"], spec))
    return {"states": 0 if sweep is None else sum(size for _, size in frontier_layers(sweep))}


def measure_counting(specs: Sequence[str], *, limit: float, repeats: int, say: Say) -> list[CountRow]:
    """One row an array and engine. Raises HcsearchError when the numbers differ."""
    engines = [engine for engine in ENGINES if engine.kind == "count"]
    arrays = [("square", spec) for spec in specs]
    rows = measure_arrays(arrays, limit=limit, repeats=repeats, say=say, engines=engines)
    states = {spec: run_job(count_states, OWN_LIMIT, spec=spec).row.get("states") for spec in specs}
    ours = engines[0].name
    return [_counted(row, states[row.array] if row.engine == ours else None) for row in rows]


def _counted(row: ArrayRow, states: int | None) -> CountRow:
    return CountRow(
        *(row.array, row.engine, row.circuits, row.classes, states),
        *(row.seconds, row.peak_mib, row.runs, row.times_ours, row.note),
    )
