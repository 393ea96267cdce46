import os

# The matrices here are small: more threads of BLAS would wait for each other, and take the cores of other tests.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# As the command does, so that kernels compile as fast.
os.environ.setdefault("NUMBA_OPT", "1")

import sys
from contextlib import suppress
from pathlib import Path

import pytest
from filelock import FileLock
from hypothesis import settings

from hcsearch.cli import progress
from tests.faults.summary import pytest_terminal_summary

__all__ = ["pytest_terminal_summary"]

EXTRAS = (
    *("coal", "distributed", "exudyn", "ezdxf", "graphillion", "mujoco", "numpydoc", "OCP", "ompl", "pinocchio"),
    *("psutil", "psycopg", "trimesh", "waitress", "werkzeug"),
)
"""Modules of extras and dependency groups; but pyarrow and sphinx, which pandas and SciPy take where installed."""

DURATIONS = Path(__file__).parents[1] / ".ci/durations"

# Tests of lines on progress set a time of their own; others compare standard error, however slow the machine is.
progress._LINE_SECONDS = 3600.0

# the first example of a test may compile a kernel
settings.register_profile("hcsearch", deadline=None)
settings.load_profile("hcsearch")


@pytest.fixture(autouse=True)
def _no_extras(request, monkeypatch):
    """Hide extras from tests that are not marked as needing one: these pass where none is installed."""
    if request.node.get_closest_marker("extra") is None:
        for name in EXTRAS:
            monkeypatch.setitem(sys.modules, name, None)


@pytest.fixture(scope="session")
def axe_script(tmp_path_factory, worker_id):
    """The script of axe-core, installed once for all workers."""
    from tests.axe import install

    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / "axe"
    folder.mkdir(exist_ok=True)
    with FileLock(folder / "lock"):
        return install(folder)


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Run command lines in this process, in an empty folder."""
    from tests.commands import run_here

    monkeypatch.chdir(tmp_path)
    return lambda *words: run_here(words, capfd)


def recorded_seconds():
    """Seconds of the tests that took longest in the last run of `.ci/run` that passed, by their names."""
    with suppress(OSError):
        lines = DURATIONS.read_text(encoding="utf-8").splitlines()
        return {name: float(seconds[:-1]) for seconds, _, name in (line.split(maxsplit=2) for line in lines)}
    return {}


def pytest_collection_modifyitems(config, items):
    """Begin with what took longest, on all workers, so that no core is left alone with it at the end.

    Each worker is given a part of the list to begin with. Parts have equal shares of what takes long, and whole modules
    of the rest, as a module's fixtures are made in each worker that runs a test of it.
    """
    workers = getattr(config, "workerinput", {}).get("workercount", 1)
    seconds = recorded_seconds()
    long = sorted((item for item in items if item.nodeid in seconds), key=lambda item: -seconds[item.nodeid])
    rest = [item for item in items if item.nodeid not in seconds]
    left = len(items)
    items.clear()
    for worker in range(workers):
        part = long[worker::workers]
        size = left // (workers - worker)  # as pytest-xdist divides them
        left -= size
        others = max(0, size - len(part))
        items += [*part, *rest[:others]]
        del rest[:others]
    items += rest
