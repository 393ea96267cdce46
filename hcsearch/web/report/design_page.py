"""The page of one design: the template filled with everything known of it. Nothing in it comes from outside."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.shape.drawing import draw_circuit
from hcsearch.store.columns import DESIGNS, FOLDINGS, Quantity
from hcsearch.web.player import player_script
from hcsearch.web.player.player_page import as_script, digest_of
from hcsearch.web.report.design_data import DesignData, ShownFolding
from hcsearch.web.report.plots import swatch
from hcsearch.web.report.templating import environment, joined_script, page_style, written

_ELSEWHERE = ("id", "array", "circuit", "grid", "design_id", "crease", "opposite", "twist", "untwisted", "status")
"""Quantities that stand elsewhere on the page."""


def render_design(data: DesignData) -> str:
    """Write the HTML page of a design; all text is escaped, and its policy admits its scripts alone."""
    payloads = [motion.payload for shown in data.foldings for motion in shown.motions]
    scripts = [*([player_script()] if payloads else []), joined_script(("copy", "design"))]
    return (
        environment()
        .get_template("design.html")
        .render(
            data=data,
            facts=_facts(DESIGNS, data.row),
            status=data.row.get("status"),
            folding_facts=folding_facts,
            picture=lambda folding: _picture(folding.circuit, data.size, folding.notation, folding.assignment),
            circuit_picture=lambda: _picture(Circuit.from_notation(data.notation), data.size, data.notation),
            # Trusted: what the plots wrote escapes its texts itself.
            drawn=Markup,
            swatch=lambda k: Markup(swatch(k)),
            payload=Markup(as_script(payloads)),
            style=Markup(page_style("style.css", "design.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )


def _picture(
    circuit: Circuit, size: tuple[float, float] | None, title: str, assignment: Sequence[str] | None = None
) -> Markup:
    svg = draw_circuit(circuit.grid, circuit.cells, assignment, numbers=True, size=size, title=title, standalone=False)
    # Trusted: integers and fixed words, and a title that `draw_circuit` escapes.
    return Markup(svg)


def folding_facts(shown: ShownFolding) -> list[tuple[str, str, str]]:
    """Name, value and note of each number that is known of a folding."""
    room, folding = shown.room, shown.folding
    n = folding.circuit.n
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    made = [
        ("stowed", room.packed.text, "the smallest upright box around all panels, packed, flat pairs rigid"),
        ("flat", room.flat.text, "the smallest upright box around all panels, flat"),
        ("box, packed over flat", f"{room.packed.volume / room.flat.volume:.4g}", "volumes of these boxes"),
        (
            "panels over packed box",
            f"{room.area * room.flat.height / room.packed.volume:.4g}",
            "volume of the panels over that of the packed box",
        ),
        ("mass of the panels", f"{1e3 * room.mass:.4g} g", "density times area times thickness"),
        ("first stack", " ".join(map(str, folding.stacks[0])), "panels, the lowest first"),
        ("second stack", " ".join(map(str, folding.stacks[1])), "panels, the lowest first"),
        ("valley creases", _creases(folding, "valley"), "hinges on the top face"),
        ("mountain creases", _creases(folding, "mountain"), "hinges on the bottom face"),
        ("flat creases", flats, "with the face of a hinge, if there is one"),
    ]
    return _facts(FOLDINGS, shown.row) + made


def _creases(folding: Folding, kind: str) -> str:
    return " ".join(str(k) for k, fold in enumerate(folding.assignment) if fold == kind)


def _facts(quantities: tuple[Quantity, ...], row: object) -> list[tuple[str, str, str]]:
    assert hasattr(row, "get")
    facts = []
    for quantity in quantities:
        value = row.get(quantity.name)
        if value is None or quantity.name in _ELSEWHERE:
            continue
        text = ("yes" if value else "no") if quantity.kind == "boolean" else written(value)
        facts.append((quantity.title, f"{text} {quantity.unit}".rstrip(), quantity.note))
    return facts
