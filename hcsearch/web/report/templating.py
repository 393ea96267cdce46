"""Templates of pages with escaping, their style and script files, and command options shown in pages."""

from __future__ import annotations

import shlex
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.shape.drawing import stylesheet
from hcsearch.store import Database
from hcsearch.system.figures import unbroken
from hcsearch.system.machine import default_database
from hcsearch.web.player.player_page import PAGE_COLOURS

_TINY = 1e-9
"""Absolute values below this one are rounding errors of zero, in all units of pages."""


@cache
def template_environment() -> Environment:
    """Return the template environment of this folder."""
    templates = Environment(
        loader=PackageLoader("hcsearch.web.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters["grouped"] = _grouped
    templates.filters["unbroken"] = unbroken
    return templates


def template_source(name: str) -> str:
    """Return the text of a file in the template folder."""
    loader = template_environment().loader
    assert loader is not None
    return loader.get_source(template_environment(), name)[0]


def page_style(*names: str) -> str:
    """Return the style of a page: pictures, colours and files of the template folder."""
    return "\n".join((stylesheet(), PAGE_COLOURS, *map(template_source, names)))


def joined_script(modules: tuple[str, ...], tail: str = "") -> str:
    """Return script modules and a final text as one script that defines no global names."""
    return (
        '"use strict";\n(() => {\n'
        + "\n".join([*(template_source(f"{name}.js") for name in modules), tail])
        + "})();\n"
    )


def written_value(value: object) -> str:
    """Return a value as text, numbers with four digits, `-` for NULL; as `written_value` of parts.js."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return "0" if abs(value) < _TINY else f"{value:.4g}"
    return str(value)


def _grouped(count: int | None) -> str:
    """Return a count with separated thousands; `-` if unknown."""
    return "-" if count is None else f"{count:,}"


def database_option_text(database: Database | None) -> str:
    """Return the option for a database file other than the default; empty for servers (URLs may hold passwords)."""
    if database is None or database.path is None or database.location == default_database():
        return ""
    return f" --db {shlex.quote(database.location)}"


def scene_option_text(name: str, where: str) -> str:
    """Return the options for a scene other than the default and for the database that may contain it."""
    return "" if name == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(name)}{where}"
