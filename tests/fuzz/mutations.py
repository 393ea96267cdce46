"""Mutated texts and command lines, the same for the same seed, and how a command is run and judged."""

import contextlib
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from hcsearch.basics.errors import MAX_MESSAGE_LINE_LENGTH, HcsearchError
from hcsearch.cli import main

ENDS = {0, 1, 2, 130}
LONGEST = 130_000
"""Characters of a text: no word of a command line is longer."""
SLOWEST = 20.0
"""Seconds of one command or text: each takes milliseconds, but the first one to need a kernel may compile it."""

MARKS = [
    *"0123456789abcdefxpth.:,;-+*@/=<>!()[]{}%&'\"\\ #_eE",
    *("\0", "\n", "\t", "\x1b[31m", "\x7f", "\x85", "\u0661", "\u202e", "\ud800", "\udcff", "é", "∞"),
    *("nan", "inf", "1e300", "1e-300", "-1", "0" * 30, "9" * 400, "not ", " or ", "hex:", "x"),
]


def mutated(chance: random.Random, text: str) -> str:
    """A text with up to four changes: marks put in, taken away or changed, pieces repeated or moved."""
    for _ in range(chance.randint(0, 4)):
        a, b = sorted((chance.randint(0, len(text)), chance.randint(0, len(text))))
        kind = chance.randrange(6)
        if kind == 0:
            text = text[:a] + chance.choice(MARKS) + text[a:]
        elif kind == 1:
            text = text[:a] + text[a + chance.randint(1, 3) :]
        elif kind == 2:
            text = text[:a] + chance.choice(MARKS) + text[a + 1 :]
        elif kind == 3:
            text = text[:a] + text[a:b] * chance.choice((2, 3, 200)) + text[b:]
        elif kind == 4:
            text = text[b:] + text[:b]
        else:
            text = text[:a] + text[a:b][::-1] + text[b:]
    return text[:LONGEST]


def is_message(text: str) -> bool:
    """Whether a text is one short line that a terminal can show."""
    return text.isprintable() and len(text) <= MAX_MESSAGE_LINE_LENGTH + len("hcsearch: ")


def judge(text, read, again=None) -> bool:
    """Whether a text is read; it reads back as the same, or is refused in one line."""
    start = time.perf_counter()
    value = refusal = None
    try:
        value = read(text)
    except HcsearchError as error:
        refusal = str(error)
    except Exception as error:
        error.add_note(repr(text[:1000]))
        raise
    assert refusal is None or is_message(refusal), (text[:300], refusal)
    if refusal is None and again is not None:
        assert again(value) == value, text
    assert time.perf_counter() - start < SLOWEST, text[:300]
    return refusal is None


def run(folder: Path, words) -> tuple[int, str, str]:
    """Run a command in a folder; its exit code, output and errors. What it raises is a failure of the program."""
    on_interrupt, on_alarm, argv = signal.getsignal(signal.SIGINT), signal.signal(signal.SIGALRM, _late), sys.argv
    code = 0
    # files, as streams of a real process are: they have descriptors, and take no half characters
    with tempfile.TemporaryFile("w+", encoding="utf-8") as out, tempfile.TemporaryFile("w+", encoding="utf-8") as err:
        sys.argv = ["hcsearch", *words]
        signal.setitimer(signal.ITIMER_REAL, SLOWEST)
        try:
            with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                main()
        except SystemExit as end:
            code = end.code or 0
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, on_alarm)
            signal.signal(signal.SIGINT, on_interrupt)
            sys.argv = argv
        return code, _read(out), _read(err)


def _read(file):
    file.flush()
    file.seek(0)
    return file.read()


class LateError(Exception):
    """A command takes too long. No kind of OSError, which commands explain."""


def _late(_number, _frame):
    raise LateError(f"not done after {SLOWEST} s")


def contents(folder: Path) -> dict[str, bytes | None]:
    """Names in a folder and below, with what its files hold."""
    return {str(path): path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


def check_command(folder: Path, words) -> int:
    """Run a command and judge it: no traceback, a code that is documented, one line for a refusal, nothing left."""
    before = contents(folder)
    try:
        code, out, err = run(folder, words)
    except Exception as error:
        error.add_note(f"hcsearch {words!r}")
        raise
    assert code in ENDS, (words, code, err)
    if code == 2:
        assert out == "", (words, out[:200])
        *warned, line = err.splitlines()
        assert len(warned) <= 1, (words, err[:1000])
        assert all(text.startswith("hcsearch: warning: ") and is_message(text) for text in warned), (words, err[:1000])
        assert line.startswith("hcsearch: "), (words, err[:300])
        assert is_message(line), (words, err[:300])
        assert contents(folder) == before, (words, sorted(set(contents(folder)) ^ set(before)))
    else:
        assert err.count("\n") <= 5, (words, err[:1000])
    return code
