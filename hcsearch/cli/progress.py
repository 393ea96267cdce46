"""Progress bars on a terminal, with rate and remaining time; silent in a pipe."""

from __future__ import annotations

import sys
import threading
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from tqdm import tqdm

_LOCK = threading.RLock()
_SOON, _LOOK = 2.0, 1.0  # s before the first line on compiled kernels, and between two


class _CompilingNote:
    """Periodic lines on a terminal that name the kernel being compiled."""

    def __init__(self) -> None:
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        if self._thread is None:
            self._over.clear()
            self._thread = threading.Thread(target=self._show, daemon=True)
            self._thread.start()

    def end(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _show(self) -> None:
        wait, has_shown = _SOON, False
        while not self._over.wait(wait):
            wait = _LOOK
            kernels = sys.modules.get("hcsearch.kernels.compiling.under_way")  # before its import nothing is compiled
            compiled = kernels.compilation_under_way() if kernels is not None else None
            if compiled is not None:
                line = f"compiling kernels, {compiled.done} of {compiled.total}: {compiled.name}"
                click.echo(f"\r{line:<79}", err=True, nl=False)
                has_shown = True
        if has_shown:
            click.echo(f"\r{'':79}\r", err=True, nl=False)


class ProgressMeter:
    """A progress bar on stderr while the block runs; called with done and total counts, and a note."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self._bar: tqdm[Any] | None = None
        self._counted = (0, unit)
        self._compiling = _CompilingNote()

    def __enter__(self) -> ProgressMeter:
        self._begin()
        return self

    def __call__(self, done: int, total: int, note: str, unit: str | None = None) -> None:
        """Show the state; a new total or unit starts a new bar."""
        from tqdm import tqdm

        # only this process writes; the multiprocessing lock of tqdm would be reported as leaked after Ctrl-C
        tqdm.set_lock(_LOCK)
        if done:
            self._compiling.end()
        else:  # kernels are compiled before the first item is done
            self._begin()
        if sys.stderr is None:
            return
        counted = (total, unit or self._unit)
        if self._bar is None or self._counted != counted:
            self._close()
            self._counted = counted
            # `disable=None` makes tqdm silent without a terminal
            self._bar = tqdm(
                total=total, initial=max(0, done - 1), unit=counted[1], disable=None, leave=False, file=sys.stderr
            )
        # the count has not changed, so `update` would not show the new note
        self._bar.set_postfix_str(note, refresh=done == self._bar.n)
        self._bar.update(done - self._bar.n)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._compiling.end()
        self._close()

    def _begin(self) -> None:
        if sys.stderr is not None and sys.stderr.isatty():
            self._compiling.start()

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
