"""Templates of pages, in which everything is escaped, and the files beside them: styles, and modules of scripts."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from hcsearch.drawing import stylesheet
from hcsearch.player.page import COLOURS


@cache
def environment() -> Environment:
    """The templates of this folder."""
    made = Environment(
        loader=PackageLoader("hcsearch.report"),
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


def _grouped(count: int | None) -> str:
    """Write a count with its thousands apart; `-` when not known."""
    return "-" if count is None else f"{count:,}"
