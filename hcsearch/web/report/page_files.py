"""Self-contained pages on a query and on a design, written from templates and data."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from hcsearch.basics.errors import HcsearchError, QueryError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.export.bill_texts import bill_summary, section_cells
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.shape.drawing import draw_circuit
from hcsearch.store import Database
from hcsearch.store.columns import DESIGN_QUANTITIES, FOLDING_QUANTITIES
from hcsearch.store.empty_results import empty_result_reason
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.case import Case
from hcsearch.subjects.design_cases import CircuitCase
from hcsearch.system.outputs import write_output
from hcsearch.system.work_steps import work_step
from hcsearch.web.player import player_script
from hcsearch.web.player.player_page import as_script, digest_of
from hcsearch.web.report.data import BEST_FIRST_ORDER, ReportData, fetch_report_data
from hcsearch.web.report.deciding_motions import with_first_motion
from hcsearch.web.report.design_data import DesignData, ShownFolding, fetch_design_data
from hcsearch.web.report.linkage_page import fetch_linkage_data, render_linkage
from hcsearch.web.report.plots import curve_swatch
from hcsearch.web.report.script_data import drawn_crease, first_design, page_data
from hcsearch.web.report.sheet_page import sheet_cells, sheet_drawings
from hcsearch.web.report.templating import joined_script, page_style, template_environment, written_value

_ELSEWHERE = ("id", "array", "circuit", "grid", "design_id", "crease", "opposite", "twist", "untwisted", "status")
"""Quantities that appear elsewhere on the page."""


def render_design(data: DesignData) -> str:
    """Return the HTML page of a design; all text is escaped, and its policy admits only its own scripts."""
    payloads = [motion.payload for shown in data.foldings for motion in shown.motions]
    scripts = [*([player_script()] if payloads else []), joined_script(("copy", "address", "design"))]
    return (
        template_environment()
        .get_template("design.html")
        .render(
            data=data,
            facts=_facts(DESIGN_QUANTITIES, data.row),
            status=data.row.get("status"),
            folding_facts=folding_facts,
            sheet_drawings=sheet_drawings,
            sheet_cells=sheet_cells,
            bill_summary=bill_summary,
            section_cells=section_cells,
            picture=lambda folding: _picture(folding.circuit, data.size, folding.notation, folding.assignment),
            circuit_picture=lambda: _picture(Circuit.from_notation(data.notation), data.size, data.notation),
            swatch=lambda k: Markup(curve_swatch(k)),
            payload=Markup(as_script(payloads)),
            style=Markup(page_style("style.css", "plots.css", "design.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )


def _picture(
    circuit: Circuit, size: tuple[float, float] | None, title: str, assignment: Sequence[str] | None = None
) -> Markup:
    svg = draw_circuit(
        *(circuit.grid, circuit.cells, assignment),
        numbers=True,
        size=size,
        title=title,
        standalone=False,
        parts=True,
    )
    triangles = " triangles" if circuit.grid.edges_per_cell == 3 else ""
    # Trusted: integers and fixed words, and a title that `draw_circuit` escapes.
    return Markup(f'<div class="picture{triangles}">{svg}</div>')


def folding_facts(shown: ShownFolding) -> list[tuple[str, str, str]]:
    """Return name, value and note of each known quantity of a folding."""
    room, folding = shown.room, shown.folding
    n = folding.circuit.n
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    computed = [
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
    return _facts(FOLDING_QUANTITIES, shown.row) + computed


def _creases(folding: Folding, kind: str) -> str:
    return " ".join(str(k) for k, fold in enumerate(folding.assignment) if fold == kind)


def _facts(quantities: tuple[Quantity, ...], row: object) -> list[tuple[str, str, str]]:
    assert hasattr(row, "get")
    facts = []
    for quantity in quantities:
        value = row.get(quantity.name)
        if value is None or quantity.name in _ELSEWHERE:
            continue
        text = ("yes" if value else "no") if quantity.kind == "boolean" else written_value(value)
        facts.append((quantity.title, f"{text} {quantity.unit}".rstrip(), quantity.note))
    return facts


CensusTable = tuple[list[str], list[tuple[int | None, list[int]]]]
"""Column names, and rows of a number of foldings with the count of designs in each column."""

CARD_SCRIPT_MODULES = (
    *("geometry", "address", "table", "parts", "columns", "compare", "card", "motions", "large", "dialog", "first"),
    *("scale", "front", "scatter", "plotting", "copy"),
)
"""Modules of the script that draw designs, for the server too, each after those that it uses."""
SCRIPT_MODULES = (
    *CARD_SCRIPT_MODULES,
    "grammar",
    "nearest",
    "envelopes",
    "conditions",
    "facets",
    "gallery",
    "rows",
    "main",
)
"""Modules of the script, each after those that it uses."""


@work_step("drawing the designs")
def render_report(data: ReportData) -> str:
    """Return the HTML page of a report, without external resources and with all text escaped.

    The page's policy admits its scripts by their hashes, so that no text in the data can run. The player is one of
    them if the data contain motions.
    """
    scripts = [*([player_script()] if data.players else []), joined_script(SCRIPT_MODULES)]
    return (
        template_environment()
        .get_template("report.html")
        .render(
            data=data,
            census=census_table(data),
            swatch=lambda k: Markup(curve_swatch(k)),
            first=_first_picture(data),
            # Trusted: JSON with HTML marks escaped, and files of this package.
            payload=Markup(as_script(page_data(data))),
            style=Markup(page_style("style.css", "plots.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )


def _first_picture(data: ReportData) -> Markup:
    """Return the picture of the design that plays, which shows until it does; empty where it cannot be drawn."""
    if not data.designs:
        return Markup()
    design = data.designs[first_design(data)]
    with suppress(HcsearchError):
        circuit, crease = Circuit.from_notation(str(design["circuit"])), drawn_crease(data, design)
        assignment = None if crease is None else Folding(circuit, crease).assignment
        return _picture(circuit, data.size, circuit.notation, assignment)
    return Markup()


def census_table(data: ReportData) -> CensusTable | None:
    """Return a table of designs by number of foldings (rows) and smallest twist (columns); None without foldings."""
    cells = [(foldings, twist, count) for foldings, twist, count in data.census if foldings is not None]
    if not cells:
        return None
    twists = sorted({twist for _, twist, _ in cells if twist is not None})
    columns = [f"least twist {twist}" for twist in twists]
    names = [_census_column(foldings, twist) for foldings, twist, _ in cells]
    columns += [name for name in ("twist not known", "no folding") if name in names]
    counts: dict[tuple[int, str], int] = {}
    for (foldings, _, count), name in zip(cells, names, strict=True):
        counts[foldings, name] = counts.get((foldings, name), 0) + count
    rows = sorted({foldings for foldings, _, _ in cells})
    return columns, [(row, [counts.get((row, name), 0) for name in columns]) for row in rows]


def _census_column(foldings: int, twist: int | None) -> str:
    """Return the census column that counts designs with this number of foldings and twist."""
    if twist is not None:
        return f"least twist {twist}"
    return "twist not known" if foldings else "no folding"


MAX_PAGE_DESIGNS = 20_000
"""Default limit of designs on a page, which its script can still search and sort quickly."""


def write_report(
    database: Database,
    query: str,
    path: Path | str,
    *,
    limit: int | None = MAX_PAGE_DESIGNS,
    sort: str = BEST_FIRST_ORDER,
    title: str = "",
    scene: str = DEFAULT_SCENE_NAME,
) -> Path:
    """Write the report on the designs that a query selects, and return its path.

    database : from `open_readonly`.
    limit : designs on the page, None for all; counts always cover all selected designs.
    scene : the one whose verdicts are shown.
    QueryError: no design is selected. OutputError: the file cannot be written.
    """
    data = fetch_report_data(database, query, limit, sort, scene)
    if not data.total:
        reason = empty_result_reason(database, query, scene=scene)
        raise QueryError(f"no design satisfies {query!r}: {reason or 'see `hcsearch query` for those of the database'}")
    data = with_first_motion(replace(data, title=title) if title else data, database)
    page = render_report(data)
    write_output(path, page)
    return Path(path)


@dataclass(frozen=True)
class Pages:
    """Makes the pages of cases as HTML.

    option : of commands that name a folding, for the scene. named : how commands name the subject, with its options,
    if it is no design.
    """

    option: str = ""
    named: str = ""

    def design_page(self, design: CircuitCase) -> str:
        """Return the page of a design."""
        return render_design(fetch_design_data(design, self.option, self.named))

    def linkage_page(self, case: Case) -> str:
        """Return the page of a linkage."""
        return render_linkage(fetch_linkage_data(case, self.named))
