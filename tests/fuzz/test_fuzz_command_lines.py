"""Bad command lines: options with values from pools of nasty ones, words dropped, repeated, changed and put in.

A line is run in this process. It ends with a documented code, without a traceback; a refusal is one line, and leaves no
file behind. Commands that list or simulate are given nothing that takes long: see `SMALL` and `REFUSED`.
"""

import os
import random
import resource

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import search_all
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database
from tests.fuzz.mutations import check_command, mutated

MOST_MEMORY = 1000
"""Megabytes by which all lines together may grow the process."""

MANY, BIG = "9" * 400, "9" * 5000
NUMBERS = ["nan", "inf", "-inf", "1e300", "1e-300", "-1", "0", "1", "0.5", "", "x", MANY, BIG, "\u0661", "1e999"]
WHOLE = ["-1", "0", "1", "3", "", "x", "1.5", "nan", MANY, BIG, "99999", "\u0661"]
SMALL = ["-1", "0", "2", "3", "4", "6", "", "x", "nan", "1e300", MANY, "99999"]  # what there is is listed at once
TEXTS = ["", "x", "\x1b[31m", "\0", "\ud800", "\udcff", "a" * 5000, "/", ".", "..", "-", "--", "$\\foo$", "é"]
DATABASES = ["d.sqlite", "none.sqlite", "cells.txt", "", "no/such/d.sqlite"]
FILES = ["none.csv", "cells.txt", "pipe", "/dev/zero", "/dev/null", ".", "", "\0", "\ud800", "a" * 5000, "d.sqlite"]
ARRAYS = ["2x2", "3-4-3", "t3", "h2", "p2x2", "@cells.txt", "@pipe", "@/dev/zero", "hex:f." + "f" * 50_000, "900x900"]
ARRAYS += ["s1", "hex:e.f.7", "square:3.3", "kite:1", "0x0", "@", "@d.sqlite", BIG + "x1", *TEXTS]
DESIGNS = ["1", "99", "1:0", "hex:024", "hex:024:1", "hex:" + "0" * 9999, "hex:0234550132:" + "0" * 5000, BIG]
DESIGNS += ["1:" + BIG, ":", "::", *TEXTS]
QUERIES = ["n=6", "array=h2", "untwisted or n=6", "(" * 2000, "not " * 2000, "n=6 " * 2000, "id=1 or (n=6 not id=2)"]
QUERIES += ["array=@/dev/zero", "circuit=hex:" + "0" * 50_000, *TEXTS]
COLUMNS = ["id,n", "-id", "id", "circuit,circuit", ",", "id," * 5000, *TEXTS]
GRID = [*GRIDS, "hexagon", "", "\0"]
SIZES = ["2x2", "1x1", "0x1", "100x100", "9999x9999", "x", "", "\u0661x1", MANY + "x1"]

COMMANDS = {
    ("show", "--db", "d.sqlite"): (DESIGNS, {"--db": DATABASES}),
    ("query", "--db", "d.sqlite"): (
        QUERIES,
        {"--db": DATABASES, "-c": COLUMNS, "-s": COLUMNS, "--limit": WHOLE, "--format": ["csv", "x"]},
    ),
    ("count",): (None, {"--grid": GRID, "--n": SMALL, "--array": ARRAYS, "--jobs": ["1", "0", "40000", "x"]}),
    ("enumerate", "--dry-run", "--until", "twist"): (
        None,
        {"--grid": GRID, "--n": SMALL, "--array": ARRAYS, "--jobs": ["1", "0", "40000"]},
    ),
    ("assembly", "unit-ii"): (None, {"--alpha": NUMBERS, "--base": NUMBERS, "--thickness": NUMBERS, "--side": NUMBERS}),
    ("assembly", "array-6r"): (SIZES, {"--side": NUMBERS, "--width": NUMBERS, "--thickness": NUMBERS}),
    ("export", "--db", "d.sqlite", "--output", "a.g6"): (
        DESIGNS,
        {"--output": FILES, "--format": ["graph6", "x"], "--kerf": NUMBERS, "--state": NUMBERS, "--profile": TEXTS},
    ),
    ("export", "--db", "d.sqlite", "--output", "a.zip", "--format", "svg"): (
        QUERIES,
        {"--output": FILES, "--format": ["bom", "x"], "--kerf": NUMBERS},
    ),
    ("identify", "spring"): (FILES, {}),
    ("identify", "motion", "none.csv"): (
        DESIGNS,
        {"--fit": TEXTS, "--rate": NUMBERS, "--held-out": FILES, "--gravity": TEXTS},
    ),
    ("identify", "damping", "--inertia", "1"): (
        FILES,
        {"--inertia": NUMBERS, "--hinges": WHOLE, "--rate": NUMBERS, "--from": NUMBERS},
    ),
    ("units", "--seconds", "0"): (
        None,
        {"--grid": GRID, "--n": ["-1", "4", "5", "x"], "--alpha": NUMBERS, "--seconds": ["nan", "-1", "0"]},
    ),
    ("rank", "--db", "d.sqlite"): (
        QUERIES,
        {"--db": DATABASES, "--limit": WHOLE, "--weight": ["dof=nan", "dof=1e300", "x", "dof="]},
    ),
}
REFUSED = {
    ("deploy", "hex:0234550132:4", "--tolerance", "-1"): {
        "--seconds": NUMBERS,
        "--damping": NUMBERS,
        "--start": NUMBERS,
    },
    ("tune", "hex:0234550132:4", "--spread", "mass=9"): {"--seconds": NUMBERS, "--held": TEXTS, "--samples": WHOLE},
    ("check", "hex:0234550132:4", "--held", "99"): {"--panel": [*SIZES, *NUMBERS], "--across": SIZES, "--scene": TEXTS},
    ("bench", "enumeration", "--limit", "nan"): {"--repeats": WHOLE},
}
"""Lines that have something wrong in them: they are refused whatever else is in them."""

