"""What commands say while they work: every one has a meter, and lines name the step, what is done and the time left."""

import io
import os
import re
import sys
import threading
import time
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.api.enumerating import enumerate_into
from hcsearch.basics.vocabulary import STAGE_NAMES, listed
from hcsearch.cli import hcsearch, progress
from hcsearch.search.pipeline.processes import ProcessExecutor
from hcsearch.search.stages.order import FOLDING_STAGES, STAGES
from hcsearch.system.work_steps import (
    StageProgress,
    hearing_work,
    part_of_progress,
    parts_of_work,
    step_of_thread,
    words_of_work,
    work_step,
)


def wait_until(happened):
    end = time.monotonic() + 20
    while not happened() and time.monotonic() < end:
        time.sleep(0.005)


def lines_within(monkeypatch, work):
    """The lines that are written while some work waits until there are three."""
    monkeypatch.setattr(progress, "_LINE_SECONDS", 0.01)
    monkeypatch.setattr(sys, "stderr", log := io.StringIO())
    work(lambda: wait_until(lambda: log.getvalue().count("\n") >= 3))
    return log.getvalue().splitlines()


def test_help_and_docstrings_list_the_stages_that_there_are():
    assert tuple(STAGES) == STAGE_NAMES
    help_text = " ".join(CliRunner().invoke(hcsearch, ["enumerate", "--help"]).output.split())
    assert f"The last stage: {listed(STAGE_NAMES, 'or')}. [default: {STAGE_NAMES[-1]}]" in help_text
    docstring = " ".join(enumerate_into.__doc__.split())
    assert f"The last stage: {listed([f'`{name}`' for name in STAGE_NAMES], 'or')}, the default." in docstring
    assert FOLDING_STAGES == ("mobility", "motion", "deployment")


def test_all_progress_has_one_type():
    texts = [path.read_text(encoding="utf-8") for path in Path(progress.__file__).parents[1].rglob("*.py")]
    assert sum(text.count("Callable[[int, int, str], None]") for text in texts) == 1


@pytest.mark.parametrize("name", sorted(hcsearch.commands))
def test_every_command_has_a_meter_but_the_one_that_waits_for_others(name, monkeypatch):
    opened = []

    class Meter(progress.ProgressMeter):
        def __enter__(self):
            opened.append(self._doing)
            return super().__enter__()

    monkeypatch.setattr("hcsearch.cli.ProgressMeter", Meter)
    assert CliRunner().invoke(hcsearch, [name, "--help"]).exit_code == 0
    assert opened == ([] if name == "serve" else [name])
    assert not progress._LINES.meters


def test_a_command_without_counts_names_itself_and_its_step(monkeypatch):
    def work(wait):
        with progress.ProgressMeter(doing="sheet"), work_step("simulating the motion"):
            wait()

    lines = lines_within(monkeypatch, work)
    assert set(lines) == {"hcsearch: 0 s, sheet, simulating the motion"}
    assert words_of_work() == ""


