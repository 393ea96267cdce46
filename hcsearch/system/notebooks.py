"""Registry of notebook views: values lie on lower layers than their renderers, which register themselves here."""

from __future__ import annotations

from collections.abc import Callable

HtmlView = Callable[[object], str | None]
"""A renderer: returns the HTML of a value, or None for types that it does not support."""

_VIEWS: list[HtmlView] = []


def register_view(view: HtmlView) -> None:
    """Register a renderer, once."""
    if view not in _VIEWS:
        _VIEWS.append(view)


def notebook_view(value: object) -> str | None:
    """Return the HTML of a value from the first renderer that supports it, else None."""
    rendered = (view(value) for view in _VIEWS)
    return next((html for html in rendered if html is not None), None)
