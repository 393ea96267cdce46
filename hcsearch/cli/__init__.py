"""The command line: commands parse options, call the library and print; heavy imports wait until a command runs."""

from __future__ import annotations

import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import entry_points, version
from itertools import chain
from typing import Any, TextIO

import click

from hcsearch.basics.errors import HcsearchError, HcsearchWarning, one_line
from hcsearch.cli.accuracy import accuracy
from hcsearch.cli.assembly import assembly
from hcsearch.cli.atlas import atlas
from hcsearch.cli.check import check
from hcsearch.cli.compile import compile_
from hcsearch.cli.count import count
from hcsearch.cli.deploy import deploy
from hcsearch.cli.drive import drive
from hcsearch.cli.enumerate import enumerate_
from hcsearch.cli.export import export
from hcsearch.cli.follow import motion_
from hcsearch.cli.identify import identify
from hcsearch.cli.init import init
from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter
from hcsearch.cli.prove import prove, verify
from hcsearch.cli.query import query
from hcsearch.cli.rank import rank
from hcsearch.cli.report import report
from hcsearch.cli.serve import serve
from hcsearch.cli.sheet import sheet
from hcsearch.cli.show import show
from hcsearch.cli.tune import tune
from hcsearch.cli.units import units
from hcsearch.system.interrupts import exit_interrupted

_ADDED = "hcsearch.commands"
_WAITING = ("serve",)
"""Commands that wait for others most of their time."""
_PIPE_CODE = 128 + 13  # exit code of SIGPIPE in shells

GROUPS: dict[str, tuple[tuple[click.Command, ...], tuple[click.Command, ...]]] = {
    "search": ((init, enumerate_, count), (units,)),
    "look": ((query, rank, show, report, serve), (assembly,)),
    "one design": ((check, deploy, tune, drive, sheet), (motion_, accuracy)),
    "prove": ((prove, verify), ()),
    "export": ((export,), ()),
    "data": ((), (atlas, identify)),
    "machine": ((), (compile_,)),
}
"""The commands by their purpose: first the ones that `hcsearch --help` describes, then further ones, which it names."""


class _UnreadError(Exception):
    """The reader of the output has closed it."""


