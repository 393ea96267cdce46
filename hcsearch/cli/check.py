"""`hcsearch check`: a pattern or a circuit of the user, taken through every stage."""

from __future__ import annotations

import json
import shlex
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.cases import case_options, circuit_options
from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter
from hcsearch.system.machine import default_database

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hcsearch.search.own_patterns.checked import Checked


@click.command(
    epilog=examples_epilog(
        "hcsearch check pattern.fold",
        "hcsearch check hex:0234435011",
        "hcsearch check pattern.fold --panel 80x8 --flat-pairs hinged",
    )
)
@circuit_options
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def check(name: str, as_json: bool, **options: Any) -> None:
    """Take a pattern or circuit of your own through all stages.

    The command prints how many foldings pass each stage, and the results for each of them. FILE.fold (or .cp, .opx,
    .svg) is a crease pattern, in any position, drawn to a thousandth of a side. Lines may cross and end on each other.
    If its panels are equal, of one of the eight shapes of --grid, and if its mountains, valleys, flat and unassigned
    edges are the creases of one circuit with a two-stack folding, it is a design; all other shared edges are slits. If
    mountains and valleys are assigned, only the folding with this assignment is checked. The notation of a circuit may
    be in any position, order or direction; CIRCUIT:CREASE checks one folding, its crease numbered as in the circuit
    that is printed.

    Any other pattern of convex panels is checked as a linkage, with any number of loops: its packed state, degrees of
    freedom, locks, motion and deployment. Valleys have hinges on the top face, mountains on the bottom face. So is a
    model that `hcsearch export` wrote, .urdf, .xml or .mjcf.

    Panels have the size that the file gives in a physical unit, unless --panel sets another: the sizes of a panel, or
    the longest edge and the thickness of a pattern that is no design.

    Exit code: 0 if springs open a folding, certified free of collisions; 1 if they do not or if this is undecided; 2
    for wrong input.
    """
    from hcsearch.api import checking

    named = case_options(options)
    with ProgressMeter("folding") as meter:
        checked = checking.check(name, progress=meter, **named)
    if as_json:
        click.echo(json.dumps(checked.facts, indent=2, allow_nan=False))
    else:
        _print(checked, named)
    if checked.fault:
        click.echo(checked.fault, err=True)
    if not checked.deploys:
        click.get_current_context().exit(1)


def _print(checked: Checked, named: Mapping[str, Any]) -> None:
    """Print the subject, then each verdict with its reasons and the command that repeats its deployment."""
    for line in checked.heads:
        click.echo(line)
    for verdict in checked.verdicts:
        click.echo(verdict.heading)
        for sentence in filter(None, (*verdict.reasons, verdict.play)):
            click.echo(f"  {sentence}")
        for name, scene in verdict.deployed_in:
            options = _scene_options(scene, checked.scene.name, named)
            click.echo(f"  {shlex.join(['hcsearch', 'deploy', name, *options])}")


def _scene_options(tried: str, name: str, named: Mapping[str, Any]) -> list[str]:
    """Write the options by which `hcsearch deploy` repeats a deployment.

    tried : the name of the scene as it was tried. name : the name of the scene asked for. named : the options.
    """
    words: list[str] = []
    from hcsearch.subjects.stored_scenes import is_scene_file

    if is_scene_file(named["scene"] or ""):
        base, *parts = tried.split(", ")
        if base == name.split(", ", maxsplit=1)[0]:
            tried = ", ".join([named["scene"], *parts])
    elif named["scene"] is not None and named["db"] != default_database():
        words = ["--db", named["db"]]
    words = ["--scene", tried, *words]
    for option, value in named.items():
        if option not in ("db", "scene", "panel", "flat_pairs"):
            words += [f"--{option}", str(value)]
    return [*words, "--flat-pairs", named["flat_pairs"]] if named["flat_pairs"] else words
