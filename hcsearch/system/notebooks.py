"""What values show of themselves in a notebook where a floor above theirs makes it: found by name, when it is shown."""

from __future__ import annotations

from importlib import import_module

_MAKERS = {"Replay": ("hcsearch.player.page", "notebook_html")}
"""Module and function for each class of values; modules of values import none of these."""


def notebook_view(value: object) -> str:
    """The HTML of a value whose class has a maker."""
    module, name = _MAKERS[type(value).__name__]
    return str(getattr(import_module(module), name)(value))
