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

from hcsearch.basics.vocabulary import counted
from hcsearch.system.terminal import duration_text
from hcsearch.system.work_steps import words_of_work

if TYPE_CHECKING:
    from tqdm import tqdm

_LOCK = threading.RLock()
SHARE = "share"
"""Unit of a meter that shows the share of the whole work: its amounts mean nothing to a user."""
_FIRST_NOTE_SECONDS, _NOTE_SECONDS = 2.0, 1.0
"""Time before the first words on compiled kernels, and between two, on a terminal, s."""
_LINE_SECONDS = 10.0
"""Time between two lines, s."""
_SHARE_FORMAT = "{percentage:3.0f}%|{bar}| [{elapsed}<{remaining}{postfix}]"
"""Bar of a share of the whole work."""


class _Repeated:
    """A function that a thread calls again and again while work is under way; intervals in seconds."""

    def __init__(self, show: Callable[[], None], first: float, interval: float) -> None:
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(show, first, interval), daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._over.set()
        self._thread.join()

    def _run(self, show: Callable[[], None], wait: float, interval: float) -> None:
        while not self._over.wait(wait):
            wait = interval
            show()


def _under_way() -> Any:
    """Return the module that knows what is compiled; None before its import, when nothing is."""
    return sys.modules.get("hcsearch.kernels.compiling.under_way")


def _compilation_note() -> str:
    """Return words on the compilation of kernels that is under way; empty if there is none."""
    kernels = _under_way()
    compiled = kernels.compilation_under_way() if kernels is not None else None
    if compiled is None:
        return ""
    done = compiled.before + compiled.done
    return f"compiling kernels, {done} done" if done else "compiling kernels"


def _compiled_before() -> tuple[int, float]:
    """Return how many kernels this process has waited for, and how long, s."""
    kernels = _under_way()
    return (0, 0.0) if kernels is None else kernels.compiled_before()


def _terminal_size() -> tuple[int, int]:
    """Return columns and rows of the terminal; usual ones where it states 0, as in `script` and in containers."""
    try:
        columns, rows = os.get_terminal_size(sys.stderr.fileno())
    except (OSError, ValueError):  # a stream that only says that it is a terminal
        columns, rows = 0, 0
    return columns or 79, rows or 24


class _Bar:
    """A bar on a terminal, beside it words on what is compiled; before the first call these alone."""

    def __init__(self, unit: str) -> None:
        self._unit, self._noted = unit, False
        self._bar: tqdm[Any] | None = None
        self._compiling = _Repeated(self._show_note, _FIRST_NOTE_SECONDS, _NOTE_SECONDS)

    def show(self, done: int, total: int, note: str) -> None:
        from tqdm import tqdm

        # only this process writes; the multiprocessing lock of tqdm would be reported as leaked after Ctrl-C
        tqdm.set_lock(_LOCK)
        with _LOCK:
            if self._bar is None or self._bar.total != total:
                self._clear()
                form = _SHARE_FORMAT if self._unit == SHARE else None
                looks: dict[str, Any] = {"unit": self._unit, "leave": False, "file": sys.stderr, "bar_format": form}
                columns, rows = _terminal_size()
                self._bar = tqdm(total=total, initial=max(0, done - 1), ncols=columns, nrows=rows, **looks)
            # the count has not changed, so `update` would not show the new note
            self._bar.set_postfix_str(note, refresh=done == self._bar.n)
            self._bar.update(done - self._bar.n)

    def write(self, text: str, *, err: bool) -> None:
        """Write a line above the bar."""
        with _LOCK:
            if self._bar is not None:
                self._bar.clear()
            self._clear_note()
            click.echo(text, err=err)
            if self._bar is not None:
                self._bar.refresh()

    def close(self) -> None:
        self._compiling.end()
        self._clear()

    def _show_note(self) -> None:
        note = _compilation_note()
        with _LOCK:
            if note and self._bar is not None:
                self._bar.set_postfix_str(note)
            elif note:
                click.echo(f"\r{note[:79]:<79}", err=True, nl=False)
                self._noted = True

    def _clear(self) -> None:
        self._clear_note()
        if self._bar is not None:
            self._bar.close()

    def _clear_note(self) -> None:
        if self._noted:
            click.echo(f"\r{'':79}\r", err=True, nl=False)
            self._noted = False


