"""What a request may have computed, in processes with a time limit, and results kept in memory.

Nothing is simulated or planned in the process that answers lists, so that these are answered all the time.
"""

from __future__ import annotations

import io
import threading
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import TimeoutError as LateError
from contextlib import suppress
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat
from hcsearch.search.pipeline.processes import DeadWorkerError, ProcessExecutor
from hcsearch.store import open_readonly
from hcsearch.web.serve.requests import ListRequest, design_address, list_address_of


@dataclass(frozen=True)
class ExportedFile:
    """A file: its name, and what is in it."""

    name: str
    content: bytes


def stored_design_page(db: str, notation: str, number: int, scene: str, named: str) -> str:
    """The page of a design of a database, with its foldings and their motions; named : its scene, in addresses."""
    from hcsearch.designs.circuit import Circuit  # noqa: PLC0415 - the engine
    from hcsearch.designs.folding import foldings  # noqa: PLC0415 - the engine
    from hcsearch.web.report.design_data import fetch_design_data  # noqa: PLC0415 - the engine
    from hcsearch.web.report.page_files import render_design  # noqa: PLC0415 - the engine

    circuit = Circuit.from_notation(notation)
    with open_readonly(db) as database:
        data = fetch_design_data(circuit, foldings(circuit), db, database, number, scene)
    row = ListRequest("designs", query=f"id={number}", scene=named, usual="")
    links = [
        ("all designs", list_address_of(replace(row, query=""))),
        ("its row as JSON", list_address_of(row, ".json")),
    ]
    links += [(f"{form.name} of its array", _export_address(number, form, named)) for form in _formats("array")]
    exports = {
        shown.folding.crease: [
            (form.name, _export_address(number, form, named, shown.folding.crease))
            for form in _formats("pattern", *(() if shown.twist else ("motion",)))
        ]
        for shown in data.foldings
    }
    return render_design(replace(data, links=links, exports=exports))


def stored_motion_json(db: str, notation: str, number: int, crease: int, scene: str) -> str:
    """The stored path of a folding in a scene, as the player takes it."""
    from hcsearch.cases.replay_sources import stored_replays  # noqa: PLC0415 - the engine
    from hcsearch.designs.circuit import Circuit  # noqa: PLC0415 - the engine
    from hcsearch.web.player import motion_json  # noqa: PLC0415 - the engine

    with open_readonly(db) as database:
        replays = stored_replays(database, {number: Circuit.from_notation(notation)}, scene)
        for path, replay in replays:
            if path.crease == crease:
                return motion_json(replay)
    raise HcsearchError(f"the path of folding {crease} is no longer in the database: open the list again")


def _formats(*of: str) -> list[ExportFormat]:
    """The formats of some kinds that are installed."""
    installed = []
    for form in EXPORT_FORMATS.values():
        with suppress(HcsearchError):
            if form.of in of:
                form.check_installed()
                installed.append(form)
    return installed


def _export_address(number: int, form: ExportFormat, named: str, crease: int | None = None) -> str:
    below = "" if crease is None else f"/foldings/{crease}"
    chosen = {"format": form.name} if form.by_name else {}
    return design_address(number, named, f"{below}/export{form.endings[0]}", **chosen)


def export_file(
    db: str, subject: str, stem: str, name: str, scene: str, motion: Any, settings: Mapping[str, Any]
) -> ExportedFile:
    """An export of a design or folding of the database; of several files, an archive. stem : of its name."""
    from hcsearch.export.export_files import checked_export_settings, export_files  # noqa: PLC0415 - the engine

    wanted = EXPORT_FORMATS[name]
    chosen = replace(checked_export_settings(wanted, settings), stem=stem)
    _, files = export_files(subject, wanted, chosen, motion, db, scene=scene)
    ending = wanted.endings[0]
    if len(files) == 1:
        return ExportedFile(stem + ending, files[ending])
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for own, content in files.items():
            packed.writestr(zipfile.ZipInfo(stem + own), content)
    return ExportedFile(f"{stem}{ending}.zip", archive.getvalue())


Value = TypeVar("Value")


class ResultCache(Generic[Value]):
    """The latest results; KeyError for one that is not kept, or no longer."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[Hashable, Value] = OrderedDict()
        self._lock = threading.Lock()

    def __getitem__(self, key: Hashable) -> Value:
        return self._values[key]

    def __setitem__(self, key: Hashable, value: Value) -> None:
        with self._lock:
            self._values[key] = value
            while len(self._values) > self._most:
                self._values.popitem(last=False)


JOB_PROCESSES = 2
"""Computations at once; as many more may wait."""
MAX_JOB_SECONDS = 120.0
MAX_KEPT_RESULTS = 32
"""Results that are kept in memory."""


class BusyError(HcsearchError):
    """Others are computed, or this one takes too long."""


class ComputingPool:
    """Makes calls in `processes` processes, started when they are needed; results are kept by a key."""

    def __init__(self, processes: int = JOB_PROCESSES, seconds: float = MAX_JOB_SECONDS) -> None:
        self._seconds = seconds
        self._idle: SimpleQueue[ProcessExecutor | None] = SimpleQueue()
        for _ in range(processes):
            self._idle.put(None)
        self._room = threading.BoundedSemaphore(2 * processes)
        self._lock = threading.Lock()
        self._kept: ResultCache[Any] = ResultCache(MAX_KEPT_RESULTS)
        self._running: set[ProcessExecutor] = set()
        self._closed = False

    def __call__(self, key: Hashable, call: Callable[..., Any], *arguments: Any) -> Any:
        """The result of a call, or what is kept of it; BusyError where there is no room, or no end in time."""
        with suppress(KeyError):
            return self._kept[key]
        if not self._room.acquire(blocking=False):
            raise BusyError("other designs are computed right now: try again in a few seconds")
        try:
            return self._computed(key, call, arguments)
        finally:
            self._room.release()

    def _computed(self, key: Hashable, call: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        try:
            worker = self._idle.get(timeout=self._seconds)
        except Empty:
            raise BusyError("other designs are computed right now: try again in a minute") from None
        try:
            with suppress(KeyError):  # made while this one waited
                return self._kept[key]
            worker = worker or self._started()
            result = worker.submit(call, *arguments).result(self._seconds)
        except LateError:
            self._end(worker)
            worker = None
            raise BusyError(
                f"this takes more than {self._seconds:g} s: run hcsearch show --html or hcsearch export instead"
            ) from None
        except DeadWorkerError:
            self._end(worker)
            worker = None
            raise BusyError("the computation was ended, perhaps for want of memory: try again") from None
        finally:
            self._idle.put(worker)
        self._kept[key] = result
        return result

    def _started(self) -> ProcessExecutor:
        with self._lock:
            if self._closed:
                raise BusyError("the server is ending: start it again")
            worker = ProcessExecutor(1)
            self._running.add(worker)
        return worker

    def _end(self, worker: ProcessExecutor | None) -> None:
        if worker is not None:
            with self._lock:
                self._running.discard(worker)
            worker.kill()

    def close(self) -> None:
        """End all processes, in the midst of what they are at."""
        with self._lock:
            self._closed = True
            running, self._running = self._running, set()
        for worker in running:
            worker.kill()
