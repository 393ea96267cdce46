"""The command line as a person meets it: real files, and real processes where a start or an end matters."""

import contextlib
import csv
import fcntl
import io
import json
import os
import pty
import re
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import termios
import time
from importlib import metadata
from pathlib import Path

import pytest

from hcsearch.store import open_database
from hcsearch.system.interrupts import INTERRUPT_EXIT_CODE, INTERRUPT_MESSAGE
from tests import forking
from tests.commands import run_here, without_progress

ENUMERATE = ("enumerate", "--until", "mobility")  # deployments take longer than all else: they have tests of their own
ENUMERATE_HEX_10 = (*ENUMERATE, "--grid", "hex", "--n", "10", "--db", "d.sqlite")


@pytest.fixture
def start(tmp_path):
    """A command in a process of its own, run to its end."""

    def call(*words):
        command = [sys.executable, "-m", "hcsearch", *words]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr + done.stdout
        assert "Traceback" not in done.stderr
        return done

    return call


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """A command in this process, with the exit code that is expected of it."""

    def call(*words, code=0, env=None):
        with monkeypatch.context() as patch:
            patch.chdir(tmp_path)
            for name, value in (env or {}).items():
                patch.setenv(name, value)
            done = run_here(words, capfd)
        assert done.returncode == code, done.stderr + done.stdout
        assert "Traceback" not in done.stderr
        return done

    return call


@pytest.fixture(scope="session")
def stored_hexagons(tmp_path_factory):
    """A database with the designs of ten hexagons."""
    folder = tmp_path_factory.mktemp("hexagons")
    assert forking.run(ENUMERATE_HEX_10, cwd=folder).returncode == 0
    return folder / "d.sqlite"


@pytest.fixture
def hexagons(stored_hexagons, tmp_path):
    """A copy of that database, as d.sqlite in the test's own folder."""
    return shutil.copy(stored_hexagons, tmp_path)


def funnel(output):
    """Numbers of a funnel by label."""
    lines = re.findall(r"^  ([\w\- ()]+?) {2,}([\d,]+|-)$", output, re.MULTILINE)
    return {label: None if number == "-" else int(number.replace(",", "")) for label, number in lines}


def rows(done):
    return list(csv.reader(io.StringIO(done.stdout)))[1:]


def test_want_of_memory_is_one_line(tmp_path):
    open_database(str(tmp_path / "d.sqlite"), create=True).close()
    words = f"{sys.executable} -m hcsearch query --db d.sqlite --sql 'SELECT hex(zeroblob(480000000))'"
    line = ["sh", "-c", f"ulimit -v 1000000; exec {words}"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("hcsearch: there is not enough memory: ask for less, as by a --limit, or free some")
    assert done.stderr.count("\n") == 1


def test_messages_repeat_little_and_escape_what_a_terminal_would_act_on(run):
    long = run("query", "--db", "x" * 200 + "/" + "y" * 90_000, code=2).stderr
    assert len(long) < 2100
    assert "\x1b" not in run("show", "hex:\x1b[31m", code=2).stderr


def test_the_main_job(start, run):
    done = start("enumerate", "--grid", "hex", "--n", "12", "--until", "twist", "--db", "a.sqlite")
    numbers = funnel(done.stdout)
    assert list(numbers.values()) == [13265, 1175, 625, 239, 88, None, None]
    assert list(numbers)[-2:] == ["movable", "deployed by springs"]
    assert without_progress(done.stderr) == ""
    sql = "SELECT count(*), sum(n_fixed), sum(two_stack), sum(untwisted), count(DISTINCT array) FROM designs"
    result = run("query", "--db", "a.sqlite", "--sql", sql, "--format", "csv")
    assert rows(result) == [["1175", "13265", "239", "88", "625"]]


@pytest.mark.parametrize(
    ("grid", "spec", "expected"),
    [("square", "6x5", ["44", "154", "43", "43"]), ("hex", "4-4-4", ["6", "12", "2", "0"])],
)
def test_one_array(run, grid, spec, expected):
    run(*ENUMERATE, "--grid", grid, "--array", spec, "--db", "a.sqlite", "--panel", "70x70x6")
    sql = "SELECT count(*), sum(orbit_size), sum(two_stack), sum(untwisted) FROM designs"
    assert rows(run("query", "--db", "a.sqlite", "--sql", sql, "--format", "csv")) == [expected]
    sql = "SELECT panel, fixed_circuits FROM runs"
    assert rows(run("query", "--db", "a.sqlite", "--sql", sql, "--format", "csv")) == [["70x70x6", expected[1]]]


def test_runs_add_up_and_repeat_nothing(run):
    first = run(*ENUMERATE_HEX_10)
    again = run(*ENUMERATE_HEX_10)
    assert "0 taken from before" in first.stdout
    assert re.search(r"batches: 0 done, [1-9]\d* taken from before", again.stdout)
    assert funnel(first.stdout) == funnel(again.stdout)
    run(*ENUMERATE, "--grid", "hex", "--n", "8", "--db", "d.sqlite")
    run(*ENUMERATE, "--grid", "hex", "--array", "3-4-3", "--db", "d.sqlite")
    sql = "SELECT n, count(*), count(DISTINCT circuit) FROM designs GROUP BY n"
    assert rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv")) == [
        ["8", "16", "16"],
        ["10", "120", "120"],
    ]


