"""`hcsearch identify`: springs and dampers from measurements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import mean, stdev
from typing import TYPE_CHECKING

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.identify_motion import motion_of_films
from hcsearch.cli.options import FiniteNumber, examples_epilog

if TYPE_CHECKING:
    from hcsearch.springs.identification.law_fitting import IdentifiedSpring
    from hcsearch.springs.identification.vibration import FreeVibration, HingeTest

_UNITS = {"stiffness": "N m/rad", "growth": "N m/rad^2", "preload": "N m", "hysteresis": "N m"}


@click.group(
    epilog=examples_epilog(
        "hcsearch identify spring moments.csv",
        "hcsearch identify damping --inertia 0.0051 --hinges 4 test1.csv test2.csv",
        "hcsearch identify motion film.csv hex:0234550132:4",
    )
)
def identify() -> None:
    """Compute springs and damping from measurements.

    The results are in the form that the options --spring and --damping of hcsearch deploy, and scene files, take.
    """


identify.add_command(motion_of_films)


@identify.command(epilog=examples_epilog("hcsearch identify spring moments.csv"))
@click.argument("file", metavar="FILE.csv")
def spring(file: str) -> None:
    """Compute the law of a spring from angles and moments.

    The file has a column angle_rad or angle_deg (the fold angle, 0 in the flat state) and a column moment_N_m or
    moment_N_mm; its rows are in the order of the measurement. Linear and quadratic laws are tried, with and without
    preload, then a table; the simplest law that fits is chosen. If the angle also decreases, the gap between loading
    and unloading is reported, and the law lies in the middle.
    """
    from hcsearch.api import identifying

    _print_spring(identifying.identify_spring(file))


@identify.command(
    epilog=examples_epilog("hcsearch identify damping --inertia 0.0051 --hinges 4 --from 0.2 test1.csv test2.csv")
)
@click.argument("files", metavar="FILE.csv...", nargs=-1, required=True)
@click.option(
    "--inertia",
    type=FiniteNumber(),
    required=True,
    metavar="I",
    help="The moment of inertia of the block about the hinges, kg m^2.",
)
@click.option(
    "--hinges",
    type=int,
    default=1,
    show_default=True,
    metavar="N",
    help="The number of equal hinges that hold the block.",
)
@click.option("--rate", type=FiniteNumber(), metavar="HZ", help="The sampling rate; it takes the place of time_s.")
@click.option(
    "--from", "start", type=FiniteNumber(), metavar="SECONDS", help="Leave out measurements before this time."
)
def damping(files: tuple[str, ...], inertia: float, hinges: int, rate: float | None, start: float | None) -> None:
    """Compute the damping of a hinge from free vibrations.

    A block that swings on one or more equal hinges is struck with a hammer; each file holds one test. It has a column
    time_s, unless --rate is given, and a column for each accelerometer, such as time_s,block_g,frame_g; all
    accelerations are in one unit. It begins after the stroke, or at the time --from. The mode of the lowest frequency
    is taken as the swing of the block.
    """
    from hcsearch.api import identifying

    measured = identifying.identify_damping(files, inertia, hinges=hinges, rate=rate, start=start)
    names = tuple(map(printable, files))
    _print_tests(names, measured.tests)
    _print_modes(names, measured.vibrations)


def _print_spring(measured: IdentifiedSpring) -> None:
    """Print the chosen law with its numbers, and a comparison of all laws."""
    chosen = measured.chosen
    low, high = measured.span
    click.echo(f"{'pairs':14}{measured.loading} loading, {measured.unloading} unloading; {low:.4g} to {high:.4g} rad")
    click.echo(f"{'law':14}{chosen.law.text}")
    for name, estimate in chosen.estimates.items():
        interval = f"95 %: {estimate.low:.4g} to {estimate.high:.4g}"
        click.echo(f"{name:14}{estimate.value:.4g} {_UNITS[name]}, standard error {estimate.error:.2g} ({interval})")
    if not (measured.loading and measured.unloading):
        click.echo(f"{'hysteresis':14}not measured: the angle goes one way only")
    click.echo(f"\n{'law tried':22}{'left, rms N m':>14}{'off, % of the greatest':>24}  verdict")
    for fit in measured.fits:
        verdict = "chosen" if fit is chosen else ("suffices" if fit.sufficient else "does not suffice")
        click.echo(f"{fit.kind:22}{fit.residual:>14.3g}{100.0 * fit.misfit:>24.2g}  {verdict}")


def _print_tests(files: Sequence[str], tests: Sequence[HingeTest]) -> None:
    """Print a row per test with standard errors, as thesis table 4.2; then average and standard deviation."""
    width = max(len("average"), *map(len, files)) + 2
    titles = ("f, Hz", "omega, rad/s", "zeta", "c, N m s/rad")
    click.echo(" " * width + "".join(f"{title:>20}" for title in titles))
    for file, test in zip(files, tests, strict=True):
        pairs = (
            (test.frequency, test.frequency_error),
            (2.0 * math.pi * test.frequency, 2.0 * math.pi * test.frequency_error),
            (test.damping, test.damping_error),
            (test.coefficient, test.coefficient_error),
        )
        click.echo(f"{file:{width}}" + "".join(f"{f'{value:#.4g} +- {error:.1g}':>20}" for value, error in pairs))
    rows = [(test.frequency, 2.0 * math.pi * test.frequency, test.damping, test.coefficient) for test in tests]
    if len(rows) > 1:
        for name, statistic in (("average", mean), ("deviation", stdev)):
            click.echo(
                f"{name:{width}}" + "".join(f"{statistic(column):>#20.4g}" for column in zip(*rows, strict=True))
            )
    stiffness = mean(test.stiffness for test in tests)
    click.echo(f"what drives the block back, springs and weight: {stiffness:.4g} N m/rad")


def _print_modes(files: Sequence[str], vibrations: Sequence[FreeVibration]) -> None:
    """Print the other modes of vibration, so that a wrong choice is visible."""
    for file, vibration in zip(files, vibrations, strict=True):
        shares = [f"{100.0 * mode.share:.3g} % at {mode.frequency:.4g} Hz" for mode in vibration.modes]
        click.echo(f"energy of {file}: {', '.join(shares)}; noise {vibration.noise:.2g} rms")
