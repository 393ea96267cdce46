"""A deployment as plain data, and as a table of its states."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.vocabulary import millimetres, play_sentence
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.springs.deployment.agreement import Agreement, hinge_arrivals
from hcsearch.springs.deployment.outcomes import reason_with_clearance
from hcsearch.springs.deployment.simulated_deployment import Deployment

if TYPE_CHECKING:
    import pandas as pd


def deployment_facts(deployment: Deployment, agreement: Agreement | None = None) -> dict[str, Any]:
    """What became of it; keys name their units, and what overflowed is None.

    agreement : with the same deployment at tighter tolerances, where it becomes flat: its verdict and time count.
    """
    return {name: finite_or_none(value) for name, value in _facts(deployment, agreement).items()}


def finite_or_none(value: Any) -> Any:
    """A value with None in the place of numbers that are not finite, in lists, too."""
    if isinstance(value, list):
        return [finite_or_none(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _facts(deployment: Deployment, agreement: Agreement | None) -> dict[str, Any]:
    compiled, motion = deployment.compiled, deployment.motion
    clearance = deployment.clearance
    books = deployment_energies(deployment)
    verdict = deployment.verdict if agreement is None else agreement.verdict
    flat_time = deployment.flat_time if agreement is None else agreement.flat_time
    reason = deployment.reason if agreement is None else agreement.reason
    untimed = agreement is not None and agreement.untimed
    collides = verdict == "collides"
    labels = labels_of(compiled.linkage)
    panels, hinges = [label_data(name) for name in labels.panels], [label_data(name) for name in labels.hinges]
    return {
        "verdict": verdict,
        "reason": reason_with_clearance(reason, deployment.outcome, clearance, labels),
        "clearance": None if clearance is None else clearance.kind,
        "collision_s": clearance.time if clearance is not None and collides else None,
        "collision_panels": [panels[k] for k in clearance.panels or ()] if clearance is not None and collides else None,
        "margin_mm": 1e3 * compiled.margin,
        **play_facts(deployment, agreement),
        "scene": compiled.setup.name,
        "formulation": compiled.formulation,
        "panels": compiled.linkage.n_panels,
        "hinges": compiled.linkage.n_hinges,
        "merged_panels": list(labels.merged),
        "loops": len(compiled.linkage.loops),
        "joints_simulated": compiled.system.n_joints,
        "seconds": compiled.seconds,
        "outcome": deployment.outcome,
        "flat_time_s": flat_time,
        "end_time_s": float(motion.times[-1]) if flat_time is None and not untimed else flat_time,
        "other_tolerances": None if agreement is None else [one.tolerance for one in agreement.others],
        "other_outcomes": None if agreement is None else [one.outcome for one in agreement.others],
        "widest_angle_rad": float(np.abs(deployment.angles[-1]).max(initial=0.0)),
        "energy_start_J": float(sum(books[name][0] for name in ("kinetic_J", "stored_J", "height_J"))),
        "energy_damped_J": float(books["damped_J"][-1]),
        "energy_lost_at_stops_J": float(books["lost_J"][-1]),
        **_driven(deployment),
        "energy_drift_J": compiled.factor * (motion if deployment.driven is None else deployment.driven).drift,
        "closure_gap": motion.gap,
        "events": [
            {
                "time_s": event.time,
                "hinges": [hinges[k] for k in compiled.hinges_of(event.joint)],
                "kind": event.kind,
                "speed_rad_s": event.speed,
            }
            for event in motion.events
        ],
        "arrivals": [
            {"time_s": a.time, "stop": a.stop, "hinges": [hinges[k] for k in a.hinges], "speed_rad_s": a.speed}
            for a in hinge_arrivals(deployment)
        ],
        "steps": motion.steps,
        "rejected_steps": motion.rejected,
        "evaluations": motion.evaluations,
        "left_out": [{"name": o.name, "what": o.what, "why": o.why} for o in compiled.omissions],
    }


def play_facts(deployment: Deployment, agreement: Agreement | None = None) -> dict[str, Any]:
    """The gaps of a deployment, mm, and how much to leave between faces; agreement : as of `deployment_facts`.

    Where panels as built overlap, the smallest gap is that overlap, below 0.
    """
    play, gap = deployment.play, None if deployment.clearance is None else deployment.clearance.gap
    if agreement is not None and agreement.verdict != "deploys":
        play = None
    needed = None if play is None else play.needed_margin
    if agreement is not None and agreement.needed_margin is not None:
        needed = agreement.needed_margin
    return {
        "min_clearance_mm": millimetres(gap if play is None else play.clearance(gap)),
        "least_gap_mm": None if play is None else millimetres(play.least_gap),
        "needed_margin_mm": millimetres(needed),
        "play": play_sentence(millimetres(needed)),
    }


def _driven(deployment: Deployment) -> dict[str, Any]:
    """What drives did, if there are any."""
    driven = deployment.driven
    if driven is None:
        return {}
    return {
        "drive_work_J": float(driven.work[-1]),
        "drive_torque_N_m": float(driven.greatest.max(initial=0.0)),
        "drive_missed_rad": float(np.abs(driven.missed).max(initial=0.0)),
    }


def deployment_table(deployment: Deployment) -> pd.DataFrame:
    """States of a deployment: time, energies, fold angles and rates of all hinges, by their names."""
    import pandas as pd  # noqa: PLC0415 - only where a table is wanted

    columns = {"time_s": deployment.motion.times, **deployment_energies(deployment)}
    names = labels_of(deployment.compiled.linkage).hinges
    columns |= {f"angle_{name}_rad": deployment.angles[:, k] for k, name in enumerate(names)}
    columns |= {f"rate_{name}_rad_s": deployment.rates[:, k] for k, name in enumerate(names)}
    return pd.DataFrame(columns)


def deployment_energies(deployment: Deployment) -> dict[str, np.ndarray]:
    """Energies at the states of a motion, J, with those of a half that was left out."""
    motion, factor = deployment.motion, deployment.compiled.factor
    return {
        "kinetic_J": factor * motion.kinetic,
        "stored_J": factor * motion.stored,
        "height_J": factor * motion.height,
        "in_stops_J": factor * motion.in_stops,
        "damped_J": factor * motion.damped,
        "lost_J": factor * motion.lost,
    }
