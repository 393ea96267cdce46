"""What the fault tests share: jobs, the command line as a user starts it, and the law that holds after every fault.

The law: no finished batch is lost, the database is sound, the same command again takes what was finished from before
and ends with exactly the rows of a run that nothing disturbed.
"""

from __future__ import annotations

import hashlib
import os
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests import forking
from tests.commands import without_progress

PATIENCE = 120  # seconds; longer than any command here takes on a slow and busy machine
ORPHANS_LIVE = 3.0  # seconds that a worker may outlive the command that started it
INTERRUPTED = 130  # exit code after Ctrl-C
JOURNALS = ("-wal", "-journal")


@dataclass(frozen=True)
class Job:
    """An enumeration, always with two workers; by default with the last stage that needs no simulation."""

    grid: str
    n: int
    until: str = "mobility"

    def into(self, path):
        words = ["enumerate", "--grid", self.grid, "--n", str(self.n), "--until", self.until]
        return [*words, "--jobs", "2", "--db", str(path)]


# Even, so that there are foldings; in batches enough to lose one (12, 60), or small, where only rows count.
MANY, MOST = Job("rectangle", 20, "twist"), Job("square", 22, "twist")
SMALL, OTHER = Job("hex", 12), Job("square", 16)
# Whose motions are planned and simulated, in pieces.
DEPLOYED = Job("hex", 10, "deployment")
# Too long to be finished here, and long enough to be shared among processes.
LONG = Job("square", 28)


@dataclass(frozen=True)
class State:
    """A sound database: the keys of its finished batches, its designs and foldings without ids, how many designs."""

    finished: frozenset = frozenset()
    rows: Counter = field(default_factory=Counter)
    designs: int = 0

    def __add__(self, other):
        return State(self.finished | other.finished, self.rows + other.rows, self.designs + other.designs)


_FINISHED = "stage IN ('circuits', 'deployment')"

PROGRAM = (sys.executable, "-m", "hcsearch")


def command(*arguments, program=PROGRAM):
    return [*program, *map(str, arguments)]


def run(*arguments, program=PROGRAM, **options):
    """Run a command to its end, with its output as text."""
    if program is PROGRAM:
        return forking.run(arguments, timeout=PATIENCE, **options)
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run(command(*arguments, program=program), text=True, timeout=PATIENCE, check=False, **options)


class Running:
    """A command on its way, in a process group of its own; whatever is left of it at the end is killed.

    anew : whether it loads the program, as a user's does, and is not forked from a process that has.
    """

    def __init__(self, *arguments, program=PROGRAM, anew=False):
        # Files, not pipes: those could fill up, and the command would wait for a reader.
        self._out, self._err = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        if program is PROGRAM and not anew:
            with Path(os.devnull).open("rb") as nothing:
                self.process = forking.Forked(arguments, *(file.fileno() for file in (nothing, self._out, self._err)))
        else:
            streams = {"stdin": subprocess.DEVNULL, "stdout": self._out, "stderr": self._err}
            self.process = subprocess.Popen(command(*arguments, program=program), start_new_session=True, **streams)
        self.group = self.process.pid

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if members(self.group):
            os.killpg(self.group, signal.SIGKILL)
        self.process.wait(PATIENCE)
        self._out.close()
        self._err.close()

    @property
    def ended(self):
        return self.process.poll() is not None

    def signal(self, number, *, whole_group=False):
        """Send a signal to the command, or, as a terminal does, to its workers as well."""
        if not self.ended:
            with suppress(ProcessLookupError):  # it has ended meanwhile
                (os.killpg if whole_group else os.kill)(self.group, number)

    def end(self, number=None, *, whole_group=False):
        """Wait for the end, after a signal if one is given: (exit code, stdout, stderr). No worker may stay."""
        if number is not None:
            self.signal(number, whole_group=whole_group)
        code = self.process.wait(PATIENCE)
        assert wait_until(lambda: not members(self.group), ORPHANS_LIVE), f"still alive: {members(self.group)}"
        return code, self._text(self._out), without_progress(self._text(self._err))

    @staticmethod
    def _text(file):
        file.seek(0)
        return file.read().decode()


def members(group):
    """The processes of a group that are alive, by /proc; one that is dead and not yet buried does not count."""
    numbers = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue  # ended meanwhile
            if int(fields[2]) == group and fields[0] not in "ZX":
                numbers.append(int(entry.name))
    return numbers


def wait_until(condition, seconds, pause=0.003):
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(pause)
    return True


