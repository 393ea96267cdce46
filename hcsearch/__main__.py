"""The start of the command line, `hcsearch` or `python -m hcsearch`: Ctrl-C is answered before anything is loaded."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line, see `cli.main`."""
    try:
        import signal  # noqa: PLC0415 - within the block, as an interrupt may come in each of these lines

        from hcsearch.system.interrupts import leave  # noqa: PLC0415 - as above

        signal.signal(signal.SIGINT, leave)
    except KeyboardInterrupt:
        sys.exit(128 + 2)
    from hcsearch.cli import main as run  # noqa: PLC0415 - loads much

    run()


if __name__ == "__main__":
    main()
