"""Lists that take long: a few at once, so that they leave threads and processors to the others.

Nobody knows beforehand which those are. Each list has a short time at first; one that takes more begins again with the
whole time, when few enough others do. Some wait for that, and one more is refused.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from hcsearch.basics.errors import QueryError
from hcsearch.store import SlowQueryError
from hcsearch.store.pages import SECONDS
from hcsearch.web.serve.computing import BusyError

T = TypeVar("T")

SHORT = 0.3
"""Seconds that any list may take."""
LONG_LISTS, WAITING = 4, 8
"""Lists at once that take longer, and those that wait for their turn, for as long as one may take."""


class LongLists:
    """Asks for lists: `most` at once may take more than `short` seconds, and `waiting` more wait for that."""

    def __init__(
        self, most: int = LONG_LISTS, waiting: int = WAITING, short: float = SHORT, seconds: float = SECONDS
    ) -> None:
        self._short, self._seconds = short, seconds
        self._turns, self._room = threading.BoundedSemaphore(most), threading.BoundedSemaphore(most + waiting)

    def __call__(self, ask: Callable[[float], T]) -> T:
        """What a question gives. ask : takes the seconds that it has, and raises SlowQueryError after them.

        BusyError where it takes long and enough others do; QueryError where it takes too long.
        """
        try:
            return ask(self._short)
        except SlowQueryError:
            pass
        if not self._room.acquire(blocking=False):
            raise _busy()
        try:
            return self._in_turn(ask)
        finally:
            self._room.release()

    def _in_turn(self, ask: Callable[[float], T]) -> T:
        if not self._turns.acquire(timeout=self._seconds):
            raise _busy()
        try:
            return ask(self._seconds)
        except SlowQueryError:
            raise QueryError(
                f"the query takes more than {self._seconds:g} s here: narrow it, as with grid= and n=, or ask "
                "`hcsearch query`"
            ) from None
        finally:
            self._turns.release()


def _busy() -> BusyError:
    return BusyError(
        "this list takes long, and so do others right now: try again in a few seconds, or narrow it, as with grid= "
        "and n="
    )
