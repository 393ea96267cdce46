"""Who works on the shards of a search: this process, others of this machine, or workers of a scheduler.

Results come in the order of the inputs whoever works on them, so a run stores the same rows with the same ids.
"""

from __future__ import annotations

import asyncio
import logging
import pickle
import re
import socket
import struct
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from itertools import islice
from typing import Any, Protocol, TypeVar

from hcsearch.basics.errors import ClusterError
from hcsearch.search.pipeline.processes import DeadWorkerError, ProcessExecutor
from hcsearch.search.pipeline.sameness import (
    ProgramRefusal,
    ProgramVersions,
    are_sources_changed,
    are_sources_mixed,
    packed_task,
    program_difference,
    run_packed_task,
    running_program,
)

SCHEDULER_GREETING_SECONDS = 8.0
"""How long to wait for a scheduler's greeting, its name looked up and the connection made, in seconds."""

_ADDRESS = re.compile(r"(?:tcp://)?([^\s/:\[\]]+|\[[0-9a-fA-F:]+\]):([0-9]{1,5})", re.ASCII)
_LONGEST = 1 << 20  # bytes of a greeting, which has some hundred


def host_and_port(address: str) -> tuple[str, int]:
    """Split an address such as tcp://HOST:8786; ClusterError when it is none."""
    match = _ADDRESS.fullmatch(address)
    try:
        if match and 0 < int(match[2]) < 1 << 16 and match[1].isprintable() and match[1].encode("idna"):
            return match[1].strip("[]"), int(match[2])
    except UnicodeError:  # a part of the name is empty or too long
        pass
    raise ClusterError(f"{address!r} is not the address of a scheduler: write it as tcp://HOST:8786, a port to 65535")


def greets_as_dask(host: str, port: int, patience: float = SCHEDULER_GREETING_SECONDS) -> bool:
    """Whether a server listens there that greets as Dask's schedulers do: at once, by a frame after its length.

    patience : in seconds, for all of it.
    """
    answers: list[bool] = []
    # In a thread: nothing else bounds the time in which a name is looked up.
    thread = threading.Thread(target=lambda: answers.append(_greets(host, port, patience)), daemon=True)
    thread.start()
    thread.join(patience)
    return answers == [True]


def _greets(host: str, port: int, patience: float) -> bool:
    try:
        with socket.create_connection((host, port), timeout=patience) as link, link.makefile("rb") as stream:
            length: int = struct.unpack("<Q", stream.read(8))[0]
            return 0 < length < _LONGEST and len(stream.read(length)) == length
    except (OSError, struct.error):
        return False


P = TypeVar("P")
T = TypeVar("T")

_PARCEL = 4  # inputs that travel together: fewer journeys
_AHEAD = 4  # parcels in work or waiting for each worker: more even out their sizes, fewer take less memory
_PATIENCE = 10.0  # seconds
_GLANCE = 0.2  # seconds
_VERSION = version("hcsearch")
_CHANGED = (
    "the sources of hcsearch were changed while it ran, and results of two programs would be mixed: run the same "
    "command again; finished batches are kept"
)


class _Pool(Protocol):
    def submit(self, task: Callable[..., T], /, *arguments: Any) -> Future[T]: ...


