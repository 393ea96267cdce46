"""Worker processes of this machine, which may be ended at any moment.

The standard library's ProcessPoolExecutor shares one pipe for the results of all workers, and itself holds its writing
end open: a worker that is ended in the midst of a result leaves it waiting for the rest for ever. Here each worker has
a pipe of its own, whose far end nobody else holds, so the end of a worker is the end of its pipe.
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


class DeadWorkerError(BrokenExecutor):
    """A worker process ended before it had answered."""


class ProcessExecutor(Executor):
    """Calls made in `workers` spawned processes, each with a thread here that waits for its answers.

    Raises OSError when they cannot be started; a call raises DeadWorkerError when its worker dies. `kill` ends them in
    the midst of their work.
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
        here, there = context.Pipe()
        with there:
            process = context.Process(target=answer_calls, args=(there,), daemon=True)
            process.start()
        self._processes.append(process)
        self._idle.put(here)

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        """Make a call in whichever worker is free first; what it is given and gives back is pickled."""
        return self._threads.submit(self._ask, call, arguments, options)

    def _ask(self, *request: Any) -> Any:
        worker = self._idle.get()
        try:
            worker.send(request)
            good, result = worker.recv()
        except (EOFError, ConnectionError) as error:
            raise DeadWorkerError from error
        finally:
            self._idle.put(worker)
        if not good:
            raise result
        return result

    def kill(self) -> None:
        """End the workers at once, and bury them; what they were at is lost."""
        for process in self._processes:
            process.kill()
        self.shutdown(cancel_futures=True)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the workers end when they have nothing more to do, and bury them."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        while not self._idle.empty():
            self._idle.get().close()
        for process in self._processes:
            process.join()


@contextmanager
def _ctrl_c_held_back() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach before they have come to `answer`."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # started here, as it lets Ctrl-C through again once it runs
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
