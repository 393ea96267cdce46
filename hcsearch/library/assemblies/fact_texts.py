"""The facts of an assembly as texts: names in words, values with units."""

from __future__ import annotations

from collections.abc import Iterator

from hcsearch.library.assemblies.description import AssemblyFacts
from hcsearch.system.terminal import short_number

_UNITS = {"_mm": "mm", "_mm2": "mm2", "_mm3": "mm3", "_deg": "degrees"}
_APART = {"published", "undecided", "notes", "slit", "hindrances"}
"""Facts that have lines of their own."""


def fact_rows(facts: AssemblyFacts) -> Iterator[tuple[str, str]]:
    """Yield the name and the value of each fact, with reasons for undecided ones, but without the thesis's values."""
    for name, value in facts.items():
        if name in _APART or (value is None and name not in facts["undecided"]):
            continue  # without a reason, the fact is not about this assembly
        label, unit = _label(name)
        yield label, f"undecided: {facts['undecided'][name]}" if value is None else f"{fact_text(value)}{unit}"
    for reason in facts["hindrances"]:
        yield "", reason
    for row in facts["slit"] or ():
        yield (
            "slit distance",
            f"{row['measured_mm']:.6g} mm at phi_1 = {row['phi_1_deg']} degrees, {row['stated_mm']:.6g} mm by eq. 5.27",
        )


def published_rows(facts: AssemblyFacts) -> Iterator[tuple[str, str, str]]:
    """Yield the name and the value of each fact that the thesis states, and whether ours agrees."""
    for name, row in facts["published"].items():
        label, unit = _label(name)
        yield (
            label,
            f"{fact_text(row['thesis'])}{unit}",
            {True: "agrees", False: "DIFFERS", None: "undecided"}[row["agree"]],
        )


def fact_lines(facts: AssemblyFacts) -> Iterator[str]:
    """Yield the facts, one a line, then the statements of the thesis and the notes."""
    rows = [*fact_rows(facts)]
    rows += [("the thesis", f"{label} {text}: {verdict}") for label, text, verdict in published_rows(facts)]
    rows += [("note", note) for note in facts["notes"]]
    yield from (f"{label:21}{text}" for label, text in rows)


def fact_text(value: object) -> str:
    """Return a value as text: lists with spaces, named values with units."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return short_number(value, 6)
    if isinstance(value, list | tuple):
        return " ".join(map(fact_text, value))
    if isinstance(value, dict):
        return ", ".join(_named(name, part) for name, part in value.items())
    return str(value)


def _named(name: str, value: object) -> str:
    """Return a named value of several: a size, a number of panels with so many facets, or a length or an angle."""
    if name == "size":
        return f"size {value[0]}x{value[1]}" if isinstance(value, list | tuple) else "size any"
    if name.isdigit():
        return f"{value} of {name}"
    label, unit = _label(name)
    return f"{label} {fact_text(value)}{unit}"


def _label(name: str) -> tuple[str, str]:
    """Return the name of a fact in words, and its unit."""
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending).replace("_", " "), f" {unit}"
    return name.replace("_", " "), ""
