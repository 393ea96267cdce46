"""`hcsearch compile`: the kernels of the main commands, beforehand, several at once."""

from __future__ import annotations

import click

from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter


@click.command("compile", epilog=examples_epilog("hcsearch compile --jobs 2"))
@click.option("--jobs", type=click.IntRange(1, 16), default=2, show_default=True, help="The number of processes.")
def compile_(jobs: int) -> None:
    """Compile the numerical parts of the main commands now.

    Otherwise each command compiles the parts that it needs when it runs for the first time.
    """
    from hcsearch.api import compiling

    if not compiling.can_compile_ahead():
        click.echo("nothing is compiled beforehand: this version of numba keeps each kernel when it is called first")
        return
    with ProgressMeter("kernel") as meter:
        done = compiling.compile_kernels(jobs, meter)
    if done.samples:
        click.echo(f"{done.kernels} kernels compiled in {done.seconds:.0f} s")
    else:
        click.echo("nothing is left to compile")
