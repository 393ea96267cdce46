"""The gallery: what is shown of one design, ready for the template."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup

from hcsearch.circuit import Circuit
from hcsearch.drawing import draw_circuit
from hcsearch.errors import NotationError
from hcsearch.folding import Folding
from hcsearch.report.data import ReportData, Row
from hcsearch.store.columns import Quantity
from hcsearch.vocabulary import STATUSES

# Said by the head and the badge of a card, so not once more among its numbers.
_HEAD = ("id", "two_stack", "untwisted", "deployable")


class FoldingChip(NamedTuple):
    """A folding of a design: its creases, its twist (None: not known), and the fold of each crease, a letter each."""

    creases: str
    twist: int | None
    letters: str
    shown: bool


@dataclass(frozen=True)
class Card:
    """One design.

    classes : what filters look at: `two-stack`, `untwisted`, `deployable`.
    badge : (class, text), the best that is known of the design.
    facts : name and value of each quantity that is known.
    keys : the values to sort by, in the order of `sortable`, as one text; empty for NULL.
    """

    id: object
    n: object
    classes: str
    badge: tuple[str, str]
    picture: Markup
    circuit: str
    array: str
    facts: list[tuple[Quantity, str]]
    keys: str
    chips: list[FoldingChip]


def sortable(data: ReportData) -> list[Quantity]:
    """List the id, and the other numbers in which the designs differ."""
    numbers = [quantity for quantity in data.columns if quantity.kind != "text"]
    return [q for q in numbers if q.name == "id" or len({design.get(q.name) for design in data.designs}) > 1]


def cards(data: ReportData) -> list[Card]:
    """Make a card for each design, in the order given."""
    order = sortable(data)
    return [_card(data, order, design) for design in data.designs]


def _card(data: ReportData, order: Sequence[Quantity], design: Row) -> Card:
    flags = [name for name in ("two_stack", "untwisted", "deployable") if design.get(name)]
    picture, chips = _pictures(design, data.foldings.get(_id(design), ()), data.size)
    facts = [
        (quantity, written(design[quantity.name]))
        for quantity in data.columns
        if quantity.kind != "text" and quantity.name not in _HEAD and design.get(quantity.name) is not None
    ]
    return Card(
        id=design.get("id"),
        n=design.get("n"),
        classes=" ".join(flag.replace("_", "-") for flag in flags),
        badge=_badge(design),
        picture=picture,
        circuit=str(design.get("circuit", "")),
        array=str(design.get("array", "")),
        facts=facts,
        keys=",".join(_key(design.get(quantity.name)) for quantity in order),
        chips=chips,
    )


def _pictures(
    design: Row, foldings: Sequence[Row], size: tuple[float, float] | None
) -> tuple[Markup, list[FoldingChip]]:
    """Draw the best folding, and list all of them to choose from; without any, draw the plain circuit."""
    notation = str(design.get("circuit", ""))
    try:
        circuit = Circuit.from_notation(notation)
    except NotationError:
        return Markup('<p class="nothing">no picture</p>'), []
    best = min(foldings, key=_rank, default=None)
    assignments = [Folding(circuit, int(str(row["crease"]))).assignment for row in foldings]
    chips = [
        FoldingChip(
            creases=f"{row['crease']}|{row['opposite']}",
            twist=None if row.get("twist") is None else int(str(row["twist"])),
            letters="".join(fold[0] for fold in assignment),
            shown=row is best,
        )
        for row, assignment in zip(foldings, assignments, strict=True)
    ]
    shown = next((a for a, chip in zip(assignments, chips, strict=True) if chip.shown), None)
    svg = draw_circuit(circuit.grid, circuit.cells, shown, size=size, title=notation, standalone=False)
    # Trusted: integers and fixed words, and a title that `draw_circuit` escapes.
    return Markup(svg), chips


def _rank(folding: Row) -> tuple[float, ...]:
    """Order foldings as the database does: by status, then least play, lowest dof, lowest crease."""
    status = str(folding.get("status") or "")
    place = STATUSES.index(status) if status in STATUSES else len(STATUSES)
    dof, play = folding.get("dof"), folding.get("needed_margin")
    numbers = [math.inf if value is None else float(str(value)) for value in (play, dof)]
    return not folding.get("untwisted"), place, *numbers, int(str(folding["crease"]))


def _badge(design: Row) -> tuple[str, str]:
    """The status, or what the foldings say while a verdict is missing."""
    if design.get("status") is not None:
        text = str(design["status"])
    elif design.get("untwisted") is not None:
        text = "untwisted" if design["untwisted"] else "twisted" if design.get("two_stack") else "no_folding"
    elif design.get("two_stack") is not None:
        text = "two_stack" if design["two_stack"] else "no_folding"
    else:
        return "unknown", "circuit"
    tone = {"deploys": "good", "untwisted": "good", "two_stack": "fair", "undecided": "fair", "movable": "good"}
    return tone.get(text, "poor"), text.replace("_", " ")


def written(value: object) -> str:
    """Write a number as people read it; `-` for NULL."""
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _key(value: object) -> str:
    return "" if value is None else str(value)


def _id(design: Row) -> int:
    return int(str(design.get("id", 0)))
