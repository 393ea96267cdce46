"""Estimates of errors as plain data, and in one line."""

from __future__ import annotations

import math
from typing import Any

from hcsearch.springs.deployment.error_estimates import PARTING_ANGLE, ErrorBar, ErrorEstimates
from hcsearch.system.terminal import short_number

ERROR_KIND = "estimate"
"""What the errors of a deployment are: estimates from simulations at tighter tolerances, and no bounds."""


def error_facts(errors: ErrorEstimates) -> dict[str, Any]:
    """Return estimates of errors as plain data; keys name their units."""
    return {
        "kind": ERROR_KIND,
        "angles_rad": errors.angle,
        "flat_time_s": _facts(errors.flat_time),
        "min_clearance_mm": _facts(errors.clearance, 1e3),
        "latch_rate_rad_s": _facts(errors.latch_rate),
        "torque_N_m": _facts(errors.torque),
        "sensitive": errors.sensitive,
        "reproducible_until_s": errors.reproducible_until,
    }


def _facts(bar: ErrorBar | None, scale: float = 1.0) -> dict[str, float] | None:
    return None if bar is None else {"value": scale * bar.value, "error": scale * bar.error}


def errors_sentence(facts: dict[str, Any]) -> str:
    """Return the errors of `error_facts` in one line."""
    units = {"flat_time_s": "s", "min_clearance_mm": "mm", "latch_rate_rad_s": "rad/s", "torque_N_m": "N m"}
    words = {
        "flat_time_s": "flat time",
        "min_clearance_mm": "clearance",
        "latch_rate_rad_s": "latch rate",
        "torque_N_m": "torque",
    }
    known = [name for name in units if facts[name] is not None]
    parts = [f"{words[name]} {with_error(**facts[name])} {units[name]}" for name in known]
    parts.append(f"fold angles +- {facts['angles_rad']:.0e} rad")
    text = f"{', '.join(parts)} ({ERROR_KIND}s)"
    until = facts["reproducible_until_s"]
    if until is not None:
        text += (
            f"; not reproducible from {short_number(until)} s on, where tolerances differ by {PARTING_ANGLE:g} rad: "
            "verdict and ending stand as said above, and angles and arrivals before"
        )
    return text


def with_error(value: float, error: float) -> str:
    """Return a number in the digits that its error leaves, with the error in one digit, such as `0.141 +- 2e-06`."""
    if not error > 0.0 or not math.isfinite(error):
        return f"{short_number(value, 6)} +- {error:.0e}"
    decimals = max(0, -math.floor(math.log10(error)))
    return f"{value:.{min(decimals, 9)}f} +- {error:.0e}"
