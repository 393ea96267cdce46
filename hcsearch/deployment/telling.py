"""A deployment as plain data, as a table of its states, and as a picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.deployment.agreement import Agreement
from hcsearch.deployment.arrivals import arrivals
from hcsearch.deployment.compiling import OMISSIONS, compile_scene
from hcsearch.deployment.deploying import Deployment, run
from hcsearch.errors import HcsearchError
from hcsearch.outputs import replacing

if TYPE_CHECKING:
    import pandas as pd

FORMATS = (".csv", ".npz", ".parquet")
"""Endings of files that tables are written to."""
PICTURES = (".svg", ".png", ".pdf")


def facts(deployment: Deployment, agreement: Agreement | None = None) -> dict[str, Any]:
    """What became of it; keys name their units, and what overflowed is None.

    agreement : with the same deployment at tighter tolerances, where it comes flat: its verdict and time count.
    """
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in _facts(deployment, agreement).items()
    }


def _facts(deployment: Deployment, agreement: Agreement | None) -> dict[str, Any]:
    compiled, motion = deployment.compiled, deployment.motion
    clearance = deployment.clearance
    books = _books(deployment)
    verdict = deployment.verdict if agreement is None else agreement.verdict
    flat_time = deployment.flat_time if agreement is None else agreement.flat_time
    collides = verdict == "collides"
    return {
        "verdict": verdict,
        "reason": _reason(deployment, deployment.reason if agreement is None else agreement.reason),
        "clearance": None if clearance is None else clearance.kind,
        "collision_s": clearance.time if clearance is not None and collides else None,
        "collision_panels": list(clearance.panels or ()) if clearance is not None and collides else None,
        "min_clearance_mm": None if clearance is None or clearance.gap is None else 1e3 * clearance.gap,
        "margin_mm": 1e3 * compiled.margin,
        "scene": compiled.scene.name,
        "formulation": compiled.formulation,
        "panels": compiled.linkage.n_panels,
        "hinges": compiled.linkage.n_hinges,
        "loops": len(compiled.linkage.loops),
        "joints_simulated": compiled.system.n_joints,
        "seconds": compiled.seconds,
        "outcome": deployment.outcome,
        "flat_time_s": flat_time,
        "end_time_s": float(motion.times[-1]) if flat_time is None else flat_time,
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
                "hinges": compiled.hinges_of(event.joint),
                "kind": event.kind,
                "speed_rad_s": event.speed,
            }
            for event in motion.events
        ],
        "arrivals": [
            {"time_s": a.time, "stop": a.stop, "hinges": list(a.hinges), "speed_rad_s": a.speed}
            for a in arrivals(deployment)
        ],
        "steps": motion.steps,
        "rejected_steps": motion.rejected,
        "evaluations": motion.evaluations,
        "left_out": [{"name": o.name, "what": o.what, "why": o.why} for o in compiled.omissions],
    }


def _driven(deployment: Deployment) -> dict[str, Any]:
    """What drives did, if there are any."""
    driven = deployment.driven
    if driven is None:
        return {}
    return {
        "drive_work_J": float(driven.work[-1]),
        "drive_torque_N_m": float(np.abs(driven.torques).max(initial=0.0)),
        "drive_missed_rad": float(np.abs(driven.missed).max(initial=0.0)),
    }


def _reason(deployment: Deployment, reason: str) -> str:
    """The sentence behind the verdict: a collision first, where there is a certain one."""
    clearance = deployment.clearance
    if deployment.outcome == "diverged" or clearance is None or clearance.kind == "clear" or clearance.panels is None:
        return reason
    one, two = clearance.panels
    what = "collide" if clearance.kind == "collides" else "come too near to be told from a collision"
    return f"panels {one} and {two} {what} at {clearance.time:.4g} s; {reason}"


def table(deployment: Deployment) -> pd.DataFrame:
    """States of a deployment: time, energies, fold angles and rates of all hinges."""
    import pandas as pd  # noqa: PLC0415

    columns = {"time_s": deployment.motion.times, **_books(deployment)}
    hinges = deployment.angles.shape[1]
    columns |= {f"angle_{k}_rad": deployment.angles[:, k] for k in range(hinges)}
    columns |= {f"rate_{k}_rad_s": deployment.rates[:, k] for k in range(hinges)}
    return pd.DataFrame(columns)


def _books(deployment: Deployment) -> dict[str, np.ndarray]:
    motion, factor = deployment.motion, deployment.compiled.factor
    return {
        "kinetic_J": factor * motion.kinetic,
        "stored_J": factor * motion.stored,
        "height_J": factor * motion.height,
        "in_stops_J": factor * motion.in_stops,
        "damped_J": factor * motion.damped,
        "lost_J": factor * motion.lost,
    }


def save_table(deployment: Deployment, path: str) -> None:
    """Write the states to a file, by its ending: .csv, .npz or .parquet (extra `parquet`)."""
    states = table(deployment)
    with replacing(path, FORMATS) as part:
        if part.suffix == ".csv":
            states.to_csv(part, index=False)
        elif part.suffix == ".npz":
            np.savez_compressed(part, allow_pickle=False, **{str(name): states[name].to_numpy() for name in states})
        else:
            try:
                states.to_parquet(part, index=False)
            except ImportError as error:
                raise HcsearchError("Parquet needs an extra: pip install 'hcsearch[parquet]', or write .csv") from error


def savings(deployment: Deployment, *, method: str | None, tolerance: float) -> list[dict[str, Any]]:
    """What each omission saved: the same scene with it kept, in joints, closure equations, evaluations and time."""
    found = []
    for omission in deployment.compiled.omissions:
        if omission.name not in OMISSIONS:
            continue
        compiled = deployment.compiled
        full = compile_scene(compiled.linkage, compiled.scene, compiled.formulation, keep=frozenset({omission.name}))
        other = run(full, method=method, tolerance=tolerance, certified=False)
        again = run(compiled, method=method, tolerance=tolerance, certified=False)
        found.append(
            {
                "name": omission.name,
                "joints": [full.system.n_joints, compiled.system.n_joints],
                "closure_equations": [_rows(full), _rows(compiled)],
                "evaluations": [other.motion.evaluations, again.motion.evaluations],
                "milliseconds": [1e3 * other.seconds, 1e3 * again.seconds],
                "outcomes": [other.outcome, again.outcome],
            }
        )
    return found


def _rows(compiled: Any) -> int:
    return sum(len(weld.kinds) for weld in compiled.system.welds)


def picture(deployment: Deployment, path: str, title: str) -> None:
    """Draw fold angles and energies over time, as PNG, SVG or PDF by the file's ending."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    motion = deployment.motion
    times = np.linspace(0.0, motion.times[-1], 400) if len(motion.times) > 1 else motion.times
    figure = Figure(figsize=(8, 6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    angles = deployment.compiled.of_hinges(motion.at(times), np.zeros((len(times), motion.q.shape[1])))[0]
    for k, column in enumerate(angles.T):
        above.plot(times, column, label=f"{k}")
    above.set(ylabel="fold angle, rad")
    above.set_title(title, parse_math=False)  # names of files may hold dollar signs
    if angles.shape[1] <= 20:
        above.legend(title="hinge", fontsize="x-small", ncols=2)
    for event in motion.events:
        if event.kind == "hit":
            above.axvline(event.time, color="grey", linewidth=0.3)
    if deployment.clearance is not None and deployment.clearance.time is not None:
        above.axvline(deployment.clearance.time, color="red", linewidth=1.0)
    for name, column in _books(deployment).items():
        if np.ptp(column) > 0.0:
            below.plot(motion.times, column, label=name.removesuffix("_J").replace("_", " "))
    below.set(xlabel="time, s", ylabel="energy, J")
    if below.lines:
        below.legend(fontsize="x-small")
    for axes in (above, below):
        axes.grid(alpha=0.3)
    with replacing(path, PICTURES) as part:
        figure.savefig(part, dpi=120)
