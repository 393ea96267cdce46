"""`hcsearch compile`, and what a terminal shows while kernels are compiled."""

import importlib
import io
import pickle
import subprocess
import sys
import time

import numba
import pytest
from click.testing import CliRunner
from numba.core.registry import cpu_target

from hcsearch.api import compiling
from hcsearch.cli import hcsearch, progress
from hcsearch.kernels.circuits.words import fingerprint_rows, insert_fingerprints
from hcsearch.kernels.collision.clearance_search import judge_clearance
from hcsearch.kernels.compiling import kernel_cache, under_way
from hcsearch.kernels.compiling.cache_folder import writable_folder
from hcsearch.kernels.compiling.compiled import end_waiting
from hcsearch.kernels.compiling.stamps import kernel_stamp, reached_kernels
from hcsearch.kernels.deployment_check import check_folding
from hcsearch.kernels.multibody.simulation import continue_simulation
from hcsearch.kernels.multibody.stops import update_held_joints


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def samples(monkeypatch):
    """One small sample, whose kernels are ready when its process has ended; the processes that were started."""
    started = []

    def start(name):
        process = subprocess.Popen(["sleep", "0.1" if name == "quick" else "60"], stderr=subprocess.PIPE, text=True)
        started.append(process)
        return process

    monkeypatch.setattr(compiling, "SAMPLES", {"quick": lambda: None, "long": lambda: None})
    monkeypatch.setattr(compiling, "_start", start)
    monkeypatch.setattr(compiling, "has_kernels_of", lambda job: any(process.poll() is not None for process in started))
    return started


def test_what_is_left_is_compiled_and_the_second_call_has_nothing_to_do(samples, monkeypatch):
    monkeypatch.setattr(compiling, "SAMPLES", {"quick": compiling.SAMPLES["quick"]})
    done = CliRunner().invoke(hcsearch, ["compile"])
    assert done.exit_code == 0
    assert done.stdout.endswith(" s\n")
    assert "kernels compiled in " in done.stdout
    assert len(samples) == 1
    again = CliRunner().invoke(hcsearch, ["compile"])
    assert again.stdout == "nothing is left to compile\n"
    assert len(samples) == 1


def test_loaded_kernels_are_those_that_samples_reach():
    used = compiling.loaded_kernels()
    assert all(kernel_stamp(kernel) for kernel in used)
    assert check_folding in used
    assert {continue_simulation, judge_clearance, update_held_joints} <= set(reached_kernels(check_folding))


CALLED = """
import sys
from numba.core.dispatcher import Dispatcher
from hcsearch.api.compiling import SAMPLES, run_sample
from hcsearch.kernels.compiling.compiled import loaded_kernels
from hcsearch.kernels.compiling.under_way import has_kernels_of
compile_for, called = Dispatcher._compile_for_args, set()
def noted(kernel, *args, **options):
    called.add(kernel)
    return compile_for(kernel, *args, **options)
Dispatcher._compile_for_args = noted
for name in SAMPLES:
    run_sample(name)
    assert has_kernels_of(name)
assert called <= loaded_kernels()
for kernel in called:
    print(kernel.py_func.__module__, kernel.py_func.__name__)
"""


@pytest.fixture(scope="module")
def called():
    """Lines with modules and names of the kernels that Python calls in all samples, run in one process."""
    done = subprocess.run([sys.executable, "-c", CALLED], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines())


def test_all_kernels_that_python_calls_in_a_sample_are_recorded(called):
    assert "hcsearch.kernels.circuits.words write_rows" in called
    # the samples ran in one process, so the last one has the kernels of all
    (*_, last) = compiling.SAMPLES
    assert called == set((writable_folder() / f"{last}.calls").read_text().splitlines())


def test_no_kernel_of_the_samples_has_more_than_40_arguments_in_its_ir(called):
    end_waiting()
    kernels = {getattr(importlib.import_module(module), name) for module, name in map(str.split, called)}
    stamps = {kernel_stamp(reached) for kernel in kernels for reached in reached_kernels(kernel)}
    counts = {}
    for path in writable_folder().glob("*.kernel"):
        if path.name.split("-")[1] in stamps:
            *_, (_, about, *_) = pickle.loads(path.read_bytes()[kernel_cache._CHECKED :])
            made = cpu_target.target_context.call_conv.get_function_type(about.restype, about.argtypes)
            counts[path.name] = len(made.args)
    assert len(counts) > 200
    assert max(counts.values()) <= 40