class _Lines:
    """A line every ten seconds on the innermost meter, which a log of a batch job or of a container keeps."""

    def __init__(self) -> None:
        self.meters: list[ProgressMeter] = []
        self._begun = 0.0
        self._compiled = 0, 0.0
        self._repeated: _Repeated | None = None

    def start(self) -> None:
        if self._repeated is None:
            if len(self.meters) == 1:
                self._begun, self._compiled = time.monotonic(), _compiled_before()
            self._repeated = _Repeated(self._show_line, _LINE_SECONDS, _LINE_SECONDS)

    def end(self) -> None:
        if self._repeated is not None:
            self._repeated.end()
            self._repeated = None

    def _show_line(self) -> None:
        state = self.meters[-1].state()
        if state:
            self._write(state)

    def tell_compilation(self) -> None:
        """Write how long kernels were compiled, if that took longer than until the first line."""
        count, seconds = (now - then for now, then in zip(_compiled_before(), self._compiled, strict=True))
        if seconds > _LINE_SECONDS:
            self._write(
                f"{counted(int(count), 'kernel')} compiled in {seconds:.0f} s; later runs read them from the cache"
            )

    def _write(self, words: str) -> None:
        with suppress(OSError, ValueError):  # stderr is closed
            click.echo(f"hcsearch: {time.monotonic() - self._begun:.0f} s, {words}", err=True)


_LINES = _Lines()


class ProgressMeter:
    """Progress on stderr while the block runs; called with done and total counts, and a note.

    unit : of the counts. doing : words that are shown without counts, for a meter that is never called.
    """

    def __init__(self, unit: str = "", *, doing: str = "") -> None:
        self._unit, self._doing = unit, doing
        self._bar: _Bar | None = None
        self._counts: tuple[int, int, str] | None = None
        self._first: tuple[float, int] = (0.0, 0)

    def __enter__(self) -> ProgressMeter:
        if sys.stderr is not None:
            _LINES.meters.append(self)
            if self._unit and sys.stderr.isatty():
                _LINES.end()
                self._bar = _Bar(self._unit)
            else:
                _LINES.start()
        return self

    def __call__(self, done: int, total: int, note: str) -> None:
        """Show the state; a new total starts a new bar. A share never falls."""
        last = self._counts
        if last is None or last[1] != total:
            self._first = (time.monotonic(), done)
        elif self._unit == SHARE:
            done = max(done, last[0])
        self._counts = (done, total, note)
        if self._bar is not None:
            self._bar.show(done, total, note)

    def write(self, text: str, *, err: bool = False) -> None:
        """Write a line while the meter is shown."""
        if self._bar is not None:
            self._bar.write(text, err=err)
        else:
            click.echo(text, err=err)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self not in _LINES.meters:
            return
        if self._bar is not None:
            self._bar.close()
        if len(_LINES.meters) == 1:
            _LINES.end()
            _LINES.tell_compilation()
        _LINES.meters.remove(self)
        if _LINES.meters:
            _LINES.start()

    def state(self) -> str:
        """Describe what is done and how far it is; while kernels are compiled, say so instead of naming their use."""
        amount, note = self._counts_texts()
        shown = ", ".join(filter(None, (amount, note)))
        shown = shown or next((meter._doing for meter in _LINES.meters if meter._doing), "")
        if compiling := _compilation_note():
            return ", ".join(filter(None, (amount or shown, compiling)))
        step = words_of_work()
        return ", ".join(filter(None, (shown, "" if step in shown else step, self._time_left())))

    def _counts_texts(self) -> tuple[str, str]:
        if self._counts is None:
            return "", ""
        done, total, note = self._counts
        amount = f"{100 * done // max(1, total)} %" if self._unit == SHARE else f"{self._unit} {done:,} of {total:,}"
        return amount, note

    def _time_left(self) -> str:
        begun, first = self._first
        done, total, _ = self._counts or (0, 0, "")
        if not first < done < total:
            return ""
        return f"about {duration_text((time.monotonic() - begun) * (total - done) / (done - first))} left"
