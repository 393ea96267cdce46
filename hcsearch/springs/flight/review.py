"""The review of a folding: its figures against the rules of a standard, and how they change with the hardware."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.records import FlightNumbers
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.scenes.laws import Law, scaled_law
from hcsearch.shape.labels import labels_of
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.flight_figures import figures_of, least_margins, tolerances_of
from hcsearch.springs.flight.flight_sheet import (
    MIN_SENSITIVITY,
    SENSITIVITY_CHANGE,
    Demand,
    FlightSheet,
    Sensitivity,
    SheetRow,
)
from hcsearch.springs.flight.latching import arrival_loads
from hcsearch.springs.flight.margin_figures import MarginFigures
from hcsearch.springs.flight.rules import JudgedTravel, Rules
from hcsearch.springs.flight.spring_choice import springs_that_pass
from hcsearch.springs.flight.stowage import footprint_of
from hcsearch.springs.flight.travel import Travel
from hcsearch.store.columns import FLIGHT_QUANTITIES, flight_value
from hcsearch.system.terminal import short_number
from hcsearch.system.work_steps import work_step


def review(
    travel: Travel, rules: Rules, *, title: str, source: str, kind: str = "folding", measured: bool = False
) -> FlightSheet:
    """Return the flight sheet of a folding, or of another linkage.

    title : its name, kind : what it is, and source : what moves it, for readers. measured : whether resisting
    torques are measured, for which a standard has smaller factors.
    """
    margins = None if travel.source == "none" else least_margins(travel)
    numbers = figures_of(travel, margins)
    judged = JudgedTravel(travel, rules, numbers, measured)
    rows = tuple(judged.rows())
    weak = _springs_are_weak(rules, rows)
    springs = _springs_instead(judged) if weak else ()
    return FlightSheet(
        title=title,
        kind=kind,
        scene=travel.setup.name,
        source=source,
        standard=rules.standard,
        rows=rows,
        demands=(*_latch_demands(judged), *_stack_demands(travel), *_damper_demands(travel)),
        numbers=numbers,
        sensitivities=sensitivities_of(travel, numbers, margins),
        omitted=tuple(_omitted(travel)),
        springs=springs,
        advice=_advice(travel, springs) if weak else "",
        dampers=_dampers(travel),
        margins=_drawn_margins(judged),
        travel=travel,
    )


def _latch_demands(judged: JudgedTravel) -> Iterator[Demand]:
    """Yield what latches and stops must bear."""
    rule, bound = judged.rules.given.get("latch"), judged.figure("latch_torque")
    if rule is None or bound is None:
        return
    factor, deployment = rule.numbers["factor"], judged.travel.deployment
    if deployment is not None:
        loads = arrival_loads(deployment, np.array(judged.travel.setup.latch_stiffness))
        torques = [float(np.nanmax(load.torques)) for load in loads if np.isfinite(load.torques).any()]
        if torques:
            strength = f"{short_number(factor * max(torques), 4)} N m"
            yield Demand("strength of latches at yield, by simulated arrivals", strength, rule.clause, "simulated")
    what, most = "the same, if one latch took all energy", f"{short_number(factor * bound, 4)} N m"
    yield Demand(what, most, rule.clause, "proved, from above")


def _stack_demands(travel: Travel) -> Iterator[Demand]:
    """Yield how thick panels may be in stacks that stand in the envelope, and how many layers stacks may have."""
    envelope = travel.setup.envelope
    if not envelope or not travel.linkage.folds_flat:
        return
    footprint = footprint_of(travel.linkage)
    length, width, height = (1e-3 * side for side in envelope_sides(envelope))
    thickest = 1e3 * footprint.greatest_thickness((length, width, height))
    layers = footprint.greatest_layers((length, width, height))
    value = f"panels {short_number(thickest)} mm thick, or {layers} layers of these" if thickest else "none"
    yield Demand(f"stacks that stand in {envelope}, obliquely too, at most", value, "scene", "proved")


def _damper_demands(travel: Travel) -> Iterator[Demand]:
    """Yield the greatest torque of a damper at a state of a simulated deployment, if there are dampers."""
    damping = np.array(travel.setup.damping)
    if travel.deployment is None or not damping.any():
        return
    torques = damping * np.abs(travel.deployment.rates).max(axis=0)
    hinge = int(torques.argmax())
    value = f"{short_number(float(torques[hinge]), 4)} N m at hinge {labels_of(travel.linkage).hinges[hinge]}"
    yield Demand("greatest torque of a damper", value, "scene", "simulated")


def _dampers(travel: Travel) -> tuple[tuple[float, tuple[str, ...]], ...]:
    """Return damping and hinges of the dampers that the scene gives."""
    labels, of_hinges = labels_of(travel.linkage).hinges, travel.setup.dampers()
    return tuple((damping, tuple(labels[k] for k in hinges)) for damping, hinges in sorted(of_hinges.items()))


def _springs_are_weak(rules: Rules, rows: Sequence[SheetRow]) -> bool:
    """Return whether a rule on torques does not pass, and its figure is known; these rules are the first rows."""
    torques = rows[: sum(key in rules.given for key in ("motorisation", "redundancy"))]
    return any(row.verdict != "pass" and row.figure is not None for row in torques)


def _springs_instead(judged: JudgedTravel) -> tuple[tuple[str, str], ...]:
    """Return springs with which the motorisation passes, by hinge; none where none are known."""
    try:
        chosen = springs_that_pass(judged.travel, judged.rules, measured=judged.measured)
    except HcsearchError:
        return ()
    labels = labels_of(judged.travel.linkage).hinges
    return tuple((label, law.text) for label, law in zip(labels, chosen.setup.laws, strict=True))


def _advice(travel: Travel, springs: Sequence[tuple[str, str]]) -> str:
    """Return a sentence on springs that do not pass; springs : others that would."""
    at_flat = law_torques(travel.setup.laws, travel.linkage.flat[None])
    who = "the springs of the scene do not pass" if at_flat.any() else "springs without preload cannot pass"
    return f"{who}; {'these would, along the same motion' if springs else 'no preloads were found that would'}"


def _omitted(travel: Travel) -> Iterator[str]:
    """Yield sentences on the parts that were left out, since the scene does not need them."""
    if not travel.linkage.loops:
        yield "closure: the panels form an open chain"
    if tolerances_of(travel).are_zero:
        yield "clearance over tolerances: the scene gives none"
    if not travel.setup.craft:
        yield "gaps to the craft: the scene gives no body"
    if not any(travel.setup.latch_stiffness):
        yield "torque of latches: the scene gives no stiffness"
    if not any(travel.setup.gravity):
        yield "gravity: the scene has none"
    if travel.setup.dampers():
        yield "dampers in the torque of springs over resistance: they do not resist at rest"


def _drawn_margins(judged: JudgedTravel) -> tuple[tuple[float, float], ...]:
    """Return the torque margins at the states of the travel, for a drawing; empty where nothing resists."""
    if judged.travel.source == "none" or not np.isfinite(judged.margins_at_states.margins).all():
        return ()
    return tuple(zip(judged.travel.shares.tolist(), judged.margins_at_states.margins.tolist(), strict=True))


@work_step("computing sensitivities")
def sensitivities_of(travel: Travel, numbers: FlightNumbers, margins: MarginFigures | None) -> tuple[Sensitivity, ...]:
    """Return how figures change with the springs and the hardware, along the same states, greatest changes first.

    numbers, margins : of the travel. Margins are computed again only where springs or losses change. Designs are ranked
    by these figures.
    """
    rows = []
    quantities = [quantity for quantity in FLIGHT_QUANTITIES if quantity.half is not None]
    for name, changed in _CHANGED.items():
        ends = [_with_scaled(travel, changed, 1.0 + sign * SENSITIVITY_CHANGE) for sign in (-1.0, 1.0)]
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
    return one.setup.resistance == other.setup.resistance and one.setup.laws == other.setup.laws


def _with_scaled(travel: Travel, name: str, factor: float) -> Travel:
    """Return a travel with a value of its setup times a factor."""
    value = getattr(travel.setup, name)
    scaled: Any = tuple(_scaled(own, factor) for own in value) if isinstance(value, tuple) else factor * value
    return travel.with_values(replace(travel.setup, **{name: scaled}))


def _scaled(value: Any, factor: float) -> Any:
    return scaled_law(value, factor) if isinstance(value, Law) else factor * value


_CHANGED = {
    "torque of springs": "laws",
    "density of panels": "density",
    "friction": "friction",
    "harness": "harness",
    "latch stiffness": "latch_stiffness",
    "tolerance of stops": "stop_tolerance",
    "play": "play",
    "tolerance of thickness": "thickness_tolerance",
    "tolerance of hinge lines": "offset_tolerance",
}
"""Values of a setup that are changed for sensitivities, by their names for readers."""
