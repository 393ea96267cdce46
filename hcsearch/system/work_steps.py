"""The steps at which this process works, in words, and the items done in them, for whoever shows progress."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

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
