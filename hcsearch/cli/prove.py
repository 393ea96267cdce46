"""`hcsearch prove` and `hcsearch verify`: certificates that are checked independently of the search."""

from __future__ import annotations

from typing import Any

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.cases import case_options, proof_options
from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter


@click.command(
    epilog=examples_epilog(
        "hcsearch prove hex:0234550132:4 --output path.json",
        "hcsearch prove hex:0223335500:4 --output lock.json --panel 100x10",
        "hcsearch prove strip.fold --output strip.json",
    )
)
@proof_options
@click.option("--output", required=True, metavar="FILE", help="The certificate to write, a file .json.")
@click.option(
    "--budget",
    type=click.IntRange(1, 50),
    metavar="EFFORTS",
    help="How many efforts the search for a path or a lock may make; from the third on, each may take minutes, and "
    "longer than the one before.  [default: 5]",
)
def prove(name: str, output: str, budget: int | None, **options: Any) -> None:
    """Write a certificate that a folding, or a pattern on a grid's lattice, can be opened, or that no motion opens it.

    The certificate of a path states that loops stay closed, and that panels, shrunk by a margin, keep apart from
    packed to flat. The certificate of a lock lists boxes of fold angles that no motion leaves, or no motion without a
    collision of panels. Both are plain data. `hcsearch verify` checks them with arithmetic that shares nothing with
    the search, and so do standalone programs that need only NumPy: path_checker.py, lock_checker.py and
    collision_checker.py in hcsearch/motion/certificates.
    """
    from hcsearch.api import proving

    with ProgressMeter("step") as meter:
        arguments = case_options(options) | ({} if budget is None else {"budget": budget})
        certificate = proving.prove(name, output, progress=meter, **arguments)
    for sentence in certificate.sentences:
        click.echo(sentence)
    click.echo(printable(output))


@click.command(
    "verify", epilog=examples_epilog("hcsearch prove hex:0223335500:4 --output lock.json", "hcsearch verify lock.json")
)
@click.argument("path", metavar="FILE")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0, min_open=True),
    default=50.0,
    show_default=True,
    help="Time after which it is not decided whether the claims are proved.",
)
def verify(path: str, seconds: float) -> None:
    """Check a certificate of `hcsearch prove`.

    The command checks that the array is that of the folding which the file names; a pattern is the one in the file.
    Then it checks each claim by interval arithmetic, and prints what is proved.

    Exit code: 0 if all claims hold; 1 if one is not proved, or not decided in the time; 2 if the file is no
    certificate.
    """
    from hcsearch.api import proving
    from hcsearch.motion.certificates.certifying import CertificateError, UnprovedCertificateError

    try:
        sentences = proving.verify(path, seconds=seconds).sentences
    except UnprovedCertificateError as refused:
        click.echo(f"{printable(path)}: not proved: {refused}", err=True)
        click.get_current_context().exit(1)
    except CertificateError as refused:
        click.echo(f"{printable(path)}: no certificate: {refused}", err=True)
        click.get_current_context().exit(2)
    for sentence in sentences:
        click.echo(sentence)
