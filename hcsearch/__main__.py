"""The start of the command line, `hcsearch` or `python -m hcsearch`.

Ctrl-C is answered before anything is loaded, and a fault of the program ends in one line, too.
"""

from __future__ import annotations

import os
import sys

FAULT_CODE = 3
"""Exit code of a fault of the program: 1 is a verdict, and 2 a refusal."""


def main() -> None:
    """Run the command line, see `cli.main`."""
    try:
        import signal  # noqa: PLC0415 - within the block, as an interrupt may come in each of these lines

        from hcsearch.system.interrupts import leave  # noqa: PLC0415 - as above

        signal.signal(signal.SIGINT, leave)
    except KeyboardInterrupt:
        sys.exit(128 + 2)
    try:
        from hcsearch.cli import main as run  # noqa: PLC0415 - loads much

        run()
    except Exception as error:
        if os.environ.get("HCSEARCH_TRACEBACK"):
            raise
        _print_fault(error)
        sys.exit(FAULT_CODE)


def _print_fault(error: Exception) -> None:
    from hcsearch.errors import one_line  # noqa: PLC0415 - nothing else needs it here

    where = error.__traceback__
    while where is not None and where.tb_next is not None:
        where = where.tb_next
    line = "" if where is None else f" at {where.tb_frame.f_globals.get('__name__')}:{where.tb_lineno}"
    message = (
        f"hcsearch: a fault of the program, {type(error).__name__}{line}: {error}; please report it with the command, "
        "which prints a traceback with HCSEARCH_TRACEBACK=1"
    )
    try:
        print(one_line(message), file=sys.stderr)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


if __name__ == "__main__":
    main()
