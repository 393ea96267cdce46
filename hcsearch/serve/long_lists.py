"""Lists that take long: a few at once, so that they leave threads and processors to the others.

Nobody knows beforehand which those are. Each list has a short time at first; one that takes more begins again with the
whole time, where few enough others do.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from hcsearch.errors import QueryError
from hcsearch.serve.computing import BusyError
from hcsearch.store import SlowQueryError
from hcsearch.store.pages import SECONDS

T = TypeVar("T")

SHORT = 0.5
"""Seconds that any list may take."""
LONG_LISTS = 4
"""Lists at once that take longer."""


class LongLists:
    """Asks for lists, each within a time; `most` at once may take more than `short` seconds."""

    def __init__(self, most: int = LONG_LISTS, short: float = SHORT, seconds: float = SECONDS) -> None:
        self._short, self._seconds = short, seconds
        self._room = threading.BoundedSemaphore(most)

    def __call__(self, ask: Callable[[float], T]) -> T:
        """What a question gives. ask : takes the seconds that it has, and raises SlowQueryError after them.

        BusyError where it takes long and enough others do; QueryError where it takes too long.
        """
        try:
            return ask(self._short)
        except SlowQueryError:
            pass
        if not self._room.acquire(blocking=False):
            raise BusyError(
                "this list takes long, and so do others right now: try again in a few seconds, or narrow it, as with "
                "grid= and n="
            )
        try:
            return ask(self._seconds)
        except SlowQueryError:
            raise QueryError(
                f"the query takes more than {self._seconds:g} s here: narrow it, as with grid= and n=, or ask "
                "`hcsearch query`"
            ) from None
        finally:
            self._room.release()
