"""The command line: commands read options, call the library and print. Heavy imports wait until a command runs."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version

import click

from hcsearch.cli.bench import bench
from hcsearch.cli.count import count
from hcsearch.cli.enumerate import enumerate_
from hcsearch.cli.query import query
from hcsearch.cli.report import report
from hcsearch.cli.show import show
from hcsearch.errors import HcsearchError


@click.group(
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Example: hcsearch enumerate --grid hex --n 12, then hcsearch query 'untwisted' -s -symmetry --limit 10",
)
@click.version_option(version("hcsearch"), prog_name="hcsearch")
def hcsearch() -> None:
    """Search for Hamiltonian-circuit designs of thick-panel arrays that fold into two stacks."""


for command in (enumerate_, count, query, show, report, bench):
    hcsearch.add_command(command)


def main() -> None:
    """Run the command line; wrong input is one line on stderr and exit code 2."""
    try:
        hcsearch.main(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except HcsearchError as error:
        _fail(str(error))
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        sys.exit(2)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        remedy = f" (see {context.command_path} --help)" if context else ""
        _fail(error.format_message() + remedy)
    except (click.Abort, KeyboardInterrupt):
        message = "hcsearch: interrupted; an enumeration into a database goes on from there when it is run again"
        click.echo(message, err=True)
        sys.exit(130)
    except BrokenPipeError:
        _discard_output()
        sys.exit(141)
    except OSError as error:
        _discard_output()
        _fail(f"cannot write or read: {error.strerror or error}; make room or choose another place")


def _discard_output() -> None:
    """Keep the interpreter from failing once more when it flushes at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str) -> None:
    click.echo("hcsearch: " + " ".join(message.split()), err=True)
    sys.exit(2)
