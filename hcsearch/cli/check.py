"""`hcsearch check`: a pattern or a circuit of the user's own through every stage."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import examples
from hcsearch.cli.progress import Meter
from hcsearch.cli.subjects import circuit_options, request_of
from hcsearch.play import millimetres, play_sentence
from hcsearch.system.machine import default_database

if TYPE_CHECKING:
    from collections.abc import Collection

    from hcsearch.circuit import Circuit
    from hcsearch.own_patterns.checking import CheckedCircuit
    from hcsearch.scenes import Scene
    from hcsearch.subjects.requests import Request


@click.command(
    epilog=examples(
        "hcsearch check pattern.fold",
        "hcsearch check hex:0234435011",
        "hcsearch check pattern.fold --panel 80x8 --flat-pairs hinged",
    )
)
@circuit_options
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def check(name: str, as_json: bool, **options: Any) -> None:
    """Take a pattern or circuit of your own through all stages.

    The command prints how many foldings pass each stage, and the results for each of them. FILE.fold is a crease
    pattern of equal triangles, rectangles or regular hexagons, edge to edge, in any position, drawn to a thousandth of
    a side. Lines may cross and end on each other. Its mountains, valleys,
    flat and unassigned edges are the creases of one circuit; all other shared edges are slits. If mountains and valleys
    are assigned, only the folding with this assignment is checked. Panels have the size that the file gives in a
    physical unit, unless --panel or --across sets another. The notation of a circuit may be in any position, order or
    direction; CIRCUIT:CREASE checks one folding, its crease numbered as in the circuit that is printed.

    Exit code: 0 if springs open a folding, certified free of collisions; 1 if they do not or if this is undecided; 2
    for wrong input.
    """
    from hcsearch.folding import why_none
    from hcsearch.own_patterns.checking import check_circuit

    request = request_of(name, options)
    circuit, creases, scene = _of_file(request) if name.lower().endswith(".fold") else _of_notation(request)
    with Meter("folding") as meter:
        checked = check_circuit(circuit, scene, creases, meter)
    if as_json:
        click.echo(json.dumps(_facts(checked, scene), indent=2, allow_nan=False))
    else:
        _print(checked, scene, request)
    if not checked.two_stack:
        click.echo(f"nothing folds: {why_none(circuit.n)}", err=True)
    if not checked.deploys:
        click.get_current_context().exit(1)


def _of_file(request: Request) -> tuple[Circuit, Collection[int] | None, Scene]:
    """The circuit of a FOLD file, the creases of the foldings that are drawn, and the scene with its panels."""
    from hcsearch.own_patterns.fold_reading import read_fold
    from hcsearch.own_patterns.recognition import recognise, sized
    from hcsearch.subjects.reading import read_scene_of

    drawing = read_fold(request.name)
    for remark in drawing.remarks:
        click.echo(f"{request.name}: {remark}", err=True)
    design = recognise(drawing)
    grid = design.circuit.grid.name
    if request.panel is None and request.across is None:
        panel = sized(design, drawing)
        request = request if panel is None else replace(request, panel=panel)
    return design.circuit, design.creases if design.assigned else None, read_scene_of(request, grid)


def _of_notation(request: Request) -> tuple[Circuit, Collection[int] | None, Scene]:
    from hcsearch.errors import HcsearchError
    from hcsearch.folding import folding_of, split_crease
    from hcsearch.subjects.designs import design_named
    from hcsearch.subjects.reading import read_scene_of

    if not request.name[:1].isdigit() and ":" not in request.name:
        raise HcsearchError(f"{request.name!r} is no circuit: name a file .fold, or a notation such as hex:0234435011")
    name, crease = split_crease(request.name)
    circuit, _ = design_named(name, request.db)
    creases = None if crease is None else [folding_of(circuit, crease).crease]
    return circuit, creases, read_scene_of(request, circuit.grid.name)


def _facts(checked: CheckedCircuit, scene: Scene) -> dict[str, Any]:
    circuit = checked.circuit
    return {
        "circuit": circuit.notation,
        "array": circuit.array.canonical().notation,
        "panels": circuit.n,
        "panel_mm": _panel(scene),
        "scene": scene.name,
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


def _panel(scene: Scene) -> str:
    from hcsearch.scenes import panel_text

    assert scene.panel is not None
    return panel_text(scene.panel)


def _print(checked: CheckedCircuit, scene: Scene, request: Request) -> None:
    circuit = checked.circuit
    click.echo(f"{circuit.notation}, array {circuit.array.canonical().notation}")
    click.echo(f"  {circuit.n} panels of {_panel(scene)} mm, scene {scene.name}")
    for label, count in checked.funnel.items():
        click.echo(f"  {label:24}{count:>6}")
    for verdict in checked.verdicts:
        status = verdict.status or "twisted"
        degrees = "degree" if verdict.dof == 1 else "degrees"
        freedoms = "" if verdict.dof is None else f", {verdict.dof} {degrees} of freedom (Kutzbach {verdict.kutzbach})"
        click.echo(f"{verdict.folding.notation}: {status}{freedoms}")
        click.echo(f"  {verdict.reason}")
        if verdict.needed_margin is not None:
            click.echo(f"  {play_sentence(millimetres(verdict.needed_margin))}")
        if verdict.scene is not None:
            words = ["hcsearch", "deploy", verdict.folding.notation, *_scene_options(verdict.scene, request)]
            click.echo(f"  {shlex.join(words)}")


def _scene_options(scene: str, request: Request) -> list[str]:
    """The options by which `hcsearch deploy` repeats a deployment in a scene, named as it was tried."""
    from hcsearch.subjects.scenes import read_scene

    words = []
    if isinstance(request.scene, str) and request.scene.endswith(".toml"):
        base, *parts = scene.split(", ")
        if base == read_scene(request.scene, request.db).name:
            scene = ", ".join([request.scene, *parts])
    elif request.scene is not None and request.db != default_database():
        words = ["--db", request.db]
    words = ["--scene", scene, *words]
    for name, value in request.values.items():
        words += [f"--{name}", str(value)]
    if request.flat_pairs is not None:
        words += ["--flat-pairs", request.flat_pairs]
    return [*words, "--merge"] if request.merge else words
