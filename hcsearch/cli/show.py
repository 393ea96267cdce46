"""`hcsearch show`: one design or one folding in full."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import database_option
from hcsearch.system.surroundings import default_database

if TYPE_CHECKING:
    from hcsearch.circuit import Circuit
    from hcsearch.folding import Folding
    from hcsearch.linkage import Linkage
    from hcsearch.typing import Reals


@click.command(epilog="Example: hcsearch show 17:4, or without a database: hcsearch show hex:0234550132")
@click.argument("design", metavar="DESIGN[:CREASE]")
@database_option
def show(design: str, db: str) -> None:
    """Print a design, named by its id or its circuit notation, and its foldings (or only the one at CREASE).

    Untwisted ones with their degrees of freedom, whether an end of the motion is proved locked, and, of a design named
    by its id, the deployments that are in the database.

    A circuit notation needs no database; it may be in any position, order or direction. Creases are numbered in the
    canonical order that the first lines show.
    """
    from hcsearch.folding import folding_of, foldings, split_crease
    from hcsearch.subjects.designs import design_named

    name, crease = split_crease(design)
    circuit, row = design_named(name, db)
    chosen = foldings(circuit) if crease is None else [folding_of(circuit, crease)]
    _print_circuit(circuit, row)
    for folding in chosen:
        _print_folding(folding)
        for tried in row.get("deployments", ()):
            if tried["crease"] == folding.crease:
                click.echo(f"  deployment, {tried['scene']}: {tried['status']}, {tried['reason']}")
                click.echo(f"    hcsearch deploy {folding.notation} --scene {shlex.quote(tried['scene'])}{_where(db)}")


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
    facts |= {name.replace("_", " "): row[name] for name in shown if row.get(name) is not None}
    for label, value in facts.items():
        click.echo(f"{label:16}{value}")
    click.echo("cells           " + "  ".join(",".join(map(str, cell)) for cell in circuit.cells))


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
    click.echo(f"  flat creases (face for a hinge, where one is wanted): {flats}")
    if lk == 0:
        _print_mechanism(folding)


def _print_mechanism(folding: Folding) -> None:
    from hcsearch.kinematics.generic import generic_rank
    from hcsearch.kinematics.rank import rank_at
    from hcsearch.linkage import Linkage
    from hcsearch.scenes import default_panel

    panel = default_panel(folding.circuit.grid.name)

    def freedoms(linkage: Linkage) -> str:
        ranks = (generic_rank(linkage), rank_at(linkage, linkage.folded), rank_at(linkage, linkage.flat))
        moving, folded, flat = ("undecided" if rank.nullity is None else rank.nullity for rank in ranks)
        kutzbach = linkage.pattern.kutzbach
        return f"{moving} moving, {folded} folded, {flat} flat at first order; Kutzbach {kutzbach}"

    click.echo(f"  freedoms, flat pairs hinged: {freedoms(Linkage(folding.pattern(panel, hinged=True)))}")
    if folding.mirror_pairs:
        pairs = ", ".join(f"{a} {b}" for a, b in folding.mirror_pairs)
        click.echo(f"  freedoms, panels {pairs} merged: {freedoms(Linkage(folding.pattern(panel, merged=True)))}")
    rigid, hinged = Linkage(folding.pattern(panel)), Linkage(folding.pattern(panel, hinged=True))
    _print_lock("folded", {"rigid": (rigid, rigid.folded), "hinged": (hinged, hinged.folded)})
    _print_lock("flat", {"rigid": (rigid, rigid.flat), "hinged": (hinged, hinged.flat)})


def _print_lock(end: str, ways: dict[str, tuple[Linkage, Reals]]) -> None:
    """Whether an end is locked with rigid, and if so with hinged flat pairs, and how tight: hinged ones move more."""
    from hcsearch.locks.proofs import lock_at
    from hcsearch.locks.tightness import tightness

    for pairs, (linkage, angles) in ways.items():
        lock = lock_at(linkage, angles)
        if not lock.locked:
            said = "rigid or hinged" if pairs == "rigid" else pairs
            click.echo(f"  {end}, flat pairs {said}: not proved locked, {lock.reason}")
            return
        proof = "exact" if lock.exact else "numerical"
        click.echo(f"  {end}, flat pairs {pairs}: locked ({proof} proof), {lock.reason}")
        tight = tightness(linkage, angles)
        if tight is not None:
            click.echo(f"    {tight.sentence}")
