"""Ctrl-C before and after the work of a command. Nothing heavy is imported here: it must be in place at once."""

from __future__ import annotations

import os

INTERRUPT_MESSAGE = "hcsearch: interrupted; work that is kept in a database goes on from there when it is run again"
INTERRUPT_EXIT_CODE = 128 + 2  # SIGINT, as shells say it


def exit_interrupted(*_signal: object, said: str = INTERRUPT_MESSAGE) -> None:
    """End without the interpreter's own end, in which objects that the interrupt left half made would complain."""
    try:  # noqa: SIM105 - contextlib takes longer to load
        os.write(2, f"{said}\n".encode())
    except OSError:
        pass  # nobody is there to read it
    os._exit(INTERRUPT_EXIT_CODE)