def test_an_array_first_and_then_all_arrays(run):
    run(*ENUMERATE, "--grid", "hex", "--array", "3-4-3", "--db", "d.sqlite")
    run(*ENUMERATE_HEX_10)
    done = run("query", "--db", "d.sqlite", "n=10 untwisted", "-c", "id,n_foldings,n_untwisted", "--format", "csv")
    assert len(rows(done)) == 25
    sql = "SELECT count(*), sum(untwisted) FROM foldings"
    assert rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv")) == [["48", "40"]]


def test_a_later_stage_fills_in_what_is_missing(run):
    run(*ENUMERATE_HEX_10, "--until", "circuits")
    sql = "SELECT count(two_stack), count(untwisted), count(status) FROM designs"
    assert rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv")) == [["0", "0", "0"]]
    run(*ENUMERATE_HEX_10, "--until", "foldings")
    assert rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv"))[0][:2] == ["120", "0"]
    run(*ENUMERATE_HEX_10)
    sums = "sum(two_stack), sum(untwisted), count(status), sum(untwisted AND status IS NULL)"
    sql = f"SELECT {sums}, count(*) FROM designs"
    counts = rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv"))
    assert counts == [["32", "25", "95", "25", "120"]]  # what moves is not judged by these stages


@pytest.mark.parametrize(("keep", "stored", "arrays"), [("two-stack", 32, 32), ("untwisted", 25, 25)])
def test_keep(run, keep, stored, arrays):
    done = run(*ENUMERATE_HEX_10, "--keep", keep)
    dry = run(*ENUMERATE_HEX_10, "--keep", keep, "--dry-run")
    assert funnel(done.stdout) == funnel(dry.stdout)
    numbers = funnel(done.stdout)
    assert numbers["non-isomorphic circuits"] == 120
    assert 0 < numbers[f"arrays ({keep})"] <= arrays
    sql = "SELECT count(*), count(DISTINCT array) FROM designs"
    result = rows(run("query", "--db", "d.sqlite", "--sql", sql, "--format", "csv"))
    assert result == [[str(stored), str(numbers[f"arrays ({keep})"])]]


@pytest.mark.parametrize("jobs", ["1", "3"])
def test_jobs_and_dry_run_change_no_number(run, tmp_path, jobs):
    dry = run(*ENUMERATE, "--grid", "square", "--n", "16", "--dry-run", "--jobs", jobs)
    assert not list(tmp_path.iterdir())
    assert list(funnel(dry.stdout).values())[:3] == [2938, 414, 397]


