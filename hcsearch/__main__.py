"""The start of the command line, `hcsearch` or `python -m hcsearch`.

Ctrl-C is handled before other modules are loaded, and a fault of the program is reported in one line.
"""

from __future__ import annotations

try:  # each of these lines may be interrupted, none between this module and `main`
    import os
    import signal
    import sys

    from hcsearch.system.interrupts import exit_interrupted

    signal.signal(signal.SIGINT, exit_interrupted)
except KeyboardInterrupt:
    raise SystemExit(128 + 2) from None  # `sys` may not be imported yet

FAULT_CODE = 3
"""Exit code for a fault of the program; 1 is a verdict, 2 wrong input."""


def main() -> None:
    """Run the command line; see `cli.main`."""
    try:
        from hcsearch.cli import main as run  # noqa: PLC0415 - slow to import

        run()
    except Exception as error:
        if _comes_of_interrupt(error):
            exit_interrupted()
        _print_fault(error)
        sys.exit(FAULT_CODE)


def _comes_of_interrupt(error: BaseException | None) -> bool:
    """Return whether Ctrl-C caused an exception; Python and libraries wrap exceptions raised in callbacks."""
    visited: set[int] = set()
    while error is not None and id(error) not in visited:
        if isinstance(error, KeyboardInterrupt):
            return True
        visited.add(id(error))
        error = error.__cause__ or error.__context__
    return False


def _print_fault(error: Exception) -> None:
    """Print a fault as one line, with its traceback if HCSEARCH_TRACEBACK is set; ignore a closed stderr."""
    import traceback  # noqa: PLC0415 - only needed here

    from hcsearch.basics.errors import one_line  # noqa: PLC0415
    from hcsearch.system.answering import raising_place_of  # noqa: PLC0415

    lines = "".join(traceback.format_exception(error)) if os.environ.get("HCSEARCH_TRACEBACK") else ""
    missing = error.name if isinstance(error, ImportError) else None
    if missing is not None and missing.partition(".")[0] != "hcsearch":
        message = f"hcsearch: {missing} cannot be loaded: {error}; install hcsearch anew, with what it depends on"
    else:
        message = (
            f"hcsearch: a fault of the program, {type(error).__name__} at {raising_place_of(error)}: {error}; "
            "please report it "
            "with the command, which prints a traceback with HCSEARCH_TRACEBACK=1"
        )
    try:
        print(lines + one_line(message), file=sys.stderr)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


if __name__ == "__main__":
    main()
