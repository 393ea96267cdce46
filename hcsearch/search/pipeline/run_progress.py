"""What a run reports while it is under way."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate, pairwise
from typing import Protocol

SHARE = "share"
"""Unit of progress of which only the share counts: the amounts are of no thing that a user knows."""
_PARTS = 1000


class RunProgress(Protocol):
    """Callback for progress: amount done and in all, a note on results, and the unit."""

    def __call__(self, done: int, total: int, note: str, unit: str = "batch") -> None:
        """Show it."""


AnnounceSentence = Callable[[str], None]


class StageProgress:
    """Progress of foldings through several stages: the stage at work, the foldings done in it, the share of the whole.

    hear : a listener of `work_steps`, which counts. Where workers are not heard, as on a cluster, `finish` counts their
    foldings.
    """

    def __init__(self, show: RunProgress, stages: Sequence[str], foldings: int) -> None:
        self._show, self._foldings, self._stage = show, foldings, stages[0]
        self._done = dict.fromkeys(stages, 0)
        self._lock = threading.Lock()
        self.show_state()

    def hear(self, step: str, count: int) -> None:
        """Count foldings in a stage, which is the one at work; other steps are ignored. Any thread may call this."""
        if step in self._done:
            with self._lock:
                self._stage = step
                self._done[step] = min(self._foldings, self._done[step] + count)

    def finish(self, foldings: int) -> None:
        """Count so many foldings, at least, as done in all stages."""
        with self._lock:
            self._done = {stage: max(done, foldings) for stage, done in self._done.items()}
        self.show_state()

    def show_state(self) -> None:
        """Show the stage at work."""
        note = f"{self._stage}, {self._done[self._stage]:,} of {self._foldings:,} foldings"
        self._show(sum(self._done.values()), self._foldings * len(self._done), note, SHARE)


def parts_of_work(amounts: Iterable[float], end: float = 1.0) -> list[tuple[float, float]]:
    """Return the shares of a work at which its parts begin and end, by their amounts. end : that of the last part."""
    done = [0.0, *accumulate(amounts)]
    return [(end * begin / done[-1], end * finish / done[-1]) for begin, finish in pairwise(done)]


def part_of_progress(show: RunProgress, name: str, begin: float, end: float, *, shares_alone: bool) -> RunProgress:
    """Return the progress of a part of a work, shown as a share of the whole that rises from one number to another.

    shares_alone : whether counts of units are of the beginning of the part, and only shares of the part itself.
    """

    def shown(done: int, total: int, note: str, unit: str = "batch") -> None:
        counts = "" if unit == SHARE else f"{unit} {done:,} of {total:,}, "
        part = 0.0 if shares_alone and unit != SHARE else done / max(1, total)
        show(int(_PARTS * (begin + (end - begin) * part)), _PARTS, f"{name}, {counts}{note}", SHARE)

    return shown
