"""`hcsearch show`: one design or one folding in full."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option, examples
from hcsearch.cli.scenes import scene_options
from hcsearch.errors import HcsearchError, printable
from hcsearch.play import play_sentence
from hcsearch.scenes import DEFAULT
from hcsearch.system.machine import default_database
from hcsearch.system.outputs import check_output
from hcsearch.system.terminal import short

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from hcsearch.circuit import Circuit
    from hcsearch.folding import Folding
    from hcsearch.scenes import PanelSize


@click.command(
    epilog=examples(
        "hcsearch show 17:4", "hcsearch show hex:0234550132", "hcsearch show 17 --html --output design.html"
    )
)
@click.argument("design", metavar="DESIGN[:CREASE]")
@database_option
@scene_options
@click.option("--html", "as_html", is_flag=True, help="Write a page with all results, plots, and motions to play.")
@click.option("--output", metavar="FILE", help="The file of the page.  [default: reports/design-DESIGN.html]")
def show(
    design: str,
    db: str,
    scene: str | None,
    panel: str | None,
    across: str | None,
    as_html: bool,
    output: str | None,
) -> None:
    """Print a design and its foldings, or write a page.

    A design is named by its id in the database or by the notation of its circuit, which may be in any position, order
    or direction and needs no database. DESIGN:CREASE shows one folding. Creases have the numbers of the canonical
    circuit, which the first line shows.

    For foldings without twist the command prints the degrees of freedom and whether the folded or the flat state is
    proved to be locked, and for a design named by its id the paths and deployments in the database. Status and numbers
    are those in a scene, and so are all results on the page; for a circuit, motions are planned and simulated anew.
    """
    if output and not as_html:
        raise HcsearchError("--output applies to a page: add --html")
    from hcsearch.folding import folding_of, foldings, split_crease, why_none
    from hcsearch.subjects.designs import design_named

    if not design[:1].isdigit() and ":" not in design:
        raise _unknown(design)
    name, crease = split_crease(design)
    circuit, number = design_named(name, db)
    chosen = foldings(circuit) if crease is None else [folding_of(circuit, crease)]
    if as_html:
        asked = _scene_of_page(circuit, number, db, scene, panel, across)
        _write_page(design, circuit, number, chosen, output, db, asked)
    elif number is None:
        size = _panel_asked_for(circuit, db, scene, panel, across)
        _print_circuit(circuit, {})
        _print_foldings(chosen, size, why_none(circuit.n))
    else:
        _print_design(circuit, number, chosen, db, scene, panel, across)


def _unknown(name: str) -> HcsearchError:
    from hcsearch.assemblies import ASSEMBLIES

    if name in ASSEMBLIES:
        return HcsearchError(f"{name} is an assembly: see hcsearch assembly {name}")
    return HcsearchError(f"{name!r} is no design: give an id, or the notation of a circuit such as hex:0234550132")


def _panel_asked_for(circuit: Circuit, db: str, scene: str | None, panel: str | None, across: str | None) -> PanelSize:
    """The size of panels of a circuit that no database names, m."""
    from hcsearch.subjects.reading import read_scene_of
    from hcsearch.subjects.requests import Request

    panel_ = read_scene_of(Request(circuit.notation, db, scene, panel, across), circuit.grid.name).panel
    assert panel_ is not None
    return panel_


def _scene_of_page(
    circuit: Circuit, number: int | None, db: str, scene: str | None, panel: str | None, across: str | None
) -> str:
    """The name of the scene whose verdicts a page has."""
    from hcsearch.store import open_readonly
    from hcsearch.subjects.scenes import scene_asked_for

    if number is None:
        if scene or panel or across:
            raise HcsearchError("a circuit is shown in the scene default: name the design by its id in a database")
        return DEFAULT
    with open_readonly(db) as database:
        return scene_asked_for(database, scene, panel, across, grid=circuit.grid.name)


def _print_design(
    circuit: Circuit,
    number: int,
    chosen: list[Folding],
    db: str,
    scene: str | None,
    panel: str | None,
    across: str | None,
) -> None:
    """A design of a database: its verdict in a scene, and motions of its foldings, in all scenes or in that one."""
    from hcsearch.folding import why_none
    from hcsearch.scenes import panel_of
    from hcsearch.store import best_creases, find_design, find_verdict, open_readonly
    from hcsearch.subjects.scenes import scene_asked_for, stored_scene

    with open_readonly(db) as database:
        asked = scene_asked_for(database, scene, panel, across, grid=circuit.grid.name)
        row = find_design(database, str(number), asked)
        best = best_creases(database, [number], asked).get(number)
        rows = [*row["motions"], *row["deployments"]]
        places = {(one["crease"], one.get("base", one["scene"])) for one in rows}
        verdicts = {place: find_verdict(database, number, *place) for place in places}
        size = panel_of(stored_scene(database, asked), circuit.grid.name)
    if scene or panel or across:
        row["motions"] = [one for one in row["motions"] if one["scene"] == asked]
        row["deployments"] = [one for one in row["deployments"] if one["base"] == asked]
    _print_circuit(circuit, row | {"scene": asked, "best": best})

    def tell(folding: Folding) -> None:
        _print_motions(folding, row, verdicts, db)

    _print_foldings(chosen, size, why_none(circuit.n), tell)


def _print_foldings(
    chosen: list[Folding], panel: PanelSize, why: str, tell: Callable[[Folding], None] = lambda _folding: None
) -> None:
    """Foldings with panels of a size. why : there are none. tell : prints what is known of one beside."""
    if not chosen:
        click.echo(f"\nno two-stack folding: {why}")
    for folding in chosen:
        _print_folding(folding, panel)
        tell(folding)


def _print_motions(folding: Folding, row: dict[str, Any], verdicts: Mapping[tuple[int, str], Any], db: str) -> None:
    """The paths and the deployments of a folding that a database holds, with the commands that repeat them."""
    from hcsearch.report.reasons import asked_scene, flat_pairs_in, way_option

    deployed = {
        (one["crease"], one["base"]): flat_pairs_in(one) for one in row["deployments"] if one["status"] == "deploys"
    }
    for path in row["motions"]:
        if path["crease"] != folding.crease:
            continue
        if path["flat_pairs"] is None:
            click.echo(f"  {path['scene']}: {path['reason']}")
            continue
        play = f"{path['needed_margin']:.4g} mm of play on every face"
        click.echo(f"  path, {path['scene']}: proved, flat pairs {path['flat_pairs']}, with {play}")
        other = deployed.get((folding.crease, path["scene"]), path["flat_pairs"]) != path["flat_pairs"]
        way = way_option(path["flat_pairs"]) if other else ""
        where = "" if path["scene"] == DEFAULT else f" --scene {shlex.quote(path['scene'])}"
        click.echo(f"    hcsearch drive {row['id']}:{folding.crease}{where}{_where(db)}{way}")
    for tried in row["deployments"]:
        if tried["crease"] == folding.crease:
            click.echo(f"  deployment, {tried['scene']}: {tried['status']}, {tried['reason']}")
            if tried["needed_margin"] is not None:
                click.echo(f"    {play_sentence(tried['needed_margin'])}")
            scene = asked_scene(tried, verdicts[folding.crease, tried["base"]])
            click.echo(f"    hcsearch deploy {folding.notation} --scene {shlex.quote(scene)}{_where(db)}")


def _where(db: str) -> str:
    """The option that names the database, where it is not the usual one."""
    from hcsearch.store.location import parse_location

    # as messages show it: a terminal may lack marks of a path, and a URL may hold a password
    return "" if db == default_database() else f" --db {shlex.quote(parse_location(db).text)}"


def _print_circuit(circuit: Circuit, row: dict[str, Any]) -> None:
    array = circuit.array
    slits = len(array.edges()) - circuit.n
    facts: dict[str, object] = {
        "circuit": circuit.notation,
        "array": array.canonical().notation,
        "panels": circuit.n,
        "slits": slits,
        "symmetry": circuit.symmetry,
        "array symmetry": array.symmetry,
        "orbit size": circuit.orbit_size,
        "fixed copies": circuit.n_fixed,
    }
    if row:
        facts |= {"id": row["id"], "scene": row["scene"], "status": row["status"] or "not judged"}
        facts |= _joined(row)
    shown = ("deployable", "needed_margin", "least_gap", "deploy_time", "min_clearance", "score")
    facts |= {name.replace("_", " "): _with_unit(name, row[name]) for name in shown if row.get(name) is not None}
    if row.get("needed_margin") is not None:
        facts["play"] = play_sentence(row["needed_margin"])
    for label, value in facts.items():
        click.echo(f"{label:16}{value}")
    click.echo("cells           " + "  ".join(",".join(map(str, cell)) for cell in circuit.cells))


def _joined(row: dict[str, Any]) -> dict[str, object]:
    """How flat pairs are joined in the motion that gave a design its status, of which its numbers are."""
    from hcsearch.report.reasons import flat_pairs_in

    if row["status"] == "movable":
        return {"flat pairs": f"{row['flat_pairs']}, in the proved path of folding {row['best']}"}
    own = (one for one in row["deployments"] if (one["crease"], one["base"]) == (row["best"], row["scene"]))
    deploys = next((one for one in own if one["status"] == "deploys"), None)
    if deploys is None:
        return {}
    return {"flat pairs": f"{flat_pairs_in(deploys)}, in the deployment of folding {row['best']}"}


def _with_unit(name: str, value: object) -> str:
    """A value of a column of `designs`, as the table of columns has its unit."""
    from hcsearch.store.conditions import find_quantity

    if find_quantity("designs", name).kind == "boolean":
        return "yes" if value else "no"
    text = short(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {find_quantity('designs', name).unit}".rstrip()


def _print_folding(folding: Folding, panel: PanelSize) -> None:
    from hcsearch.twisting import twist

    n = folding.circuit.n
    lk = twist(folding)
    click.echo(f"\nfolding {folding.crease}: flat creases {folding.crease} and {folding.opposite}, twist {lk}")
    for label, stack in zip(("first", "second"), folding.stacks, strict=True):
        click.echo(f"  {label} stack, lowest panel first: {' '.join(map(str, stack))}")
    for kind in ("valley", "mountain"):
        creases = [str(k) for k, assigned in enumerate(folding.assignment) if assigned == kind]
        face = "top" if kind == "valley" else "bottom"
        click.echo(f"  {kind} creases, hinges on the {face} face: {' '.join(creases)}")
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    click.echo(f"  flat creases (the face of a hinge, if there is one): {flats}")
    if lk == 0:
        _print_mechanism(folding, panel)


def _print_mechanism(folding: Folding, panel: PanelSize) -> None:
    from hcsearch.subjects.mechanisms import freedoms_of, lock_sentences

    for freedoms in freedoms_of(folding, panel):
        click.echo(f"  {freedoms.sentence}")
    for sentence, *more in lock_sentences(folding, panel):
        click.echo(f"  {sentence}")
        for exact in more:
            click.echo(f"    {exact}")


def _write_page(
    design: str,
    circuit: Circuit,
    number: int | None,
    chosen: list[Folding],
    output: str | None,
    db: str,
    scene: str,
) -> None:
    from pathlib import Path

    from hcsearch.report import write_design

    path = Path(output or f"reports/design-{design.replace(':', '-')}.html")
    check_output(path)
    click.echo(printable(str(write_design(circuit, chosen, path, db=db, number=number, scene=scene))))
