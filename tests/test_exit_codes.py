"""What a script reads: exit code 1 is a verdict, 2 a refusal, 3 a fault of the program, each with one line."""

import os
import pickle
import re
import subprocess
import sys
from pathlib import Path

import pytest

from hcsearch.search.pipeline.processes import ProcessExecutor
from hcsearch.system.answering import raising_place_of
from hcsearch.system.interrupts import INTERRUPT_MESSAGE

BROKEN = Path(__file__).with_name("broken")
ROOT = Path(__file__).parents[1]
SHOW = ("show", "hex:0234550132")
IN_WORKERS = ("enumerate", "--grid", "hex", "--n", "13", "--until", "motion", "--jobs", "2", "--dry-run")
"""The least search that other processes work on."""


@pytest.fixture
def run(tmp_path):
    """A command in a process of its own, in which something is broken, or only in its workers."""

    def call(broken, *words, workers=False, traceback=False):
        env = os.environ | {"PYTHONPATH": f"{BROKEN}{os.pathsep}{ROOT}", "BROKEN": broken}
        env |= {"BROKEN_IN": "workers"} if workers else {}
        env |= {"HCSEARCH_TRACEBACK": "1"} if traceback else {}
        command = [sys.executable, "-m", "hcsearch", *words]
        return subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=300, check=False)

    return call


def fault(done):
    """The line of a fault of the program; what was announced before is left out."""
    assert done.returncode == 3
    assert "Traceback" not in done.stderr
    lines = [line for line in done.stderr.splitlines() if not line.startswith("about ")]
    (line,) = lines
    assert line.startswith("hcsearch: ")
    return line


def test_a_fault_is_one_line_that_says_where_and_how_to_see_more(run):
    done = run("hcsearch.designs.folding:foldings", *SHOW)
    assert fault(done) == (
        "hcsearch: a fault of the program, RuntimeError at sitecustomize:16: broken on purpose; please report it with "
        "the command, which prints a traceback with HCSEARCH_TRACEBACK=1"
    )
    assert done.stdout == ""


def test_the_traceback_is_printed_on_demand_with_the_same_code(run):
    done = run("hcsearch.designs.folding:foldings", *SHOW, traceback=True)
    assert done.returncode == 3
    assert done.stderr.startswith("Traceback (most recent call last):\n")
    assert re.search(r"hcsearch/cli/show\.py\", line \d+, in show", done.stderr)
    assert done.stderr.splitlines()[-2:][0] == "RuntimeError: broken on purpose"


def test_an_interrupt_that_comes_back_as_another_exception_is_no_fault(run, monkeypatch):
    monkeypatch.setenv("BROKEN_BY", "interrupt")
    done = run("hcsearch.designs.folding:foldings", *SHOW)
    assert (done.returncode, done.stderr) == (130, f"{INTERRUPT_MESSAGE}\n")


@pytest.mark.parametrize("module", ["numpy", "click", "hcsearch.cli", "hcsearch.cli.query", "hcsearch.designs.folding"])
def test_what_cannot_be_loaded_is_no_verdict(run, module):
    line = fault(run(module, *SHOW))
    if module.startswith("hcsearch"):
        assert line.startswith("hcsearch: a fault of the program, ImportError at sitecustomize:")
    else:
        assert line == (
            f"hcsearch: {module} cannot be loaded: broken on purpose; install hcsearch anew, with what it depends on"
        )


@pytest.mark.parametrize(
    "broken", ["hcsearch.search.pipeline.shards:run_shard", "hcsearch.search.enumeration.array_circuits", "numpy"]
)
def test_a_fault_in_a_worker_process_is_one_line_too(run, broken):
    done = run(broken, *IN_WORKERS, workers=True)
    line = fault(done)
    assert "broken on purpose" in line
    assert [said.partition(" ")[0] for said in done.stdout.splitlines()] == ["searching"]


def test_the_place_and_the_traceback_of_a_fault_are_those_in_the_worker(run):
    broken = "hcsearch.search.pipeline.shards:run_shard"
    assert "RuntimeError at sitecustomize:16" in fault(run(broken, *IN_WORKERS, workers=True))
    done = run(broken, *IN_WORKERS, workers=True, traceback=True)
    assert done.returncode == 3
    assert "in a worker process:\nTraceback" in done.stderr
    assert re.search(r"hcsearch/search/pipeline/shards\.py\", line \d+, in __call__", done.stderr)


def test_a_fault_is_none_of_the_verdicts(run, tmp_path):
    """The commands that end with 1 where nothing deploys."""
    words = {
        "deploy": ("hcsearch.springs.deployment.simulated_deployment:simulate_deployment", "hex:0234550132:4"),
        "check": ("hcsearch.search.own_patterns.single_circuits:check_circuit", "square:0123"),
        "tune": ("hcsearch.springs.tuning.spring_tuning:tune_springs", "hex:0234550132:4"),
        "drive": ("hcsearch.springs.drive.driven_folding:drive_along", "hex:0234550132:4"),
        "motion": ("hcsearch.motion.paths.branches:follow_branch", "hex:0234550132:4"),
    }
    for command, (broken, name) in words.items():
        module, _, function = broken.partition(":")
        assert re.search(rf"^def {function}\(", (ROOT / f"{module.replace('.', '/')}.py").read_text(), re.MULTILINE)
        assert "broken on purpose" in fault(run(broken, command, name))


class TwoWordsError(Exception):
    """Cannot be made anew of its message, as pickle does."""

    def __init__(self, one, two):
        super().__init__(f"{one} {two}")


class HoldingError(Exception):
    """Cannot be pickled for what it holds."""


def raise_two_words():
    raise TwoWordsError("two", "words")


def raise_holding():
    error = HoldingError("held")
    error.held = lambda: None
    raise error


def unpicklable():
    return lambda: None


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (raise_two_words, RuntimeError, "TwoWordsError: two words"),
        (raise_holding, RuntimeError, "HoldingError: held"),
        (unpicklable, (AttributeError, pickle.PicklingError), "pickle"),
    ],
)
def test_faults_that_cannot_be_sent_are_told_all_the_same(call, kind, message):
    pool = ProcessExecutor(1)
    try:
        with pytest.raises(kind, match=message) as raised:
            pool.submit(call).result()
        assert pool.submit(len, "abc").result() == 3  # the worker goes on
        module, _, line = raising_place_of(raised.value).partition(":")
        assert module == ("hcsearch.system.answering" if call is unpicklable else __name__)
        assert int(line) > 0
    finally:
        pool.kill()
