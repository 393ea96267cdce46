"""A Dask cluster on this machine, started by its own commands, for as long as it is measured."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

from hcsearch.basics.errors import HcsearchError

PACKAGE = "distributed"

_PATIENCE = 60.0  # seconds
_POLL = 0.05
_FORGOTTEN = "2 hours"  # without work, after which a cluster that nobody ended ends itself


@contextmanager
def running_cluster(workers: int) -> Iterator[str]:
    """The address of a scheduler that has some workers, each a process of one thread; all are ended at the end."""
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        address = folder / "scheduler.json"
        options = [
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--idle-timeout",
            _FORGOTTEN,
            "--scheduler-file",
            str(address),
        ]
        scheduler = stack.enter_context(_started("scheduler", options, folder / "scheduler.log"))
        _wait(scheduler, folder / "scheduler.log", lambda: address.exists() and address.stat().st_size > 0)
        address = json.loads(address.read_text(encoding="utf-8"))["address"]
        options = [address, "--nthreads", "1", "--no-nanny", "--death-timeout", "60", "--local-directory", name]
        logs = [folder / f"worker-{k}.log" for k in range(workers)]
        started = [stack.enter_context(_started("worker", options, log)) for log in logs]
        for worker, log in zip(started, logs, strict=True):
            _wait(worker, log, partial(_says, log, "Registered to"))
        yield address


@contextmanager
def _started(what: str, options: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    with log.open("wb") as file:
        # in a session of its own, so that Ctrl-C reaches only the one who ends it
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", what, *options, "--no-dashboard"],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
            start_new_session=True,
        )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _says(log: Path, words: str) -> bool:
    return words in log.read_text(encoding="utf-8", errors="replace")


def _wait(process: subprocess.Popen[bytes], log: Path, ready: Callable[[], bool]) -> None:
    """Wait until a process is ready; HcsearchError with its last words when it ends, or takes too long."""
    deadline = time.monotonic() + _PATIENCE
    while not ready():
        if process.poll() is not None or time.monotonic() > deadline:
            words = log.read_text(encoding="utf-8", errors="replace").strip().splitlines() or ["no answer"]
            raise HcsearchError(f"a Dask {log.stem} does not start: {words[-1]}")
        time.sleep(_POLL)
