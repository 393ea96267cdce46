"""`hcsearch show`: one design, folding, assembly or pattern in full."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from hcsearch.basics.errors import HcsearchError, printable
from hcsearch.basics.vocabulary import play_sentence
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch.api.showing import ShownDesign
    from hcsearch.designs.folding import Folding
    from hcsearch.store.quantity import Quantity


@click.command(
    epilog=examples_epilog(
        "hcsearch show 17:4",
        "hcsearch show hex:0234550132",
        "hcsearch show 17 --html --output design.html",
        "hcsearch show unit-ii --html",
        "hcsearch show strip.fold --html",
        "hcsearch show springs.toml --html",
    )
)
@click.argument("design", metavar="DESIGN[:CREASE]|ASSEMBLY|FILE.toml|FILE.fold")
@database_option
@scene_options
@click.option("--html", "as_html", is_flag=True, help="Write a page with all results, plots, and motions to play.")
@click.option(
    "--output",
    metavar="FILE",
    help="The file of the page.  [default: reports/design-DESIGN.html, reports/assembly-ASSEMBLY.html, "
    "reports/pattern-FILE.html or, of a file .toml, reports/case-FILE.html]",
)
def show(design: str, db: str, scene: str | None, panel: str | None, as_html: bool, output: str | None) -> None:
    """Print a design and its foldings, an assembly of the thesis or a pattern of your own, or write a page.

    A design is named by its id in the database or by the notation of its circuit, which may be in any position, order
    or direction and needs no database. DESIGN:CREASE shows one folding. Creases have the numbers of the canonical
    circuit, which the first line shows.

    For foldings without twist the command prints the degrees of freedom and whether the folded or the flat state is
    proved to be locked, and for a design named by its id the paths and deployments in the database. Status and numbers
    are those in a scene, and so are all results on the page; for a circuit, motions are planned and simulated anew.

    For an assembly, the command prints its properties like `hcsearch assembly`, and the page plays its motion by
    springs. For a pattern of panels, .fold, .cp, .opx or .svg, or a model .urdf, .xml or .mjcf, it prints the
    degrees of freedom and the locks, and the page also plays the planned path; a file that draws a design stands for
    it.

    FILE.toml is a scene that names a folding, an assembly or a pattern, as `hcsearch tune` and `hcsearch drive` write
    it. The command shows what it names, with these sizes, and the page plays its motion with these springs or drives.
    """
    if output and not as_html:
        raise HcsearchError("--output applies to a page: add --html")
    from hcsearch.api import showing

    if as_html:
        click.echo(printable(str(showing.show_page(design, output, db=db, scene=scene, panel=panel))))
        return
    shown = showing.show(design, db=db, scene=scene, panel=panel)
    if not isinstance(shown, showing.ShownDesign):
        for label, text in shown.rows():
            click.echo(f"{label:21}{text}")
        return
    _print_circuit(shown)
    if not shown.foldings:
        click.echo(f"\nno two-stack folding: {shown.no_folding_reason}")
    for folding in shown.foldings:
        _print_folding(folding, shown.linking_number(folding))
        for sentence, *details in shown.sentences(folding):
            click.echo("\n    ".join([f"  {sentence}", *details]))


def _print_circuit(shown: ShownDesign) -> None:
    circuit, array, stored = shown.circuit, shown.circuit.array, shown.stored
    facts: dict[str, object] = {
        "circuit": circuit.notation,
        "array": array.canonical().notation,
        "panels": circuit.n,
        "slits": len(array.edges()) - circuit.n,
        "symmetry": circuit.symmetry,
        "array symmetry": array.symmetry,
        "orbit size": circuit.orbit_size,
        "fixed copies": circuit.n_fixed,
    }
    if stored is not None:
        facts |= {"id": stored.number, "scene": stored.scene, "status": stored.row["status"] or "not judged"}
        facts |= {} if stored.joining is None else {"flat pairs": stored.joining}
        facts |= {quantity.name.replace("_", " "): _with_unit(quantity, value) for quantity, value in stored.quantities}
        if stored.row["needed_margin"] is not None:
            facts["play"] = play_sentence(stored.row["needed_margin"])
    for label, value in facts.items():
        click.echo(f"{label:16}{value}")
    click.echo("cells           " + "  ".join(",".join(map(str, cell)) for cell in circuit.cells))


def _with_unit(quantity: Quantity, value: object) -> str:
    if quantity.kind == "boolean":
        return "yes" if value else "no"
    text = short_number(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {quantity.unit}".rstrip()


def _print_folding(folding: Folding, twist: int) -> None:
    n = folding.circuit.n
    click.echo(f"\nfolding {folding.crease}: flat creases {folding.crease} and {folding.opposite}, twist {twist}")
    for label, stack in zip(("first", "second"), folding.stacks, strict=True):
        click.echo(f"  {label} stack, lowest panel first: {' '.join(map(str, stack))}")
    for kind in ("valley", "mountain"):
        creases = [str(k) for k, assigned in enumerate(folding.assignment) if assigned == kind]
        face = "top" if kind == "valley" else "bottom"
        click.echo(f"  {kind} creases, hinges on the {face} face: {' '.join(creases)}")
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    click.echo(f"  flat creases (the face of a hinge, if there is one): {flats}")
