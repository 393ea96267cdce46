"""Medians of the times of repeated runs; short runs are repeated more often."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import NamedTuple, TypeVar

T = TypeVar("T")


class Repeats(NamedTuple):
    """How often runs are repeated.

    usual : number of runs; short : number where the first takes less than `short_seconds`. enough_seconds : total time
    after which no further run begins.
    """

    usual: int
    short: int
    short_seconds: float
    enough_seconds: float


PROCESSOR_REPEATS = Repeats(usual=3, short=15, short_seconds=0.02, enough_seconds=0.5)
"""Repeats of the simulations of a table of methods."""


def median_of_runs(run: Callable[[], float], repeats: Repeats) -> tuple[float, int]:
    """Return the median of the seconds of runs, and how many there were; run : returns its seconds."""
    times = [run()]
    wanted = repeats.short if times[0] < repeats.short_seconds else repeats.usual
    while len(times) < wanted and sum(times) < repeats.enough_seconds:
        times.append(run())
    return statistics.median(times), len(times)


def processor_seconds(run: Callable[[], T], repeats: Repeats = PROCESSOR_REPEATS) -> tuple[T, float, int]:
    """Return the result of a run, the median of its processor time (s) after a first run, and the number of runs."""
    results = [run()]

    def timed() -> float:
        begin = time.process_time()
        results[:] = [run()]
        return time.process_time() - begin

    seconds, runs = median_of_runs(timed, repeats)
    return results[0], seconds, runs
