"""The review of a folding: its figures against the rules of a standard, and how they change with the hardware."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.records import FlightNumbers
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.scenes.laws import scaled_law
from hcsearch.shape.labels import labels_of
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.flight_figures import figures_of, least_margins, root_of, tolerances_of, travel_margins
from hcsearch.springs.flight.flight_sheet import SENSITIVITY_CHANGE, Demand, FlightSheet, Sensitivity, SheetRow
from hcsearch.springs.flight.footprints import footprint_of
from hcsearch.springs.flight.latching import arrival_loads
from hcsearch.springs.flight.margin_figures import MarginFigure, MarginFigures
from hcsearch.springs.flight.path_margins import PathMargins
from hcsearch.springs.flight.rules import MotorisationRule, Rules
from hcsearch.springs.flight.shape_errors import shape_errors
from hcsearch.springs.flight.spring_choice import springs_that_pass
from hcsearch.springs.flight.stowage import stowage_of
from hcsearch.springs.flight.travel import Travel
from hcsearch.store.columns import FLIGHT_QUANTITIES, flight_value
from hcsearch.system.terminal import short_number
from hcsearch.system.work_steps import work_step


def review(travel: Travel, rules: Rules, *, title: str, source: str, measured: bool = False) -> FlightSheet:
    """Return the flight sheet of a folding, or of another linkage.

    title : its name, and source : what moves it, for readers. measured : whether resisting torques are measured, for
    which a standard has smaller factors.
    """
    margins = None if travel.source == "none" else least_margins(travel)
    numbers = figures_of(travel, margins)
    reviewed = _Review(travel, rules, numbers, measured)
    rows = tuple(reviewed.rows())
    springs = reviewed.springs(rows)
    return FlightSheet(
        title=title,
        scene=travel.setup.name,
        source=source,
        standard=rules.standard,
        rows=rows,
        demands=tuple(reviewed.demands()),
        numbers=numbers,
        sensitivities=sensitivities_of(travel, numbers, margins),
        omitted=tuple(reviewed.omitted()),
        springs=springs,
        advice=reviewed.advice(rows, springs),
        dampers=reviewed.dampers(),
        margins=reviewed.drawn_margins(),
        travel=travel,
    )


def rule_rows(travel: Travel, rules: Rules, numbers: FlightNumbers, *, measured: bool = False) -> tuple[SheetRow, ...]:
    """Return the rows of a sheet alone; numbers : the figures of the travel."""
    return tuple(_Review(travel, rules, numbers, measured).rows())


@dataclass(frozen=True)
class _Review:
    """One folding against the rules of a standard."""

    travel: Travel
    rules: Rules
    numbers: FlightNumbers
    measured: bool

    def rows(self) -> Iterator[SheetRow]:
        """Yield the rules that the standard has, and those that the scene asks for."""
        rules, numbers = self.rules, self.numbers
        if rules.motorisation is not None:
            yield from self._motorisation(rules.motorisation)
        if rules.clearance is not None:
            clause, ratio = rules.clearance.clause, rules.clearance.ratio
            note = "least gap over the tolerances at all times" if numbers.clearance_ratio else "no tolerances given"
            figure = numbers.clearance_ratio
            yield SheetRow("clearance over tolerances", clause, figure, ratio, note=note, **self._at_all_times)
        if rules.frequency is not None:
            clause, hz, note = rules.frequency.clause, rules.frequency.hz, "rigid panels on their latches"
            yield SheetRow("deployed frequency", clause, numbers.deployed_hz, hz, "Hz", note=note, side="from below")
        if rules.flatness is not None:
            yield self._flatness(rules.flatness.clause, rules.flatness.mm)
        yield from self._scene_rows()

    @property
    def _at_all_times(self) -> dict[str, Any]:
        """How gaps of the motion are known."""
        return {"kind": "proved" if self.travel.source == "path" else "simulated", "side": "from below"}

    def _motorisation(self, rule: MotorisationRule) -> Iterator[SheetRow]:
        """Yield the rows on torques, with all springs and with one failed."""
        friction, harness = rule.weights(measured=self.measured)
        kind = "measured" if self.measured else "theoretical"
        figures = None
        if self.travel.source != "none":
            resistance = self.travel.hardware.friction + harness / friction * self.travel.hardware.harness
            figures = least_margins(self.travel, resistance)
        whole, failed = figures or (None, None)
        yield self._torque_row("torque of springs over resistance", rule.clause, whole, friction, f"{kind} factors")
        if self.rules.redundancy is not None:
            clause = self.rules.redundancy.clause
            yield self._torque_row("the same, one spring failed", clause, failed, friction, "", failed=True)

    def _torque_row(
        self, name: str, clause: str, margin: MarginFigure | None, required: float, note: str, *, failed: bool = False
    ) -> SheetRow:
        if margin is None:
            return SheetRow(name, clause, None, required, note="no motion")
        if math.isinf(margin.least):
            return SheetRow(name, clause, None, required, note="no friction and no harness given")
        label = "" if margin.hinge < 0 else labels_of(self.travel.linkage).hinges[margin.hinge]
        who = "" if not label else f"spring {label} failed" if failed else f"hinge {label}"
        least = "" if margin.value == margin.least else f"{short_number(margin.least, 4)} at a state"
        at = f"least at {short_number(100.0 * margin.at, 3)} % of the travel"
        gaps = f"without a bound in {short_number(100.0 * margin.unbounded, 2)} % of it" if margin.unbounded else ""
        notes = (who, at, least, gaps, self._guided(margin.least, failed=failed), note)
        return SheetRow(
            name,
            clause,
            margin.value,
            required,
            note=", ".join(filter(None, notes)),
            kind=margin.kind,
            side="exact" if margin.value == margin.least else "from below",
            other=margin.least,
        )

    def _guided(self, least: float, *, failed: bool) -> str:
        """Return the least ratio along a proved path in words, where it is less than the margin of free motions.

        Of a simulated motion it says nothing: inertia drives hinges against their springs.
        """
        if self.travel.source != "path":
            return ""
        margins = self.margins_at_states
        guided = float((margins.along_failed if failed else margins.along).min())
        differs = guided < least * (1.0 - MIN_SENSITIVITY)
        return f"guided along the path {short_number(guided, 3)}, sampled" if differs else ""

    @cached_property
    def margins_at_states(self) -> PathMargins:
        """The margins at the states of the travel, by the weights of the rule; of the scene alone without one."""
        rule, hardware = self.rules.motorisation, self.travel.hardware
        friction, harness = rule.weights(measured=self.measured) if rule is not None else (1.0, 1.0)
        return travel_margins(self.travel, hardware.friction + harness / friction * hardware.harness)

    def _flatness(self, clause: str, greatest: float) -> SheetRow:
        tolerances = tolerances_of(self.travel)
        if tolerances.are_zero:
            return SheetRow(
                "flatness as built", clause, None, greatest, "mm", at_least=False, note="no tolerances given"
            )
        standard = self.travel.standard
        shape = shape_errors(standard.linkage, tolerances_of(standard), root_of(standard))
        worst, note = 1e3 * (shape.flatness + shape.second_order), "worst case"
        return SheetRow(
            "flatness as built", clause, worst, greatest, "mm", at_least=False, note=note, side="from above"
        )

    def _scene_rows(self) -> Iterator[SheetRow]:
        hardware = self.travel.hardware
        if hardware.envelope:
            box = stowage_of(self.travel.linkage, self.travel.setup.density).packed
            note = f"{box.text} into {hardware.envelope}"
            yield SheetRow("room in the envelope", "scene", 1e3 * box.room_in(hardware.envelope), 0.0, "mm", note=note)
        if hardware.craft:
            gap = self.numbers.craft_clearance
            figure, note = None if gap is None else 1e3 * gap, "gap over the whole travel"
            yield SheetRow("gap to the craft", "scene", figure, 0.0, "mm", note=note, **self._at_all_times)

    def demands(self) -> Iterator[Demand]:
        """Yield what latches and stops must bear, and what the envelope demands of the stacks."""
        rule, bound = self.rules.latch, self.numbers.latch_torque
        envelope = self.travel.hardware.envelope
        if rule is not None and bound is not None:
            arriving = self._arriving_torque()
            if arriving is not None:
                strength = f"{short_number(rule.factor * arriving, 4)} N m"
                yield Demand("strength of latches at yield, by simulated arrivals", strength, rule.clause, "simulated")
            what, most = "the same, if one latch took all energy", f"{short_number(rule.factor * bound, 4)} N m"
            yield Demand(what, most, rule.clause, "proved, from above")
        if envelope and self.travel.linkage.folds_flat:
            what = f"stacks that stand in {envelope}, obliquely too, at most"
            yield Demand(what, self._stacks_in(envelope), "scene", "proved")
        yield from self._damper_torque()

    def _damper_torque(self) -> Iterator[Demand]:
        """Yield the greatest torque of a damper at a state of a simulated deployment, if there are dampers."""
        deployment, damping = self.travel.deployment, np.array(self.travel.setup.damping)
        if deployment is None or not damping.any():
            return
        torques = damping * np.abs(deployment.rates).max(axis=0)
        hinge = int(torques.argmax())
        label = labels_of(self.travel.linkage).hinges[hinge]
        value = f"{short_number(float(torques[hinge]), 4)} N m at hinge {label}"
        yield Demand("greatest torque of a damper", value, "scene", "simulated")

    def dampers(self) -> tuple[tuple[float, tuple[str, ...]], ...]:
        """Return damping and hinges of the dampers that the scene gives."""
        labels, of_hinges = labels_of(self.travel.linkage).hinges, self.travel.setup.dampers()
        return tuple((damping, tuple(labels[k] for k in hinges)) for damping, hinges in sorted(of_hinges.items()))

    def _arriving_torque(self) -> float | None:
        """Return the greatest torque of a latch at a simulated arrival, N m; None without a simulation."""
        if self.travel.deployment is None:
            return None
        loads = arrival_loads(self.travel.deployment, self.travel.hardware.latch_stiffness)
        torques = [float(np.nanmax(load.torques)) for load in loads if np.isfinite(load.torques).any()]
        return max(torques, default=None)

    def _stacks_in(self, envelope: str) -> str:
        """Return in words how thick panels may be in stacks that stand in an envelope, and how many of these may be."""
        footprint = footprint_of(self.travel.linkage)
        length, width, height = (1e-3 * side for side in envelope_sides(envelope))
        thickest = 1e3 * footprint.greatest_thickness((length, width, height))
        layers = footprint.greatest_layers((length, width, height))
        return f"panels {short_number(thickest)} mm thick, or {layers} layers of these" if thickest else "none"

    def springs(self, rows: Sequence[SheetRow]) -> tuple[tuple[str, str], ...]:
        """Return springs with which the motorisation passes, by hinge; none where it passes, or none are known."""
        if not self._too_weak(rows):
            return ()
        try:
            chosen = springs_that_pass(self.travel, self.rules, measured=self.measured)
        except HcsearchError:
            return ()
        labels = labels_of(self.travel.linkage).hinges
        return tuple((label, law.text) for label, law in zip(labels, chosen.setup.laws, strict=True))

    def advice(self, rows: Sequence[SheetRow], springs: Sequence[tuple[str, str]]) -> str:
        """Return a sentence on springs that do not pass; empty where they do."""
        if not self._too_weak(rows):
            return ""
        at_flat = law_torques(self.travel.setup.laws, self.travel.linkage.flat[None])
        who = "the springs of the scene do not pass" if at_flat.any() else "springs without preload cannot pass"
        return f"{who}; {'these would, along the same motion' if springs else 'no preloads were found that would'}"

    def _too_weak(self, rows: Sequence[SheetRow]) -> bool:
        """Return whether a rule on torques does not pass, and its figure is known."""
        torques = rows[: 2 if self.rules.redundancy else 1] if self.rules.motorisation else ()
        return any(row.verdict != "pass" and row.figure is not None for row in torques)

    def omitted(self) -> Iterator[str]:
        """Yield sentences on what was left out, since the scene does not need it."""
        travel, hardware = self.travel, self.travel.hardware
        if not travel.linkage.loops:
            yield "closure: the panels form an open chain"
        if tolerances_of(travel).are_zero:
            yield "clearance over tolerances: the scene gives none"
        if not hardware.craft:
            yield "gaps to the craft: the scene gives no body"
        if not hardware.latch_stiffness.any():
            yield "torque of latches: the scene gives no stiffness"
        if not any(travel.setup.gravity):
            yield "gravity: the scene has none"
        if travel.setup.dampers():
            yield "dampers in the torque of springs over resistance: they do not resist at rest"

    def drawn_margins(self) -> tuple[tuple[float, float], ...]:
        """Return the torque margins at the states of the travel, for a drawing; empty where nothing resists."""
        if self.travel.source == "none" or not np.isfinite(self.margins_at_states.margins).all():
            return ()
        return tuple(zip(self.travel.shares.tolist(), self.margins_at_states.margins.tolist(), strict=True))


_SENSITIVE = ("torque_margin", "torque_margin_failed", "deployed_hz", "latch_torque", "clearance_ratio")
"""Figures whose sensitivities are computed."""
MIN_SENSITIVITY = 1e-6
"""Change of a figure, over the figure, below which it does not depend on a value."""


@work_step("computing sensitivities")
def sensitivities_of(travel: Travel, numbers: FlightNumbers, margins: MarginFigures | None) -> tuple[Sensitivity, ...]:
    """Return how figures change with the springs and the hardware, along the same states, greatest changes first.

    numbers, margins : of the travel. Margins are computed again only where what they depend on changes.
    """
    rows = []
    quantities = [quantity for quantity in FLIGHT_QUANTITIES if quantity.name in _SENSITIVE]
    for name, changed in _CHANGES.items():
        ends = [changed(travel, 1.0 + sign * SENSITIVITY_CHANGE) for sign in (-1.0, 1.0)]
        low, high = (figures_of(end, margins if _have_equal_margins(end, travel) else None) for end in ends)
        for quantity in quantities:
            values = [flight_value(quantity, one) for one in (low, numbers, high)]
            if not all(isinstance(value, float) for value in values):
                continue
            below, figure, above = (float(value) for value in values)  # type: ignore[arg-type]
            spread = abs(above - below) / abs(figure) if figure else 0.0
            if spread > MIN_SENSITIVITY:
                rows.append(Sensitivity(name, quantity.title, below, above, quantity.unit, spread))
    return tuple(sorted(rows, key=lambda row: -row.spread))


def _have_equal_margins(one: Travel, other: Travel) -> bool:
    """Return whether the torque margins of two travels along the same states are equal, as springs and losses are."""
    equal = np.array_equal(one.hardware.resistance, other.hardware.resistance)
    return equal and one.setup.laws == other.setup.laws


def _with_springs(travel: Travel, factor: float) -> Travel:
    laws = tuple(scaled_law(law, factor) for law in travel.setup.laws)
    return travel.with_values(replace(travel.setup, laws=laws))


def _with_density(travel: Travel, factor: float) -> Travel:
    return travel.with_values(replace(travel.setup, density=factor * travel.setup.density))


def _with_hardware(name: str) -> Callable[[Travel, float], Travel]:
    def changed(travel: Travel, factor: float) -> Travel:
        value = factor * getattr(travel.hardware, name)
        return travel.with_values(hardware=replace(travel.hardware, **{name: value}))

    return changed


_CHANGES: dict[str, Callable[[Travel, float], Travel]] = {
    "torque of springs": _with_springs,
    "density of panels": _with_density,
    "friction": _with_hardware("friction"),
    "harness": _with_hardware("harness"),
    "latch stiffness": _with_hardware("latch_stiffness"),
    "tolerance of stops": _with_hardware("stop_tolerance"),
    "play": _with_hardware("play"),
    "tolerance of thickness": _with_hardware("thickness_tolerance"),
    "tolerance of hinge lines": _with_hardware("offset_tolerance"),
}
