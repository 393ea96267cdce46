"""Circuits of one array: ours against the peers, on the same arrays in the same run, each in its own process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec

from hcsearch.basics.errors import HcsearchError
from hcsearch_bench.peers.engines import ENGINES, Engine
from hcsearch_bench.run.bench import Say
from hcsearch_bench.run.job import OWN_LIMIT, JobResult, run_job
from hcsearch_bench.run.machine import MISSING
from hcsearch_bench.run.work_precision import OURS

# by number of circuits, so that a peer past its limit need not be tried on what follows
ARRAYS = (
    ("square", "4x4"),
    ("square", "6x4"),
    ("square", "6x5"),
    ("square", "6x6"),
    ("hex", "h3"),
    ("square", "7x6"),
    ("square", "8x6"),
    ("square", "8x7"),
    ("hex", "t8"),
    ("hex", "p6x6"),
    ("square", "8x8"),
    ("hex", "h4"),
    ("square", "9x8"),
)
QUICK = (("square", "4x4"), ("square", "6x6"))


@dataclass(frozen=True)
class ArrayRow:
    """One engine at one task on one array. Times are processor seconds, medians of `runs`; None where there is none.

    build_s : until the data structure stands; answer_s : for the number, or for going through the list.
    times_ours : (build_s + answer_s) over ours at the same kind of task, counting or listing (edge sets).
    note : why there are no numbers.
    """

    grid: str
    array: str
    engine: str
    task: str
    circuits: int | None = None
    classes: int | None = None
    listed: int | None = None
    build_s: float | None = None
    answer_s: float | None = None
    wall_s: float | None = None
    listed_per_s: float | None = None
    peak_mib: float | None = None
    runs: int | None = None
    times_ours: float | None = None
    note: str = ""

    @property
    def kind(self) -> str:
        """`count` or `list`: what it is compared in."""
        return self.task.split(":")[0]

    @property
    def seconds(self) -> float | None:
        """Build and answer together."""
        return None if self.build_s is None or self.answer_s is None else self.build_s + self.answer_s


def measure_arrays(
    arrays: Sequence[tuple[str, str]],
    *,
    limit: float,
    repeats: int,
    say: Say,
    engines: Sequence[Engine] = ENGINES,
) -> list[ArrayRow]:
    """One row an array and engine. Raises HcsearchError when two engines find different numbers of circuits.

    limit : seconds on the wall for a peer's process; one that needs more is not tried on the arrays that follow.
    """
    rows: list[ArrayRow] = []
    beaten: set[Engine] = set()
    for grid, spec in arrays:
        own = []
        for engine in engines:
            say(f"{grid} {spec}: {engine.name}, {engine.task}")
            row = _measure(grid, spec, engine, limit=limit, repeats=repeats, beaten=engine in beaten)
            if row.note and engine.peer:
                beaten.add(engine)
            own.append(row)
        _check_counts(own)
        rows += _with_ratios(own)
    return rows


def _measure(grid: str, spec: str, engine: Engine, *, limit: float, repeats: int, beaten: bool) -> ArrayRow:
    row = ArrayRow(grid, spec, engine.name, engine.task)
    if engine.package and find_spec(engine.package) is None:
        return replace(row, note=MISSING)
    if beaten:
        return replace(row, note="not tried")
    allowed = limit if engine.peer else OWN_LIMIT
    result = run_job(engine.job, allowed, grid=grid, spec=spec, repeats=repeats)
    return _filled(row, result)


def _filled(row: ArrayRow, result: JobResult) -> ArrayRow:
    row = replace(row, peak_mib=result.peak_mib, note=result.note, **result.row)
    if row.listed and row.answer_s:
        row = replace(row, listed_per_s=row.listed / row.answer_s)
    return row


def _check_counts(rows: list[ArrayRow]) -> None:
    for name in ("circuits", "classes"):
        counts = {f"{row.engine}, {row.task}": getattr(row, name) for row in rows if getattr(row, name) is not None}
        if len(set(counts.values())) > 1:
            numbers = "; ".join(f"{who} {count}" for who, count in counts.items())
            raise HcsearchError(f"{rows[0].grid} {rows[0].array}: engines disagree on {name}: {numbers}; report this")


def _with_ratios(rows: list[ArrayRow]) -> Iterator[ArrayRow]:
    ours: dict[str, float] = {}
    for row in rows:  # the first of ours at each kind of task
        if row.engine == OURS and row.seconds is not None:
            ours.setdefault(row.kind, row.seconds)
    for row in rows:
        base = ours.get(row.kind)
        yield row if base is None or row.seconds is None else replace(row, times_ours=row.seconds / base)
