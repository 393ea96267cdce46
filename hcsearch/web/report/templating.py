"""Templates of pages, in which everything is escaped; files beside them; options of commands in pages."""

from __future__ import annotations

import shlex
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.shape.drawing import stylesheet
from hcsearch.store import Database
from hcsearch.system.machine import default_database
from hcsearch.web.player.player_page import PAGE_COLOURS

_TINY = 1e-9
"""What rounding leaves of a zero, in any unit that pages have."""


@cache
def template_environment() -> Environment:
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


def template_source(name: str) -> str:
    """The text of a file among the templates."""
    loader = template_environment().loader
    assert loader is not None
    return loader.get_source(template_environment(), name)[0]


def page_style(*names: str) -> str:
    """The style of a page: pictures, colours, and files among the templates."""
    return "\n".join((stylesheet(), PAGE_COLOURS, *map(template_source, names)))


def joined_script(modules: tuple[str, ...], last: str = "") -> str:
    """The modules of a script, and a text after them, as one, of which nothing is seen from outside."""
    return (
        '"use strict";\n(() => {\n'
        + "\n".join([*(template_source(f"{name}.js") for name in modules), last])
        + "})();\n"
    )


def written_value(value: object) -> str:
    """Write a value, numbers in four digits; `-` for NULL. `written_value` of parts.js writes the same."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return "0" if abs(value) < _TINY else f"{value:.4g}"
    return str(value)


def _grouped(count: int | None) -> str:
    """Write a count with its thousands apart; `-` when not known."""
    return "-" if count is None else f"{count:,}"


def database_option_text(database: Database | None) -> str:
    """The option that names a database file, where it is not the usual one; URLs of servers may hold passwords."""
    if database is None or database.path is None or database.location == default_database():
        return ""
    return f" --db {shlex.quote(database.location)}"


def scene_option_text(name: str, where: str) -> str:
    """The option that names a scene, where it is not the usual one, and the database that may hold it."""
    return "" if name == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(name)}{where}"
