"""`hcsearch sheet`: a folding or a pattern against the rules of a standard for space mechanisms."""

from __future__ import annotations

import json
from typing import Any

import click

from hcsearch.cli.cases import case_options, folding_options
from hcsearch.cli.options import examples_epilog, json_option


@click.command(
    epilog=examples_epilog(
        "hcsearch sheet hex:0234550132:4 --scene solar.toml",
        "hcsearch sheet hex:0234550132:4 --scene flight.toml --output sheet.html",
        "hcsearch sheet 17:4 --scene solar.toml --rules house.toml --output sheet.tex",
        "hcsearch sheet strip.fold --friction 0.001",
    )
)
@folding_options
@click.option(
    "--rules",
    metavar="ecss|aiaa|FILE.toml",
    default="ecss",
    show_default=True,
    help="The standard: ECSS-E-ST-33-01C, AIAA S-114, or a file with factors and clauses of another.",
)
@click.option(
    "--measured",
    is_flag=True,
    help="Friction and harness are measured values, for which a standard has smaller factors.",
)
@json_option
@click.option("--output", metavar="FILE", help="Write the sheet to a file .html, .md, .tex or .txt instead.")
def sheet(name: str, as_json: bool, **options: Any) -> None:
    """Compare a folding, or a pattern of your own, with the rules of a standard.

    The sheet gives each rule with its clause, the figure and whether it passes: torque margin over the whole travel,
    also with one spring failed, clearance over tolerances, frequency, flatness and room where the standard or the scene
    asks for them; then how figures change with the hardware, and what was left out. Friction, latches, tolerances, the
    envelope and the craft are values of the scene. Each figure is proved, sampled at states, or simulated: of these
    a sampled one does not pass, and one whose bound and whose sample lie on both sides of the rule is not known.

    The motion is that of the stored verdict; without one it is simulated, and else planned.

    Exit code: 0 if all rules pass; 1 if one fails or a figure is not known; 2 for wrong input.
    """
    from hcsearch.api import reviewing

    if options["output"]:
        reviewing.check_sheet_file(options["output"])
    reviewed = reviewing.sheet(name, rules=options["rules"], measured=options["measured"], **case_options(options))
    if options["output"]:
        reviewing.save_sheet(reviewed, options["output"])
        click.echo(options["output"])
    elif as_json:
        click.echo(json.dumps(reviewed.facts(), indent=2, allow_nan=False))
    else:
        click.echo(reviewing.sheet_in(reviewed, "text"), nl=False)
    if reviewed.verdict != "pass":
        click.get_current_context().exit(1)
