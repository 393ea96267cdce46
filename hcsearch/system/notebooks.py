"""What values show of themselves in a notebook where a floor above makes it, looked up by name when it is shown."""

from __future__ import annotations

from importlib import import_module

_MAKERS = {
    "Deployed": ("hcsearch.player.notebooks", "deployed_html"),
    "Folding": ("hcsearch.player.notebooks", "folding_html"),
    "Replay": ("hcsearch.player.page", "notebook_html"),
}
"""Module and function for each class of values; modules of values import none of these."""


def notebook_view(value: object) -> str | None:
    """The HTML of a value whose class has a maker; None where its picture says as much."""
    module, name = _MAKERS[type(value).__name__]
    shown: str | None = getattr(import_module(module), name)(value)
    return shown
