"""Workers for the shards of a search: this process, other processes of this machine, or a Dask cluster.

Results come in the order of the inputs with all kinds of workers, so a run stores the same rows with the same ids.
"""

from __future__ import annotations

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
"""Timeout for a scheduler's greeting, including name lookup and connection, s."""

_ADDRESS = re.compile(r"(?:tcp://)?([^\s/:\[\]]+|\[[0-9a-fA-F:]+\]):([0-9]{1,5})", re.ASCII)
_MAX_GREETING_BYTES = 1 << 20  # bytes of a greeting, which usually has some hundred


def host_and_port(address: str) -> tuple[str, int]:
    """Split an address such as tcp://HOST:8786 into host and port; ClusterError for an invalid one."""
    match = _ADDRESS.fullmatch(address)
    try:
        if match and 0 < int(match[2]) < 1 << 16 and match[1].isprintable() and match[1].encode("idna"):
            return match[1].strip("[]"), int(match[2])
    except UnicodeError:  # a part of the name is empty or too long
        pass
    raise ClusterError(f"{address!r} is not the address of a scheduler: write it as tcp://HOST:8786, a port to 65535")


def greets_as_dask(host: str, port: int, timeout: float = SCHEDULER_GREETING_SECONDS) -> bool:
    """Whether a server at an address sends the greeting of a Dask scheduler: a frame preceded by its length.

    timeout : for lookup, connection and greeting together, s.
    """
    answers: list[bool] = []
    # in a thread, since the duration of a name lookup cannot be limited otherwise
    thread = threading.Thread(target=lambda: answers.append(_greets(host, port, timeout)), daemon=True)
    thread.start()
    thread.join(timeout)
    return answers == [True]


def _greets(host: str, port: int, timeout: float) -> bool:
    try:
        with socket.create_connection((host, port), timeout=timeout) as connection, connection.makefile("rb") as reader:
            length: int = struct.unpack("<Q", reader.read(8))[0]
            return 0 < length < _MAX_GREETING_BYTES and len(reader.read(length)) == length
    except (OSError, struct.error):
        return False


P = TypeVar("P")
T = TypeVar("T")

_MAX_PARCEL_INPUTS = 4  # inputs per parcel: more save transfers
_PARCELS_PER_WORKER = 4  # parcels in progress or queued per worker: more balance their sizes, fewer save memory
_CLUSTER_TIMEOUT = 10.0  # s
_RESULT_POLL_SECONDS = 0.2
_VERSION = version("hcsearch")
_CHANGED = (
    "the sources of hcsearch were changed while it ran, and results of two programs would be mixed: run the same "
    "command again; finished batches are kept"
)


class _Pool(Protocol):
    def submit(self, task: Callable[..., T], /, *arguments: Any) -> Future[T]: ...


