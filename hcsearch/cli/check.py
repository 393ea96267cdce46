"""`hcsearch check`: a pattern or a circuit of the user, taken through every stage."""

from __future__ import annotations

import json
import shlex
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.vocabulary import counted, millimetres, play_sentence
from hcsearch.cli.cases import case_options, circuit_options, sizes_text
from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import ProgressMeter
from hcsearch.system.machine import default_database

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hcsearch.search.own_patterns.checked_patterns import CheckedPattern
    from hcsearch.search.own_patterns.single_circuits import CheckedCircuit


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
    from hcsearch.search.own_patterns.checked_patterns import CheckedPattern

    named = case_options(options)
    with ProgressMeter("folding") as meter:
        checked = checking.check(name, progress=meter, **named)
    if isinstance(checked, CheckedPattern):
        _show_pattern(checked, as_json=as_json)
    else:
        _show_circuit(checked, named, as_json=as_json)
    if not checked.deploys:
        click.get_current_context().exit(1)


def _show_pattern(checked: CheckedPattern, *, as_json: bool) -> None:
    """Print the results on a pattern that is no design."""
    facts = checked.facts()
    if as_json:
        click.echo(json.dumps(facts, indent=2, allow_nan=False))
        return
    sizes = f"longest edge {facts['longest_edge_mm']:.6g} mm, {facts['thickness_mm']:.6g} mm thick"
    click.echo(f"{facts['pattern']}: {sizes_text(facts)}")
    click.echo(f"  {sizes}, scene {facts['scene']}")
    if facts["moved_mm"]:
        click.echo(f"  points are moved by up to {facts['moved_mm']:.3g} mm, so that the packed state closes")
    freedoms = {"during the motion": "dof", "packed": "dof_packed", "flat": "dof_flat"}
    told = [f"{'-' if facts[key] is None else facts[key]} {state}" for state, key in freedoms.items()]
    click.echo(f"  degrees of freedom: {', '.join(told)} (Kutzbach {facts['kutzbach']})")
    click.echo(f"status: {facts['status'] or 'no packed state'}")
    for sentence in facts["reasons"]:
        click.echo(f"  {sentence}")
    if facts["play"] is not None:
        click.echo(f"  {facts['play']}")


def _show_circuit(checked: CheckedCircuit, named: Mapping[str, Any], *, as_json: bool) -> None:
    """Print the results on the foldings of a circuit."""
    from hcsearch.designs.folding import no_folding_reason

    if as_json:
        click.echo(json.dumps(_facts(checked), indent=2, allow_nan=False))
    else:
        _print(checked, named)
    if not checked.two_stack:
        click.echo(f"nothing folds: {no_folding_reason(checked.circuit.n)}", err=True)


def _facts(checked: CheckedCircuit) -> dict[str, Any]:
    circuit = checked.circuit
    return {
        "circuit": circuit.notation,
        "array": circuit.array.canonical().notation,
        "panels": circuit.n,
        "panel_mm": _panel(checked),
        "scene": checked.scene.name,
        "funnel": checked.funnel,
        "foldings": [
            {
                "folding": verdict.folding.notation,
                "status": verdict.status or "twisted",
                "twist": verdict.twist,
                "dof": verdict.dof,
                "kutzbach": verdict.kutzbach,
                "reason": verdict.reason,
                "needed_margin_mm": millimetres(verdict.needed_margin),
                "least_gap_mm": millimetres(verdict.least_gap),
                "play": play_sentence(millimetres(verdict.needed_margin)),
                "deploys_in": verdict.scene,
            }
            for verdict in checked.verdicts
        ],
    }


def _panel(checked: CheckedCircuit) -> str:
    from hcsearch.designs.panel_sizes import panel_text

    assert checked.scene.panel is not None
    return panel_text(checked.scene.panel)


def _print(checked: CheckedCircuit, named: Mapping[str, Any]) -> None:
    circuit = checked.circuit
    click.echo(f"{circuit.notation}, array {circuit.array.canonical().notation}")
    click.echo(f"  {circuit.n} panels of {_panel(checked)} mm, scene {checked.scene.name}")
    for label, count in checked.funnel.items():
        click.echo(f"  {label:24}{count:>6}")
    for verdict in checked.verdicts:
        status = verdict.status or "twisted"
        freedoms = ""
        if verdict.dof is not None:
            freedoms = f", {counted(verdict.dof, 'degree')} of freedom (Kutzbach {verdict.kutzbach})"
        click.echo(f"{verdict.folding.notation}: {status}{freedoms}")
        click.echo(f"  {verdict.reason}")
        if verdict.needed_margin is not None:
            click.echo(f"  {play_sentence(millimetres(verdict.needed_margin))}")
        if verdict.scene is not None:
            words = [
                "hcsearch",
                "deploy",
                verdict.folding.notation,
                *_scene_options(verdict.scene, checked.scene.name, named),
            ]
            click.echo(f"  {shlex.join(words)}")


def _scene_options(tried: str, name: str, named: Mapping[str, Any]) -> list[str]:
    """Write the options by which `hcsearch deploy` repeats a deployment.

    tried : the name of the scene as it was tried. name : of the scene that was asked for. named : the options.
    """
    words: list[str] = []
    if (named["scene"] or "").endswith(".toml"):
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
