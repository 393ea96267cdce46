"""The review of a folding: its figures against the rules of a standard, and how they change with the hardware."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.records import FlightNumbers
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.scenes.laws import scaled_law
from hcsearch.shape.labels import labels_of
from hcsearch.springs.flight.flight_figures import figures_of, root_of, tolerances_of, travel_margins
from hcsearch.springs.flight.flight_sheet import SENSITIVITY_CHANGE, FlightSheet, Sensitivity, SheetRow
from hcsearch.springs.flight.footprints import footprint_of
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
    numbers = figures_of(travel)
    reviewed = _Review(travel, rules, numbers, measured)
    rows = tuple(reviewed.rows())
    return FlightSheet(
        title=title,
        scene=travel.setup.name,
        source=source,
        standard=rules.standard,
        rows=rows,
        demands=tuple(reviewed.demands()),
        numbers=numbers,
        sensitivities=sensitivities_of(travel, numbers),
        omitted=tuple(reviewed.omitted()),
        springs=reviewed.springs(rows),
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
            note = "least gap over the tolerances, a lower bound" if numbers.clearance_ratio else "no tolerances given"
            yield SheetRow("clearance over tolerances", clause, numbers.clearance_ratio, ratio, note=note)
        if rules.frequency is not None:
            note = "rigid panels on their latches, a lower bound"
            yield SheetRow(
                "deployed frequency", rules.frequency.clause, numbers.deployed_hz, rules.frequency.hz, "Hz", note=note
            )
        if rules.flatness is not None:
            yield self._flatness(rules.flatness.clause, rules.flatness.mm)
        yield from self._scene_rows()

    def _motorisation(self, rule: MotorisationRule) -> Iterator[SheetRow]:
        """Yield the rows on torques, with all springs and with one failed."""
        friction, harness = rule.weights(measured=self.measured)
        kind = "measured" if self.measured else "theoretical"
        margins = self._weighted_margins(harness / friction)
        yield self._torque_row("torque of springs over resistance", rule.clause, margins, friction, f"{kind} factors")
        if self.rules.redundancy is not None:
            clause = self.rules.redundancy.clause
            yield self._torque_row("the same, one spring failed", clause, margins, friction, "", failed=True)

    def _weighted_margins(self, harness: float) -> PathMargins | None:
        """Return the margins with a weight of the harness relative to friction; None without a motion."""
        travel, hardware = self.travel, self.travel.hardware
        if travel.source == "none":
            return None
        return travel_margins(travel, resistance=hardware.friction + harness * hardware.harness)

    def _torque_row(
        self, name: str, clause: str, margins: PathMargins | None, required: float, note: str, *, failed: bool = False
    ) -> SheetRow:
        if margins is None:
            return SheetRow(name, clause, None, required, note="no motion")
        state = margins.least_failed_state if failed else margins.least_state
        least = float((margins.failed if failed else margins.margins)[state])
        if math.isinf(least):
            return SheetRow(name, clause, None, required, note="no friction and no harness given")
        labels = labels_of(self.travel.linkage).hinges
        hinge = int((margins.failed_hinges if failed else margins.hinges)[state])
        at = f"least at {short_number(100.0 * float(self.travel.shares[state]), 3)} % of the travel"
        who = "" if hinge < 0 else f"spring {labels[hinge]} failed" if failed else f"hinge {labels[hinge]}"
        guided = float((margins.along_failed if failed else margins.along).min())
        # of a simulated motion it says nothing: inertia drives hinges against their springs
        differs = self.travel.source == "path" and guided < least * (1.0 - MIN_SENSITIVITY)
        path = f"guided along the path {short_number(guided, 3)}" if differs else ""
        return SheetRow(name, clause, least, required, note=", ".join(filter(None, (who, at, path, note))))

    def _flatness(self, clause: str, greatest: float) -> SheetRow:
        tolerances = tolerances_of(self.travel)
        if tolerances.are_zero:
            return SheetRow(
                "flatness as built", clause, None, greatest, "mm", at_least=False, note="no tolerances given"
            )
        shape = shape_errors(self.travel.linkage, tolerances, root_of(self.travel))
        worst = 1e3 * (shape.flatness + shape.second_order)
        return SheetRow(
            "flatness as built", clause, worst, greatest, "mm", at_least=False, note="worst case, an upper bound"
        )

    def _scene_rows(self) -> Iterator[SheetRow]:
        hardware = self.travel.hardware
        if hardware.envelope:
            box = stowage_of(self.travel.linkage, self.travel.setup.density).packed
            note = f"{box.text} into {hardware.envelope}"
            yield SheetRow("room in the envelope", "scene", 1e3 * box.room_in(hardware.envelope), 0.0, "mm", note=note)
        if hardware.craft:
            gap = self.numbers.craft_clearance
            note = "gap over the whole travel, a lower bound"
            yield SheetRow("gap to the craft", "scene", None if gap is None else 1e3 * gap, 0.0, "mm", note=note)

    def demands(self) -> Iterator[tuple[str, str, str]]:
        """Yield what latches and stops must bear, and what the envelope demands of the stacks."""
        rule, torque = self.rules.latch, self.numbers.latch_torque
        envelope = self.travel.hardware.envelope
        if rule is not None and torque is not None:
            strength = f"{short_number(rule.factor * torque, 4)} N m"
            yield "strength of latches at yield, at least", strength, rule.clause
        if envelope and self.travel.linkage.folds_flat:
            yield f"stacks that stand in {envelope}, obliquely too, at most", self._stacks_in(envelope), "scene"

    def _stacks_in(self, envelope: str) -> str:
        """Return in words how thick panels may be in stacks that stand in an envelope, and how many of these may be."""
        footprint = footprint_of(self.travel.linkage)
        length, width, height = (1e-3 * side for side in envelope_sides(envelope))
        thickest = 1e3 * footprint.greatest_thickness((length, width, height))
        layers = footprint.greatest_layers((length, width, height))
        return f"panels {short_number(thickest)} mm thick, or {layers} layers of these" if thickest else "none"

    def springs(self, rows: Sequence[SheetRow]) -> tuple[tuple[str, str], ...]:
        """Return springs with which the motorisation passes, by hinge; none where it passes, or none are found."""
        rule = self.rules.motorisation
        if rule is None or not any(row.verdict == "fail" and row.figure is not None for row in rows[:2]):
            return ()
        try:
            chosen = springs_that_pass(self.travel, self.rules, measured=self.measured)
        except HcsearchError:
            return ()
        labels = labels_of(self.travel.linkage).hinges
        return tuple((label, law.text) for label, law in zip(labels, chosen.setup.laws, strict=True))

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

    def drawn_margins(self) -> tuple[tuple[float, float], ...]:
        """Return the torque margin along the travel, for a drawing; empty where nothing resists."""
        margins = self._weighted_margins(1.0)
        if margins is None or not np.isfinite(margins.margins).all():
            return ()
        return tuple(zip(self.travel.shares.tolist(), margins.margins.tolist(), strict=True))


_SENSITIVE = ("torque_margin", "torque_margin_failed", "deployed_hz", "latch_torque", "clearance_ratio")
"""Figures whose sensitivities are computed."""
MIN_SENSITIVITY = 1e-6
"""Change of a figure, over the figure, below which it does not depend on a value."""


@work_step("computing sensitivities")
def sensitivities_of(travel: Travel, numbers: FlightNumbers) -> tuple[Sensitivity, ...]:
    """Return how figures change with the springs and the hardware, along the same states, greatest changes first."""
    rows = []
    quantities = [quantity for quantity in FLIGHT_QUANTITIES if quantity.name in _SENSITIVE]
    for name, changed in _CHANGES.items():
        low, high = (figures_of(changed(travel, 1.0 + sign * SENSITIVITY_CHANGE)) for sign in (-1.0, 1.0))
        for quantity in quantities:
            values = [flight_value(quantity, one) for one in (low, numbers, high)]
            if not all(isinstance(value, float) for value in values):
                continue
            below, figure, above = (float(value) for value in values)  # type: ignore[arg-type]
            spread = abs(above - below) / abs(figure) if figure else 0.0
            if spread > MIN_SENSITIVITY:
                rows.append(Sensitivity(name, quantity.title, below, above, quantity.unit, spread))
    return tuple(sorted(rows, key=lambda row: -row.spread))


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