@dataclass(frozen=True)
class WorkerPool:
    """A pool of workers: `jobs` processes of this machine, or all workers of the cluster of a scheduler's address."""

    jobs: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.scheduler is not None:
            host_and_port(self.scheduler)

    def check_cluster(self) -> None:
        """Check that the cluster, if any, can be used; ClusterError otherwise."""
        if self.scheduler is not None:
            with _cluster(self.scheduler):
                pass

    def map_ordered(
        self,
        task: Callable[[P], T],
        inputs: Sequence[P],
        parcel_size: int = _MAX_PARCEL_INPUTS,
        threads: int = 1,
        waiting: Callable[[], None] = lambda: None,
    ) -> Iterator[tuple[P, T]]:
        """Yield each input with its result, in order; tasks for other processes are pickled.

        parcel_size : greatest number of inputs sent together; a kill loses only parcels whose results are not yet
        recorded.
        threads : used where this process is the only worker. waiting : called several times a second while a result is
        waited for, but not for a result of a cluster.

        Raises ClusterError when workers die or the scheduler cannot be reached, and when a worker runs another program
        than this process did at the start, or this process does; results that were yielded before are valid.
        """
        expected = running_program()
        if self.scheduler is None and (self.jobs == 1 or len(inputs) < 2):
            # in another thread, so that Ctrl-C interrupts a wait and not a kernel
            executor = ThreadPoolExecutor(threads)
            try:
                # some tasks wait, since results are recorded meanwhile and tasks differ in duration
                for item, result in _in_order(executor, task, inputs, 2 * threads - 1, waiting):
                    if are_sources_mixed():
                        raise ClusterError(_CHANGED)
                    yield item, result
            finally:
                executor.shutdown(wait=False, cancel_futures=True)
            return
        with self._pool() as (pool, workers):
            size = max(1, min(parcel_size, len(inputs) // (2 * _PARCELS_PER_WORKER * workers)))
            parcels = [inputs[start : start + size] for start in range(0, len(inputs), size)]
            for parcel_inputs, answer in _in_order(
                _Packing(pool, expected), task, parcels, _PARCELS_PER_WORKER * workers, waiting
            ):
                if isinstance(answer, ProgramRefusal) or are_sources_mixed():
                    raise self._refused(answer)
                yield from zip(parcel_inputs, answer, strict=True)

    def _refused(self, answer: object) -> ClusterError:
        """Return the error that explains why results are rejected."""
        worker_program = answer.program if isinstance(answer, ProgramRefusal) else None
        if self.scheduler is None or are_sources_mixed():
            return ClusterError(_CHANGED)
        who = (
            "loaded sources that were changed while it ran"
            if worker_program is None
            else f"has {program_difference(worker_program)}"
        )
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
            # a process that is still busy has a batch that is not needed and may take minutes
            pool.kill()


def _in_order(
    pool: _Pool, task: Callable[..., Any], parcels: Sequence[P], ahead: int, waiting: Callable[[], None]
) -> Iterator[tuple[P, Any]]:
    submitted: deque[tuple[P, Future[Any]]] = deque()
    remaining = iter(parcels)
    try:
        while True:
            submitted.extend(
                (parcel, pool.submit(task, parcel)) for parcel in islice(remaining, ahead - len(submitted))
            )
            if not submitted:
                return
            parcel, future = submitted.popleft()
            yield parcel, _result(future, waiting)
    finally:
        for _, future in submitted:
            future.cancel()


class _ClusterPool:
    """A pool that submits tasks to a cluster.

    It does not use the client's executor, which never delivers a result that is ready when the scheduler dies, nor an
    error, so that a wait would never end; a future of the client itself raises.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, task: Callable[..., T], /, *arguments: Any) -> Future[T]:
        future: Future[T] = self._client.submit(task, *arguments, pure=False)
        return future


class _Packing:
    """A pool whose workers execute a task on parcels of inputs, if they run the expected program."""

    def __init__(self, pool: _Pool, expected: ProgramVersions) -> None:
        self._pool, self._expected = pool, expected

    def submit(self, task: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        (parcel,) = arguments
        return self._pool.submit(run_packed_task, self._expected, packed_task(task, parcel))


def _result(future: Future[T], waiting: Callable[[], None]) -> T:
    """Return the result of a future, waiting in short intervals so that an interrupt is noticed soon."""
    while isinstance(future, Future) and not wait((future,), _RESULT_POLL_SECONDS).done:
        waiting()
    return future.result()  # a future of a cluster can be interrupted


@contextmanager
def _cluster(address: str) -> Iterator[tuple[_Pool, int]]:
    """Yield a pool on the workers of a Dask scheduler, and the number of their threads."""
    import asyncio  # noqa: PLC0415 - loads slowly

    try:
        from distributed import Client, KilledWorker  # noqa: PLC0415 - an extra
        from distributed.client import ClosedClientError  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ClusterError("--scheduler needs Dask: pip install 'hcsearch[cluster]'") from error
    if not greets_as_dask(*host_and_port(address)):
        raise _no_scheduler(address)
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # their messages arrive as exceptions
    connect: Any = Client  # untyped
    try:
        # a client of anything but a scheduler waits long and logs errors when it is discarded
        kind = asyncio.run(asyncio.wait_for(_kind(address), _CLUSTER_TIMEOUT))
    except Exception as error:  # any failure of a protocol that only begins like Dask's
        raise _no_scheduler(address) from error
    if kind != "Scheduler":
        raise _no_scheduler(address)
    try:
        client = connect(address, timeout=_CLUSTER_TIMEOUT, set_as_default=False, direct_to_workers=True)
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
        _check_workers(
            client, address
        )  # a worker that has joined may run another hcsearch, without the objects that were sent
        raise
    finally:
        client.close(timeout=_CLUSTER_TIMEOUT)


async def _kind(address: str) -> str | None:
    """Return the type of the Dask server at an address: Scheduler, Worker, Nanny."""
    from distributed import core  # noqa: PLC0415 - an extra

    dask: Any = core  # untyped
    link = await dask.connect(address, timeout=_CLUSTER_TIMEOUT)
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
    """Return the number of the workers' threads; ClusterError without workers, or where they run another hcsearch."""
    try:
        client.wait_for_workers(1, timeout=_CLUSTER_TIMEOUT)
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
        other_versions = ", ".join(sorted(versions))
        raise ClusterError(f"the Dask workers at {address} run hcsearch {other_versions}: install {_VERSION} there")
    for worker, worker_program in programs.items():
        if mismatch := program_difference(worker_program):
            raise ClusterError(
                f"the Dask worker {worker} has {mismatch}: install there what runs here, and start it again"
            )
    return sum(client.nthreads().values())
