"""Readers of the output that go away early: no traceback, and the work is finished or goes on."""

import os
import subprocess

import pytest

from tests.faults.fault_tools import MANY, SMALL, command, look

PIPE_BROKEN = 141  # as a shell says of a command that SIGPIPE ended


def end_without_reader(lines_read, *words):
    """Read some lines of a command's output, then close the pipe: (exit code, lines, stderr)."""
    process = subprocess.Popen(command(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lines = [process.stdout.readline() for _ in range(lines_read)]
    process.stdout.close()
    err = process.stderr.read()
    process.stderr.close()
    return process.wait(), lines, err


@pytest.mark.parametrize(
    "style", ["csv", *(pytest.param(style, marks=pytest.mark.slow) for style in ("json", "table", "markdown"))]
)
def test_head_of_a_query_ends_quietly(reference, tally, style):
    code, lines, err = end_without_reader(1, "query", "--db", reference(MANY).path, "--format", style)
    assert code in (0, PIPE_BROKEN)
    assert err == ""
    assert "id" in lines[0]
    tally("broken pipe", 1, 0, 0)


def test_query_that_nobody_reads_ends_quietly(reference, tally):
    code, _, err = end_without_reader(0, "query", "--db", reference(MANY).path, "--format", "csv")
    assert (code, err) == (PIPE_BROKEN, "")
    tally("broken pipe", 1, 0, 0)


def test_enumeration_that_nobody_reads_is_finished(tmp_path, law):
    path = tmp_path / "designs.sqlite"
    code, _, err = end_without_reader(0, *SMALL.into(path))
    assert code in (0, PIPE_BROKEN)
    assert err == ""
    finished = look(path, rows=False).finished
    assert finished
    law("broken pipe", path, SMALL, injected=1, before=finished)


@pytest.mark.parametrize("buffered", [False, True])
def test_refusal_that_nobody_reads_is_still_a_refusal(tmp_path, tally, buffered):
    read, write = os.pipe()
    os.close(read)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    environment |= {} if buffered else {"PYTHONUNBUFFERED": "1"}
    line = command("query", "--db", tmp_path / "none.sqlite")
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=write, text=True, env=environment, check=False)
    os.close(write)
    assert (done.returncode, done.stdout) == (2, "")
    tally("broken pipe", 1, 0, 0)


def test_enumeration_without_any_output_is_finished(tmp_path, law):
    """Standard output and error closed, as `>&- 2>&-` does."""
    path = tmp_path / "designs.sqlite"
    line = ["sh", "-c", 'exec "$@" >&- 2>&-', "sh", *command(*SMALL.into(path))]
    assert subprocess.run(line, check=False).returncode == 0
    law("broken pipe", path, SMALL, injected=1, before=look(path, rows=False).finished)
