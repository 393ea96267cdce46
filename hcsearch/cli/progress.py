"""Progress of long work: a bar with rate and remaining time on a terminal, a line every ten seconds elsewhere.

A command without counts, and what a command does before and after it counts, has lines everywhere.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

from hcsearch.search.pipeline.run_progress import SHARE
from hcsearch.system.terminal import duration_text
from hcsearch.system.work_steps import words_of_work

if TYPE_CHECKING:
    from tqdm import tqdm

_LOCK = threading.RLock()
_FIRST_NOTE_SECONDS, _NOTE_SECONDS = 2.0, 1.0
"""Time before the first line on compiled kernels, and between two, on a terminal, s."""
_LINE_SECONDS = 10.0
"""Time between two lines, s."""
_SHARE_FORMAT = "{percentage:3.0f}%|{bar}| [{elapsed}<{remaining}{postfix}]"
_COUNT_FORMAT = "{n_fmt}/{total_fmt} {unit} [{elapsed}, {rate_fmt}{postfix}]"
"""Bars of a share of the whole work, and of counts that are not of the whole work."""


class _Repeated:
    """A function that a thread calls again and again while work is under way; intervals in seconds."""

    def __init__(self, show: Callable[[], None], first: float, interval: float) -> None:
        self._show, self._first, self._interval = show, first, interval
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        if self._thread is None:
            self._over.clear()
            self._thread = threading.Thread(target=self._run, daemon=True)
            self._thread.start()

    def end(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _run(self) -> None:
        wait = self._first
        while not self._over.wait(wait):
            wait = self._interval
            self._show()


def _compilation_note() -> str:
    """Return words on the compilation of kernels that is under way; empty if there is none."""
    kernels = sys.modules.get("hcsearch.kernels.compiling.under_way")  # before its import nothing is compiled
    compiled = kernels.compilation_under_way() if kernels is not None else None
    if compiled is None:
        return ""
    done = compiled.before + compiled.done
    return f"compiling kernels, {done} done" if done else "compiling kernels"


def _terminal_size() -> tuple[int, int]:
    """Return columns and rows of the terminal; usual ones where it states 0, as those of `script` and of containers."""
    try:
        columns, rows = os.get_terminal_size(sys.stderr.fileno())
    except (OSError, ValueError):  # a stream that only says that it is a terminal
        columns, rows = 0, 0
    return columns or 79, rows or 24


class _Bar:
    """A bar on a terminal; before the first item is done, lines on what is compiled."""

    def __init__(self, *, parts: bool) -> None:
        self._bar: tqdm[Any] | None = None
        self._counted: tuple[int, str] | None = None
        self._parts = parts
        self._compiling = _Repeated(self._show_note, _FIRST_NOTE_SECONDS, _NOTE_SECONDS)
        self._noted = False
        self._compiling.start()

    def show(self, done: int, total: int, unit: str, note: str) -> None:
        from tqdm import tqdm

        # only this process writes; the multiprocessing lock of tqdm would be reported as leaked after Ctrl-C
        tqdm.set_lock(_LOCK)
        if done:
            self._end_notes()
        else:  # kernels are compiled before the first item is done
            self._compiling.start()
        if self._bar is None or self._counted != (total, unit):
            if self._bar is not None:
                self._bar.close()
            self._counted = (total, unit)
            form = _SHARE_FORMAT if unit == SHARE else _COUNT_FORMAT if self._parts else None
            first = max(0, done - 1)
            looks: dict[str, Any] = {"unit": unit, "leave": False, "file": sys.stderr, "bar_format": form}
            columns, rows = _terminal_size()
            self._bar = tqdm(total=total, initial=first, ncols=columns, nrows=rows, **looks)
        # the count has not changed, so `update` would not show the new note
        self._bar.set_postfix_str(note, refresh=done == self._bar.n)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._end_notes()
        if self._bar is not None:
            self._bar.close()

    def _show_note(self) -> None:
        note = _compilation_note()
        if note:
            click.echo(f"\r{note[:79]:<79}", err=True, nl=False)
            self._noted = True

    def _end_notes(self) -> None:
        self._compiling.end()
        if self._noted:
            click.echo(f"\r{'':79}\r", err=True, nl=False)
            self._noted = False


class _Lines:
    """A line every ten seconds on the innermost meter, which a log of a batch job or of a container keeps."""

    def __init__(self) -> None:
        self.meters: list[ProgressMeter] = []
        self._begun = 0.0
        self._repeated: _Repeated | None = None

    def start(self) -> None:
        if self._repeated is None:
            if len(self.meters) == 1:
                self._begun = time.monotonic()
            self._repeated = _Repeated(self._show_line, _LINE_SECONDS, _LINE_SECONDS)
            self._repeated.start()

    def end(self) -> None:
        if self._repeated is not None:
            self._repeated.end()
            self._repeated = None

    def _show_line(self) -> None:
        state = self.meters[-1].state()
        if state:
            with suppress(OSError, ValueError):  # stderr is closed
                click.echo(f"hcsearch: {time.monotonic() - self._begun:.0f} s, {state}", err=True)


_LINES = _Lines()


class ProgressMeter:
    """Progress on stderr while the block runs; called with done and total counts, and a note.

    unit : of the counts. doing : words that are shown without counts, for a meter that is never called. parts : whether
    counts are of parts of the work, one after the other, and only the unit `SHARE` of the whole.
    """

    def __init__(self, unit: str = "", *, doing: str = "", parts: bool = False) -> None:
        self._unit, self._doing, self._parts = unit, doing, parts
        self._bar: _Bar | None = None
        self._counts: tuple[int, int, str, str] | None = None
        self._first: tuple[float, int] = (0.0, 0)

    def __enter__(self) -> ProgressMeter:
        if sys.stderr is not None:
            _LINES.meters.append(self)
            if self._unit and sys.stderr.isatty():
                _LINES.end()
                self._bar = _Bar(parts=self._parts)
            else:
                _LINES.start()
        return self

    def __call__(self, done: int, total: int, note: str, unit: str | None = None) -> None:
        """Show the state; a new total or unit starts a new bar. A share never falls."""
        shown = unit or self._unit
        last = self._counts
        if last is None or last[1:3] != (total, shown):
            self._first = (time.monotonic(), done)
        elif shown == SHARE:
            done = max(done, last[0])
        self._counts = (done, total, shown, note)
        if self._bar is not None:
            self._bar.show(done, total, shown, note)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self not in _LINES.meters:
            return
        if self._bar is not None:
            self._bar.close()
        if len(_LINES.meters) == 1:
            _LINES.end()
        _LINES.meters.remove(self)
        if _LINES.meters:
            _LINES.start()

    def state(self) -> str:
        """Describe what is done and how far it is, and the compilation or the step under way."""
        shown = self._counts_text() or next((meter._doing for meter in _LINES.meters if meter._doing), "")
        step = _compilation_note() or words_of_work()
        return ", ".join(filter(None, (shown, "" if step in shown else step, self._time_left())))

    def _counts_text(self) -> str:
        if self._counts is None:
            return ""
        done, total, unit, note = self._counts
        amount = f"{100 * done // max(1, total)} %" if unit == SHARE else f"{unit} {done:,} of {total:,}"
        return ", ".join(filter(None, (amount, note)))

    def _time_left(self) -> str:
        begun, first = self._first
        done, total, unit, _ = self._counts or (0, 0, "", "")
        if not first < done < total or (self._parts and unit != SHARE):
            return ""
        return f"about {duration_text((time.monotonic() - begun) * (total - done) / (done - first))} left"
