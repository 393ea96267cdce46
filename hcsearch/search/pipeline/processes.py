"""An executor of worker processes on this machine, which may be killed at any moment.

The standard library's ProcessPoolExecutor uses one pipe for the results of all workers and keeps its writing end open:
if a worker is killed while it writes a result, the executor waits for the rest forever. Here each worker has its own
pipe, whose other end no other process holds, so that the death of a worker closes its pipe.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from typing import Any

from hcsearch.system.answering import answer_calls
from hcsearch.system.work_steps import tell_listeners


class DeadWorkerError(BrokenExecutor):
    """A worker process died before it answered."""


class ProcessExecutor(Executor):
    """Executor with `workers` spawned processes, each served by a thread that waits for its answers.

    Raises OSError when processes cannot be started; a call raises DeadWorkerError when its worker dies. `kill` stops
    workers without waiting for their calls.
    """

    def __init__(self, workers: int) -> None:
        self._processes: list[BaseProcess] = []
        self._idle: SimpleQueue[Connection] = SimpleQueue()
        self._threads = ThreadPoolExecutor(workers)
        try:
            with _ctrl_c_held_back():
                for _ in range(workers):
                    self._start()
        except BaseException:
            self.kill()
            raise

    def _start(self) -> None:
        # spawned, not forked: this process has threads
        context = multiprocessing.get_context("spawn")
        local_end, worker_end = context.Pipe()
        with worker_end:
            process = context.Process(target=answer_calls, args=(worker_end,), daemon=True)
            process.start()
        self._processes.append(process)
        self._idle.put(local_end)

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        """Submit a call to the first free worker; arguments and result are pickled."""
        return self._threads.submit(self._ask, call, arguments, options)

    def _ask(self, *request: Any) -> Any:
        worker = self._idle.get()
        try:
            worker.send(request)
            succeeded, result = worker.recv()
            while succeeded is None:
                tell_listeners(*result)
                succeeded, result = worker.recv()
        except (EOFError, ConnectionError) as error:
            raise DeadWorkerError from error
        finally:
            self._idle.put(worker)
        if not succeeded:
            raise result
        return result

    def kill(self) -> None:
        """Kill and join all workers; unfinished calls are lost."""
        for process in self._processes:
            process.kill()
        self.shutdown(cancel_futures=True)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let workers finish their calls, then close their pipes and join them."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        while not self._idle.empty():
            self._idle.get().close()
        for process in self._processes:
            process.join()


@contextmanager
def _ctrl_c_held_back() -> Iterator[None]:
    """Block SIGINT while processes are started, so that they inherit the block until `answer` ignores it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # started first, since starting it unblocks SIGINT
    resource_tracker.ensure_running()
    previous_mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous_mask)
