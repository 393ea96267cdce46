"""Clocks and medians of repeated runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from hcsearch.springs.accuracy.work_rows import Repeats, median_of_runs

T = TypeVar("T")
Row = dict[str, Any]

ENOUGH = 6.0
"""Seconds of runs, after which none is repeated."""
SHORT = 0.1
"""Seconds; shorter runs are repeated five times as often."""


class Stopwatch:
    """Sums the time spent inside `with` blocks: processor seconds of this process, and seconds on the wall."""

    def __init__(self) -> None:
        self.cpu = self.wall = 0.0

    def __enter__(self) -> Stopwatch:
        self._begin = (time.process_time(), time.perf_counter())
        return self

    def __exit__(self, *_: object) -> None:
        self.cpu += time.process_time() - self._begin[0]
        self.wall += time.perf_counter() - self._begin[1]


def timed(watch: Stopwatch, source: Iterable[T]) -> Iterator[T]:
    """The items of an iterable; the watch runs only while the next one is made."""
    iterator = iter(source)
    while True:
        with watch:
            try:
                item = next(iterator)
            except StopIteration:
                return
        yield item


def repeated(run: Callable[[], Row], repeats: int) -> Row:
    """Repeat a run and take the median of every float; other values must be equal every time.

    No further run begins once ENOUGH seconds are spent, so what is slow is measured fewer times; `runs` says how many.
    """
    rows: list[Row] = []
    begin = time.perf_counter()
    while len(rows) < repeats and (not rows or time.perf_counter() - begin < ENOUGH):
        rows.append(run())
    medians: Row = {}
    for name, value in rows[0].items():
        values = [row[name] for row in rows]
        if isinstance(value, float):
            medians[name] = statistics.median(values)
        elif any(other != value for other in values):
            raise AssertionError(f"repeated runs differ in {name}: {values}")
        else:
            medians[name] = value
    return medians | {"runs": len(rows)}


def median_time(run: Callable[[], float], repeats: int) -> tuple[float, int]:
    """Median of the seconds of runs, and how many there were: five times as many where they are short."""
    return median_of_runs(run, Repeats(repeats, 5 * repeats if repeats > 1 else repeats, SHORT, ENOUGH))


def measured(compute: Callable[[], T], repeats: int) -> tuple[T, float, int]:
    """What a computation gives, the median of its seconds on the wall, and how many runs there were."""
    results: list[T] = []

    def run() -> float:
        begin = time.perf_counter()
        results[:] = [compute()]
        return time.perf_counter() - begin

    seconds, runs = median_time(run, repeats)
    return results[0], seconds, runs