@dataclass(frozen=True)
class WorkerPool:
    """`jobs` processes of this machine, or, where a scheduler's address is given, all workers of its cluster."""

    jobs: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.scheduler is not None:
            host_and_port(self.scheduler)

    def check(self) -> None:
        """Refuse a cluster that cannot be used, before anything else is touched."""
        if self.scheduler is not None:
            with _cluster(self.scheduler):
                pass

    def work(
        self, task: Callable[[P], T], inputs: Sequence[P], parcel: int = _PARCEL, threads: int = 1
    ) -> Iterator[tuple[P, T]]:
        """Yield each input with its result, in order; a task is pickled where other processes work on it.

        parcel : the most inputs that travel together. A kill loses no parcel that has come back and been recorded.
        threads : of a crew of one process.

        Raises ClusterError when workers die or the scheduler cannot be reached, and when a worker or this process runs
        another program than this one was when it began; what was yielded before stays good.
        """
        expected = running_program()
        if self.scheduler is None and (self.jobs == 1 or len(inputs) < 2):
            # one at least, so that Ctrl-C finds this one waiting and not within a kernel
            own = ThreadPoolExecutor(threads)
            try:
                # one waits while another is recorded, and tasks are not equally long
                for one, result in _in_order(own, task, inputs, 2 * threads - 1):
                    if are_sources_mixed():
                        raise ClusterError(_CHANGED)
                    yield one, result
            finally:
                own.shutdown(wait=False, cancel_futures=True)
            return
        with self._pool() as (pool, workers):
            size = max(1, min(parcel, len(inputs) // (2 * _AHEAD * workers)))
            parcels = [inputs[at : at + size] for at in range(0, len(inputs), size)]
            for sent, answer in _in_order(_Packing(pool, expected), task, parcels, _AHEAD * workers):
                if isinstance(answer, ProgramRefusal) or are_sources_mixed():
                    raise self._refused(answer)
                yield from zip(sent, answer, strict=True)

    def _refused(self, answer: object) -> ClusterError:
        """Why results are not to be used."""
        other = answer.program if isinstance(answer, ProgramRefusal) else None
        if self.scheduler is None or are_sources_mixed():
            return ClusterError(_CHANGED)
        who = "loaded sources that were changed while it ran" if other is None else f"has {program_difference(other)}"
        return ClusterError(
            f"a Dask worker at {self.scheduler} {who}: stop it, install there what runs here, and run the same command "
            "again; finished batches are kept"
        )

    @contextmanager
    def _pool(self) -> Iterator[tuple[_Pool, int]]:
        if self.scheduler is not None:
            with _cluster(self.scheduler) as pool_and_threads:
                yield pool_and_threads
            return
        try:
            pool = ProcessExecutor(self.jobs)
        except OSError as error:
            raise ClusterError(f"cannot start {self.jobs} processes ({error.strerror}): use fewer --jobs") from error
        try:
            yield pool, self.jobs
        except DeadWorkerError as error:
            if are_sources_changed():
                raise ClusterError(_CHANGED) from error
            raise ClusterError(
                "a worker process died, perhaps for want of memory: run it again, with fewer --jobs; finished batches "
                "are kept"
            ) from error
        finally:
            # a process that is still at work has a batch that is not needed, which may take minutes
            pool.kill()


def _in_order(pool: _Pool, task: Callable[..., Any], parcels: Sequence[P], ahead: int) -> Iterator[tuple[P, Any]]:
    waiting: deque[tuple[P, Future[Any]]] = deque()
    todo = iter(parcels)
    try:
        while True:
            waiting.extend((parcel, pool.submit(task, parcel)) for parcel in islice(todo, ahead - len(waiting)))
            if not waiting:
                return
            parcel, future = waiting.popleft()
            yield parcel, _result(future)
    finally:
        for _, future in waiting:
            future.cancel()


class _ClusterPool:
    """Work given to a cluster.

    Not the client's own executor: a result that is ready when the scheduler dies is never delivered by that one, nor
    is an error, and whoever waits for it waits for ever. A future of the client itself raises.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, task: Callable[..., T], /, *arguments: Any) -> Future[T]:
        future: Future[T] = self._client.submit(task, *arguments, pure=False)
        return future


class _Packing:
    """A pool whose workers work on parcels of inputs, if they run the expected program."""

    def __init__(self, pool: _Pool, expected: ProgramVersions) -> None:
        self._pool, self._expected = pool, expected

    def submit(self, task: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        (parcel,) = arguments
        return self._pool.submit(run_packed_task, self._expected, packed_task(task, parcel))


def _result(future: Future[T]) -> T:
    """What a future gives. An interrupt that comes just before a wait is noticed only after it: no wait is long."""
    while isinstance(future, Future) and not wait((future,), _GLANCE).done:
        pass
    return future.result()  # one of a cluster wakes by itself


@contextmanager
def _cluster(address: str) -> Iterator[tuple[_Pool, int]]:
    """A pool on the workers of a Dask scheduler, and how many threads they have."""
    try:
        from distributed import Client, KilledWorker  # noqa: PLC0415 - an extra
        from distributed.client import ClosedClientError  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ClusterError("--scheduler needs Dask: pip install 'hcsearch[cluster]'") from error
    if not greets_as_dask(*host_and_port(address)):
        raise _no_scheduler(address)
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what they have to say comes as an exception
    connect: Any = Client  # untyped
    try:
        # A client of anything else, such as a worker, waits long and complains when it is thrown away.
        kind = asyncio.run(asyncio.wait_for(_kind(address), _PATIENCE))
    except Exception as error:  # whatever comes of a language that only begins like Dask's
        raise _no_scheduler(address) from error
    if kind != "Scheduler":
        raise _no_scheduler(address)
    try:
        client = connect(address, timeout=_PATIENCE, set_as_default=False, direct_to_workers=True)
    except (OSError, ValueError, TypeError) as error:
        raise _no_scheduler(address) from error
    try:
        yield _ClusterPool(client), _check_workers(client, address)
    except (KilledWorker, CancelledError, ClosedClientError, OSError) as error:
        raise ClusterError(
            f"the Dask cluster at {address} lost its scheduler, or the same batch on several workers: see their logs, "
            "start them again and run the same command; finished batches are kept"
        ) from error
    except (ImportError, AttributeError, TypeError, pickle.UnpicklingError):
        _check_workers(client, address)  # one that has joined may run another hcsearch, which has not what was sent
        raise
    finally:
        client.close(timeout=_PATIENCE)


async def _kind(address: str) -> str | None:
    """What listens at an address of Dask: Scheduler, Worker, Nanny."""
    from distributed import core  # noqa: PLC0415 - an extra

    dask: Any = core  # untyped
    link = await dask.connect(address, timeout=_PATIENCE)
    try:
        identity = await dask.send_recv(link, op="identity")
        return identity.get("type") if isinstance(identity, dict) else None
    finally:
        link.abort()


def _no_scheduler(address: str) -> ClusterError:
    return ClusterError(
        f"no Dask scheduler answers at {address}: start one with `dask scheduler` and give its address, such as "
        "tcp://HOST:8786"
    )


def _check_workers(client: Any, address: str) -> int:
    """Number of threads of the workers; ClusterError when there are none, or when they run another hcsearch."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError as error:
        remedy = f"start some with `dask worker {address}`"
        raise ClusterError(f"the Dask scheduler at {address} has no workers: {remedy}") from error
    try:
        versions = set(client.run(version, "hcsearch").values())
        programs = client.run(running_program) if versions == {_VERSION} else {}
    except Exception as error:
        raise ClusterError(
            f"the Dask workers at {address} cannot import hcsearch, or have an older one: install there what runs here"
        ) from error
    if versions != {_VERSION}:
        others = ", ".join(sorted(versions))
        raise ClusterError(f"the Dask workers at {address} run hcsearch {others}: install {_VERSION} there")
    for worker, other in programs.items():
        if found := program_difference(other):
            raise ClusterError(
                f"the Dask worker {worker} has {found}: install there what runs here, and start it again"
            )
    return sum(client.nthreads().values())
