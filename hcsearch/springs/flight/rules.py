"""Rules of a standard: read from a TOML file, and held against the figures of a travel.

A file has a `title`, an `issue` and tables of rules, each with its `clause`; rules that it leaves out are not judged.
docs/reference/rules.md lists all of them. A kind of rule is one row of `RULE_KINDS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple, cast

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.designs.records import FlightNumbers
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import labels_of
from hcsearch.springs.flight.flight_figures import least_margins, root_of, tolerances_of, travel_margins
from hcsearch.springs.flight.flight_sheet import MIN_SENSITIVITY, FigureSide, SheetRow
from hcsearch.springs.flight.margin_figures import FigureKind, MarginFigures
from hcsearch.springs.flight.path_margins import PathMargins
from hcsearch.springs.flight.shape_errors import shape_errors
from hcsearch.springs.flight.stowage import stowage_of
from hcsearch.springs.flight.travel import Travel
from hcsearch.system.reading import parse_toml, read_toml
from hcsearch.system.terminal import short_number

STANDARDS = ("ecss", "aiaa")
"""Standards whose rules come with the program."""

_LEAST, _GREATEST = 1e-9, 1e9
"""Bounds of the numbers of a rule, whose products stay numbers."""


@dataclass(frozen=True)
class Rule:
    """A rule of a standard: its clause, and its numbers by the keys of its kind."""

    clause: str
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class Rules:
    """The rules of a standard by the keys of their kinds; title, issue : of the standard."""

    title: str
    issue: str
    given: Mapping[str, Rule]

    @property
    def standard(self) -> str:
        """Title and issue."""
        return f"{self.title}, {self.issue}"

    def weights(self, *, measured: bool) -> tuple[float, float]:
        """Return the weights of friction and of harness over the torque of springs, which must be no less.

        measured : whether resisting torques are measured, for which a standard has smaller factors. Both are 1 where
        the standard asks for no torque.
        """
        if "motorisation" not in self.given:
            return 1.0, 1.0
        numbers, ending = self.given["motorisation"].numbers, "_measured" if measured else ""
        friction, harness = (
            numbers["overall"] * numbers[name + ending] / numbers["springs"] for name in ("friction", "harness")
        )
        return friction, harness

    def resistance(self, setup: Setup, *, measured: bool) -> Reals:
        """Return the torque that resists at each hinge, (n_hinges,), N m, with the harness weighed against friction."""
        friction, harness = self.weights(measured=measured)
        return setup.weighted_resistance(harness / friction)


class Judged(NamedTuple):
    """The value that is compared with a rule, None where it is not known; the others as in `SheetRow`."""

    value: float | None
    note: str = ""
    kind: FigureKind = "proved"
    side: FigureSide = "exact"
    other: float | None = None


@dataclass(frozen=True)
class JudgedTravel:
    """A travel with its figures before the rules of a standard; measured : as in `Rules.weights`."""

    travel: Travel
    rules: Rules
    numbers: FlightNumbers
    measured: bool = False

    def rows(self) -> Iterator[SheetRow]:
        """Yield the rules that the standard has, and what the scene asks for."""
        for key, kind in RULE_KINDS.items():
            rule = self.rules.given.get(key)
            if rule is not None and kind.judged is not None:
                required = kind.required(self) if kind.required is not None else rule.numbers[kind.numbers[0]]
                figure = kind.judged(self)
                yield SheetRow(kind.row, rule.clause, figure.value, required, kind.unit, kind.at_least, *figure[1:])
        setup = self.travel.setup
        if setup.envelope:
            box = stowage_of(self.travel.linkage, setup.density).packed
            room, note = 1e3 * box.room_in(setup.envelope), f"{box.text} into {setup.envelope}"
            yield SheetRow("room in the envelope", "scene", room, 0.0, "mm", note=note)
        if setup.craft:
            gap = self.figure("craft_clearance")
            figure = self.at_all_times(None if gap is None else 1e3 * gap, "gap over the whole travel")
            yield SheetRow("gap to the craft", "scene", figure.value, 0.0, "mm", True, *figure[1:])

    def figure(self, name: str) -> float | None:
        """Return a figure that is a number."""
        return cast("float | None", self.numbers[name])

    def at_all_times(self, figure: float | None, note: str) -> Judged:
        """Return a figure of the gaps of the motion."""
        return Judged(figure, note, "proved" if self.travel.source == "path" else "simulated", "from below")

    @cached_property
    def resistance(self) -> Reals:
        """The torque that resists at each hinge, by the weights of the rules."""
        return self.rules.resistance(self.travel.setup, measured=self.measured)

    @cached_property
    def margins_at_states(self) -> PathMargins:
        """The margins at the states of the travel, by the weights of the rules."""
        return travel_margins(self.travel, self.resistance)

    @cached_property
    def least(self) -> MarginFigures:
        """The least margins of the travel, by the weights of the rules."""
        return least_margins(self.travel, self.resistance)

    def required_torque(self) -> float:
        """Return the least torque of springs over the resistance."""
        return self.rules.weights(measured=self.measured)[0]

    def torque(self, *, failed: bool) -> Judged:
        """Return the least torque margin with all springs, or with one failed."""
        if self.travel.source == "none":
            return Judged(None, "no motion")
        margin = self.least.failed if failed else self.least.whole
        if math.isinf(margin.least):
            return Judged(None, "no friction and no harness given")
        label = "" if margin.hinge < 0 else labels_of(self.travel.linkage).hinges[margin.hinge]
        notes = (
            "" if not label else f"spring {label} failed" if failed else f"hinge {label}",
            f"least at {short_number(100.0 * margin.at, 3)} % of the travel",
            "" if margin.value == margin.least else f"{short_number(margin.least, 4)} at a state",
            f"without a bound in {short_number(100.0 * margin.unbounded, 2)} % of it" if margin.unbounded else "",
            self._guided(margin.least, failed=failed),
            "" if failed else f"{'measured' if self.measured else 'theoretical'} factors",
        )
        side: FigureSide = "exact" if margin.value == margin.least else "from below"
        return Judged(margin.value, ", ".join(filter(None, notes)), margin.kind, side, margin.least)

    def _guided(self, least: float, *, failed: bool) -> str:
        """Return the least ratio along a proved path in words, where it is less than the margin of free motions.

        Of a simulated motion it says nothing: inertia drives hinges against their springs.
        """
        if self.travel.source != "path":
            return ""
        guided = float((self.margins_at_states.along_failed if failed else self.margins_at_states.along).min())
        differs = guided < least * (1.0 - MIN_SENSITIVITY)
        return f"guided along the path {short_number(guided, 3)}, sampled" if differs else ""

    def clearance(self) -> Judged:
        """Return the least gap over the tolerances."""
        figure = self.figure("clearance_ratio")
        return self.at_all_times(
            figure, "least gap over the tolerances at all times" if figure else "no tolerances given"
        )

    def frequency(self) -> Judged:
        """Return the first frequency of the flat array."""
        return Judged(self.figure("deployed_hz"), "rigid panels on their latches", side="from below")

    def flatness(self) -> Judged:
        """Return the greatest distance of a corner from the mean plane as built, mm."""
        if tolerances_of(self.travel).are_zero:
            return Judged(None, "no tolerances given")
        standard = self.travel.standard
        shape = shape_errors(standard.linkage, tolerances_of(standard), root_of(standard))
        return Judged(1e3 * (shape.flatness + shape.second_order), "worst case", side="from above")


@dataclass(frozen=True)
class RuleKind:
    """A kind of rule: the table of a file that it stands in, and the row of a sheet that judges it.

    key : of the table. numbers : keys of its numbers. row : name of the row. judged : its figure; None where a rule is
    not judged. required : what the figure is compared with; the number of the rule unless given. unit : of both.
    at_least : whether the figure must be at least the required one, else at most.
    """

    key: str
    numbers: tuple[str, ...]
    row: str = ""
    judged: Callable[[JudgedTravel], Judged] | None = None
    required: Callable[[JudgedTravel], float] | None = None
    unit: str = ""
    at_least: bool = True


# The least torque is overall * (friction * F + harness * H) / springs, with the torques F of friction and H of the
# harness, and their own factors where these are measured. Of latches a sheet states the strength that they need.
RULE_KINDS = {
    kind.key: kind
    for kind in (
        RuleKind(
            "motorisation",
            ("overall", "springs", "friction", "harness", "friction_measured", "harness_measured"),
            *("torque of springs over resistance", lambda travel: travel.torque(failed=False)),
            JudgedTravel.required_torque,
        ),
        RuleKind(
            *("redundancy", (), "the same, one spring failed", lambda travel: travel.torque(failed=True)),
            JudgedTravel.required_torque,
        ),
        RuleKind("latch", ("factor",)),
        RuleKind("clearance", ("ratio",), "clearance over tolerances", JudgedTravel.clearance),
        RuleKind("frequency", ("hz",), "deployed frequency", JudgedTravel.frequency, unit="Hz"),
        RuleKind("flatness", ("mm",), "flatness as built", JudgedTravel.flatness, unit="mm", at_least=False),
    )
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
    unknown = set(table) - {"title", "issue", *RULE_KINDS}
    if unknown:
        raise InputFileError(
            f"{origin} has the unknown key {min(unknown)!r}: it has title, issue, {', '.join(RULE_KINDS)}"
        )
    texts = {key: table.get(key) for key in ("title", "issue")}
    for key, text in texts.items():
        if not isinstance(text, str) or not text:
            raise InputFileError(f'{origin} has no {key}: write {key} = "...", of the standard')
    rules = {key: _rule(origin, kind, table[key]) for key, kind in RULE_KINDS.items() if key in table}
    if "redundancy" in rules and "motorisation" not in rules:
        raise InputFileError(f"{origin} has redundancy without motorisation: add the table motorisation")
    return Rules(**texts, given=rules)  # type: ignore[arg-type]


def _rule(origin: str, kind: RuleKind, table: Any) -> Rule:
    """Return a rule from its table; InputFileError for other keys or values."""
    names = ("clause", *kind.numbers)
    if not isinstance(table, dict) or set(table) != set(names):
        raise InputFileError(f"{origin} must have all of [{kind.key}] and nothing else there: {', '.join(names)}")
    for name, value in table.items():
        if name == "clause":
            if not isinstance(value, str):
                raise InputFileError(f'{origin} has {kind.key}.clause = {value!r}: write a text, such as "4.7.5.3.1"')
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not _LEAST <= value <= _GREATEST:
            raise InputFileError(
                f"{origin} has {kind.key}.{name} = {value!r}: write a number above 0, from {_LEAST:g} to {_GREATEST:g}"
            )
    return Rule(table["clause"], {name: float(table[name]) for name in kind.numbers})
