"""Pages from templates of the server and the report, the page of all assemblies, and static styles and scripts."""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader
from markupsafe import Markup

from hcsearch.library.assemblies import ASSEMBLIES, Assembly
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.store.columns import VIEWS
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.linkage_cases import parameters_of
from hcsearch.web.player import player_script
from hcsearch.web.report.page_files import CARD_SCRIPT_MODULES
from hcsearch.web.report.templating import joined_script, page_style, template_environment, written_value
from hcsearch.web.serve.requests import design_address, list_address_of


def render_page(name: str, **values: Any) -> str:
    """Return a page from a template, with all values escaped."""
    return _environment().get_template(name).render(**values)


@cache
def _environment() -> Environment:
    report_templates = template_environment()
    assert report_templates.loader is not None
    templates = report_templates.overlay(
        loader=ChoiceLoader([PackageLoader("hcsearch.web.serve"), report_templates.loader])
    )
    templates.globals.update(
        address=list_address_of,
        design_address=design_address,
        other_end=_other_end,
        views=tuple(VIEWS),
        static=static_address,
    )
    templates.filters["cell"] = _cell
    return templates


@cache
def static_files() -> dict[str, tuple[str, str]]:
    """Return content and type of the static files by name."""
    loader = _environment().loader
    assert loader is not None

    def text(name: str) -> str:
        return loader.get_source(_environment(), name)[0]

    return {
        "style.css": ("\n".join((page_style("style.css"), text("serve.css"))), "text/css"),
        "list.js": (joined_script((), text("list.js")), "text/javascript"),
        "player.js": (player_script(), "text/javascript"),
        "cards.js": (joined_script(CARD_SCRIPT_MODULES, text("serve.js")), "text/javascript"),
    }


@cache
def static_address(name: str) -> str:
    """Return the address of a static file, which changes with its content, so that browsers may cache it."""
    return f"/static/{hashlib.sha256(static_files()[name][0].encode()).hexdigest()[:16]}/{name}"


def _other_end(quantity: Quantity, sort: str) -> str:
    """Return the order that a click on a column's head asks for: the better end first, then the other one."""
    if sort != quantity.better_first:
        return quantity.better_first
    return sort.removeprefix("-") if sort.startswith("-") else f"-{sort}"


def _cell(value: object, name: str) -> str:
    """Return a value as text in a table; errors may be tiny, other tiny values are rounding errors of zero."""
    return f"{value:.4g}" if isinstance(value, float) and name.endswith("_error") else written_value(value)


@cache
def render_assembly_list() -> str:
    """Return the HTML page that lists the assemblies with their default sizes."""
    return render_page("assemblies.html", assemblies=[(one, _picture(one)) for one in ASSEMBLIES.values()])


def _picture(assembly: Assembly) -> Markup:
    pattern = assembly.build(parameters_of(assembly, {}))
    # Trusted: integers and fixed words, and a title that `draw_pattern` escapes.
    return Markup(draw_pattern(pattern, assembly.title, standalone=False))
