"""Long computations in processes of their own: few at once, each with a time limit, and nobody else waits for them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from concurrent.futures import TimeoutError as LateError
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.search.pipeline.processes import DeadWorkerError, ProcessExecutor
from hcsearch.web.serve.keeping import Kept

PROCESSES = 2
"""Computations at once; as many more may wait."""
SECONDS = 120.0
KEPT = 32
"""Results that are kept in memory."""


class BusyError(HcsearchError):
    """Others are computed, or this one takes too long."""


class Computing:
    """Makes calls in `processes` processes, started when they are needed; results are kept by a key."""

    def __init__(self, processes: int = PROCESSES, seconds: float = SECONDS) -> None:
        self._seconds = seconds
        self._idle: SimpleQueue[ProcessExecutor | None] = SimpleQueue()
        for _ in range(processes):
            self._idle.put(None)
        self._room = threading.BoundedSemaphore(2 * processes)
        self._lock = threading.Lock()
        self._kept: Kept[Any] = Kept(KEPT)
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
