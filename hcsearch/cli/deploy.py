"""`hcsearch deploy`: the spring-driven deployment of a folding, an assembly, or what a file describes."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option
from hcsearch.errors import HcsearchError

if TYPE_CHECKING:
    from hcsearch.deployment.deploying import Deployment
    from hcsearch.linkage import Linkage
    from hcsearch.scenes import PanelSize

_METHODS = ("bogacki-shampine", "dormand-prince", "dormand-prince-8", "implicit")


@click.command(
    epilog="Example: hcsearch deploy thesis-4x4 --formulation penalty; hcsearch deploy hex:0234435011:1 --explain; "
    "hcsearch deploy unit-i --spring linear:0.05 --output unit-i.csv"
)
@click.argument("subject", metavar="DESIGN:CREASE|ASSEMBLY|FILE.toml")
@click.option("--scene", "scene_name", help="default, earth, thesis, satellite.  [default: default]")
@click.option(
    "--formulation",
    type=click.Choice(("constrained", "compliant", "penalty", "quasistatic")),
    default="constrained",
    show_default=True,
)
@click.option(
    "--method", type=click.Choice(_METHODS), help="Integrator.  [default: dormand-prince; compliant: implicit]"
)
@click.option(
    "--tolerance", type=float, default=1e-6, show_default=True, help="Error of a step, relative and absolute."
)
@click.option("--spring", metavar="LAW", help="Moment-angle law of all hinges, as linear:0.1 (N m/rad).")
@click.option("--springs", "own_springs", multiple=True, metavar="HINGE=LAW", help="Law of one hinge; may be repeated.")
@click.option("--damping", type=float, metavar="C", help="N m s/rad at every hinge.  [default: 0.043 s x stiffness]")
@click.option("--gravity", metavar="X,Y,Z", help="m/s^2, in axes of the flat state seen from +z.")
@click.option(
    "--held", metavar="PANEL|free", help="The panel that stands still.  [default: the bottom pair, or panel 0]"
)
@click.option("--start", type=float, metavar="SHARE", help="Of the folded angles.  [default: 0.999]")
@click.option("--restitution", type=float, metavar="E", help="Of hinge stops, 0 to 1.  [default: 0]")
@click.option("--seconds", type=float, metavar="S", help="To simulate.  [default: 1]")
@click.option("--panel", "panel_text", metavar="LxWxT", help="Size of the panels of a design, in mm.")
@click.option("--flat-pairs", type=click.Choice(("rigid", "hinged")), help="Of a design.  [default: rigid]")
@click.option("--merge", is_flag=True, help="Make mirror pairs of a design's panels one.")
@click.option("--explain", is_flag=True, help="Say what was left out, why it may be, and what it saved.")
@click.option("--json", "as_json", is_flag=True, help="Print plain data.")
@click.option("--output", metavar="FILE", help="Write all states: .csv, .npz or .parquet.")
@click.option("--picture", metavar="FILE", help="Draw fold angles and energies over time: .svg, .png or .pdf.")
@database_option
def deploy(subject: str, scene_name: str | None, as_json: bool, **options: Any) -> None:
    """Simulate the deployment of a folding, of an assembly of the thesis, or of what a file describes.

    It starts at rest in the packed state and ends flat, at rest elsewhere, jammed, or when the time is over. The first
    contact of panels that cut into each other by more than 0.2 mm is told beside.
    """
    from hcsearch.deployment import subjects, telling  # noqa: PLC0415
    from hcsearch.deployment.deploying import deploy as simulated  # noqa: PLC0415

    if options["output"]:
        telling.check_file(options["output"], telling.FORMATS)
    if options["picture"]:
        telling.check_file(options["picture"], telling.PICTURES)
    linkage, given = _subject(subject, options)
    named = given.pop("name", "default")
    scene = subjects.scene_with(subjects.scene_named(scene_name or named), given | _scene_values(options))
    method = options["method"]
    deployment = simulated(linkage, scene, options["formulation"], method=method, tolerance=options["tolerance"])
    told = telling.facts(deployment)
    if options["explain"]:
        told["saved"] = telling.savings(deployment, method=method, tolerance=options["tolerance"])
    if options["output"]:
        telling.save_table(deployment, options["output"])
    if options["picture"]:
        telling.picture(deployment, options["picture"], f"{subject}: {deployment.reason}")
    if as_json:
        click.echo(json.dumps(told, indent=2, allow_nan=False))
    else:
        _print(deployment, told)


def _subject(name: str, options: dict[str, Any]) -> tuple[Linkage, dict[str, Any]]:
    """The linkage that a name or a file tells, and the values of the scene that a file gives."""
    from hcsearch.assemblies import ASSEMBLIES  # noqa: PLC0415
    from hcsearch.deployment.subjects import folding_linkage, read_file  # noqa: PLC0415
    from hcsearch.linkage import Linkage  # noqa: PLC0415

    given: dict[str, Any] = {}
    panel = _panel(options["panel_text"])
    hinged, merged = options["flat_pairs"] == "hinged", options["merge"]
    parameters: dict[str, Any] = {}
    if name.endswith(".toml"):
        found = read_file(name)
        given = dict(found.get("scene", {}))
        name = found["design"] if "design" in found else found["assembly"]
        parameters = dict(found.get("parameters", {}))
        hinged = hinged or found.get("flat_pairs") == "hinged"
        merged = merged or bool(found.get("merge"))
        panel = panel or _panel(found.get("panel_mm"))
    if name in ASSEMBLIES:
        if panel or hinged or merged:
            raise HcsearchError(
                f"{name} is an assembly with sizes of its own: leave out --panel, --flat-pairs, --merge"
            )
        from hcsearch.cli.assembly import parameters_of  # noqa: PLC0415

        assembly = ASSEMBLIES[name]
        return Linkage(assembly.build(parameters_of(assembly, parameters))), given
    if parameters:
        raise HcsearchError(f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly")
    return folding_linkage(_folding(name, options["db"]), panel, hinged=hinged, merged=merged), given


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
    if not all(0.0 < side < math.inf for side in (length, width, thickness)):
        raise HcsearchError(f"{text!r} is no panel: give positive lengths in mm, such as 50x40x6")
    return (length, width, thickness)


def _scene_values(options: dict[str, Any]) -> dict[str, Any]:
    """The values of the scene that the command line gives."""
    names = ("spring", "damping", "held", "start", "restitution", "seconds")
    values = {name: options[name] for name in names if options[name] is not None}
    if options["gravity"] is not None:
        values["gravity"] = options["gravity"].split(",")
    if options["own_springs"]:
        pairs = [text.partition("=") for text in options["own_springs"]]
        for hinge, equals, _ in pairs:
            if not (equals and hinge.isascii() and hinge.isdigit()):
                raise HcsearchError(f"cannot read --springs {hinge!r}: write HINGE=LAW, such as 3=linear:0.2")
        values["springs"] = {hinge: law for hinge, _, law in pairs}
    return values


def _print(deployment: Deployment, told: dict[str, Any]) -> None:
    """The outcome, one fact a line."""
    left, events, arrived = told.pop("left_out"), told.pop("events"), told.pop("arrivals")
    saved = told.pop("saved", None)
    for name, value in told.items():
        shown = "-" if value is None else (f"{value:.6g}" if isinstance(value, float) else value)
        click.echo(f"{name.replace('_', ' '):24}{shown}")
    click.echo(f"{'stops hit':24}{sum(event['kind'] == 'hit' for event in events)}")
    for arrival in arrived[:10]:
        hinges = ", ".join(map(str, arrival["hinges"]))
        what = f"hinge {hinges} {arrival['stop']} at {arrival['speed_rad_s']:.3g} rad/s"
        click.echo(f"{'':24}{arrival['time_s']:.6g} s: {what}")
    if saved is None:
        return
    click.echo("left out")
    for omission in left:
        click.echo(f"  {omission['name']:22}{omission['what']}: {omission['why']}")
        for row in saved:
            if row["name"] == omission["name"]:
                pairs = [f"{key.replace('_', ' ')} {a:.4g} -> {b:.4g}" for key, (a, b) in _numbers(row).items()]
                click.echo(f"{'':24}{', '.join(pairs)}")


def _numbers(row: dict[str, Any]) -> dict[str, tuple[float, float]]:
    names = ("joints", "closure_equations", "evaluations", "milliseconds")
    return {name: (float(row[name][0]), float(row[name][1])) for name in names}