@pytest.mark.parametrize(
    ("words", "numbers"),
    [
        (("--grid", "hex", "--n", "9"), [380, 37, 29, 0, 0, None, None]),
        (("--grid", "triangle", "--n", "8"), [0, 0, 0, 0, 0, None, None]),
        (("--grid", "square", "--n", "7"), [0, 0, 0, 0, 0, None, None]),
        (("--grid", "rectangle", "--n", "101"), [0, 0, 0, 0, 0, None, None]),
        (("--grid", "square", "--array", "5x5"), [0, 0, 0, 0, 0, None, None]),
        (("--grid", "square", "--array", "1x1"), [0, 0, 0, 0, 0, None, None]),
    ],
)
def test_nothing_found_is_a_result(run, words, numbers):
    assert list(funnel(run(*ENUMERATE, *words, "--db", "d.sqlite").stdout).values()) == numbers


def test_count(run):
    assert (
        "circuits           4638576\nup to symmetry     580717"
        in run("count", "--grid", "square", "--array", "8x8").stdout
    )
    assert "fixed circuits     13265\nup to symmetry     1175" in run("count", "--grid", "hex", "--n", "12").stdout


@pytest.mark.usefixtures("hexagons")
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("enumerate", "--grid", "octagon", "--n", "6"), "'octagon' is not one of"),
        (("enumerate", "--grid", "hex", "--n", "2"), "at least 3 panels"),
        (("enumerate", "--grid", "hex", "--n", "-4"), "at least 3 panels"),
        (("enumerate", "--grid", "hex", "--n", "1000"), "too large"),
        (("enumerate", "--grid", "hex", "--n", "40"), "too large to list"),
        (("count", "--grid", "square", "--n", "60"), "too large to list"),
        (("count", "--grid", "hex", "--array", "h1000"), "larger than"),
        (("count", "--grid", "square", "--array", "9" * 5000 + "x1"), "larger than"),
        (("count", "--grid", "square", "--array", "square:-f.f"), "malformed array"),
        (("count", "--grid", "square", "--array", "square:0xf.f"), "malformed array"),
        (("enumerate", "--grid", "hex", "--n", "6", "--until", ""), "unknown"),
        (("enumerate", "--grid", "hex", "--n", "many"), "not a valid integer"),
        (("enumerate", "--grid", "hex"), "either --n N"),
        (("enumerate", "--grid", "hex", "--n", "6", "--array", "h2"), "either --n N"),
        (("enumerate", "--grid", "hex", "--n", "6", "--until", "magic"), "unknown"),
        (("enumerate", "--grid", "hex", "--n", "6", "--until", "circuits", "--keep", "untwisted"), "--until twist"),
        (("enumerate", "--grid", "hex", "--n", "6", "--panel", "50"), "length x width x thickness"),
        (("enumerate", "--grid", "hex", "--n", "6", "--panel", "50x0x6"), "length x width x thickness"),
        (("enumerate", "--grid", "hex", "--n", "6", "--jobs", "0"), "--jobs"),
        (("enumerate", "--grid", "hex", "--n", "6", "--jobs", "40000"), "--jobs 40000 is more than four"),
        (("count", "--grid", "hex", "--n", "6", "--jobs", "40000"), "at most, or leave it out"),
        (("count", "--grid", "hex", "--array", "hex:f." + "f" * 50_000), "is larger than 20000 cells"),
        (("count", "--grid", "hex", "--array", "@pipe"), "cannot read the cells in pipe: it is a pipe or a device"),
        (("count", "--grid", "hex", "--array", "@/dev/zero"), "it is a pipe or a device"),
        (("units", "--grid", "hex", "--n", "10", "--seconds", "nan"), "nan is not a finite number"),
        (("units", "--grid", "triangle", "--n", "10", "--alpha", "nan"), "nan is not a finite number"),
        (("units", "--grid", "triangle", "--n", "10", "--alpha", "1e-300"), "from 0.0001 to 89.9999"),
        (("bench", "enumeration", "--quick", "--limit", "nan"), "nan is not a finite number"),
        (("bench", "tables", "--limit", "inf"), "inf is not a finite number"),
        (("show", "hex:0234550132:" + "9" * 5000), "no two-stack folding at crease"),
        (("show", "hex:0234550132:" + "0" * 5000), "no two-stack folding at crease 0"),
        (("show", "hex:" + "0" * 100_000), "the circuit is larger than 20000 cells"),
        (("query", "--db", "d.sqlite", "\x1b[31m"), r"\x1b[31m"),
        (("query", "--\x1b[31m"), r"--\x1b[31m"),
        (("enumerate", "--grid", "square", "--array", "12x12"), "too many to store"),
        (("enumerate", "--grid", "square", "--array", "40x40"), "too wide"),
        (("enumerate", "--grid", "square", "--array", "@cells.txt"), "not connected"),
        (("enumerate", "--grid", "square", "--array", "@twice.txt"), "given twice"),
        (("enumerate", "--grid", "square", "--array", "@missing.txt"), "cannot read"),
        (("enumerate", "--grid", "square", "--array", "square:zz"), "malformed array"),
        (("enumerate", "--grid", "hex", "--n", "6", "--db", "no/such/folder/d.sqlite"), "folder"),
        (("enumerate", "--grid", "hex", "--n", "6", "--db", "cells.txt"), "database"),
        (("enumerate", "--grid", "hex", "--n", "6", "--db", "foreign.sqlite"), "foreign.sqlite"),
        (("query", "--db", "nothing.sqlite"), "nothing.sqlite"),
        (("query", "--db", "d.sqlite", "size=3"), "size"),
        (("query", "--db", "d.sqlite", "n=twelve"), "twelve"),
        (("query", "--db", "d.sqlite", "n=10", "--sql", "SELECT 1"), "a SELECT stands alone"),
        (("query", "--db", "d.sqlite", "--sql", "DELETE FROM runs"), "write one SELECT"),
        (("query", "--db", "d.sqlite", "--sql", "ATTACH 'x.sqlite' AS x"), "read-only"),
        (("query", "--db", "d.sqlite", "--sql", "PRAGMA writable_schema=1"), "read-only"),
        (("show", "--db", "d.sqlite", "99999"), "no design"),
        (("show", "--db", "d.sqlite", "hex:012"), "does not close"),
        (("show", "--db", "d.sqlite", "one:two:three"), "malformed design"),
        (("show", "hex:024:1"), "no two-stack folding"),
        (("report", "--db", "d.sqlite", "--output", "cells.txt/r.html"), "there is no folder cells.txt"),
        (("fold",), "No such command"),
    ],
)
def test_bad_input_is_one_line_and_changes_nothing(run, tmp_path, words, message):
    (tmp_path / "cells.txt").write_text("0 0\n5 5\n")
    (tmp_path / "twice.txt").write_text("0 0\n0 1\n0 0\n")
    os.mkfifo(tmp_path / "pipe")
    foreign = sqlite3.connect(tmp_path / "foreign.sqlite")
    foreign.execute("CREATE TABLE mine (x)")
    foreign.close()
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    done = run(*words, code=2)
    assert message in done.stderr
    assert len(done.stderr) < 1300
    assert "\x1b" not in done.stderr
    assert done.stderr.startswith("hcsearch: ")
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""
    after = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    assert after == before


