"""Progress of long work: a bar with rate and remaining time on a terminal, a line every ten seconds elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from tqdm import tqdm

_LOCK = threading.RLock()
_FIRST_NOTE_SECONDS, _NOTE_SECONDS = 2.0, 1.0
"""Time before the first line on compiled kernels, and between two, on a terminal, s."""
_LINE_SECONDS = 10.0
"""Time between two lines where there is no terminal, s."""


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


def _compilation_note() -> str | None:
    """Return a line on the kernel that is being compiled; None if there is none."""
    kernels = sys.modules.get("hcsearch.kernels.compiling.under_way")  # before its import nothing is compiled
    compiled = kernels.compilation_under_way() if kernels is not None else None
    return None if compiled is None else f"compiling kernels, {compiled.done} of {compiled.total}: {compiled.name}"


class _Bar:
    """A bar on a terminal; before the first item is done, lines that name the kernel being compiled."""

    def __init__(self) -> None:
        self._bar: tqdm[Any] | None = None
        self._counted: tuple[int, str] | None = None
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
            self._bar = tqdm(total=total, initial=max(0, done - 1), unit=unit, leave=False, file=sys.stderr)
        # the count has not changed, so `update` would not show the new note
        self._bar.set_postfix_str(note, refresh=done == self._bar.n)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._end_notes()
        if self._bar is not None:
            self._bar.close()

    def _show_note(self) -> None:
        note = _compilation_note()
        if note is not None:
            click.echo(f"\r{note[:79]:<79}", err=True, nl=False)
            self._noted = True

    def _end_notes(self) -> None:
        self._compiling.end()
        if self._noted:
            click.echo(f"\r{'':79}\r", err=True, nl=False)
            self._noted = False


class _Lines:
    """A line every ten seconds, which a log of a batch job or of a container keeps; short work writes none."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._state = ""
        self._repeated = _Repeated(self._show_line, _LINE_SECONDS, _LINE_SECONDS)
        self._repeated.start()

    def show(self, done: int, total: int, unit: str, note: str) -> None:
        self._state = ", ".join(part for part in (f"{unit} {done:,} of {total:,}", note) if part)

    def close(self) -> None:
        self._repeated.end()

    def _show_line(self) -> None:
        state = _compilation_note() or self._state
        if state:
            click.echo(f"hcsearch: {time.monotonic() - self._begun:.0f} s, {state}", err=True)


class ProgressMeter:
    """Progress on stderr while the block runs; called with done and total counts, and a note."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self._shown: _Bar | _Lines | None = None

    def __enter__(self) -> ProgressMeter:
        if sys.stderr is not None:
            self._shown = _Bar() if sys.stderr.isatty() else _Lines()
        return self

    def __call__(self, done: int, total: int, note: str, unit: str | None = None) -> None:
        """Show the state; a new total or unit starts a new bar."""
        if self._shown is not None:
            self._shown.show(done, total, unit or self._unit, note)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._shown is not None:
            self._shown.close()
