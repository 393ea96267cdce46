"""Handling of Ctrl-C before and after the work of a command; imports nothing heavy, so that it is installed at once."""

from __future__ import annotations

import os

INTERRUPT_MESSAGE = "hcsearch: interrupted; the same command continues work that is stored in a database"
INTERRUPT_EXIT_CODE = 128 + 2  # SIGINT, as shells say it


def exit_interrupted(*_signal: object, message: str = INTERRUPT_MESSAGE) -> None:
    """Exit at once with a message, without finalising the interpreter: half-built objects would report errors."""
    try:  # noqa: SIM105 - contextlib takes longer to load
        os.write(2, f"{message}\n".encode())
    except OSError:
        pass  # stderr is closed
    os._exit(INTERRUPT_EXIT_CODE)