@pytest.mark.usefixtures("hexagons")
def test_query_formats_and_order(run):
    words = ("query", "--db", "d.sqlite", "n=10 n_foldings>=0", "-c", "id,min_twist,symmetry")
    table = run(*words, "-s", "-min_twist,id", "--limit", "200").stdout.splitlines()
    assert table[0].split() == ["id", "min_twist", "symmetry"]
    assert table[-1].split()[1] == "-"
    data = json.loads(run(*words, "-s", "min_twist", "--format", "json").stdout)
    assert len(data) == 120
    assert data[0]["min_twist"] == 0
    assert data[-1]["min_twist"] is None
    assert run(*words, "--limit", "1", "--format", "markdown").stdout.startswith("|")
    assert run("query", "min_twist=0", "-c", "n", "--format", "csv", env={"HCSEARCH_DB": "d.sqlite"}).stdout == (
        "n\n" + "10\n" * 25
    )


@pytest.mark.usefixtures("hexagons")
def test_show_a_design_and_a_folding(run):
    (row,) = rows(
        run(
            "query", "--db", "d.sqlite", "untwisted n_foldings=2", "-c", "id,circuit", "--limit", "1", "--format", "csv"
        )
    )
    by_id = run("show", "--db", "d.sqlite", row[0]).stdout
    assert by_id.count("twist 0") == 2
    assert f"circuit         {row[1]}" in by_id
    by_notation = run("show", row[1]).stdout
    assert [line for line in by_id.splitlines() if not line.startswith(("id ", "scene ", "status"))] == (
        by_notation.splitlines()
    )
    crease = re.search(r"folding (\d+)", by_id).group(1)
    assert run("show", "--db", "d.sqlite", f"{row[0]}:{crease}").stdout.count("folding ") == 1


