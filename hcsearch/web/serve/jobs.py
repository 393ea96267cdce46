"""Computations for requests, in processes with a time limit, and a cache of results.

The process that answers lists neither simulates nor plans, so that lists are always answered.
"""

from __future__ import annotations

import io
import threading
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import TimeoutError as LateError
from contextlib import suppress
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import ReplaySource
from hcsearch.export.export_files import export_files
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat
from hcsearch.export.settings import ExportSettings
from hcsearch.search.pipeline.processes import DeadWorkerError, ProcessExecutor
from hcsearch.subjects.case import Case
from hcsearch.subjects.design_cases import CircuitCase
from hcsearch.subjects.replay_sources import replay_of_design
from hcsearch.web.serve.requests import ListRequest, design_address, list_address_of


@dataclass(frozen=True)
class ExportedFile:
    """A file: its name and content."""

    name: str
    content: bytes


def subject_page(db: str, name: str, scene: str | None, scene_parameter: str) -> str:
    """Return the page of a stored design, with its foldings and their motions, or of an assembly.

    scene_parameter : scene in addresses.
    """
    from hcsearch.subjects.resolve import resolve  # noqa: PLC0415 - the engine

    return resolve(name, db, scene=scene, extent="page").page(_LinkedPages(named=name, scene=scene_parameter))


@dataclass(frozen=True)
class _LinkedPages:
    """Makes the pages of cases with links to neighbouring pages; named : the case. scene : in addresses."""

    named: str
    scene: str

    def design_page(self, design: CircuitCase) -> str:
        """Return the page of a stored design, with links to its files."""
        from hcsearch.web.report.design_data import fetch_design_data  # noqa: PLC0415 - the engine
        from hcsearch.web.report.page_files import render_design  # noqa: PLC0415 - the engine

        data = fetch_design_data(design)
        row = ListRequest("designs", query=f"id={self.named}", scene=self.scene, default_scene="")
        links = [
            ("all designs", list_address_of(replace(row, query=""))),
            ("its row as JSON", list_address_of(row, ".json")),
        ]
        links += [(f"{form.name} of its array", self._export_address(form)) for form in _formats("array")]
        exports = {
            shown.folding.crease: [
                (form.name, self._export_address(form, shown.folding.crease))
                for form in _formats("pattern", *(() if shown.twist else ("motion",)))
            ]
            for shown in data.foldings
        }
        return render_design(replace(data, links=links, exports=exports))

    def linkage_page(self, case: Case) -> str:
        """Return the page of an assembly."""
        from hcsearch.web.report.linkage_page import fetch_linkage_data, render_linkage  # noqa: PLC0415 - the engine

        return render_linkage(replace(fetch_linkage_data(case, self.named), links=[("all assemblies", "/assemblies")]))

    def _export_address(self, form: ExportFormat, crease: int | None = None) -> str:
        below = "" if crease is None else f"/foldings/{crease}"
        choice = {"format": form.name} if form.only_by_name else {}
        return design_address(self.named, self.scene, f"{below}/export{form.endings[0]}", **choice)


def motion_data(db: str, name: str, scene: str) -> str:
    """Return the motion of a stored folding with a path, as data of the player."""
    from hcsearch.subjects.resolve import resolve  # noqa: PLC0415 - the engine

    return resolve(name, db, scene=scene, extent="page").page(_DecidingMotion())


class _DecidingMotion:
    """Makes data of the player instead of pages."""

    def design_page(self, design: CircuitCase) -> str:
        """Return the deployment that gave a folding with a path its status, else the path."""
        from hcsearch.web.player import motion_json  # noqa: PLC0415 - the engine
        from hcsearch.web.report.deciding_motions import deciding_deployment  # noqa: PLC0415 - the engine

        (case,), stored = design.cases, design.stored
        crease = case.folding.crease
        path = None if stored is None else replay_of_design(stored, case.folding)
        if stored is None or path is None:
            raise HcsearchError(f"the path of folding {crease} is no longer in the database: open the list again")
        deciding = None
        with suppress(HcsearchError):  # its scene does not suit it: the path plays
            deciding = deciding_deployment(case, stored.folding_row(crease), stored.deployments_of(crease))
        return motion_json(path if deciding is None else deciding.replay)

    def linkage_page(self, case: Case) -> str:
        """Refuse linkages that are no design."""
        raise HcsearchError(f"{case.title} is no folding with a path")


def _formats(*of: str) -> list[ExportFormat]:
    """Return the installed formats of some kinds."""
    installed = []
    for form in EXPORT_FORMATS.values():
        with suppress(HcsearchError):
            if form.subject in of:
                form.check_installed()
                installed.append(form)
    return installed


def export_file(
    db: str, subject: str, form: ExportFormat, settings: ExportSettings, motion: ReplaySource | None, scene: str
) -> ExportedFile:
    """Return an export of a stored design or folding, an archive if of several files."""
    _, files = export_files(subject, form, settings, motion, db, scene=scene)
    stem, ending = settings.stem, form.endings[0]
    if len(files) == 1:
        return ExportedFile(stem + settings.ending, files[ending])
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for suffix, content in files.items():
            packed.writestr(zipfile.ZipInfo(stem + suffix), content)
    return ExportedFile(f"{stem}{ending}.zip", archive.getvalue())


Value = TypeVar("Value")


class ResultCache(Generic[Value]):
    """A cache of the latest results; KeyError for a key that is not in it."""

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._values: OrderedDict[Hashable, Value] = OrderedDict()
        self._lock = threading.Lock()

    def __getitem__(self, key: Hashable) -> Value:
        return self._values[key]

    def __setitem__(self, key: Hashable, value: Value) -> None:
        with self._lock:
            self._values[key] = value
            while len(self._values) > self._capacity:
                self._values.popitem(last=False)


JOB_PROCESSES = 2
"""Largest number of simultaneous computations; as many more may wait."""
MAX_JOB_SECONDS = 120.0
MAX_KEPT_RESULTS = 32
"""Capacity of the cache of results."""


class BusyError(HcsearchError):
    """The server is busy with other requests, or this one takes too long."""


class ComputingPool:
    """Runs calls in up to `processes` processes, started on demand; results are cached by a key."""

    def __init__(self, processes: int = JOB_PROCESSES, seconds: float = MAX_JOB_SECONDS) -> None:
        self._seconds = seconds
        self._idle: SimpleQueue[ProcessExecutor | None] = SimpleQueue()
        for _ in range(processes):
            self._idle.put(None)
        self._room = threading.BoundedSemaphore(2 * processes)
        self._lock = threading.Lock()
        self._cache: ResultCache[Any] = ResultCache(MAX_KEPT_RESULTS)
        self._running: set[ProcessExecutor] = set()
        self._closed = False

    def __call__(self, key: Hashable, call: Callable[..., Any], *arguments: Any) -> Any:
        """Return the result of a call, perhaps from the cache; BusyError if too many wait or time runs out."""
        with suppress(KeyError):
            return self._cache[key]
        if not self._room.acquire(blocking=False):
            raise BusyError("other pages are computed right now: try again in a few seconds")
        try:
            return self._computed(key, call, arguments)
        finally:
            self._room.release()

    def _computed(self, key: Hashable, call: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        try:
            worker = self._idle.get(timeout=self._seconds)
        except Empty:
            raise BusyError("other pages are computed right now: try again in a minute") from None
        try:
            with suppress(KeyError):  # computed by another thread meanwhile
                return self._cache[key]
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
        self._cache[key] = result
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
        """Kill all processes; their computations are lost."""
        with self._lock:
            self._closed = True
            running, self._running = self._running, set()
        for worker in running:
            worker.kill()