def progress(path):
    """(runs begun, batches finished) of a database in use; (0, 0) while there is none to be read."""
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=0.1)) as connection:
            return connection.execute(
                f"SELECT (SELECT count(*) FROM run), (SELECT count(*) FROM batch WHERE {_FINISHED})"
            ).fetchone()
    except sqlite3.Error:
        return (0, 0)


def wait_for(running, path, more, begun=(0, 0)):
    """Wait until the command has begun its run and finished `more` batches, or has ended."""
    target = begun[0] + 1, begun[1] + more
    reached = wait_until(lambda: running.ended or _at_least(progress(path), target), PATIENCE)
    assert reached, f"neither ended nor at {target} runs and batches"


def _at_least(now, target):
    return now[0] >= target[0] and now[1] >= target[1]


@contextmanager
def copied(path):
    """A copy of a database with its journals, so that looking at it does not repair the original."""
    with tempfile.TemporaryDirectory() as folder:
        yield copy(path, Path(folder) / "copy")


def look(path, *, rows=True):
    """The state of a database that nobody writes to, as the next one to open it will find it. It must be sound."""
    if not Path(path).exists():
        return State()
    with copied(path) as copy, closing(sqlite3.connect(copy)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
        if not connection.execute("SELECT 1 FROM sqlite_schema").fetchone():
            return State()  # killed before there were tables
        finished = connection.execute(
            f"SELECT grid, n, target, keep, scene, prefix FROM batch WHERE {_FINISHED}"
        ).fetchall()
        designs = connection.execute("SELECT count(*) FROM designs").fetchone()[0]
        return State(frozenset(finished), _rows(connection) if rows else Counter(), designs)


def _rows(connection):
    rows = Counter(row[1:] for row in connection.execute("SELECT * FROM designs"))
    of_design = "SELECT d.circuit, f.* FROM foldings AS f JOIN designs AS d ON d.id = f.design_id"
    rows.update((row[0], *row[2:]) for row in connection.execute(of_design))
    tried = "SELECT d.circuit, p.* FROM deployments AS p JOIN designs AS d ON d.id = p.design_id"
    rows.update((row[0], *row[2:]) for row in connection.execute(tried))
    planned = "SELECT d.circuit, m.* FROM motions AS m JOIN designs AS d ON d.id = m.design_id"
    rows.update((row[0], *row[2:]) for row in connection.execute(planned))
    return rows


def batches(text):
    """(done, taken from before) as the summary of a command says."""
    done, taken = re.search(r"^batches: (\d+) done, (\d+) taken from before$", text, re.MULTILINE).groups()
    return int(done), int(taken)


def funnel(text):
    """The counts of a summary, by label."""
    return dict(line.strip().rsplit(maxsplit=1) for line in text.splitlines() if line.startswith("  "))


def assert_refused(code, err):
    """A failure is exit code 2 and one line that says what to do."""
    assert code == 2, err
    assert_one_line(err)


def assert_one_line(err):
    assert err.startswith("hcsearch: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1, err


def seeded(name):
    """A source of chance for one test; what it drew is printed when the test fails."""
    seed = int(os.environ.get("FAULT_SEED", "20240229"))
    print(f"FAULT_SEED={seed} for {name}")
    return random.Random(f"{seed} {name}")


def leaf(path, name):
    """Offset and size of the first leaf page of a table or index, found along the left edge of its tree."""
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        size = connection.execute("PRAGMA page_size").fetchone()[0]
        page = connection.execute("SELECT rootpage FROM sqlite_schema WHERE name = ?", (name,)).fetchone()[0]
    content = Path(path).read_bytes()
    while True:
        at = (page - 1) * size
        if content[at] in (10, 13):  # leaf of an index, of a table
            return at, size
        first_cell = at + int.from_bytes(content[at + 12 : at + 14])
        page = int.from_bytes(content[first_cell : first_cell + 4])


def copy(source, path):
    """Copy a database with its journals, which nobody may be writing."""
    for suffix in ("", *JOURNALS):
        if Path(f"{source}{suffix}").exists():
            shutil.copyfile(f"{source}{suffix}", f"{path}{suffix}")
    return path


def digest(path):
    """A fingerprint of a database file and its log, as far as they hold content; not of the shared memory."""
    contents = [Path(f"{path}{suffix}") for suffix in ("", *JOURNALS)]
    return [hashlib.sha256(file.read_bytes()).hexdigest() for file in contents if file.exists() and file.stat().st_size]
