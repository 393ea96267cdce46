"""Streamed CSV and JSON of lists, and exports of designs and foldings."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

from hcsearch.basics.vocabulary import ReplaySource
from hcsearch.export.export_files import checked_export_settings
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat
from hcsearch.export.settings import SETTING_NAMES, ExportSettings
from hcsearch.store import Database, format_rows, select_page, stream
from hcsearch.web.serve.jobs import BusyError
from hcsearch.web.serve.listing import page_row_count
from hcsearch.web.serve.requests import MAX_PARAMETER_LENGTHS, AddressError, ListRequest, read_parameters

MAX_STREAMS = 3
"""Largest number of simultaneous downloads of all rows; each occupies a thread."""

STREAM_CHUNK_ROWS = 500
"""Largest number of rows read at once like a page; more are streamed."""

MEDIA_TYPES = {"csv": "text/csv", "json": "application/json"}


class ResultStreams:
    """Starts streamed downloads, a limited number at a time."""

    def __init__(self, max_streams: int = MAX_STREAMS) -> None:
        self._room = threading.BoundedSemaphore(max_streams)

    def start(self, database: Database, list_request: ListRequest, style: str, order: str) -> SentText:
        """Begin to read all rows in an order; errors of the query are raised here, not amid the answer."""
        if not self._room.acquire(blocking=False):
            raise BusyError("other files are being sent right now: try again when they have ended")
        with ExitStack() as stack:
            stack.callback(self._room.release)
            texts = format_rows(stack.enter_context(_all(database, list_request, order)), style)
            return SentText(next(texts, ""), texts, stack.pop_all())


class SentText(Iterator[bytes]):
    """The pieces of a text; `close` releases the resources of reading, also before the first piece."""

    def __init__(self, first_text: str, texts: Iterator[str], resources: ExitStack) -> None:
        self._first_text: str | None = first_text
        self._texts, self._resources = texts, resources

    def __next__(self) -> bytes:
        text, self._first_text = self._first_text, None
        try:
            return (next(self._texts) if text is None else text).encode(errors="replace")
        except StopIteration:
            self.close()
            raise
        except BaseException:
            with self._resources:  # explains failures of the database
                raise

    def close(self) -> None:
        """End reading."""
        close = getattr(self._texts, "close", None)
        if close is not None:
            close()
        self._resources.close()


def _all(database: Database, list_request: ListRequest, order: str) -> Any:
    return stream(
        database,
        list_request.selection,
        columns=list_request.columns,
        sort=order,
        limit=list_request.limit,
        view=list_request.view,
        scene=list_request.scene,
    )


def asks_for_few_rows(list_request: ListRequest) -> bool:
    """Return whether a request is for the rows of one page or for a small number of rows."""
    return list_request.page is not None or (list_request.limit is not None and list_request.limit <= STREAM_CHUNK_ROWS)


def text_of_few_rows(database: Database, list_request: ListRequest, style: str, order: str, seconds: float) -> bytes:
    """Return the text of the rows of a page, or of the first few, in an order; SlowQueryError after some seconds."""
    size = STREAM_CHUNK_ROWS if list_request.page is None else page_row_count(list_request)
    skip = (list_request.number - 1) * size
    count = size if list_request.limit is None else min(size, list_request.limit)
    selected = select_page(
        database,
        list_request.selection,
        columns=list_request.columns,
        sort=order,
        skip=skip,
        count=count,
        view=list_request.view,
        scene=list_request.scene,
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
"""Parsers of export settings by their names in `ExportSettings`, which checks their limits."""
assert set(_READ) == set(SETTING_NAMES)


def read_export(ending: str, pairs: Any) -> tuple[ExportFormat, ExportSettings, ReplaySource | None, str]:
    """Return format, settings, motion and scene (empty if not named) in the address of an export.

    HcsearchError for values that exports do not accept.
    """
    values = read_parameters(
        pairs, dict.fromkeys(_READ, 20) | {"format": 20, "motion": 10, "scene": MAX_PARAMETER_LENGTHS["scene"]}
    )
    name = values.get("format")
    candidates = [
        form for form in EXPORT_FORMATS.values() if (not form.only_by_name if name is None else form.name == name)
    ]
    candidates = [form for form in candidates if "." + ending in form.endings]
    if len(candidates) != 1:
        names = ", ".join(f"{form.endings[0]} ({form.name})" for form in EXPORT_FORMATS.values())
        raise AddressError(f"no one export ends in .{ending}: the formats are {names}; choose with format=NAME")
    motion: Any = values.get("motion")
    if motion is not None:
        _word(motion, ("path", "springs"))
    settings = {name: read(values[name]) for name, read in _READ.items() if name in values}
    return candidates[0], checked_export_settings(candidates[0], settings), motion, values.get("scene", "")
