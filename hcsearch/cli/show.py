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
from hcsearch.system.numbers import short
from hcsearch.system.outputs import check_output
from hcsearch.system.surroundings import default_database

if TYPE_CHECKING:
    from hcsearch.circuit import Circuit
    from hcsearch.folding import Folding


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
    proved to be locked, and for a design named by its id the deployments in the database. The page of a design named by
    its id shows the results of a scene; for a circuit, motions are planned and simulated anew.
    """
    if not as_html and (output or scene or panel or across):
        raise HcsearchError("--output, --scene, --panel and --across apply to a page: add --html")
    from hcsearch.folding import folding_of, foldings, split_crease
    from hcsearch.subjects.designs import design_named

    name, crease = split_crease(design)
    circuit, row = design_named(name, db)
    chosen = foldings(circuit) if crease is None else [folding_of(circuit, crease)]
    if as_html:
        asked = _scene_of_page(row, db, scene, panel, across)
        _write_page(design, circuit, row, chosen, output, db, asked)
        return
    _print_circuit(circuit, row)
    if not chosen:
        click.echo("\nno two-stack folding")
    for folding in chosen:
        _print_folding(folding)
        for tried in row.get("deployments", ()):
            if tried["crease"] == folding.crease:
                click.echo(f"  deployment, {tried['scene']}: {tried['status']}, {tried['reason']}")
                if tried["needed_margin"] is not None:
                    click.echo(f"    {play_sentence(tried['needed_margin'])}")
                click.echo(f"    hcsearch deploy {folding.notation} --scene {shlex.quote(tried['scene'])}{_where(db)}")


def _scene_of_page(row: dict[str, Any], db: str, scene: str | None, panel: str | None, across: str | None) -> str:
    """The name of the scene whose verdicts a page has."""
    from hcsearch.store import open_readonly
    from hcsearch.subjects.scenes import scene_asked_for

    if not row:
        if scene or panel or across:
            raise HcsearchError("a circuit is shown in the scene default: name the design by its id in a database")
        return DEFAULT
    with open_readonly(db) as database:
        return scene_asked_for(database, scene, panel, across)


def _where(db: str) -> str:
    """The option that names the database, where it is not the usual one."""
    return "" if db == default_database() else f" --db {shlex.quote(db)}"


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
    shown: tuple[str, ...] = ("id", "status", "deployable", "flat_pairs", "needed_margin", "least_gap")
    shown += ("deploy_time", "min_clearance", "score")
    facts |= {name.replace("_", " "): _with_unit(name, row[name]) for name in shown if row.get(name) is not None}
    if row.get("needed_margin") is not None:
        facts["play"] = play_sentence(row["needed_margin"])
    for label, value in facts.items():
        click.echo(f"{label:16}{value}")
    click.echo("cells           " + "  ".join(",".join(map(str, cell)) for cell in circuit.cells))


def _with_unit(name: str, value: object) -> str:
    """A value of a column of `designs`, as the table of columns has its unit."""
    from hcsearch.store.conditions import find_quantity

    text = short(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {find_quantity('designs', name).unit}".rstrip()


def _print_folding(folding: Folding) -> None:
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
        _print_mechanism(folding)


def _print_mechanism(folding: Folding) -> None:
    from hcsearch.scenes import default_panel
    from hcsearch.subjects.mechanisms import freedoms_of, lock_sentences

    panel = default_panel(folding.circuit.grid.name)
    for freedoms in freedoms_of(folding, panel):
        click.echo(f"  {freedoms.sentence}")
    for sentence, *more in lock_sentences(folding, panel):
        click.echo(f"  {sentence}")
        for exact in more:
            click.echo(f"    {exact}")


def _write_page(
    design: str, circuit: Circuit, row: dict[str, Any], chosen: list[Folding], output: str | None, db: str, scene: str
) -> None:
    from pathlib import Path

    from hcsearch.report import write_design

    number = int(row["id"]) if row else None
    path = Path(output or f"reports/design-{design.replace(':', '-')}.html")
    check_output(path)
    click.echo(printable(str(write_design(circuit, chosen, path, db=db, number=number, scene=scene))))
