"""The figures of one folding, from its travel: what a scene does not need is left out."""

from __future__ import annotations

import math
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.records import FlightNumbers
from hcsearch.shape.labels import labels_of
from hcsearch.springs.flight.build_errors import BuildTolerances
from hcsearch.springs.flight.clearance_ratio import clearance_ratio
from hcsearch.springs.flight.law_torques import law_torques
from hcsearch.springs.flight.path_margins import PathMargins, margins_along, path_rates
from hcsearch.springs.flight.shape_errors import shape_errors
from hcsearch.springs.flight.travel import Travel


def figures_of(travel: Travel) -> FlightNumbers:
    """Return the figures of a folding in a scene."""
    figures = _shape(travel)
    if travel.source != "none":
        figures |= _margins(travel) | _clearance(travel)
    return FlightNumbers(**figures)


def tolerances_of(travel: Travel) -> BuildTolerances:
    """Return the tolerances with which an array is built."""
    hardware = travel.hardware
    return BuildTolerances(
        tuple(hardware.stop_tolerance.tolist()),
        tuple(hardware.play.tolist()),
        hardware.offset_tolerance,
        hardware.thickness_tolerance,
    )


def travel_margins(travel: Travel) -> PathMargins:
    """Return the torque margins at the states of a travel."""
    rates = path_rates(travel.linkage, travel.states)
    return margins_along(rates, law_torques(travel.setup.laws, travel.states), travel.hardware.resistance)


def _margins(travel: Travel) -> dict[str, Any]:
    margins = travel_margins(travel)
    state, failed = margins.least_state, margins.least_failed_state
    least, hinge = float(margins.margins[state]), int(margins.hinges[state])
    if math.isinf(least):  # nothing resists, and springs drive at every state
        return {}
    return {
        "torque_margin": least,
        "torque_margin_hinge": labels_of(travel.linkage).hinges[hinge] if hinge >= 0 else None,
        "torque_margin_at": float(travel.shares[state]),
        "torque_margin_failed": _finite(float(margins.failed[failed])),
    }


def _shape(travel: Travel) -> dict[str, Any]:
    root = travel.setup.held if travel.hardware.root is None else travel.hardware.root
    shape = shape_errors(travel.linkage, tolerances_of(travel), root)
    return {
        "self_stresses": shape.self_stresses,
        "flatness": shape.flatness_per_rad,
        "tilt": shape.tilt_per_rad,
    }


def _clearance(travel: Travel) -> dict[str, Any]:
    tolerances = tolerances_of(travel)
    if not (any(tolerances.angles) or tolerances.offset or tolerances.thickness):
        return {}
    try:
        course, slack = travel.course
    except HcsearchError:
        return {}
    greatest = slack if isinstance(slack, float) else float(slack.max(initial=0.0))
    ratio = clearance_ratio(travel.linkage, course, greatest, tolerances, travel.setup.margin)
    return {"clearance_ratio": None if ratio is None else ratio.ratio}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
