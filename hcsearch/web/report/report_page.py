"""Reports as files: the template filled with the data. Nothing in it comes from outside the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from markupsafe import Markup

from hcsearch.basics.errors import QueryError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, open_readonly
from hcsearch.system.outputs import write_output
from hcsearch.web.player import player_script
from hcsearch.web.player.player_page import as_script, digest_of
from hcsearch.web.report.data import BEST_FIRST, ReportData, fetch
from hcsearch.web.report.design_data import design_data
from hcsearch.web.report.design_page import render_design
from hcsearch.web.report.script_data import page_data
from hcsearch.web.report.templating import environment, joined_script, page_style

Census = tuple[list[str], list[tuple[int | None, list[int]]]]
"""Names of columns, and rows: a number of foldings, and the designs in each column."""

MODULES = ("geometry", "grammar", "conditions", "table", "parts", "card", "gallery", "dialog", "copy", "main")
"""Files of the script, each after those that it uses."""


def render(data: ReportData) -> str:
    """Write the HTML page of a report: no external resource, all text escaped.

    The page's own policy admits its scripts by their hashes, so that no text in the data could ever run. One is the
    player, where the data hold motions.
    """
    scripts = [*([player_script()] if data.players else []), joined_script(MODULES)]
    return (
        environment()
        .get_template("report.html")
        .render(
            data=data,
            census=census_table(data),
            only=[
                quantity for quantity in data.columns if quantity.kind == "boolean" and _has_box(data, quantity.name)
            ],
            # Trusted: JSON without a mark of HTML in it, and files of this package.
            payload=Markup(as_script(page_data(data))),
            style=Markup(page_style("style.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )


def _has_box(data: ReportData, name: str) -> bool:
    """Whether a yes/no quantity has a box to tick: the two that are always known, and others that some design has."""
    return name in {"two_stack", "untwisted"} or any(design.get(name) for design in data.designs)


def census_table(data: ReportData) -> Census | None:
    """Count designs by number of foldings (rows) and smallest twist (columns); None before foldings are known."""
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
    """The column of the census that designs are counted in."""
    if twist is not None:
        return f"least twist {twist}"
    return "twist not known" if foldings else "no folding"


LIMIT = 20_000
"""Designs on a page by default: so many are searched and sorted at once."""


def write_report(
    database: Database,
    query: str,
    path: Path | str,
    *,
    limit: int | None = LIMIT,
    sort: str = BEST_FIRST,
    title: str = "",
    scene: str = DEFAULT_SCENE_NAME,
) -> Path:
    """Write the report on the designs that a query selects, and return its path.

    database : from `open_readonly`.
    limit : designs on the page, None for all; the numbers on the page count all of them in any case.
    scene : whose verdicts are shown.
    QueryError: no design is selected. OutputError: the file cannot be written.
    """
    data = fetch(database, query, limit, sort, scene)
    if not data.total:
        raise QueryError(f"no design satisfies {query!r}: see `hcsearch query` for those of the database")
    page = render(replace(data, title=title) if title else data)
    write_output(path, page)
    return Path(path)


def write_design(
    circuit: Circuit,
    foldings: Sequence[Folding],
    path: Path | str,
    *,
    db: str,
    number: int | None = None,
    scene: str = DEFAULT_SCENE_NAME,
) -> Path:
    """Write the page of a design, and return its path.

    foldings : that are shown. db : names the database, which is asked where it has a number for the design.
    OutputError: the file cannot be written. SceneError: the database has no such scene.
    """
    if number is None:
        data = design_data(circuit, foldings, db, None, 0)
    else:
        with open_readonly(db) as database:
            data = design_data(circuit, foldings, db, database, number, scene)
    write_output(path, render_design(data))
    return Path(path)
