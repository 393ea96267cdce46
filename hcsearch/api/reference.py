"""The reference of all public names, which `make docs` generates from their docstrings."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from functools import cached_property
from importlib import import_module
from typing import Any

from hcsearch.api.kinds import describe_kind
from hcsearch.basics.vocabulary import Formulation, Keep, Way
from hcsearch.cases.case import CaseSubject
from hcsearch.cases.names import Place
from hcsearch.cases.replay_sources import ReplaySource
from hcsearch.system.lazy import names_in_stub

REFERENCE_TITLE = """# Reference of the Python names

All names are imported from the package, as in `from hcsearch import deploy`; [python.md](../howto/python.md) shows how
to use them. Lengths are in metres and angles in radians, but sizes in texts are in millimetres: `panel="50x40x6"`.

`make docs` generates this page from the docstrings.
"""
VALUE_DESCRIPTIONS = {
    "GRIDS": "The grids by their names: `triangle`, `square`, `rectangle`, `hex`.",
    "SCENES": "The scenes of the program by their names: `default`, `earth`, `thesis`, `satellite`.",
    "__version__": "The release that is installed.",
}
SIGNATURE_KINDS = {
    "CaseSubject": CaseSubject,
    "Formulation": Formulation,
    "Keep": Keep,
    "Place": Place,
    "ReplaySource": ReplaySource,
    "Way": Way,
}
"""Names of kinds in the signatures of functions."""
CODE_WIDTH = 100
_ITEM = re.compile(r"(?:^|(?<=\.)) *([a-z_][a-z_, ]*) : ")
"""How docstrings describe parameters and fields: `name : text.`"""


def reference_page() -> str:
    """The document."""
    parts = [REFERENCE_TITLE]
    for group, names in names_in_stub("hcsearch").items():
        parts.append(f"\n## {group}\n")
        parts += [_entry(name, getattr(import_module(module), name)) for name, module in names.items()]
    parts.append("\n## Kinds in signatures\n\n| kind | what to give |\n|---|---|\n")
    parts += [f"| `{name}` | {describe_kind(kind)} |\n" for name, kind in SIGNATURE_KINDS.items()]
    return "".join(parts)


def _entry(name: str, value: Any) -> str:
    """The part on one name."""
    lines = [f"\n### `{name}`\n"]
    if name in VALUE_DESCRIPTIONS:
        return "".join([*lines, f"\n{VALUE_DESCRIPTIONS[name]}\n"])
    if not inspect.isclass(value):
        return "".join([*lines, _code(_signature(name, value)), _prose(value)])
    if not issubclass(value, Exception):
        lines.append(_code(_signature(name, value)))
    lines.append(_prose(value))
    members = list(_members(value))
    if members:
        lines += ["\n| | |\n|---|---|\n", *(f"| `{shown}` | {said} |\n" for shown, said in members)]
    return "".join(lines)


def _signature(name: str, value: Any) -> str:
    """How a function is called, or a value made, with the kinds of what is given."""
    if is_dataclass(value):
        given = [f"{own.name}: {own.type}{_default(own)}" for own in fields(value) if own.init]
        called = f"{name}({', '.join(given)})"
    else:
        called = name + re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(inspect.signature(value)))
    if len(called) <= CODE_WIDTH:
        return called
    inside, _, after = called[len(name) + 1 :].rpartition(")")
    return "\n".join([f"{name}(", *(f"    {part}," for part in _parts(inside)), f"){after}"])


def _default(own: Any) -> str:
    return "" if own.default is MISSING and own.default_factory is MISSING else f" = {own.default!r}"


def _parts(text: str) -> list[str]:
    """What commas separate that stand in no brackets."""
    parts, depth = [""], 0
    for mark in text:
        depth += (mark in "([{") - (mark in ")]}")
        if mark == "," and not depth:
            parts.append("")
        else:
            parts[-1] += mark
    return [part.strip() for part in parts]


def _members(kind: type) -> Iterator[tuple[str, str]]:
    """Public methods and properties of a class, in its order, with the first line of each docstring."""
    for name, member in vars(kind).items():
        own = member.__func__ if isinstance(member, staticmethod) else member
        if name.startswith("_") or not (inspect.isfunction(own) or isinstance(own, (property, cached_property))):
            continue
        first = (inspect.getdoc(own) or "").splitlines()[0].replace("|", "\\|")
        yield (f"{name}({_names(own)})" if inspect.isfunction(own) else name), first


def _names(function: Any) -> str:
    """Names of what a function is given."""
    given = [one for one in inspect.signature(function).parameters.values() if one.name != "self"]
    return ", ".join(one.name if one.default is one.empty else f"{one.name}={one.default!r}" for one in given)


def _prose(value: Any) -> str:
    """A docstring as paragraphs, its examples as blocks."""
    blocks = []
    for paragraph in (inspect.getdoc(value) or "").split("\n\n"):
        if paragraph.startswith(">>>"):
            blocks.append(f"```python\n{paragraph}\n\n```")  # the empty line ends the output for doctest
        else:
            blocks.append(_ITEM.sub(r"\n- `\1`: ", " ".join(line.strip() for line in paragraph.splitlines())).strip())
    return "".join(f"\n{block}\n" for block in blocks)


def _code(text: str) -> str:
    return f"\n```python\n{text}\n```\n"


if __name__ == "__main__":
    print(reference_page(), end="")