class _Commands(click.Group):
    """The group of all commands: built-in ones, and entry points `hcsearch.commands` of installed packages.

    Unlike click itself, it reports a broken pipe separately from failures.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted({*super().list_commands(ctx), *entry_points(group=_ADDED).names})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by name; commands of entry points are imported on demand."""
        command = super().get_command(ctx, cmd_name)
        if command is None:
            for added in entry_points(group=_ADDED, name=cmd_name):
                command = added.load()
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands in groups; further ones by name only."""
        width = max(map(len, GROUPS))  # no name on this screen is longer
        room = formatter.width - width - 6  # as click has it
        sections = {
            group: [(str(command.name), command.get_short_help_str(room)) for command in first]
            for group, (first, _) in GROUPS.items()
        }
        named = {group: [str(command.name) for command in further] for group, (_, further) in GROUPS.items()}
        named["machine"] += [name for name in self.list_commands(ctx) if name not in self.commands]
        sections["further commands"] = [(group, ", ".join(names)) for group, names in named.items() if names]
        for title, rows in sections.items():
            if rows:
                with formatter.section(title.capitalize()):
                    formatter.write_dl([(name.ljust(width), text) for name, text in rows])

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; raise _UnreadError for a broken pipe."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError as error:
            raise _UnreadError from error


@click.group(
    cls=_Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples_epilog(
        "hcsearch enumerate --grid hex --n 12", "hcsearch query untwisted -s -symmetry --limit 10", "hcsearch show 1174"
    ),
)
@click.version_option(version("hcsearch"), prog_name="hcsearch")
@click.pass_context
def hcsearch(context: click.Context) -> None:
    """Search for flat arrays of thick panels that fold into two stacks.

    `hcsearch COMMAND --help` describes a command. A design is named by its id in the database or by the notation of its
    circuit, as 17 or hex:0234550132; a folding by the lower of its two flat creases, as 17:4 or hex:0234550132:4.
    """
    if context.invoked_subcommand is not None and context.invoked_subcommand not in _WAITING:
        context.with_resource(ProgressMeter(doing=context.invoked_subcommand))


for command in chain.from_iterable(chain(*GROUPS.values())):
    hcsearch.add_command(command)


def main() -> None:
    """Run the command line; wrong input is one line on stderr and exit code 2."""
    # read by NumPy on import; matrices are small here, and more threads would wait for each other
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    # read by numba on import, for the compiler part that all kernels of a process share: a tenth faster
    os.environ.setdefault("NUMBA_OPT", "1")
    if sys.stdout is not None and sys.stdout.errors == "strict":  # names may hold letters that its encoding lacks
        sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    unraisable, sys.unraisablehook = sys.unraisablehook, _interrupting_again(sys.unraisablehook)
    try:
        signal.signal(signal.SIGINT, _interrupt)
        with _warning_in_lines():
            code = hcsearch.main(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        if isinstance(code, int) and code:  # a result that is neither failure nor success
            sys.exit(code)
    except HcsearchError as error:
        _fail(str(error))
    except click.exceptions.NoArgsIsHelpError as error:
        _print_error(error.format_message())
        sys.exit(2)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        remedy = f" (see {context.command_path} --help)" if context else ""
        _fail(error.format_message() + remedy)
    except (click.Abort, KeyboardInterrupt):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        exit_interrupted()
    except MemoryError:
        _fail(f"there is not enough memory: ask for less{_smaller()}, or free some")
    except (_UnreadError, BrokenPipeError):
        _discard(sys.stdout)
        sys.exit(_PIPE_CODE)
    except OSError as error:
        _discard(sys.stdout)
        _fail(f"cannot write or read: {error.strerror or error}; make room or choose another place")
    finally:
        signal.signal(signal.SIGINT, exit_interrupted)
        sys.unraisablehook = unraisable


@contextmanager
def _warning_in_lines() -> Iterator[None]:
    """Print warnings of this program as plain lines; warnings of libraries stay unchanged."""
    with warnings.catch_warnings():
        show_default = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *rest: Any, **options: Any) -> None:
            if issubclass(category, HcsearchWarning):
                _print_error(f"hcsearch: warning: {one_line(str(message))}")
            else:
                show_default(message, category, *rest, **options)

        warnings.showwarning = show
        warnings.simplefilter("default", HcsearchWarning)
        yield


def _smaller() -> str:
    """Return a hint at the options that reduce the work of the running command."""
    command = next((hcsearch.commands[word] for word in sys.argv[1:] if word in hcsearch.commands), None)
    options = {option for applicable in command.params for option in applicable.opts} if command is not None else set()
    remedies = {"--n": "a smaller --n", "--jobs": "fewer --jobs", "--limit": "a --limit"}
    applicable = [remedy for option, remedy in remedies.items() if option in options]
    return f", as by {' or '.join(applicable)}" if applicable else ", as a pattern of fewer panels"


def _interrupt(_number: int, _frame: object) -> None:
    """Shut down cleanly at the first Ctrl-C and at once at the next; the database is safe either way."""
    signal.signal(signal.SIGINT, exit_interrupted)
    raise KeyboardInterrupt


def _interrupting_again(hook: Callable[[sys.UnraisableHookArgs], object]) -> Callable[[sys.UnraisableHookArgs], None]:
    """Return a hook for exceptions that Python prints and ignores, as in finalisers: a Ctrl-C comes again after it."""

    def report(ignored: sys.UnraisableHookArgs) -> None:
        if not isinstance(ignored.exc_value, KeyboardInterrupt):
            hook(ignored)
        elif hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, _interrupt)
            signal.setitimer(signal.ITIMER_REAL, 0.001)
        else:
            exit_interrupted()

    return report


def _discard(stream: TextIO | None) -> None:
    """Redirect a broken stream, so that the interpreter does not fail again when it flushes it at exit."""
    if stream is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _fail(message: str) -> None:
    _print_error("hcsearch: " + one_line(message))
    sys.exit(2)


def _print_error(message: str) -> None:
    """Print to stderr, ignoring a closed stream."""
    try:
        click.echo(message, err=True)
    except OSError:
        _discard(sys.stderr)