def test_show_says_for_which_flat_pairs_an_end_is_locked_and_how_tight(run):
    printed = run("show", "hex:0234550132:3").stdout
    assert "folded, flat pairs rigid: locked (exact proof), a wrench" in printed
    assert "leaving it opens the loops by 1.7 mm, until a turn of 199 degrees" in printed
    assert "flat pairs hinged" not in printed.partition("Kutzbach 4")[2]
    neither = "neither the folded nor the flat state is proved locked by itself"
    assert neither not in printed
    assert run("show", "hex:0234550132:4").stdout.count(neither) == 1
    printed = run("show", "hex:0233534001:2").stdout
    assert "folded, flat pairs hinged: locked (exact proof)" in printed
    assert "would open the loops by more than 6 mm" in printed


@pytest.mark.usefixtures("hexagons")
def test_show_writes_a_page_of_a_design(run, tmp_path):
    words = ("query", "circuit=hex:0233534001", "--db", "d.sqlite", "-c", "id", "--format", "json")
    (row,) = json.loads(run(*words).stdout)
    done = run("show", f"{row['id']}:2", "--db", "d.sqlite", "--html")
    assert done.stdout == f"reports/design-{row['id']}-2.html\n"
    assert "locked" in (tmp_path / done.stdout.strip()).read_text(encoding="utf-8")
    assert run("show", "hex:0233534001:2", "--html", "--output", "page.html").stdout == "page.html\n"
    told = run("show", "hex:0233534001", "--output", "page.html", code=2).stderr
    assert told.strip() == "hcsearch: --output applies to a page: add --html"
    assert "is a database" in run("show", "hex:0233534001", "--html", "--output", "d.sqlite", code=2).stderr


@pytest.mark.usefixtures("hexagons")
def test_report(run, tmp_path):
    done = run("report", "n=10 two_stack", "--db", "d.sqlite", "--output", "reports/r.html")
    page = (tmp_path / done.stdout.strip()).read_text(encoding="utf-8")
    assert '"count":32,' in page
    done = run("report", "n=99", "--db", "d.sqlite", "--output", "reports/none.html", code=2)
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "reports" / "none.html").exists()


