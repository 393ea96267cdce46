"""What `hcsearch deploy` and `hcsearch tune` are given: a folding, an assembly or a file, and the scene it is in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option
from hcsearch.cli.scenes import read_scene, scene_options, with_size
from hcsearch.errors import HcsearchError, SceneError
from hcsearch.scenes import DEFAULT, panel_of, panel_text

if TYPE_CHECKING:
    from hcsearch.deployment.driving import Drives
    from hcsearch.folding import Folding
    from hcsearch.linkage import Linkage
    from hcsearch.scenes import FlatPairs, Scene
    from hcsearch.vocabulary import Formulation

Command = Callable[..., Any]


@dataclass(frozen=True)
class Subject:
    """What is deployed, and its scene, in which panels and flat pairs are those of the linkage.

    facts : what it is, in a file. formulation : what a file names, or None. drives : of hinges, if a file has any.
    """

    linkage: Linkage
    scene: Scene
    formulation: Formulation | None
    facts: dict[str, Any]
    drives: Drives | None = None

    @property
    def key(self) -> dict[str, Any]:
        """What tells it from others among stored evaluations: what it is, with its sizes."""
        if self.scene.panel is None:
            return self.facts
        return self.facts | {
            "panel_mm": panel_text(self.scene.panel),
            "flat_pairs": self.scene.flat_pairs,
            "merge": self.scene.merge,
        }


_MERGE = click.option("--merge", is_flag=True, help="Make the two panels of each mirror pair of a design one.")
_HELD = click.option(
    "--held", metavar="PANEL|free", help="The panel that stands still.  [default: the bottom pair, or panel 0]"
)
_GRAVITY = click.option("--gravity", metavar="X,Y,Z", help="m/s^2, in axes of the flat state seen from +z.")


def subject_options(command: Command) -> Command:
    """The argument, and the options that say what the panels are and what acts on them."""
    return _with(
        command,
        database_option,
        _MERGE,
        _flat_pairs("rigid"),
        click.option(
            "--seconds", type=float, metavar="S", help="To simulate.  [default: 1, longer where the scene is slower]"
        ),
        _HELD,
        _GRAVITY,
        scene_options,
        click.argument("subject", metavar="DESIGN:CREASE|ASSEMBLY|FILE.toml"),
    )


def folding_options(command: Command) -> Command:
    """The same where the subject is a folding, which moves as long as it takes, in any way of joining flat pairs."""
    return _with(
        command,
        database_option,
        _MERGE,
        _flat_pairs("either"),
        _HELD,
        _GRAVITY,
        scene_options,
        click.argument("subject", metavar="DESIGN:CREASE|FILE.toml"),
    )


def _flat_pairs(default: str) -> Command:
    return click.option(
        "--flat-pairs",
        type=click.Choice(("rigid", "hinged")),
        help=f"How the flat pairs of a design are joined.  [default: {default}]",
    )


def _with(command: Command, *options: Command) -> Command:
    for option in options:
        command = option(command)
    return command


def read_subject(name: str, options: dict[str, Any]) -> Subject:
    """What a name or a file stands for, with the options beside; options hold more values of the scene by name."""
    from hcsearch.assemblies import ASSEMBLIES
    from hcsearch.deployment.scene_files import read_file

    found: dict[str, Any] = {}
    if name.endswith(".toml"):
        found = read_file(name)
        if not {"design", "assembly"} & set(found):
            raise SceneError(f"{name} must name a design or an assembly: write design = 'hex:0234550132:4'")
        name = found["design"] if "design" in found else found["assembly"]
    scene, parts = _scene(found, options)
    parameters = dict(found.get("parameters", {}))
    if name in ASSEMBLIES:
        sized = options["panel"] or options["across"] or scene.panel
        if sized or options["merge"] or options["flat_pairs"] or "panel_mm" in found or parts:
            raise HcsearchError(
                f"{name} is an assembly with sizes of its own: leave out --panel, --across, --flat-pairs, --merge"
            )
        return replace(_assembly(name, parameters, scene, found.get("formulation")), drives=_drives(found))
    if parameters:
        raise HcsearchError(f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly")
    subject = _design(folding_named(name, options["db"]), scene, parts, options, found.get("formulation"))
    return replace(subject, drives=_drives(found))


def read_folding(name: str, options: dict[str, Any]) -> tuple[Folding, Scene]:
    """The folding that a name or a file stands for, and its scene, in which panels are settled and flat pairs open."""
    from hcsearch.assemblies import ASSEMBLIES
    from hcsearch.deployment.scene_files import read_file

    found: dict[str, Any] = {}
    if name.endswith(".toml"):
        found = read_file(name)
        if "design" not in found:
            raise SceneError(f"{name} must name a design: write design = 'hex:0234550132:4'")
        if "drive" in found:
            raise SceneError(f"{name} has a drive: give it to hcsearch deploy, or leave out its table [drive]")
        if found.get("formulation", "constrained") != "constrained":
            raise SceneError(f"{name} has formulation = {found['formulation']!r}: drives need 'constrained'")
        name = found["design"]
    if name in ASSEMBLIES:
        raise HcsearchError(f"{name} is an assembly, which has no packed state in stacks: name DESIGN:CREASE")
    folding = folding_named(name, options["db"])
    scene, parts = _scene(found, options)
    if parts:
        raise SceneError(f"a drive needs no {parts[-1]!r}: name a scene, and --flat-pairs or --merge")
    grid = folding.circuit.grid.name
    scene = with_size(scene, options["panel"], options["across"], grid)
    return folding, replace(scene, panel=panel_of(scene, grid))


def _drives(found: dict[str, Any]) -> Drives | None:
    from hcsearch.deployment.driving import drives_in

    return drives_in(found["drive"]) if "drive" in found else None


def _assembly(name: str, parameters: dict[str, Any], scene: Scene, formulation: Formulation | None) -> Subject:
    from hcsearch.assemblies import ASSEMBLIES
    from hcsearch.cli.assembly import parameters_of
    from hcsearch.linkage import Linkage

    assembly = ASSEMBLIES[name]
    linkage = Linkage(assembly.build(parameters_of(assembly, parameters)))
    return Subject(linkage, scene, formulation, {"assembly": name, "parameters": parameters})


def _design(
    folding: Folding, scene: Scene, parts: list[str], options: dict[str, Any], formulation: Formulation | None
) -> Subject:
    """A folding in a scene, as a look of the stage `deployment` takes it where parts of the scene's name say so."""
    from hcsearch.deployment.compiling import compile_scene
    from hcsearch.deployment.looks import Look, first_look, look_parts, scene_of, springs_of
    from hcsearch.deployment.scales import settled
    from hcsearch.deployment.springs import with_springs
    from hcsearch.flat_pairs import folding_linkage

    pairs, springs = look_parts(parts)
    if parts:
        raise SceneError(f"there is nothing called {parts[0]!r} in a scene: see `hcsearch show` for what was tried")
    scene = with_size(scene, options["panel"], options["across"], folding.circuit.grid.name)
    panel = panel_of(scene, folding.circuit.grid.name)
    look = first_look(scene)
    if springs or (pairs is not None and pairs != look.pairs):
        look = Look(pairs or look.pairs, springs)
    linkage = folding_linkage(folding, panel, hinged=look.pairs == "hinged", merged=look.pairs == "merged")
    way: FlatPairs = "hinged" if look.pairs == "hinged" else "rigid"
    if not look.first:
        scene = scene_of(settled(scene, linkage), look)
    if springs:
        compiled = compile_scene(linkage, scene, keep=frozenset({"stops"}))
        scene = with_springs(compiled, springs_of(folding, compiled, springs)).scene
    scene = replace(scene, panel=panel, flat_pairs=way, merge=look.pairs == "merged")
    return Subject(linkage, scene, formulation, {"design": folding.notation})


def _scene(found: dict[str, Any], options: dict[str, Any]) -> tuple[Scene, list[str]]:
    """The scene of a file or by its name, with what the options change, and parts of the name that say how to look."""
    from hcsearch.deployment.looks import look_parts
    from hcsearch.deployment.scene_files import scene_in, scene_with

    base, parts = None, []
    if (text := options["scene"]) is not None and text.strip():
        named = [part.strip() for part in text.split(",")]
        before = list(named)
        look_parts(named)
        parts = before[len(named) :]
        base = read_scene(", ".join(named) or DEFAULT, options["db"])
    elif text is not None:
        base = read_scene(text, options["db"])
    scene = scene_in(found, base=base)
    # of these one command or the other has options
    own = ("spring", "springs", "damping", "start", "restitution", "spring_range")
    names = ("held", "seconds", "gravity", "flat_pairs", *own)
    values = {name: options[name] for name in names if options.get(name) is not None}
    if options["merge"]:
        values["merge"] = True
    return scene_with(scene, values), parts


def folding_named(name: str, db: str) -> Folding:
    """The folding that a name stands for: DESIGN:CREASE, or a design that has one."""
    from hcsearch.cli.show import design_named, split_design
    from hcsearch.folding import folding_of, foldings

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
