"""A design and its foldings in words, as `hcsearch show` prints them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hcsearch.basics.vocabulary import play_sentence
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.stored_designs import StoredDesign
from hcsearch.system.terminal import short_number


def design_facts(circuit: Circuit, stored: StoredDesign | None) -> dict[str, Any]:
    """Return the properties of a circuit, and the results on its design in a database."""
    array = circuit.array
    facts: dict[str, Any] = {
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
    return facts


def _with_unit(quantity: Quantity, value: object) -> str:
    if quantity.kind == "boolean":
        return "yes" if value else "no"
    text = short_number(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {quantity.unit}".rstrip()


def folding_lines(folding: Folding) -> Iterator[str]:
    """Yield the flat creases, the stacks and the hinges of a folding."""
    n = folding.circuit.n
    yield f"\nfolding {folding.crease}: flat creases {folding.crease} and {folding.opposite}, twist {twist(folding)}"
    for label, stack in zip(("first", "second"), folding.stacks, strict=True):
        yield f"  {label} stack, lowest panel first: {' '.join(map(str, stack))}"
    for kind in ("valley", "mountain"):
        creases = [str(k) for k, assigned in enumerate(folding.assignment) if assigned == kind]
        face = "top" if kind == "valley" else "bottom"
        yield f"  {kind} creases, hinges on the {face} face: {' '.join(creases)}"
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    yield f"  flat creases (the face of a hinge, if there is one): {flats}"
