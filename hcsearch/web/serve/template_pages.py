"""Pages from templates, here and in `report`, and the files that they load: styles and scripts of the report."""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader

from hcsearch.store.columns import VIEWS
from hcsearch.web.player import player_script
from hcsearch.web.report.templating import joined_script, page_style, template_environment, written_value
from hcsearch.web.serve.requests import design_address, list_address_of

CARD_SCRIPT_MODULES = ("geometry", "table", "parts", "card", "dialog", "copy")
"""Modules of the report's script that draw cards; `serve.js` uses them."""


def render_page(name: str, **values: Any) -> str:
    """A page from a template, with everything in it escaped."""
    return _environment().get_template(name).render(**values)


@cache
def _environment() -> Environment:
    theirs = template_environment()
    assert theirs.loader is not None
    made = theirs.overlay(loader=ChoiceLoader([PackageLoader("hcsearch.web.serve"), theirs.loader]))
    made.globals.update(
        address=list_address_of, design_address=design_address, views=tuple(VIEWS), static=static_address
    )
    made.filters["cell"] = _cell
    return made


@cache
def static_files() -> dict[str, tuple[str, str]]:
    """Content and type of the files that pages load, by name."""
    own = _environment().loader
    assert own is not None

    def text(name: str) -> str:
        return own.get_source(_environment(), name)[0]

    return {
        "style.css": ("\n".join((page_style("style.css"), text("serve.css"))), "text/css"),
        "list.js": (joined_script((), text("list.js")), "text/javascript"),
        "player.js": (player_script(), "text/javascript"),
        "cards.js": (joined_script(CARD_SCRIPT_MODULES, text("serve.js")), "text/javascript"),
    }


@cache
def static_address(name: str) -> str:
    """The address of a file, which is another one when the file is: browsers may keep it."""
    return f"/static/{hashlib.sha256(static_files()[name][0].encode()).hexdigest()[:16]}/{name}"


def _cell(value: object, name: str) -> str:
    """A value in a table. Errors may be tiny; of anything else, rounding leaves so little of a zero."""
    return f"{value:.4g}" if isinstance(value, float) and name.endswith("_error") else written_value(value)
