"""Springs with which a folding passes the motorisation of a standard: least preloads, or springs that are offered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import FREE_LAW, Law, law_named, preloaded_law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.spring_sets import tied_hinges
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.certified_margins import CERTIFIED_SHARE
from hcsearch.springs.flight.flight_figures import least_margins
from hcsearch.springs.flight.rules import Rules
from hcsearch.springs.flight.spring_design import SpringRule, choose_springs, least_preloads
from hcsearch.springs.flight.travel import Travel

GREATEST_PRELOAD_FACTOR = 1000.0
"""Greatest preload that is tried, over the greatest resisting torque times the required margin."""
PRELOAD_DIGITS = 3
"""Digits to which preloads are rounded up."""
RAISES = (1.0, 1.01, 1.02, 1.03, 1.04, 1.05, 1.1, 1.2, 1.3, 1.4)
"""Factors of the required margin that are asked for in turn, until springs pass as a flight sheet judges them: its
bound between states is a little below the least margin, and more beside singular states, and with other digits of a
preload it may find another motion at a singular end."""
MAX_STATES_ADDED, ADDED_SHARES = 4, 1e-4 * np.array([-9.0, -3.0, -1.0, 0.0, 1.0, 3.0, 9.0])
"""Greatest number of times that states are added where chosen springs have too little margin, and how far beside that
place, in shares of the time of the path."""


@dataclass(frozen=True, eq=False)
class ChosenSprings(ByValue):
    """Springs that pass the motorisation rule at all states of a travel.

    setup : with their laws. preloads : (n_hinges,), N m, added to the springs of the scene; zeros where springs that
    are offered were chosen. margin, required : torque margins, also with any one spring failed where `redundant`.
    lower_bound : no preloads of a smaller sum pass, N m; None for springs that are offered.
    """

    linkage: Linkage
    setup: Setup
    preloads: Reals
    margin: float
    required: float
    redundant: bool
    lower_bound: float | None

    def facts(self) -> dict[str, Any]:
        """Return the springs as plain data, in the order of `hinges`."""
        hinges = [label_data(name) for name in labels_of(self.linkage).hinges]
        return {
            "hinges": hinges,
            "springs": [law.text for law in self.setup.laws],
            "preload_N_m": self.preloads.tolist(),
            "total_preload_N_m": float(self.preloads.sum()),
            "no_smaller_total_passes_N_m": self.lower_bound,
            "torque_margin": self.margin,
            "required": self.required,
            "one_spring_failed": self.redundant,
        }


def springs_that_pass(
    travel: Travel, rules: Rules, *, measured: bool = False, offers: Sequence[str] = ()
) -> ChosenSprings:
    """Choose springs with which a folding passes the motorisation of a standard, also with one failed if it asks so.

    offers : laws of springs that can be bought; each hinge gets one or none. Without offers the springs of the scene
    get the least preloads. Mirror hinges get equal springs. Springs are judged at the states of the travel: with other
    springs a deployment takes another way, which `hcsearch sheet` reviews.
    HcsearchError where nothing resists, the standard has no motorisation, or no springs pass.
    """
    own, travel = travel, travel.standard  # congruent foldings get equal springs
    laws, lower_bound = [law_named(text) for text in offers], None
    raises = iter(RAISES)
    raised = next(raises)
    for turn in range(MAX_STATES_ADDED + len(RAISES)):
        rule = _spring_rule(travel, rules, measured=measured)
        asked = replace(rule, required=raised * rule.required)
        first = lower_bound is None
        setup, preloads, bound = _of_offers(travel, asked, laws) if offers else _with_preloads(travel, asked, first)
        lower_bound = bound if lower_bound is None else lower_bound  # of the rule itself
        found = least_margins(travel.with_values(setup), rule.friction)
        judged = found if rule.redundant else found[:1]
        margins = [figure.value for figure in judged if figure.value is not None]
        # deployed by these springs it takes another way, whose bound may end at this share of the same least margin
        share = 1.0 if travel.source == "path" else CERTIFIED_SHARE
        if len(margins) == len(judged) and share * min(margins) >= rule.required:
            of_own = _of_own(own, setup), preloads[_standard_of(own)]
            return ChosenSprings(own.linkage, *of_own, min(margins), rule.required, rule.redundant, lower_bound)
        weak = [figure.time for figure in judged if figure.time is not None and figure.least < rule.required]
        if weak and turn < MAX_STATES_ADDED:  # between the states that the springs were chosen for
            travel = travel.with_states(_beside(travel.course[0].times, weak))
        elif (next_raise := next(raises, None)) is not None:
            raised = next_raise
        else:
            break
    raise HcsearchError(
        f"no springs were found with a torque margin of {rule.required:g} at all points of the travel: give less "
        "friction, or other springs"
    )


def _beside(times: Reals, weak: Sequence[float]) -> Reals:
    """Return times of a course beside those at which springs are too weak."""
    ends = float(times[0]), float(times[-1])
    beside = np.add.outer(weak, (ends[1] - ends[0]) * ADDED_SHARES)
    return np.unique(beside[(beside > ends[0]) & (beside < ends[1])])


def _standard_of(travel: Travel) -> WholeNumbers:
    """Return the hinge of the standard travel for each hinge of a travel."""
    return np.argsort(travel.standard_hinges)


def _of_own(travel: Travel, setup: Setup) -> Setup:
    """Return the setup of a travel with the laws of one of its standard travel."""
    return replace(travel.setup, laws=tuple(setup.laws[hinge] for hinge in _standard_of(travel)))


def _spring_rule(travel: Travel, rules: Rules, *, measured: bool) -> SpringRule:
    """Return what springs have to satisfy along a travel."""
    if "motorisation" not in rules.given:
        raise HcsearchError(f"{rules.standard} asks for no torque of springs: name rules with a table [motorisation]")
    if travel.source == "none":
        raise HcsearchError("springs are chosen along a motion: name a folding that moves")
    resistance = rules.resistance(travel.setup, measured=measured)
    if not resistance.any():
        raise HcsearchError("nothing resists the springs: give friction or harness in the scene, or --friction 0.001")
    required, _ = rules.weights(measured=measured)
    return SpringRule(travel.rates, resistance, required, _groups(travel), redundant="redundancy" in rules.given)


def _groups(travel: Travel) -> WholeNumbers:
    groups = np.empty(travel.linkage.n_hinges, np.int64)
    for number, hinges in enumerate(tied_hinges(travel.linkage, travel.setup.held)):
        groups[list(hinges)] = number
    return groups


def _with_preloads(travel: Travel, rule: SpringRule, bounded: bool) -> tuple[Setup, Reals, float]:
    """Add least preloads to the springs of the scene; return them, and a bound of their sum, 0 if unasked."""
    torques = law_torques(travel.setup.laws, travel.states)
    design = least_preloads(
        rule, torques, GREATEST_PRELOAD_FACTOR * rule.required * float(rule.friction.max()), bounded=bounded
    )
    preloads = _rounded_up(design.preloads)
    laws = tuple(preloaded_law(law, float(preload)) for law, preload in zip(travel.setup.laws, preloads, strict=True))
    return replace(travel.setup, laws=laws), preloads, design.lower_bound


def _rounded_up(preloads: Reals) -> Reals:
    """Round numbers up to `PRELOAD_DIGITS`."""
    steps = np.array(
        [10.0 ** (math.floor(math.log10(value)) + 1 - PRELOAD_DIGITS) if value > 0.0 else 1.0 for value in preloads]
    )
    rounded: Reals = np.array([float(f"{value:.10g}") for value in np.ceil(preloads / steps - 1e-9) * steps]) + 0.0
    return rounded


def _of_offers(travel: Travel, rule: SpringRule, offers: Sequence[Law]) -> tuple[Setup, Reals, None]:
    """Choose one of some springs, or none, at each hinge: as few as pass."""
    catalogue = [FREE_LAW, *offers]
    fields = np.array([law_torques([law] * travel.linkage.n_hinges, travel.states) for law in catalogue])
    costs = np.array([0.0, *(1.0 for _ in offers)])
    design = choose_springs(rule, np.zeros_like(fields[0]), fields, costs)
    laws = tuple(catalogue[k] for k in design.springs.tolist())
    return replace(travel.setup, laws=laws), np.zeros(len(laws)), None
