"""`hcsearch drive`: a folding driven along its certified path by motors at few hinges."""

from __future__ import annotations

import json
from typing import Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.cases import case_options, folding_options
from hcsearch.cli.options import FiniteNumber, examples_epilog, json_option
from hcsearch.cli.progress import ProgressMeter
from hcsearch.system.figures import check_picture
from hcsearch.system.outputs import check_output
from hcsearch.system.terminal import short_number


@click.command(
    epilog=examples_epilog(
        "hcsearch drive hex:0234435011:1 --picture drive.svg --output drive.toml",
        "hcsearch deploy drive.toml",
        "hcsearch drive hex:0234435011:1 --rate 0.5 --scene earth",
        "hcsearch drive hex:0234550132:3 --latches",
    ),
)
@folding_options
@click.option(
    "--rate",
    type=FiniteNumber(min=1e-6, max=1e6),
    metavar="R",
    help="The greatest rate of any hinge, rad/s.  [default: 1]",
)
@click.option(
    "--acceleration",
    type=FiniteNumber(min=1e-6, max=1e6),
    metavar="A",
    help="The greatest acceleration of any hinge, rad/s^2.  [default: 5]",
)
@click.option(
    "--near",
    metavar="START,END",
    help="How far from the packed state the drive starts, and how far from the flat state it ends, rad.  "
    "[default: 0.01,0.005]",
)
@click.option(
    "--hinges",
    "driven_hinges",
    metavar="K,K,...",
    help="The driven hinges by their creases, at least as many as there are degrees of freedom.  [default: chosen by "
    "the program]",
)
@click.option(
    "--firm",
    type=FiniteNumber(min=0, max=1),
    metavar="S",
    help="Add driven hinges until the least singular value of the reduced Jacobian reaches S; 0 adds none.  "
    "[default: 0.1]",
)
@click.option(
    "--period",
    type=FiniteNumber(min=1e-5, max=0.1),
    metavar="S",
    help="The time between two updates of the controller, s; drives interpolate between them.  [default: 0.002]",
)
@click.option(
    "--latches",
    is_flag=True,
    help="Also simulate springs alone, with hinges that are latched and released in the order of the path.",
)
@json_option
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="FILE",
    help="Write angles and torques over time (.csv, .parquet), or the scene with the drive (.toml); may be repeated.",
)
@click.option(
    "--picture", metavar="FILE", help="Draw fold angles and torques over time into a file .svg, .png or .pdf."
)
def drive(name: str, as_json: bool, **options: Any) -> None:
    """Choose motors that open a folding along a proved path.

    The program chooses as many driven hinges as there are degrees of freedom, by the conditioning of the reduced
    Jacobian along the path, and hinges that turn one way only where possible; near a dead point it adds more. It sets a
    time law along the path, computes the torques by inverse dynamics, and simulates the motion under position control.
    The greatest planned torque sizes the motor; the torques of the simulation show whether the controller follows.

    Exit code: 0 if the driven motion ends flat, certified free of collisions; 1 if it does not, or if no path is
    proved; 2 for wrong input.
    """
    from hcsearch.api import driving

    for path in options["outputs"]:
        check_output(path, driving.DRIVE_SUFFIXES)
    if options["picture"]:
        check_picture(options["picture"])
    drive_options = _drive_options(options)
    try:
        with ProgressMeter("step") as meter:
            driven = driving.drive(name, options=drive_options, progress=meter, **case_options(options))
    except driving.NoPathError as error:
        outcome = {"verdict": "no drive", "reason": str(error)}
        click.echo(json.dumps(outcome, indent=2) if as_json else f"no drive: {error}")
        click.get_current_context().exit(1)
    for path in options["outputs"]:
        driven.save(path)
    if options["picture"]:
        driven.picture(options["picture"])
    outcome = driven.facts()
    if options["latches"]:
        outcome |= driving.latch_facts(driven)
    if as_json:
        click.echo(json.dumps(outcome, indent=2, allow_nan=False))
    else:
        _print(outcome)
    if not driven.deployment.deploys:
        click.get_current_context().exit(1)


def _drive_options(options: dict[str, Any]) -> Any:
    from hcsearch.api.driving import DriveOptions

    values = {name: options[name] for name in ("rate", "acceleration", "firm", "period") if options[name] is not None}
    if options["near"] is not None:
        values["near"] = _near(options["near"])
    if options["driven_hinges"] is not None:
        values["hinges"] = tuple(options["driven_hinges"].split(","))
    return DriveOptions(**values)


def _near(text: str) -> tuple[float, float]:
    try:
        start, end = (float(part) for part in text.split(","))
    except ValueError as error:
        raise HcsearchError(f"cannot read --near {text!r}: write two angles in rad, such as 0.01,0.005") from error
    if not (1e-4 <= start <= 0.5 and 1e-4 <= end <= 0.008):
        raise HcsearchError(
            f"--near {text} is out of range: start 0.0001 to 0.5 rad from packed, and end 0.0001 to 0.008 rad from "
            "flat, which counts as flat from 0.01 on"
        )
    return start, end


def _print(outcome: dict[str, Any]) -> None:
    """Print one fact per line, and the driven hinges as a table."""
    lists = ("planned_torque_N_m", "torque_rms_N_m", "torque_N_m", "gain_N_m_rad", "gain_N_m_s_rad")
    for name, value in outcome.items():
        if name in (*lists, "follows"):
            continue
        shown = "-" if value is None else (short_number(value, 6) if isinstance(value, float) else value)
        if name == "latches":
            shown = (
                "; ".join(f"{a} until {b} is at {angle:.3g} rad" for a, b, angle in map(dict.values, value)) or "none"
            )
        elif isinstance(value, list):
            shown = ", ".join(map(str, value)) or "none"
        elif name == "motor_torque_N_m":
            shown = f"{shown}, planned: this torque sizes the motor"
        click.echo(f"{name.replace('_', ' '):30}{shown}")
    heads = ("planned", "rms", "simulated", "gain", "damping")
    click.echo("\nhinge" + "".join(f"{head:>11}" for head in heads) + "   N m, N m/rad, N m s/rad")
    columns = (outcome[name] for name in lists)
    for hinge, row in zip(outcome["driven"], zip(*columns, strict=True), strict=True):
        click.echo(f"{hinge!s:<5}" + "".join(f"{'-' if value is None else format(value, '.4g'):>11}" for value in row))
