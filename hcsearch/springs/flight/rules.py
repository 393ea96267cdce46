"""Rules of a standard, read from a TOML file: factors and clauses by which a flight sheet is judged.

A file has a `title`, an `issue` and tables of rules, each with its `clause`; rules that it leaves out are not judged.
docs/reference/rules.md lists all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import InputFileError
from hcsearch.system.reading import parse_toml, read_toml

STANDARDS = ("ecss", "aiaa")
"""Standards whose rules come with the program."""

_LEAST, _GREATEST = 1e-9, 1e9
"""Bounds of the numbers of a rule, whose products stay numbers."""


@dataclass(frozen=True)
class MotorisationRule:
    """The torque that springs must have over what resists, at every point of the travel.

    springs : factor of the torque of driving springs. overall : factor of all that resists. friction, harness : their
    factors, and those of measured values.
    """

    clause: str
    overall: float
    springs: float
    friction: float
    harness: float
    friction_measured: float
    harness_measured: float

    def weights(self, *, measured: bool) -> tuple[float, float]:
        """Return the weights of friction and of harness over the torque of springs, which must be no less."""
        factors = (self.friction_measured, self.harness_measured) if measured else (self.friction, self.harness)
        friction, harness = (self.overall * factor / self.springs for factor in factors)
        return friction, harness


@dataclass(frozen=True)
class RedundancyRule:
    """The motorisation with any one spring failed."""

    clause: str


@dataclass(frozen=True)
class LatchRule:
    """The strength of latches over the torque at the end of the travel: at least `factor`."""

    clause: str
    factor: float


@dataclass(frozen=True)
class ClearanceRule:
    """The gap between panels over the tolerances: at least `ratio`."""

    clause: str
    ratio: float


@dataclass(frozen=True)
class FrequencyRule:
    """The first frequency of the flat array: at least `hz`."""

    clause: str
    hz: float


@dataclass(frozen=True)
class FlatnessRule:
    """The distance of corners of the flat array from its mean plane, as built: at most `mm`."""

    clause: str
    mm: float


@dataclass(frozen=True)
class Rules:
    """The rules of a standard; None for those that it does not have.

    title, issue : of the standard.
    """

    title: str
    issue: str
    motorisation: MotorisationRule | None = None
    redundancy: RedundancyRule | None = None
    latch: LatchRule | None = None
    clearance: ClearanceRule | None = None
    frequency: FrequencyRule | None = None
    flatness: FlatnessRule | None = None

    @property
    def standard(self) -> str:
        """Title and issue."""
        return f"{self.title}, {self.issue}"


_TABLES: dict[str, type[Any]] = {
    "motorisation": MotorisationRule,
    "redundancy": RedundancyRule,
    "latch": LatchRule,
    "clearance": ClearanceRule,
    "frequency": FrequencyRule,
    "flatness": FlatnessRule,
}


def read_rules(name: str) -> Rules:
    """Return the rules of a standard of `STANDARDS`, or of a file `.toml`; InputFileError for what cannot be read."""
    if name in STANDARDS:
        text = files("hcsearch.springs.flight").joinpath(f"standards/{name}.toml").read_text("utf-8")
        return _checked(name, parse_toml(text))
    if not name.endswith(".toml"):
        raise InputFileError(f"there are no rules {name[:40]!r}: name {', '.join(STANDARDS)}, or a file .toml")
    return _checked(Path(name).name, read_toml(name))


def _checked(origin: str, table: Mapping[str, Any]) -> Rules:
    unknown = set(table) - {"title", "issue", *_TABLES}
    if unknown:
        raise InputFileError(
            f"{origin} has the unknown key {min(unknown)!r}: it has title, issue, {', '.join(_TABLES)}"
        )
    texts = {key: table.get(key) for key in ("title", "issue")}
    for key, text in texts.items():
        if not isinstance(text, str) or not text:
            raise InputFileError(f'{origin} has no {key}: write {key} = "...", of the standard')
    rules = {key: _rule(origin, key, table[key]) for key in _TABLES if key in table}
    if rules.get("redundancy") is not None and "motorisation" not in rules:
        raise InputFileError(f"{origin} has redundancy without motorisation: add the table motorisation")
    return Rules(**texts, **rules)  # type: ignore[arg-type]


def _rule(origin: str, key: str, table: Any) -> Any:
    """Return a rule from its table; InputFileError for other keys or values."""
    names = [rule_field.name for rule_field in fields(_TABLES[key])]
    if not isinstance(table, dict) or set(table) != set(names):
        raise InputFileError(f"{origin} must have all of [{key}] and nothing else there: {', '.join(names)}")
    for name, value in table.items():
        if name == "clause":
            if not isinstance(value, str):
                raise InputFileError(f'{origin} has {key}.clause = {value!r}: write a text, such as "4.7.5.3.1"')
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not _LEAST <= value <= _GREATEST:
            raise InputFileError(
                f"{origin} has {key}.{name} = {value!r}: write a number above 0, from {_LEAST:g} to {_GREATEST:g}"
            )
    return _TABLES[key](**{name: value if name == "clause" else float(value) for name, value in table.items()})
