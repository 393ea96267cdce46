"""CSV and JSON of what a list selects, as it is read; exports of designs and foldings."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat
from hcsearch.export.settings import SETTING_NAMES, ExportSettings
from hcsearch.store import Database, format_rows, select_page, stream
from hcsearch.web.serve.jobs import BusyError
from hcsearch.web.serve.listing import page_row_count
from hcsearch.web.serve.requests import MAX_PARAMETER_LENGTHS, AddressError, ListRequest, read_parameters

MAX_STREAMS = 3
"""Files of all rows that are sent at once: each keeps a thread."""

STREAM_CHUNK_ROWS = 500
"""Rows that are read at once, in the way of pages."""

MEDIA_TYPES = {"csv": "text/csv", "json": "application/json"}


class ResultStreams:
    """Texts of whole results, a few at once."""

    def __init__(self, most: int = MAX_STREAMS) -> None:
        self._room = threading.BoundedSemaphore(most)

    def start(self, database: Database, asked: ListRequest, style: str) -> SentText:
        """Begin to read all rows; what is wrong with the query is raised here, and not in the midst of the answer."""
        if not self._room.acquire(blocking=False):
            raise BusyError("other files are being sent right now: try again when they have ended")
        with ExitStack() as stack:
            stack.callback(self._room.release)
            texts = format_rows(stack.enter_context(_all(database, asked)), style)
            return SentText(next(texts, ""), texts, stack.pop_all())


class SentText(Iterator[bytes]):
    """Pieces of a text; `close` gives back what reading it held, also of one that nobody began to read."""

    def __init__(self, first: str, texts: Iterator[str], held: ExitStack) -> None:
        self._first: str | None = first
        self._texts, self._held = texts, held

    def __next__(self) -> bytes:
        text, self._first = self._first, None
        try:
            return (next(self._texts) if text is None else text).encode(errors="replace")
        except StopIteration:
            self.close()
            raise
        except BaseException:
            with self._held:  # which says what is wrong with the database, if that is it
                raise

    def close(self) -> None:
        """End reading."""
        close = getattr(self._texts, "close", None)
        if close is not None:
            close()
        self._held.close()


def _all(database: Database, asked: ListRequest) -> Any:
    return stream(
        database,
        asked.query,
        columns=asked.columns,
        sort=asked.sort,
        limit=asked.limit,
        view=asked.view,
        scene=asked.scene,
    )


def asks_for_few_rows(asked: ListRequest) -> bool:
    """Whether the rows of one page are asked for, or the first few."""
    return asked.page is not None or (asked.limit is not None and asked.limit <= STREAM_CHUNK_ROWS)


def text_of_few_rows(database: Database, asked: ListRequest, style: str, seconds: float) -> bytes:
    """The text of the rows of one page, or of the first few; SlowQueryError after some seconds."""
    size = STREAM_CHUNK_ROWS if asked.page is None else page_row_count(asked)
    skip = (asked.number - 1) * size
    count = size if asked.limit is None else min(size, asked.limit)
    selected = select_page(
        database,
        asked.query,
        columns=asked.columns,
        sort=asked.sort,
        skip=skip,
        count=count,
        view=asked.view,
        scene=asked.scene,
        seconds=seconds,
    )
    return "".join(format_rows(selected.stream(), style)).encode(errors="replace")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise AddressError(f"{text!r} is no number: write one") from None


def _word(text: str, words: tuple[str, ...]) -> str:
    if text not in words:
        raise AddressError(f"{text!r} is none of {', '.join(words)}: write one of these")
    return text


_READ: dict[str, Callable[[str], Any]] = {
    "state": str,
    "sheet": str,
    "kerf_mm": _number,
    "hinge_gap_mm": _number,
    "profile": str,
    "part": str,
    "contact": lambda text: _word(text, ("0", "1")) == "1",
    "timestep_s": _number,
}
"""How settings of exports are read, by their names in `ExportSettings`, which has their limits."""
assert set(_READ) == set(SETTING_NAMES)


def read_export(ending: str, pairs: Any) -> tuple[ExportFormat, str, str | None, dict[str, Any]]:
    """The format of an export's address, its scene (empty where none is named), its motion, and its settings.

    HcsearchError for values that exports do not take.
    """
    given = read_parameters(
        pairs, dict.fromkeys(_READ, 20) | {"format": 20, "motion": 10, "scene": MAX_PARAMETER_LENGTHS["scene"]}
    )
    name = given.get("format")
    known = [form for form in EXPORT_FORMATS.values() if (not form.by_name if name is None else form.name == name)]
    known = [form for form in known if "." + ending in form.endings]
    if len(known) != 1:
        names = ", ".join(f"{form.endings[0]} ({form.name})" for form in EXPORT_FORMATS.values())
        raise AddressError(f"no one export ends in .{ending}: the formats are {names}; choose with format=NAME")
    motion = given.get("motion")
    if motion is not None:
        _word(motion, ("path", "springs"))
    settings = {name: read(given[name]) for name, read in _READ.items() if name in given}
    ExportSettings(**settings)  # refused here, and not in a process that is started first
    return known[0], given.get("scene", ""), motion, settings
