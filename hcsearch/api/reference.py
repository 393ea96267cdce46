"""Generation of the reference of all public names from their docstrings, for `make docs`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from hcsearch.api.kinds import describe_kind
from hcsearch.basics.vocabulary import Formulation, Keep, ReplaySource, Until, Way
from hcsearch.cases.case import CaseSubject
from hcsearch.store import Database
from hcsearch.system.lazy import names_in_stub

REFERENCE_TITLE = """# Reference of the Python names

All names are imported from the package, as in `from hcsearch import deploy`; [python.md](../howto/python.md) shows how
to use them. Lengths are in metres and angles in radians, but sizes in texts are in millimetres: `panel="50x40x6"`.

`make docs` generates this page from the docstrings.
"""
VALUE_DESCRIPTIONS = {
    "GRIDS": "The nine grids by their names, such as `hex` and `right45`.",
    "SCENES": "The scenes of the program by their names: `default`, `earth`, `thesis`, `satellite`.",
    "__version__": "The release that is installed.",
}
SIGNATURE_KINDS = {
    "CaseSubject": CaseSubject,
    "Formulation": Formulation,
    "Keep": Keep,
    "Place": str | Path | Database,
    "ReplaySource": ReplaySource,
    "Until": Until,
    "Way": Way,
}
"""Names of kinds in the signatures of functions."""
CODE_WIDTH = 100
_ITEM = re.compile(r"(?:^|(?<=\.)) *([a-z_][a-z_, ]*) : ")
"""The form of parameters and fields in docstrings: `name : text.`"""


def reference_page() -> str:
    """Return the reference as Markdown."""
    parts = [REFERENCE_TITLE]
    for group, names in names_in_stub("hcsearch").items():
        parts.append(f"\n## {group}\n")
        parts += [_entry(name, getattr(import_module(module), name)) for name, module in names.items()]
    parts.append("\n## Kinds in signatures\n\n| kind | what to give |\n|---|---|\n")
    parts += [f"| `{name}` | {describe_kind(kind)} |\n" for name, kind in SIGNATURE_KINDS.items()]
    return "".join(parts)


def _entry(name: str, value: Any) -> str:
    """Return the section on a name."""
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
        lines += ["\n| | |\n|---|---|\n", *(f"| `{shown}` | {summary} |\n" for shown, summary in members)]
    return "".join(lines)


def _signature(name: str, value: Any) -> str:
    """Return the signature of a function or class with the kinds of its arguments."""
    if is_dataclass(value):
        parameters = [f"{field.name}: {field.type}{_default(field)}" for field in fields(value) if field.init]
        called = f"{name}({', '.join(parameters)})"
    else:
        called = name + re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(inspect.signature(value)))
    if len(called) <= CODE_WIDTH:
        return called
    inside, _, result = called[len(name) + 1 :].rpartition(")")
    return "\n".join([f"{name}(", *(f"    {part}," for part in _parts(inside)), f"){result}"])


def _default(field: Any) -> str:
    return "" if field.default is MISSING and field.default_factory is MISSING else f" = {field.default!r}"


def _parts(text: str) -> list[str]:
    """Split a text at commas outside brackets."""
    parts, depth = [""], 0
    for mark in text:
        depth += (mark in "([{") - (mark in ")]}")
        if mark == "," and not depth:
            parts.append("")
        else:
            parts[-1] += mark
    return [part.strip() for part in parts]


def _members(kind: type) -> Iterator[tuple[str, str]]:
    """Return the public methods and properties of a class in order, with their summaries."""
    for name, member in vars(kind).items():
        function = member.__func__ if isinstance(member, staticmethod) else member
        if name.startswith("_") or not (
            inspect.isfunction(function) or isinstance(function, (property, cached_property))
        ):
            continue
        summary = (inspect.getdoc(function) or "").splitlines()[0].replace("|", "\\|")
        yield (f"{name}({_names(function)})" if inspect.isfunction(function) else name), summary


def _names(function: Any) -> str:
    """Return the parameter names of a function."""
    parameters = [
        parameter for parameter in inspect.signature(function).parameters.values() if parameter.name != "self"
    ]
    return ", ".join(
        parameter.name if parameter.default is parameter.empty else f"{parameter.name}={parameter.default!r}"
        for parameter in parameters
    )


def _prose(value: Any) -> str:
    """Return a docstring as Markdown paragraphs, with examples as code blocks."""
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
