"""The page: the template filled with the data. Nothing in it comes from outside the file."""

from __future__ import annotations

import base64
import hashlib
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from hcsearch.drawing import stylesheet
from hcsearch.report.cards import cards, sortable
from hcsearch.report.data import ReportData


def render(data: ReportData) -> str:
    """Write the HTML page of a report: no external resource, all text escaped, readable without scripts.

    The page's own policy admits its one script by its hash, so that no text in the data could ever run.
    """
    script = _source("script.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return (
        _environment()
        .get_template("report.html")
        .render(
            data=data,
            cards=cards(data),
            sortable=sortable(data),
            census=census_table(data),
            # Trusted: files of this package.
            style=Markup(stylesheet() + "\n" + _source("style.css")),
            script=Markup(script),
            digest=digest,
        )
    )


def census_table(data: ReportData) -> tuple[list[int | None], list[tuple[int | None, list[int]]]] | None:
    """Count designs by number of foldings (rows) and smallest twist (columns); None before foldings are known."""
    cells = [(foldings, twist, count) for foldings, twist, count in data.census if foldings is not None]
    if not cells:
        return None

    def last(value: int | None) -> tuple[bool, int]:
        return (value is None, value or 0)

    twists = sorted({twist for _, twist, _ in cells}, key=last)
    rows = sorted({foldings for foldings, _, _ in cells})
    return twists, [(row, [sum(c for f, t, c in cells if (f, t) == (row, twist)) for twist in twists]) for row in rows]


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("hcsearch.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["grouped"] = _grouped
    return environment


def _source(name: str) -> str:
    loader = _environment().loader
    assert loader is not None
    return loader.get_source(_environment(), name)[0]


def _grouped(count: int | None) -> str:
    """Write a count with its thousands apart; `-` when not known."""
    return "-" if count is None else f"{count:,}"