KNOWN = [
    ("show", "hex:0234550132:" + "0" * 5000),
    ("identify", "damping", "--inertia", "1", "--hinges", MANY, "none.csv"),
    ("identify", "spring", "/dev/zero"),
    ("assembly", "unit-ii", "--base", "1e300"),
    ("assembly", "unit-ii", "--base", "1e-300"),
    ("assembly", "unit-ii", "--alpha", "1e-300"),
    ("assembly", "unit-i", "--thickness", "1e300"),
    ("assembly", "array-6r", "100x100"),
    ("units", "--grid", "hex", "--n", "10", "--seconds", "nan"),
    ("units", "--grid", "triangle", "--n", "10", "--alpha", "nan"),
    ("bench", "enumeration", "--quick", "--limit", "nan"),
    ("count", "--grid", "hex", "--array", "hex:f." + "f" * 50_000),
    ("count", "--grid", "hex", "--array", "@pipe"),
    ("count", "--grid", "hex", "--n", "6", "--jobs", "40000"),
    ("deploy", "hex:0234550132:4", "--spring", "1*" * 2000 + "linear:0.1"),
    ("deploy", "hex:0234550132:4", "--spring", "table:-1e300@0,1e300@1e-9"),
    ("deploy", "hex:0234550132:4", "--spring", "1e308*linear:1e300"),
    ("query", "--db", "d.sqlite", "(" * 2000 + "n=6" + ")" * 2000),
    ("query", "--db", "d.sqlite", "grid=square array=4-4-4"),
    ("export", "--db", "d.sqlite", "n=6", "--output", "a" * 5000, "--format", "svg"),
]
"""Lines that were accepted, hung, filled the memory or ended in a traceback."""


@pytest.fixture
def folder(tmp_path):
    """A folder with a database of a few designs, and other files."""
    with open_database(str(tmp_path / "d.sqlite"), create=True) as database:
        run_into(Plan(search_all(GRIDS["hex"], 6, "all"), "twist"), database)
    (tmp_path / "cells.txt").write_text("0 0\n0 1\n1 0\n1 1\n")
    os.mkfifo(tmp_path / "pipe")
    return tmp_path


def command_line(chance):
    """A command with a few options from the pools, and now and then a word dropped, changed or put in."""
    if chance.random() < 0.1:
        words, options = chance.choice(list(REFUSED.items()))
        return [*words, *_options(chance, options)]
    words, (first, options) = chance.choice(list(COMMANDS.items()))
    line = [*words, *([chance.choice(first)] if first else []), *_options(chance, options)]
    at = chance.randrange(len(words), len(line) + 1)
    kind = chance.randrange(8)
    if kind == 0:
        line.insert(at, chance.choice(TEXTS))
    elif kind == 1 and at < len(line):
        line.pop(at)
    elif kind == 2 and words[0] in ("show", "query", "rank", "identify") and at < len(line):
        line[at] = mutated(chance, line[at])
    return line


def _options(chance, options):
    names = chance.sample(sorted(options), min(len(options), chance.randint(0, 3)))
    return [word for name in names for word in (name, chance.choice(options[name]))]


def fuzz(seed, count, folder):
    """Run so many lines, and how often each code came."""
    chance = random.Random(seed)
    codes = [check_command(folder, command_line(chance)) for _ in range(count)]
    return {code: codes.count(code) for code in sorted(set(codes))}


def memory():
    """Megabytes that the process has had at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


@pytest.mark.parametrize("words", KNOWN, ids=lambda words: " ".join(words)[:40])
def test_lines_that_once_broke_it_are_refused(folder, words):
    assert check_command(folder, words) == 2


def test_bad_command_lines_are_refused_in_one_line(folder):
    before = memory()
    codes = fuzz(1, 150, folder)
    assert codes[2] > 75
    assert codes[0] > 5
    assert memory() - before < MOST_MEMORY


@pytest.mark.slow
def test_many_bad_command_lines_are_refused_in_one_line(folder):
    before = memory()
    codes = fuzz(2, 1500, folder)
    assert codes[2] > 750
    assert codes[0] > 50
    assert memory() - before < MOST_MEMORY
