"""The page: the template filled with the data. Nothing in it comes from outside the file."""

from __future__ import annotations

from markupsafe import Markup

from hcsearch.player import player_script
from hcsearch.player.scripts import as_script, digest_of
from hcsearch.report.census import census_table
from hcsearch.report.data import ReportData
from hcsearch.report.payload import page_data
from hcsearch.report.templating import environment, joined_script, page_style

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
