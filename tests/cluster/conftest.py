"""A Dask cluster of separate processes, started by the commands that docs/howto/search_at_scale.md gives."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def until(condition, seconds=60.0):
    """The first true value of a condition; a failed test when there is none in time."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.02)
    raise AssertionError("nothing happened in time")


class Cluster:
    """A scheduler with two workers, each a process group of its own."""

    def __init__(self, folder: Path, workers: int = 2):
        self.folder, self.dask = folder, [sys.executable, "-m", "dask"]
        address_file = folder / "scheduler.json"
        words = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(address_file)]
        self.scheduler = subprocess.Popen(
            [*self.dask, "scheduler", *words], cwd=folder, start_new_session=True, **QUIET
        )
        self.address = until(
            lambda: (
                address_file.exists()
                and address_file.stat().st_size
                and json.loads(address_file.read_text())["address"]
            )
        )
        self.workers: list[subprocess.Popen[bytes]] = []
        if workers:
            self.start_workers(workers)

    def start_workers(self, workers, **environment):
        words = [self.address, "--nworkers", str(workers), "--nthreads", "1", "--no-dashboard"]
        command, others = [*self.dask, "worker", *words], os.environ | environment
        self.workers.append(subprocess.Popen(command, cwd=self.folder, env=others, start_new_session=True, **QUIET))

    @property
    def worker(self):
        """The first that was started."""
        return self.workers[0]

    def working(self):
        """Process ids of the workers themselves, children of the one that was started."""
        listed = subprocess.run(
            ["pgrep", "-P", str(self.worker.pid), "-f", "spawn_main"], check=False, capture_output=True, text=True
        )
        return [int(line) for line in listed.stdout.split()]

    def stop(self):
        for process in (*self.workers, self.scheduler):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait(30)


@pytest.fixture
def cluster(tmp_path):
    running = Cluster(tmp_path)
    yield running
    running.stop()


@pytest.fixture
def lonely(tmp_path):
    """A scheduler without workers."""
    running = Cluster(tmp_path, workers=0)
    yield running
    running.stop()
