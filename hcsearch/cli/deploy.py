"""`hcsearch deploy`: the spring-driven deployment of a folding, an assembly or the subject of a file."""

from __future__ import annotations

import json
from typing import Any

import click
from click.core import ParameterSource

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import FORMULATIONS, INTEGRATORS
from hcsearch.cli.cases import resolve_named, subject_options, value_options
from hcsearch.cli.options import Command, examples_epilog, json_option
from hcsearch.system.figures import check_picture
from hcsearch.system.outputs import TABLE_SUFFIXES, check_output, write_table
from hcsearch.system.terminal import short_number


def scene_value_options(command: Command) -> Command:
    """Add the options for springs, `--springs` and `--dampers` of single hinges among them."""
    options = (
        *value_options("springs"),
        click.option(
            "--springs",
            "own_springs",
            multiple=True,
            metavar="HINGE=LAW",
            help="The spring at one hinge, named by its crease; may be repeated.",
        ),
        click.option(
            "--dampers",
            "own_dampers",
            multiple=True,
            metavar="HINGE=C",
            help="The damping at one hinge, named by its crease, N m s/rad; may be repeated.",
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


@click.command(
    epilog=examples_epilog(
        "hcsearch deploy hex:0234550132:4 --picture angles.svg",
        "hcsearch deploy thesis-4x4 --formulation penalty",
        "hcsearch deploy unit-i --spring linear:0.05 --output unit-i.csv",
    )
)
@subject_options
@click.option("--formulation", type=click.Choice(FORMULATIONS), help="The equations of motion.  [default: constrained]")
@click.option(
    "--method",
    type=click.Choice(INTEGRATORS),
    help="The integrator.  [default: dormand-prince, and implicit where the scene is stiff; for compliant: "
    "linearly-implicit]",
)
@click.option(
    "--tolerance", type=float, default=1e-6, show_default=True, help="The error of a step, relative and absolute."
)
@scene_value_options
@click.option(
    "--explain",
    is_flag=True,
    help="List the parts that the simulation leaves out, and why this does not change the motion.",
)
@json_option
@click.option("--output", metavar="FILE", help="Write all states to a file .csv, .npz or .parquet.")
@click.option(
    "--picture", metavar="FILE", help="Draw fold angles and energies over time into a file .svg, .png or .pdf."
)
def deploy(name: str, as_json: bool, **options: Any) -> None:
    """Simulate how springs open a folding or an assembly.

    The motion starts at rest in the packed state and ends when the array is flat, at rest, stuck, jammed, or when the
    time is over. It is either certified free of collisions, for panels shrunk by a margin on every face (0.1 mm for
    panels of 50 mm), or the first collision is reported. A motion that ends flat is simulated at tighter tolerances,
    too. Its time is printed with the digits that agree; if one of them ends otherwise, the verdict is undecided.

    Exit code: 0 if the array becomes flat, certified free of collisions; 1 if it does not or if this is undecided; 2
    for wrong input.
    """
    from hcsearch.api import deploying
    from hcsearch.springs.deployment.omission_savings import omission_savings, saving_facts

    if options["output"]:
        check_output(options["output"], TABLE_SUFFIXES)
    if options["picture"]:
        check_picture(options["picture"])
    case = resolve_named(name, options | values_of_hinges(options))
    if case.drive is not None and options["explain"]:
        raise HcsearchError("--explain does not apply to a scene with drives: leave it out")
    method, tolerance = options["method"], options["tolerance"]
    tolerance_source = click.get_current_context().get_parameter_source("tolerance")
    if case.drive is not None and tolerance_source is ParameterSource.COMMANDLINE:
        raise HcsearchError("--tolerance does not apply to a scene with drives: leave it out")
    formulation = options["formulation"]
    deployed = deploying.deploy(case, formulation=formulation, method=method, tolerance=tolerance)
    outcome = deployed.facts()
    if options["explain"]:
        savings = omission_savings(deployed.deployment.compiled, method=method, tolerance=tolerance)
        outcome["saved"] = [saving_facts(saving) for saving in savings]
    if options["output"]:
        write_table(options["output"], deployed.table())
    if options["picture"]:
        deployed.picture(options["picture"])
    if as_json:
        click.echo(json.dumps(outcome, indent=2, allow_nan=False))
    else:
        _print(outcome)
    if outcome["verdict"] != "deploys":
        click.get_current_context().exit(1)


def values_of_hinges(options: dict[str, Any]) -> dict[str, Any]:
    """Return the springs and dampers of single hinges as values of a scene."""
    laws = _by_hinge(options["own_springs"], "--springs", "HINGE=LAW, such as 3=linear:0.2")
    dampers = _by_hinge(options["own_dampers"], "--dampers", "HINGE=C, such as 3=0.01")
    values: dict[str, Any] = {"springs": laws} if laws else {}
    if dampers:
        values["hinges"] = {hinge: {"damping": damping} for hinge, damping in dampers.items()}
    return values


def _by_hinge(texts: tuple[str, ...], option: str, example: str) -> dict[str, str]:
    """Return what an option gives to single hinges."""
    from hcsearch.shape.labels import is_label

    pairs = [text.partition("=") for text in texts]
    for hinge, equals, _ in pairs:
        if not (equals and is_label(hinge)):
            raise HcsearchError(f"cannot read {option} {hinge!r}: write {example}")
    given = {hinge: value for hinge, _, value in pairs}
    if len(given) < len(pairs):
        raise HcsearchError(f"{option} names a hinge twice: leave one out")
    return given


def _print(outcome: dict[str, Any]) -> None:
    """Print the outcome, one fact per line."""
    from hcsearch.springs.deployment.error_estimates import errors_sentence
    from hcsearch.springs.deployment.omission_savings import saving_sentence

    omissions, events, arrived = outcome.pop("left_out"), outcome.pop("events"), outcome.pop("arrivals")
    saved = outcome.pop("saved", None)
    errors = outcome.pop("errors")
    outcome["merged_panels"] = ", ".join(outcome["merged_panels"]) or "none"
    for name, value in outcome.items():
        shown = "-" if value is None else (short_number(value, 6) if isinstance(value, float) else value)
        click.echo(f"{name.replace('_', ' '):24}{shown}")
    if errors is not None:
        click.echo(f"{'errors':24}{errors_sentence(errors)}")
    click.echo(f"{'stops hit':24}{sum(event['kind'] == 'hit' for event in events)}")
    for arrival in arrived[:10]:
        hinges = ", ".join(map(str, arrival["hinges"]))
        sentence = f"hinge {hinges} {arrival['stop']} at {short_number(arrival['speed_rad_s'], 3)} rad/s"
        click.echo(f"{'':24}{short_number(arrival['time_s'], 6)} s: {sentence}")
    if saved is None:
        return
    click.echo("left out")
    for omission in omissions:
        click.echo(f"  {omission['name']:22}{omission['what']}: {omission['why']}")
        for row in saved:
            if row["name"] == omission["name"]:
                click.echo(f"{'':24}{saving_sentence(row)}")