def test_two_enumerations_into_one_new_database_at_the_same_time(tmp_path):
    command = [sys.executable, "-m", "hcsearch", *ENUMERATE, "--grid", "hex", "--db", "both.sqlite", "--n"]
    both = [
        subprocess.Popen([*command, n], cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        for n in ("13", "12")
    ]
    for process in both:
        assert without_progress(process.communicate(timeout=300)[1].decode()) in {
            "",
            "nothing folds: an odd number of panels, 13, makes no two equal stacks\n",
        }
        assert process.returncode == 0
    with sqlite3.connect(tmp_path / "both.sqlite") as database:
        counts = database.execute("SELECT n, count(*), sum(n_fixed) FROM designs GROUP BY n ORDER BY n").fetchall()
    database.close()
    assert counts == [(12, 1175, 13265), (13, 3807, 45144)]


def test_a_killed_run_goes_on_where_it_stopped(run, tmp_path):
    words = ("enumerate", "--grid", "hex", "--n", "16", "--until", "twist", "--db", "k.sqlite", "--jobs", "2")
    killed = 0
    while killed < 4:
        process = subprocess.Popen([sys.executable, "-m", "hcsearch", *words], cwd=tmp_path, stdout=subprocess.DEVNULL)
        # kill only once this process has stored something new, so that every round gets further
        wait_for_batches(tmp_path / "k.sqlite", more_than=stored_batches(tmp_path / "k.sqlite"), process=process)
        process.send_signal(signal.SIGKILL)
        process.wait()
        killed += 1
    before = stored_batches(tmp_path / "k.sqlite")
    done = run(*words)
    assert list(funnel(done.stdout).values())[:2] == [1930635, 161705]
    reused = int(re.search(r"(\d+) taken from before", done.stdout).group(1))
    assert reused >= before > 0
    sql = "SELECT count(*), sum(n_fixed), count(two_stack), count(untwisted) FROM designs"
    assert rows(run("query", "--db", "k.sqlite", "--sql", sql, "--format", "csv")) == [
        ["161705", "1930635", "161705", "161705"]
    ]


def stored_batches(path: Path) -> int:
    if not path.exists():
        return 0
    database = sqlite3.connect(path, timeout=30)
    try:
        return database.execute("SELECT count(DISTINCT prefix) FROM batch").fetchone()[0]
    except sqlite3.OperationalError:  # not created yet
        return 0
    finally:
        database.close()


def wait_for_batches(path: Path, *, more_than: int, process: subprocess.Popen) -> None:
    end = time.monotonic() + 600  # other versions compile kernels first, beside other tests
    while stored_batches(path) <= more_than:
        assert process.poll() is None, "the run ended before it could be killed"
        assert time.monotonic() < end
        time.sleep(0.03)


@pytest.mark.usefixtures("hexagons")
def test_a_closed_pipe_ends_quietly(tmp_path):
    command = f"{sys.executable} -m hcsearch query --db d.sqlite -c circuit | head -n 1"
    done = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["circuit"]
    assert done.stderr == ""


def test_ctrl_c_in_a_finaliser_ends_a_command(tmp_path):
    code = """
import signal, sys, time
from hcsearch import cli
from hcsearch.system.outputs import replacing_file

class Held:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

@cli.hcsearch.command()
def hold():
    with replacing_file("a.txt"):
        Held()
        time.sleep(30)

cli.main()
"""
    line = [sys.executable, "-c", code, "hold"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, list(tmp_path.iterdir())) == (INTERRUPT_EXIT_CODE, [])
    assert done.stderr == f"\n{INTERRUPT_MESSAGE}\n"


def test_help_and_version_do_not_load_the_engine():
    code = "import sys, hcsearch.cli; print([m for m in ('numpy', 'numba', 'sqlalchemy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    done = subprocess.run([sys.executable, "-m", "hcsearch", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"hcsearch, version {metadata.version('hcsearch')}\n"


def on_a_terminal(words):
    """Run the command on a pseudo-terminal of 110 columns; return all it wrote there."""
    process, terminal = pty.fork()
    if process == 0:
        fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 110, 0, 0))
        os.execv(sys.executable, [sys.executable, "-m", "hcsearch", *words])
    written = b""
    with contextlib.suppress(OSError):  # the terminal's end
        while block := os.read(terminal, 4096):
            written += block
    assert os.waitpid(process, 0)[1] == 0
    return written.decode()


# Python 3.12 and newer warn of threads, which pytest-xdist has; the forked process begins anew at once
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_progress_with_rate_and_remaining_time_on_a_terminal():
    shown = on_a_terminal([*ENUMERATE, "--grid", "hex", "--n", "16", "--dry-run"])
    assert re.search(r"\d+%\|.*\| \d+/\d+ \[\d\d:\d\d<\d\d:\d\d, .*batch/s, [a-z]+, [\d,]+ circuits\]", shown)
    assert "161,705" in shown


def interruptible():
    """Let a process take the interrupt, which children of a test run in the background ignore, and yield to the test.

    On a busy machine it is done otherwise before the test sees its first batches.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.nice(4)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_says_how_to_go_on(run, tmp_path, number):
    words = (*ENUMERATE, "--grid", "hex", "--n", "17", "--db", "i.sqlite")
    process = subprocess.Popen(
        [sys.executable, "-m", "hcsearch", *words],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,  # noqa: PLW1509 - no threads here
    )
    wait_for_batches(tmp_path / "i.sqlite", more_than=3, process=process)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert without_progress(said).strip() == (
            "hcsearch: interrupted; the same command continues work that is stored in a database"
        )
    else:
        assert process.returncode == -signal.SIGTERM
    done = run(*words)
    assert list(funnel(done.stdout).values())[:2] == [6897210, 575325]
    assert "0 taken from before" not in done.stdout
