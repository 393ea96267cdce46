"""Turns of slow lists: only a few of them run at a time.

Slow lists are not known beforehand. Each list first gets a short time limit; one that exceeds it starts again with the
full limit once fewer than `MAX_LONG_LISTS` others run. `MAX_WAITING_LISTS` lists may wait for that; further ones are
refused.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from hcsearch.store import SlowQueryError
from hcsearch.store.queries import STATEMENT_SECONDS
from hcsearch.web.serve.jobs import BusyError

T = TypeVar("T")

SHORT_LIST_SECONDS = 0.3
"""Time limit of the first attempt of a list, in seconds."""
MAX_LONG_LISTS, MAX_WAITING_LISTS = 4, 8
"""Largest numbers of slow lists that run and that wait; a list waits at most `STATEMENT_SECONDS`."""


class LongLists:
    """Runs queries of lists: at most `max_long_lists` run beyond `short` seconds, and `waiting` more wait for that."""

    def __init__(
        self,
        max_long_lists: int = MAX_LONG_LISTS,
        waiting: int = MAX_WAITING_LISTS,
        short: float = SHORT_LIST_SECONDS,
        seconds: float = STATEMENT_SECONDS,
    ) -> None:
        self._short, self._seconds = short, seconds
        self._turns, self._room = (
            threading.BoundedSemaphore(max_long_lists),
            threading.BoundedSemaphore(max_long_lists + waiting),
        )

    def __call__(self, ask: Callable[[float], T], seconds: float | None = None) -> T:
        """Return the result of a query.

        ask : takes the time limit in seconds, and raises SlowQueryError beyond it. seconds : full time limit, if less
        than that of all lists; the query waits as long for its turn. BusyError if it is slow and too many slow ones
        wait; SlowQueryError if it exceeds the full time limit.
        """
        full = self._seconds if seconds is None else min(seconds, self._seconds)
        try:
            return ask(self._short)
        except SlowQueryError:
            pass
        if not self._room.acquire(blocking=False):
            raise _busy()
        try:
            return self._in_turn(ask, full)
        finally:
            self._room.release()

    def _in_turn(self, ask: Callable[[float], T], seconds: float) -> T:
        if not self._turns.acquire(timeout=seconds):
            raise _busy()
        try:
            return ask(seconds)
        except SlowQueryError:
            raise SlowQueryError(
                f"the query takes more than {seconds:g} s here: narrow it, as with grid= and n=, or ask "
                "`hcsearch query`"
            ) from None
        finally:
            self._turns.release()


def _busy() -> BusyError:
    return BusyError(
        "this list takes long, and so do others right now: try again in a few seconds, or narrow it, as with grid= "
        "and n="
    )