def test_kernels_of_a_job_are_missing_until_they_are_recorded_and_again_when_one_has_changed(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    assert not under_way.has_kernels_of("job")
    monkeypatch.setattr(under_way, "CALLED_BY_PYTHON", {insert_fingerprints})
    under_way.record_called_kernels("job")
    assert not under_way.has_kernels_of("job")
    file = writable_folder() / f"0-{kernel_stamp(insert_fingerprints)}-insert_fingerprints.kernel"
    file.touch()
    assert under_way.has_kernels_of("job")
    file.unlink()
    assert not under_way.has_kernels_of("job")


def test_a_sample_that_fails_is_one_line(samples, monkeypatch):
    def fail(_):
        return subprocess.Popen(
            [sys.executable, "-c", "raise SystemExit('no room')"], stderr=subprocess.PIPE, text=True
        )

    monkeypatch.setattr(compiling, "_start", fail)
    done = CliRunner().invoke(hcsearch, ["compile"])
    assert str(done.exception) == "the kernels could not be compiled (no room)"


def test_kernels_are_compiled_ahead_only_where_a_run_needs_them_and_they_are_missing(samples, tmp_path):
    target = ["--grid", "hex", "--n", "6", "--until", "twist", "--db", str(tmp_path / "designs.sqlite")]
    assert CliRunner().invoke(hcsearch, ["enumerate", *target]).exit_code == 0
    assert not samples  # no stage of this run deploys anything
    with compiling.compiling_ahead("long"):
        assert samples[0].poll() is None
    assert samples[0].poll() == -9  # nobody needs them any more
    with compiling.compiling_ahead("long"):
        assert len(samples) == 1  # they are ready


def test_a_terminal_says_that_kernels_are_compiled_and_a_pipe_does_not_at_once(monkeypatch):
    monkeypatch.setattr(progress, "_FIRST_NOTE_SECONDS", 0.01)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    everything = under_way.missing_stamps([insert_fingerprints]) | {"one", "two"}
    monkeypatch.setattr(under_way._State, "missing", everything)
    monkeypatch.setattr(under_way._State, "begun", time.monotonic())
    under_way.set_current_kernel(fingerprint_rows)
    done = len(everything) - len(under_way.uncompiled_stamps(everything))
    monkeypatch.setattr(under_way._State, "before", 7)  # compiled for earlier calls: the count never falls
    line = f"\rcompiling kernels, {7 + done} done"
    with progress.ProgressMeter("batch"):
        begin = time.monotonic()
        while line not in terminal.getvalue() and time.monotonic() < begin + 20:
            time.sleep(0.01)
    assert line in terminal.getvalue()
    assert terminal.getvalue().endswith(" \r")
    under_way.end_compilation()
    assert under_way.compilation_under_way() is None
    assert under_way._State.before == 7 + done
    monkeypatch.setattr(sys, "stderr", pipe := io.StringIO())
    under_way.set_current_kernel(fingerprint_rows)
    with progress.ProgressMeter("batch") as meter:
        meter(1, 2, "circuits")
        time.sleep(0.1)
        assert meter.state() == "batch 1 of 2, circuits"  # nothing is missing
    assert pipe.getvalue() == ""
    under_way.end_compilation()


def test_the_time_of_compilation_is_a_line_of_its_own(monkeypatch):
    monkeypatch.setattr(progress, "_LINE_SECONDS", 0.01)
    monkeypatch.setattr(sys, "stderr", log := io.StringIO())
    monkeypatch.setattr(under_way._State, "before", 0)
    monkeypatch.setattr(under_way._State, "seconds", 0.0)
    with progress.ProgressMeter(doing="show"):
        pass
    assert log.getvalue() == ""
    with progress.ProgressMeter(doing="enumerate"), progress.ProgressMeter(progress.SHARE) as meter:
        meter(20, 100, "motion, 1 of 9 foldings")
        monkeypatch.setattr(under_way, "missing_stamps", lambda kernels: frozenset({"none"}))
        under_way.start_compilation(insert_fingerprints)
        under_way.set_current_kernel(insert_fingerprints)
        assert meter.state() == "20 %, compiling kernels"
        monkeypatch.setattr(under_way._State, "begun", time.monotonic() - 42.0)
        monkeypatch.setattr(under_way, "uncompiled_stamps", lambda stamps: frozenset())
        under_way.end_compilation()
    last = log.getvalue().splitlines()[-1]
    assert last == "hcsearch: 0 s, 1 kernel compiled in 42 s; later runs read them from the cache"


def test_without_a_terminal_long_work_writes_a_line_from_time_to_time(monkeypatch):
    monkeypatch.setattr(progress, "_LINE_SECONDS", 0.01)
    monkeypatch.setattr(sys, "stderr", log := io.StringIO())
    with progress.ProgressMeter("batch") as meter:
        meter(1234, 5000, "12 designs")
        begin = time.monotonic()
        while log.getvalue().count("\n") < 2 and time.monotonic() < begin + 20:
            time.sleep(0.01)
    line, again, *_ = log.getvalue().splitlines()
    assert line == again == "hcsearch: 0 s, batch 1,234 of 5,000, 12 designs"
    ended = log.getvalue()
    time.sleep(0.05)
    assert log.getvalue() == ended
