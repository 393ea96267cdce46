"""Progress of long work: the steps at which this process works, the items done in them, and the share of the whole."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate, pairwise

Progress = Callable[[int, int, str], None]
"""Called with the amounts done and in all, and a note on results."""
Announcement = Callable[[str], None]
"""Called with a sentence, such as one that says how long a run takes."""
_PARTS = 1000
WorkListener = Callable[[str, int], None]
"""Called with the words of a step that begins, or in which items are done, and their number."""

_LOCK = threading.Lock()
_ACTIVE: list[WorkStep] = []
_LISTENERS: list[WorkListener] = []
_OF_THREAD = threading.local()


class WorkStep:
    """A step under way. words : such as `searching for a path`. done : items done in it."""

    def __init__(self, words: str) -> None:
        self.words, self.done = words, 0

    def advance(self, count: int) -> None:
        """Count further items as done, in any thread."""
        with _LOCK:
            self.done += count
        tell_listeners(self.words, count)


@contextmanager
def work_step(words: str) -> Iterator[WorkStep]:
    """Name the step that the block, or a decorated function, is."""
    outer, step = getattr(_OF_THREAD, "step", None), WorkStep(words)
    _OF_THREAD.step = step
    with _LOCK:
        _ACTIVE.append(step)
    tell_listeners(words, 0)
    try:
        yield step
    finally:
        _OF_THREAD.step = outer
        with _LOCK:
            _ACTIVE.remove(step)


def step_of_thread() -> WorkStep:
    """Return the innermost step of this thread; without one, a step that nobody shows."""
    step: WorkStep | None = getattr(_OF_THREAD, "step", None)
    return WorkStep("") if step is None else step


def words_of_work() -> str:
    """Return the words of the step that has begun last and is under way in this process; empty without one."""
    with _LOCK:
        return _ACTIVE[-1].words if _ACTIVE else ""


@contextmanager
def hearing_work(listener: WorkListener) -> Iterator[None]:
    """Call a function, in any thread, for each step that begins and each item that is done while the block runs."""
    _LISTENERS.append(listener)
    try:
        yield
    finally:
        _LISTENERS.remove(listener)


def tell_listeners(words: str, count: int) -> None:
    """Tell all listeners of a step and of items done in it, also of those of another process."""
    for listener in list(_LISTENERS):
        listener(words, count)


def no_progress(done: int, total: int, note: str) -> None:
    """Show no progress."""


def no_announcement(sentence: str) -> None:
    """Announce nothing."""


class StageProgress:
    """Progress of foldings through several stages: the stage at work, the foldings done in it, the share of the whole.

    hear : a listener, which counts. Where workers are not heard, as on a cluster, `finish` counts their foldings.
    """

    def __init__(self, show: Progress, stages: Sequence[str], foldings: int) -> None:
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
        self._show(sum(self._done.values()), self._foldings * len(self._done), note)


def parts_of_work(amounts: Iterable[float], end: float = 1.0) -> list[tuple[float, float]]:
    """Return the shares of a work at which its parts begin and end, by their amounts. end : that of the last part."""
    done = [0.0, *accumulate(amounts)]
    return [(end * begin / done[-1], end * finish / done[-1]) for begin, finish in pairwise(done)]


def part_of_progress(show: Progress, begin: float, end: float, *, name: str = "", unit: str = "") -> Progress:
    """Return the progress of a part of a work, shown as a share of the whole that rises from one number to another.

    name : of the part. unit : of its amounts, which the note then states.
    """

    def shown(done: int, total: int, note: str) -> None:
        counts = f"{unit} {done:,} of {total:,}" if unit else ""
        share = begin + (end - begin) * done / max(1, total)
        show(int(_PARTS * share), _PARTS, ", ".join(filter(None, (name, counts, note))))

    return shown
