"""Progress on a terminal, with rate and remaining time; silent in a pipe."""

from __future__ import annotations

import sys
import threading
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from tqdm import tqdm

_FIRST = "on a new machine the kernels are compiled first, up to a minute ..."


class Meter:
    """A bar on stderr while the block runs; call it with what is done, how much there is, and a note."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self._bar: tqdm[Any] | None = None
        self._counted = (0, unit)
        self._hint = threading.Timer(2.0, click.echo, (_FIRST,), {"err": True})

    def __enter__(self) -> Meter:
        if sys.stderr is not None and sys.stderr.isatty():
            self._hint.start()
        return self

    def __call__(self, done: int, total: int, note: str, unit: str | None = None) -> None:
        """Show the state; another total or unit than before begins a new bar."""
        from tqdm import tqdm  # noqa: PLC0415

        self._hint.cancel()
        if sys.stderr is None:
            return
        counted = (total, unit or self._unit)
        if self._bar is None or self._counted != counted:
            self._close()
            self._counted = counted
            # `disable=None` is tqdm's word for silence where there is no terminal
            self._bar = tqdm(
                total=total, initial=max(0, done - 1), unit=counted[1], disable=None, leave=False, file=sys.stderr
            )
        self._bar.set_postfix_str(note, refresh=False)
        self._bar.update(done - self._bar.n)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._hint.cancel()
        self._close()

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
