"""`hcsearch show`: one design or one folding in full."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.errors import HcsearchError, printable
from hcsearch.basics.vocabulary import play_sentence
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.system.machine import default_database
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from hcsearch.designs.circuit import Circuit
    from hcsearch.designs.folding import Folding
    from hcsearch.designs.panel_sizes import PanelSize


@click.command(
    epilog=examples_epilog(
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
    from hcsearch.api import showing
    from hcsearch.designs.folding import no_folding_reason

    if as_html:
        click.echo(printable(str(showing.show_page(design, output, db=db, scene=scene, panel=panel))))
        return
    shown = showing.show(design, db=db, scene=scene, panel=panel)
    row = dict(shown.row) | ({} if shown.number is None else {"scene": shown.scene, "best": shown.best})
    _print_circuit(shown.circuit, row)

    def tell(folding: Folding) -> None:
        if shown.number is not None:
            _print_motions(folding, row, shown.verdicts, db)

    _print_foldings(shown.foldings, shown.panel, no_folding_reason(shown.circuit.n), tell)


def _print_foldings(chosen: Sequence[Folding], panel: PanelSize, why: str, tell: Callable[[Folding], None]) -> None:
    """Print foldings with panels of a size. why : the reason for none. tell : prints further results on a folding."""
    if not chosen:
        click.echo(f"\nno two-stack folding: {why}")
    for folding in chosen:
        _print_folding(folding, panel)
        tell(folding)


def _print_motions(folding: Folding, row: dict[str, Any], verdicts: Mapping[tuple[int, str], Any], db: str) -> None:
    """The paths and the deployments of a folding that a database holds, with the commands that repeat them."""
    from hcsearch.web.report.reasons import deployment_scene_name, way_option_text

    deployed = {(one["crease"], one["base"]): one["pairs"] for one in row["deployments"] if one["status"] == "deploys"}
    for path in row["motions"]:
        if path["crease"] != folding.crease:
            continue
        if path["flat_pairs"] is None:
            click.echo(f"  {path['scene']}: {path['reason']}")
            continue
        play = f"{path['needed_margin']:.4g} mm of play on every face"
        click.echo(f"  path, {path['scene']}: proved, flat pairs {path['flat_pairs']}, with {play}")
        other = deployed.get((folding.crease, path["scene"]), path["flat_pairs"]) != path["flat_pairs"]
        way = way_option_text(path["flat_pairs"]) if other else ""
        where = "" if path["scene"] == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(path['scene'])}"
        click.echo(f"    hcsearch drive {row['id']}:{folding.crease}{where}{_where(db)}{way}")
    for tried in row["deployments"]:
        if tried["crease"] == folding.crease:
            click.echo(f"  deployment, {tried['scene']}: {tried['status']}, {tried['reason']}")
            if tried["needed_margin"] is not None:
                click.echo(f"    {play_sentence(tried['needed_margin'])}")
            scene = deployment_scene_name(tried, verdicts[folding.crease, tried["base"]])
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
    if row["status"] == "movable":
        return {"flat pairs": f"{row['flat_pairs']}, in the proved path of folding {row['best']}"}
    own = (one for one in row["deployments"] if (one["crease"], one["base"]) == (row["best"], row["scene"]))
    deploys = next((one for one in own if one["status"] == "deploys"), None)
    if deploys is None:
        return {}
    return {"flat pairs": f"{deploys['pairs']}, in the deployment of folding {row['best']}"}


def _with_unit(name: str, value: object) -> str:
    """A value of a column of `designs`, as the table of columns has its unit."""
    from hcsearch.store.conditions import find_quantity

    if find_quantity("designs", name).kind == "boolean":
        return "yes" if value else "no"
    text = short_number(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {find_quantity('designs', name).unit}".rstrip()


def _print_folding(folding: Folding, panel: PanelSize) -> None:
    from hcsearch.designs.twisting import twist

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
    from hcsearch.cases.mechanisms import freedoms_of, lock_sentences

    for freedoms in freedoms_of(folding, panel):
        click.echo(f"  {freedoms.sentence}")
    for sentence, *more in lock_sentences(folding, panel):
        click.echo(f"  {sentence}")
        for exact in more:
            click.echo(f"    {exact}")
