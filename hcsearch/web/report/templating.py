"""Templates of pages, in which everything is escaped, numbers in them, and files beside them: styles and scripts."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from hcsearch.shape.drawing import stylesheet
from hcsearch.web.player.page import COLOURS

_TINY = 1e-9
"""What rounding leaves of a zero, in any unit that pages have."""


@cache
def environment() -> Environment:
    """The templates of this folder."""
    made = Environment(
        loader=PackageLoader("hcsearch.web.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["grouped"] = _grouped
    return made


def source(name: str) -> str:
    """The text of a file among the templates."""
    loader = environment().loader
    assert loader is not None
    return loader.get_source(environment(), name)[0]


def page_style(*names: str) -> str:
    """The style of a page: pictures, colours, and files among the templates."""
    return "\n".join((stylesheet(), COLOURS, *map(source, names)))


def joined_script(modules: tuple[str, ...], last: str = "") -> str:
    """The modules of a script, and a text after them, as one, of which nothing is seen from outside."""
    return '"use strict";\n(() => {\n' + "\n".join([*(source(f"{name}.js") for name in modules), last]) + "})();\n"


def written(value: object) -> str:
    """Write a value, numbers in four digits; `-` for NULL. `written` of parts.js writes the same."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return "0" if abs(value) < _TINY else f"{value:.4g}"
    return str(value)


def _grouped(count: int | None) -> str:
    """Write a count with its thousands apart; `-` when not known."""
    return "-" if count is None else f"{count:,}"
