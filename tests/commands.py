"""Command lines in this process, as most starts of an interpreter take longer than what the command then does."""

import re
import signal
import subprocess
import sys

from hcsearch.cli import main


def run_here(words, capfd):
    """Run a command line as a shell does: its exit code, standard output and standard error."""
    capfd.readouterr()
    on_interrupt, arguments, code = signal.getsignal(signal.SIGINT), sys.argv, 0
    sys.argv = ["hcsearch", *words]
    try:
        main()
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.argv = arguments
        signal.signal(signal.SIGINT, on_interrupt)
    return subprocess.CompletedProcess(words, code, *capfd.readouterr())


def without_progress(errors):
    """Standard error without the lines that long work writes every ten seconds where there is no terminal."""
    return re.sub(r"^hcsearch: \d+ s, .*\n", "", errors, flags=re.MULTILINE)
