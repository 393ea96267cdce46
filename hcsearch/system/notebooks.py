"""HTML of values in notebooks: values lie on lower layers than what draws them, which registers itself here."""

from __future__ import annotations

from collections.abc import Callable

HtmlView = Callable[[object], str | None]
"""Returns the HTML of the values that it knows, None of others."""

_VIEWS: list[HtmlView] = []


def register_view(view: HtmlView) -> None:
    """Ask a function for the HTML of values, too."""
    if view not in _VIEWS:
        _VIEWS.append(view)


def notebook_view(value: object) -> str | None:
    """Return the HTML of a value, made by the first function that knows it; None where there is none."""
    made = (view(value) for view in _VIEWS)
    return next((html for html in made if html is not None), None)
