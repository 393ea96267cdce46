"""`hcsearch accuracy`: error against run time of a deployment, beside references."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import FORMULATIONS
from hcsearch.cli.cases import case_options, subject_options
from hcsearch.cli.deploy import scene_value_options, values_of_hinges
from hcsearch.cli.options import FiniteNumber, examples_epilog, json_option
from hcsearch.cli.progress import ProgressMeter
from hcsearch.system.figures import check_picture
from hcsearch.system.outputs import TABLE_SUFFIXES, check_output, write_table
from hcsearch.system.terminal import short_number, tolerance_text

if TYPE_CHECKING:
    from hcsearch.springs.accuracy.measured_accuracy import MeasuredAccuracy
    from hcsearch.springs.accuracy.stability_report import MeasuredStability
    from hcsearch.springs.accuracy.work_rows import FormulationWork, WorkRow

_HEADINGS = ("method", "tolerance", "angles, rad", "flat time, s", "energy", "closure", "ms", "steps", "ending")


class _Angle(FiniteNumber):
    """A positive angle in radians, with its unit or without."""

    name = "angle"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        return super().convert(str(value).removesuffix("rad").strip(), param, ctx)


class _Sweep(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """A value of a scene and its range, such as damping=1e-4..10."""

    name = "sweep"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float, float]:
        value_name, _, numbers = str(value).partition("=")
        low, _, high = numbers.partition("..")
        try:
            return value_name.strip(), float(low), float(high)
        except ValueError:
            self.fail(f"cannot read {value!r}: write VALUE=LOW..HIGH, such as damping=1e-4..10", param, ctx)


@click.command(
    epilog=examples_epilog(
        "hcsearch accuracy hex:0234550132:4 --formulation constrained --error 1e-4",
        "hcsearch accuracy hex:0234550132:4 --sweep damping=1e-4..10 --picture map.svg",
        "hcsearch accuracy unit-i --scene earth --limit 0.5 --picture work.svg --output work.csv",
    )
)
@subject_options
@click.option(
    "--formulation",
    type=click.Choice(FORMULATIONS),
    help="The equations of motion that are tried.  [default: all that apply]",
)
@scene_value_options
@click.option(
    "--error",
    type=_Angle(min=0, min_open=True),
    metavar="RAD",
    help="Name the cheapest setting with at most this error of the fold angles, rad.",
)
@click.option(
    "--sweep",
    "sweeps",
    type=_Sweep(),
    multiple=True,
    metavar="VALUE=LOW..HIGH",
    help="Judge simulations with other values of damping, stiffness, thickness, density, friction, spread or size, as "
    "in damping=1e-4..10; may be given twice.",
)
@click.option(
    "--stress",
    is_flag=True,
    help="Judge simulations with each value times 10 and over 10, and known extremes.",
)
@click.option(
    "--limit",
    type=FiniteNumber(min=0, min_open=True),
    default=1.0,
    show_default=True,
    metavar="S",
    help="The greatest time of one simulation, or reference, s, about; what would take longer is not tried.",
)
@json_option
@click.option("--output", metavar="FILE", help="Write all simulations as a table to a file .csv, .npz or .parquet.")
@click.option("--picture", metavar="FILE", help="Draw error against processor time into a file .svg, .png or .pdf.")
def accuracy(name: str, as_json: bool, **options: Any) -> None:
    """Measure the error of a deployment against its run time.

    The deployment is simulated by each method at tolerances from 1e-3 to 1e-10, in each formulation that applies, and
    compared with a reference of order 8 at 1e-13, or the tightest tolerance that ends. A second reference, by another
    method and with nothing left out, shows how exact the first one is. Errors are the greatest at any time, also
    inside steps. The setting that hcsearch deploy takes by default is marked. Times are of the processor. Then follow
    the errors of the default setting, and what is left out with what this saves and changes.

    With --sweep or --stress simulations of scenes with other values are judged instead: accurate (an error of at most
    100 tolerances), degraded (within a bound by a rougher simulation), refused (it says that it has no answer), or
    wrong.
    """
    from hcsearch.api import measuring_accuracy

    if options["output"]:
        check_output(options["output"], TABLE_SUFFIXES)
    if options["picture"]:
        check_picture(options["picture"])
    arguments = case_options(options | values_of_hinges(options))
    arguments |= {"formulation": options["formulation"], "limit": options["limit"]}
    measured: MeasuredAccuracy | MeasuredStability
    if options["sweeps"] or options["stress"]:
        arguments["sweep"] = _sweep_of(options)
        with ProgressMeter("point") as meter:
            measured = measuring_accuracy.stability(name, progress=meter, **arguments)
    else:
        with ProgressMeter("simulation") as meter:
            measured = measuring_accuracy.accuracy(name, progress=meter, error=options["error"], **arguments)
    if options["output"]:
        write_table(options["output"], measured.table())
    if options["picture"]:
        measured.picture(options["picture"])
    if as_json:
        click.echo(json.dumps(measured.facts(), indent=2, allow_nan=False))
    else:
        _print(measured)


def _sweep_of(options: dict[str, Any]) -> dict[str, tuple[float, float]] | None:
    """Return the sweep by value; None for the standard set."""
    sweeps = options["sweeps"]
    if options["error"] is not None:
        raise HcsearchError("--error is for a table of methods: leave it out, or --sweep and --stress")
    if options["stress"]:
        if sweeps:
            raise HcsearchError("give either --sweep or --stress: each is a set of points of its own")
        return None
    if len({value for value, _, _ in sweeps}) < len(sweeps):
        raise HcsearchError("--sweep names a value twice: leave one out")
    return {value: (low, high) for value, low, high in sweeps}


def _print(measured: MeasuredAccuracy | MeasuredStability) -> None:
    """Print results, by their kind."""
    from hcsearch.springs.accuracy.stability_report import MeasuredStability

    if isinstance(measured, MeasuredStability):
        _print_points(measured)
    else:
        _print_accuracy(measured)


def _print_points(measured: MeasuredStability) -> None:
    """Print the judgement at each point, one a line, and how many there are of each."""
    lines: list[tuple[str, ...]] = [
        ("point", "judgement", "error, rad", "bound, rad", "energy", "ms", "steps", "reason")
    ]
    for point in measured.points:
        lines.append(
            (
                ("> " if point.own else "  ") + point.label,
                point.judgement,
                _number(point.error),
                _number(point.bound),
                _number(point.drift),
                short_number(1e3 * point.seconds, 3),
                "-" if point.steps is None else str(point.steps),
                point.reason or str(point.outcome),
            )
        )
    _print_aligned(lines)
    click.echo(", ".join(f"{count} {judgement}" for judgement, count in measured.counts.items()))


def _print_accuracy(measured: MeasuredAccuracy) -> None:
    """Print a table for each formulation, and the cheapest setting."""
    from hcsearch.springs.accuracy.measured_accuracy import model_sentence, reference_sentence

    for work in measured.works:
        click.echo(f"{work.formulation}: {reference_sentence(work)}")
        if model := model_sentence(work):
            click.echo(model)
        if work.rows:
            _print_rows(work)
        click.echo()
    _print_errors(measured.facts()["errors"])
    _print_omissions(measured)
    if measured.wanted is not None:
        click.echo(_cheapest_sentence(measured))


def _print_errors(errors: dict[str, Any] | None) -> None:
    """Print the error bars of the default setting, what the reference says, and the effect of a perturbed start."""
    from hcsearch.springs.accuracy.measured_accuracy import PERTURBATION
    from hcsearch.springs.deployment.error_estimates import PARTING_ANGLE, errors_sentence

    if errors is None:
        click.echo("errors: no estimate, as a simulation of the default setting gets nowhere or diverges")
        return
    click.echo(f"errors by default: {errors_sentence(errors)}")
    measured = errors["measured_angles_rad"]
    if measured is not None:
        time = "" if errors["measured_flat_time_s"] is None else f", flat time {errors['measured_flat_time_s']:.0e} s"
        click.echo(f"beside the reference: fold angles {measured:.0e} rad{time}")
    until = errors["perturbed_until_s"]
    parted = "never parts from it" if until is None else f"parts from it at {short_number(until)} s"
    click.echo(f"a start that differs by {PERTURBATION:g} rad {parted} by more than {PARTING_ANGLE:g} rad")


def _print_omissions(measured: MeasuredAccuracy) -> None:
    """Print what is left out by default, what that saves and what it changes."""
    from hcsearch.springs.deployment.omission_savings import saving_facts, saving_sentence

    click.echo("left out by default")
    for saving in measured.omitted:
        omission = saving.omission
        click.echo(f"  {omission.name:22}{omission.what}: {omission.why}")
        click.echo(f"{'':24}saves {short_number(saving.saved, 2)} ms: {saving_sentence(saving_facts(saving))}")


def _print_rows(work: FormulationWork) -> None:
    """Print the simulations of a formulation, one a line; a method that is no longer tried has one line for all."""
    lines: list[tuple[str, ...]] = [_HEADINGS]
    for method in dict.fromkeys(row.method for row in work.rows):
        rows = [row for row in work.rows if row.method == method]
        lines += [_cells(row, work) for row in rows if row.outcome is not None]
        if untried := [row for row in rows if row.outcome is None]:
            tolerances = tolerance_text(untried[0].tolerance) + (" on" if len(untried) > 1 else "")
            mark = "> " if any(row.default for row in untried) else "  "
            lines.append((mark + method, tolerances, untried[0].note))
    _print_aligned(lines)


def _print_aligned(lines: Sequence[Sequence[str]]) -> None:
    """Print lines in columns that fit all lines with as many cells as the first one; a last cell may be wider."""
    widths = [
        max(map(len, cells)) for cells in zip(*(line for line in lines if len(line) == len(lines[0])), strict=True)
    ]
    for *cells, last in lines:
        padded = [f"{cell:{width}}" for cell, width in zip(cells, widths, strict=False)]
        click.echo("  ".join([*padded, last]).rstrip())


def _cells(row: WorkRow, work: FormulationWork) -> tuple[str, ...]:
    doubt = None if work.reference is None else work.reference.angle_doubt
    angle = f"< {doubt:.1e}" if row.below and doubt else _number(row.angle_error)
    return (
        ("> " if row.default else "  ") + row.method,
        tolerance_text(row.tolerance),
        angle,
        _number(row.time_error),
        _number(row.drift),
        _number(row.opening),
        "-" if row.seconds is None else short_number(1e3 * row.seconds, 3),
        "-" if row.steps is None else str(row.steps),
        str(row.outcome),
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}"


def _cheapest_sentence(measured: MeasuredAccuracy) -> str:
    row = measured.cheapest
    wanted = f"{measured.wanted:.2g} rad"
    if row is None or row.seconds is None:
        return f"no setting has an error of at most {wanted}: take a larger --limit, or a larger --error"
    milliseconds = short_number(1e3 * row.seconds, 2)
    return f"cheapest for {wanted}: hcsearch deploy {row.options} ({milliseconds} ms, error {row.angle_error:.1e} rad)"
