"""Reports of a drive: plain data, tables, pictures, and scene files for `hcsearch deploy`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import scene_of_setup
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.springs.deployment.deployment_facts import finite_or_none, mark_collision, play_facts
from hcsearch.springs.deployment.drives import drives_text
from hcsearch.springs.deployment.outcomes import reason_with_clearance
from hcsearch.springs.drive.driven_folding import Drive, Latch, judge_following
from hcsearch.system.figures import add_legend, curve_look, figure_for, line_style, set_title
from hcsearch.system.outputs import write_output, write_table

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.springs.deployment.simulated_deployment import Deployment
    from hcsearch.system.figures import Axes


def drive_facts(drive: Drive) -> dict[str, Any]:
    """Return a drive as plain data; keys name their units, and numbers that are not finite are None."""
    return {name: finite_or_none(value) for name, value in _facts(drive).items()}


def _facts(drive: Drive) -> dict[str, Any]:
    choice, deployment = drive.choice, drive.deployment
    labels = labels_of(drive.linkage)
    clearance = deployment.clearance
    following = judge_following(drive)
    span = float(np.ptp(drive.torques.stored) + np.ptp(drive.torques.kinetic) + np.ptp(drive.torques.height))
    return {
        "verdict": deployment.verdict,
        "motor_torque_N_m": max(_greatest(drive.torques.torques), default=0.0),
        "control": following.sentence,
        "reason": deployment.reason,
        "clearance": None if clearance is None else clearance.kind,
        "margin_mm": 1e3 * deployment.compiled.margin,
        **play_facts(deployment),
        "path_play_mm": 1e3 * drive.play,
        "flat_pairs": drive.way,
        "scene": drive.scene.name,
        "hinges": drive.linkage.n_hinges,
        "freedoms": choice.freedoms,
        "merged_panels": list(labels.merged),
        "driven": [label_data(labels.hinges[hinge]) for hinge in choice.hinges],
        "driven_monotone": [label_data(labels.hinges[hinge]) for hinge in choice.monotone],
        "least_singular_value": choice.least_value,
        "least_at": choice.least_place,
        "closure_least_singular_value": choice.closure_value,
        "closure_least_at": choice.closure_place,
        "sets_tried": choice.tried,
        "from_packed_rad": drive.timed.path.end_angles[0],
        "to_flat_rad": drive.timed.path.end_angles[1],
        "beyond_stops_rad": drive.timed.path.stop_overshoot,
        "seconds": drive.timed.seconds,
        "flat_time_s": deployment.flat_time,
        "greatest_rate_rad_s": float(np.abs(drive.torques.rates).max()),
        "greatest_acceleration_rad_s2": float(np.abs(drive.torques.accelerations).max()),
        "missed_rad": drive.missed,
        "follows": following.follows,
        "torque_from_plan": following.share,
        "planned_torque_N_m": _greatest(drive.torques.torques),
        "torque_rms_N_m": np.sqrt((drive.torques.torques**2).mean(axis=0)).tolist(),
        "torque_N_m": drive.greatest.tolist(),
        "gain_N_m_rad": drive.drives.stiffness.tolist(),
        "gain_N_m_s_rad": drive.drives.damping.tolist(),
        "energy_imbalance": drive.torques.imbalance / span if span else 0.0,
        "work_J": float(deployment.driven.work[-1]) if deployment.driven is not None else None,
    }


def latch_facts(latches: tuple[Latch, ...], deployment: Deployment) -> dict[str, Any]:
    """Return latches, and the verdict on the deployment by springs alone with them, as plain data."""
    clearance = deployment.clearance
    names = [label_data(name) for name in labels_of(deployment.compiled.linkage).hinges]
    return {
        "latches": [
            {"hinge": names[latch.hinge], "waits_for": names[latch.waits_for], "angle_rad": latch.angle}
            for latch in latches
        ],
        "latched_verdict": deployment.verdict,
        "latched_reason": deployment.reason,
        "latched_clearance": None if clearance is None else clearance.kind,
    }


def _greatest(torques: np.ndarray) -> list[float]:
    greatest: list[float] = np.abs(torques).max(axis=0).tolist()
    return greatest


def drive_table(drive: Drive) -> pd.DataFrame:
    """Return the planned course: time, fold angles and rates of all hinges, torques of the driven ones."""
    import pandas as pd  # noqa: PLC0415 - only where a table is wanted

    torques = drive.torques
    names = labels_of(drive.linkage).hinges
    columns = {"time_s": torques.times}
    columns |= {f"angle_{name}_rad": torques.angles[:, k] for k, name in enumerate(names)}
    columns |= {f"rate_{name}_rad_s": torques.rates[:, k] for k, name in enumerate(names)}
    columns |= {f"torque_{names[k]}_N_m": torques.torques[:, i] for i, k in enumerate(torques.driven)}
    return pd.DataFrame(columns)


DRIVE_TABLE_SUFFIXES = (".csv", ".parquet")
"""Endings of files of the course."""
DRIVE_SCENE_SUFFIXES = (".toml",)


def save_drive(drive: Drive, path: str) -> None:
    """Write the course of a drive (.csv, .parquet), or a scene with the drive (.toml)."""
    if path.endswith(DRIVE_SCENE_SUFFIXES):
        labels = labels_of(drive.linkage)
        scene = scene_of_setup(drive.setup, drive.scene, labels)
        text = scene_file_text({"design": drive.folding.notation}, "constrained", scene)
        write_output(path, f"{text}\n{drives_text(drive.drives, labels)}")
    else:
        write_table(path, drive_table(drive), DRIVE_TABLE_SUFFIXES)


ENVELOPE_PART_COUNT = 60
"""Number of time intervals, for each of which mean, least and greatest simulated torque are drawn."""
LINE_SIMPLIFICATION_PIXELS = 0.5
"""Greatest deviation of a simplified line, in pixels."""


def draw_drive(drive: Drive, path: str) -> None:
    """Draw fold angles and torques over time: planned torques as lines, simulated ones as a mean in a faint band."""
    torques, labels, deployment = drive.torques, labels_of(drive.linkage), drive.deployment
    with figure_for(path, (9, 7), simpler=LINE_SIMPLIFICATION_PIXELS) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        for number, k in enumerate(torques.driven):
            above.plot(torques.times, torques.angles[:, k], label=labels.hinges[k], zorder=3.0, **line_style(number))
        for number, column in enumerate(np.delete(torques.angles, torques.driven, axis=1).T):
            label = "_others" if number else "others"
            above.plot(torques.times, column, linewidth=0.6, color="grey", alpha=0.6, label=label)
        above.set(ylabel="fold angle, rad")
        reason = reason_with_clearance(deployment.reason, deployment.outcome, deployment.clearance, labels)
        set_title(above, f"{drive.folding.notation}: {reason}")
        mark_collision(above, deployment)
        for number, column in enumerate(torques.torques.T):
            below.plot(torques.times, column, label=labels.hinges[torques.driven[number]], **line_style(number))
        _draw_simulated(below, drive)
        below.set(xlabel="time, s", ylabel="torque, N m (band: simulated)")
        for axes in (above, below):
            add_legend(axes, "driven hinge")


def _draw_simulated(axes: Axes, drive: Drive) -> None:
    """Draw the simulated torques of each driven hinge: a faint band from the least to the greatest, and their mean."""
    driven = drive.deployment.driven
    if driven is None:
        return
    centres, mean, least, greatest = envelope(drive.deployment.motion.times, driven.torques)
    for number in range(mean.shape[1]):
        colour = curve_look(number).colour
        axes.fill_between(centres, least[:, number], greatest[:, number], color=colour, alpha=0.2, linewidth=0.0)
        axes.plot(centres, mean[:, number], color=colour, alpha=0.6, linewidth=0.4)


def envelope(times: Reals, values: Reals, parts: int = ENVELOPE_PART_COUNT) -> tuple[Reals, Reals, Reals, Reals]:
    """Return centres, mean, least and greatest of values, (k, n), in those of equal time intervals that hold states.

    The mean is over time, by the trapezoidal rule.
    """
    edges = np.linspace(times[0], times[-1], parts + 1)[1:-1]
    part = np.searchsorted(edges, times, side="right")
    first = np.flatnonzero(np.r_[True, np.diff(part) > 0])
    least, greatest = np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)
    step = np.diff(times)
    weight = 0.5 * (np.r_[step, 0.0] + np.r_[0.0, step]) + 1e-300
    whole = np.add.reduceat(weight, first)
    mean = np.add.reduceat(values * weight[:, None], first) / whole[:, None]
    return np.add.reduceat(times * weight, first) / whole, mean, least, greatest
