"""Search for flat arrays of thick panels that fold into two stacks.

`parse_array`, `enumerate_circuits`, `foldings` and `twist` give arrays, their circuits, and how these fold. `deploy`,
`tune`, `replay` and `save` simulate a folding, choose its springs, play its motion, and export it. `enumerate_into`
searches into a database; `read` and `rank` read it as pandas tables. docs/howto/python.md shows all of this.

>>> from hcsearch import enumerate_circuits, foldings, twist
>>> [[twist(folding) for folding in foldings(circuit)] for circuit in enumerate_circuits("hex", n=6)]
[[], [0], [], []]
"""

# `__init__.pyi` lists the names; they are imported on first use: the command line starts without loading what it does
# not need

from __future__ import annotations


def __getattr__(name: str) -> object:
    # not above: the command line loads this module before it can answer Ctrl-C
    from hcsearch.system.lazy import lazy_importer  # noqa: PLC0415
    from hcsearch.system.notebooks import register_view  # noqa: PLC0415

    register_view(_notebook_view)
    return lazy_importer(__name__)(name)


def _notebook_view(value: object) -> str | None:
    """Return the HTML of a value in a notebook."""
    from hcsearch.api.notebook_views import notebook_value_html  # noqa: PLC0415 - loads the player

    return notebook_value_html(value)


def __dir__() -> list[str]:
    from hcsearch.system.lazy import lazy_importer  # noqa: PLC0415 - as above

    names: list[str] = lazy_importer(__name__)("__all__")  # type: ignore[assignment]
    return names