def test_a_terminal_that_states_no_width_has_a_bar(monkeypatch):
    main, side = pytest.importorskip("pty").openpty()  # 0 columns, as `script` has them in a job
    os.set_blocking(main, False)
    with os.fdopen(side, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with progress.ProgressMeter("step") as meter:
            meter(1, 3, "motion")
            shown = os.read(main, 4096)
    os.close(main)
    assert b"/3" in shown


def test_an_inner_meter_takes_the_lines_over_and_gives_them_back(monkeypatch):
    def inner(wait):
        with progress.ProgressMeter(doing="tune"), progress.ProgressMeter("set") as meter:
            meter(3, 500, "collides")
            wait()

    def outer(wait):
        with progress.ProgressMeter(doing="tune"):
            with progress.ProgressMeter("set") as meter:
                meter(3, 500, "collides")
            wait()

    for work, line in ((inner, "hcsearch: 0 s, set 3 of 500, collides"), (outer, "hcsearch: 0 s, tune")):
        lines = lines_within(monkeypatch, work)
        # one more may be written before the inner meter begins, and after it ends
        own = lines[lines.index(line) : len(lines) - lines[::-1].index(line)]
        assert own == [line] * len(own)
        assert len(own) >= len(lines) - 2


def test_a_share_never_falls_and_says_how_long_it_takes(monkeypatch):
    def work(wait):
        with progress.ProgressMeter(progress.SHARE) as meter:
            meter(0, 200, "motion")
            assert meter.state() == "0 %, motion"
            meter(100, 200, "motion")
            assert re.fullmatch(r"50 %, motion, about \S+ seconds left", meter.state())
            meter(90, 200, "flight")
            assert meter.state().startswith("50 %, flight, ")
            wait()

    assert all(line.startswith("hcsearch: 0 s, 50 %, flight, about ") for line in lines_within(monkeypatch, work))


def test_a_terminal_shows_a_bar_of_shares_alone(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    monkeypatch.setattr(sys, "stdout", terminal)
    with progress.ProgressMeter(doing="enumerate"), progress.ProgressMeter(progress.SHARE) as meter:
        meter(5, 120, "batch 1 of 4, circuits")
        assert "/120" not in terminal.getvalue()
        meter.write("  two-stack 2")  # where the bar was
        assert re.search(r"\r +\r  two-stack 2\n\r +\d%\|", terminal.getvalue())
        for _ in range(2):  # the second call shows the note of the first
            meter(30, 120, "motion, 30 of 40 foldings")
    assert re.search(r" 25%\|.*\| \[\d\d:\d\d<.*, motion, 30 of 40 foldings\]", terminal.getvalue())


EVENTS = st.lists(st.tuples(st.sampled_from(["motion", "deployment", "flight", "searching"]), st.integers(0, 5)))


@given(EVENTS, st.integers(1, 12))
def test_stages_are_counted_and_their_share_rises(events, foldings):
    shown = []
    stages = StageProgress(lambda *state: shown.append(state), ["motion", "deployment", "flight"], foldings)
    for step, count in events:
        stages.hear(step, count)
        stages.show_state()
    stages.finish(foldings)
    assert [done for done, *_ in shown] == sorted(done for done, *_ in shown)
    assert shown[-1][:2] == (3 * foldings, 3 * foldings)
    last = next((step for step, _ in reversed(events) if step != "searching"), "motion")
    assert shown[-1][2:] == (f"{last}, {foldings} of {foldings} foldings",)
    if events:
        counted = sum(count for step, count in events if step == last)
        assert shown[-2][2] == f"{last}, {min(counted, foldings)} of {foldings} foldings"


def test_parts_of_a_work_follow_each_other():
    assert parts_of_work([1.0, 3.0], 0.5) == [(0.0, 0.125), (0.125, 0.5)]
    shown = []
    part = part_of_progress(lambda *state: shown.append(state), 0.2, 0.6, name="hex n = 8")
    part_of_progress(part, 0.0, 0.1, unit="batch")(7, 9, "circuits")
    part(1, 2, "motion, 1 of 2 foldings")
    assert shown == [
        (230, 1000, "hex n = 8, batch 7 of 9, circuits"),
        (400, 1000, "hex n = 8, motion, 1 of 2 foldings"),
    ]


def _advance(count):
    with work_step("motion"):
        step_of_thread().advance(count)
    return count


def test_steps_are_heard_from_other_threads_and_processes():
    heard = []
    with hearing_work(lambda *event: heard.append(event)):
        thread = threading.Thread(target=_advance, args=(2,))
        thread.start()
        thread.join()
        with ProcessExecutor(1) as pool:
            assert pool.submit(_advance, 5).result() == 5
    assert heard == [("motion", 0), ("motion", 2), ("motion", 0), ("motion", 5)]


def test_a_closed_standard_error_is_no_fault(monkeypatch):
    monkeypatch.setattr(progress, "_LINE_SECONDS", 0.01)
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    with progress.ProgressMeter(doing="show"):
        log.close()
        time.sleep(0.05)
        assert progress._LINES._repeated._thread.is_alive()


def test_help_of_the_group_opens_no_meter():
    assert isinstance(hcsearch, click.Group)
    assert CliRunner().invoke(hcsearch, ["--help"]).exit_code == 0
    assert not progress._LINES.meters
