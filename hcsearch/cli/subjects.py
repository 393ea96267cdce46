"""What `hcsearch deploy` and `hcsearch tune` are given: a folding, an assembly or a file, and the scene it is in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option
from hcsearch.errors import HcsearchError

if TYPE_CHECKING:
    from hcsearch.deployment.compiling import Formulation
    from hcsearch.linkage import Linkage
    from hcsearch.scenes import PanelSize, Scene

Command = Callable[..., Any]

SMALLEST, LARGEST = 1e-6, 1e4
"""Lengths of panels, m."""


@dataclass(frozen=True)
class Subject:
    """What is deployed, and its scene.

    facts : its keys in a file but for the scene and the formulation. formulation : what a file names, or None.
    """

    linkage: Linkage
    scene: Scene
    formulation: Formulation | None
    facts: dict[str, Any]


def subject_options(command: Command) -> Command:
    """The argument, and the options that tell the panels and what acts on them."""
    for option in (
        database_option,
        click.option("--merge", is_flag=True, help="Make mirror pairs of a design's panels one."),
        click.option("--flat-pairs", type=click.Choice(("rigid", "hinged")), help="Of a design.  [default: rigid]"),
        click.option("--panel", "panel_text", metavar="LxWxT", help="Size of the panels of a design, in mm."),
        click.option("--seconds", type=float, metavar="S", help="To simulate.  [default: 1]"),
        click.option(
            "--held", metavar="PANEL|free", help="The panel that stands still.  [default: the bottom pair, or panel 0]"
        ),
        click.option("--gravity", metavar="X,Y,Z", help="m/s^2, in axes of the flat state seen from +z."),
        click.option("--scene", "scene_name", help="default, earth, thesis, satellite.  [default: default]"),
        click.argument("subject", metavar="DESIGN:CREASE|ASSEMBLY|FILE.toml"),
    ):
        command = option(command)
    return command


def read_subject(name: str, options: dict[str, Any]) -> Subject:
    """What a name or a file tells, with the options beside."""
    from hcsearch.assemblies import ASSEMBLIES  # noqa: PLC0415
    from hcsearch.deployment.subjects import folding_linkage, read_file  # noqa: PLC0415
    from hcsearch.linkage import Linkage  # noqa: PLC0415

    found = read_file(name) if name.endswith(".toml") else {}
    scene, formulation = _scene(found, options), found.get("formulation")
    if found:
        name = found["design"] if "design" in found else found["assembly"]
    panel = _panel(options["panel_text"] or found.get("panel_mm"))
    pairs = options["flat_pairs"] or found.get("flat_pairs", "rigid")
    merged = options["merge"] or bool(found.get("merge"))
    parameters = dict(found.get("parameters", {}))
    if name in ASSEMBLIES:
        if panel or pairs == "hinged" or merged:
            raise HcsearchError(
                f"{name} is an assembly with sizes of its own: leave out --panel, --flat-pairs, --merge"
            )
        from hcsearch.cli.assembly import parameters_of  # noqa: PLC0415

        assembly = ASSEMBLIES[name]
        linkage = Linkage(assembly.build(parameters_of(assembly, parameters)))
        return Subject(linkage, scene, formulation, {"assembly": name, "parameters": parameters})
    if parameters:
        raise HcsearchError(f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly")
    folding = _folding(name, options["db"])
    linkage = folding_linkage(folding, panel, hinged=pairs == "hinged", merged=merged)
    from hcsearch.scenes import default_panel  # noqa: PLC0415

    size = "x".join(f"{1e3 * side:g}" for side in panel or default_panel(folding.circuit.grid.name))
    facts = {"design": str(folding), "panel_mm": size, "flat_pairs": pairs, "merge": merged}
    return Subject(linkage, scene, formulation, facts)


def _scene(found: dict[str, Any], options: dict[str, Any]) -> Scene:
    """The scene of a file or by its name, with what the options change."""
    from hcsearch.deployment.subjects import scene_named, scene_with  # noqa: PLC0415

    given = dict(found.get("scene", {}))
    named = given.pop("name", "default")
    values = {name: options[name] for name in ("held", "seconds") if options[name] is not None}
    if options["gravity"] is not None:
        values["gravity"] = options["gravity"].split(",")
    return scene_with(scene_named(options["scene_name"] or named), given | values)


def _folding(name: str, db: str) -> Any:
    from hcsearch.cli.show import design_named, split_design  # noqa: PLC0415
    from hcsearch.folding import folding_of, foldings  # noqa: PLC0415

    if not any(mark.isdigit() for mark in name) or not (name[0].isdigit() or ":" in name):
        raise HcsearchError(f"there is no assembly {name!r}: see hcsearch assembly list, or name DESIGN:CREASE")
    text, crease = split_design(name)
    circuit, _ = design_named(text, db)
    if crease is not None:
        return folding_of(circuit, crease)
    found = foldings(circuit)
    if not found:
        raise HcsearchError(f"{text} does not fold into two stacks: choose among hcsearch query 'two_stack'")
    if len(found) > 1:
        creases = ", ".join(str(folding.crease) for folding in found)
        raise HcsearchError(f"{text} has {len(found)} foldings: name one as {text}:CREASE; its creases are {creases}")
    return found[0]


def _panel(text: str | None) -> PanelSize | None:
    if text is None:
        return None
    try:
        length, width, thickness = (float(part) * 1e-3 for part in str(text).split("x"))
    except ValueError as error:
        raise HcsearchError(f"{text!r} is no panel: write length x width x thickness in mm, such as 50x40x6") from error
    if not all(SMALLEST <= side <= LARGEST for side in (length, width, thickness)):
        raise HcsearchError(
            f"{text!r} is no panel: give lengths from {1e3 * SMALLEST:g} to {1e3 * LARGEST:g} mm, such as 50x40x6"
        )
    return (length, width, thickness)
