"""A drive: plain data, tables, pictures, scene files for `hcsearch deploy`, and the comparison with its plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Way, finite_or_none
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import Setup, scene_of_setup
from hcsearch.shape.angle_curves import draw_angle_curves
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.deployment_facts import mark_collision, play_facts
from hcsearch.springs.deployment.drives import Drives, drives_text
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.springs.drive.choosing import DrivenHinges
from hcsearch.springs.drive.torques import Torques
from hcsearch.springs.drive.trajectory import TimedPath
from hcsearch.system.figures import curve_look, figure_for, label_curves, line_style, set_title
from hcsearch.system.outputs import write_output, write_table

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.system.figures import Axes


DRIVE_SUFFIXES = (".csv", ".parquet", ".toml")
"""Endings of files of the course, and of the scene with the drive."""


@dataclass(frozen=True)
class Drive:
    """The result of `drive`: a driven folding, or another linkage.

    Parameters
    ----------
    subject
        What is driven, as the entries of a scene file.
    linkage, way
        Its panels and hinges, and the joint of its flat pairs.
    choice
        The driven hinges, and how they were evaluated along the path.
    timed
        The planned course in time.
    torques
        The torques along the course.
    drives
        The targets and gains of the driven hinges.
    play
        Least play of each face (m) at which its path is proved clear.
    scene
        The scene with the panels and the flat-pair joint (`way`) of the path.
    setup
        The scene evaluated for the linkage, with the time of the course.
    deployment
        The motion simulated under control, certified at the scene's margin.
    """

    subject: Mapping[str, str]
    way: Way
    linkage: Linkage
    scene: Scene
    setup: Setup
    play: float
    choice: DrivenHinges
    timed: TimedPath
    torques: Torques
    drives: Drives
    deployment: Deployment

    @property
    def title(self) -> str:
        """The name of what is driven."""
        return next(iter(self.subject.values()))

    @property
    def greatest(self) -> Reals:
        """Greatest torque of each driven hinge under control, until the end of the course, (n_driven,), N m."""
        assert self.deployment.driven is not None
        return self.deployment.driven.greatest_torques

    @property
    def missed(self) -> float:
        """Greatest deviation of a hinge, driven or not, from its planned course during the motion (rad)."""
        return float(np.abs(self.deployment.angles - self.timed.at(self.deployment.motion.times)[0]).max())

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch drive --json` prints them; keys name their units."""
        return {name: finite_or_none(value) for name, value in _facts(self).items()}

    def table(self) -> pd.DataFrame:
        """A pandas table of the planned course: time, angles and rates of all hinges, torques of the driven ones."""
        import pandas as pd  # noqa: PLC0415 - only where a table is wanted

        torques, names = self.torques, labels_of(self.linkage).hinges
        columns = {"time_s": torques.times}
        columns |= {f"angle_{name}_rad": torques.angles[:, k] for k, name in enumerate(names)}
        columns |= {f"rate_{name}_rad_s": torques.rates[:, k] for k, name in enumerate(names)}
        columns |= {f"torque_{names[k]}_N_m": torques.torques[:, i] for i, k in enumerate(torques.driven)}
        return pd.DataFrame(columns)

    def save(self, path: str) -> None:
        """Write the planned course to a file .csv or .parquet, or the scene with the drive to a file .toml."""
        if path.endswith(".toml"):
            labels = labels_of(self.linkage)
            scene = scene_of_setup(self.setup, self.scene, labels)
            text = scene_file_text(self.subject, "constrained", scene)
            write_output(path, f"{text}\n{drives_text(self.drives, labels)}")
        else:
            write_table(path, self.table(), DRIVE_SUFFIXES)

    def picture(self, path: str) -> None:
        """Draw fold angles and torques over time into a file .svg, .png or .pdf; simulated torques as a faint band."""
        torques, labels, deployment = self.torques, labels_of(self.linkage), self.deployment
        with figure_for(path, (9, 7), simpler=LINE_SIMPLIFICATION_PIXELS) as figure:
            above, below = figure.subplots(2, 1, sharex=True)
            driven = list(torques.driven)
            names = [labels.hinges[k] for k in driven]
            numbers = draw_angle_curves(above, torques.times, torques.angles[:, driven], names)
            others = np.degrees(np.delete(torques.angles, driven, axis=1))
            for column in others.T:
                above.plot(torques.times, column, linewidth=0.6, color="grey", alpha=0.6)
            if others.size:
                above.set(ylabel="fold angle, degrees (thin grey: not driven)")
            set_title(above, f"{self.title}: {deployment.sentence}")
            mark_collision(above, deployment)
            for name, number, column in zip(names, numbers, torques.torques.T, strict=True):
                below.plot(torques.times, column, label=name, **line_style(number))
            _draw_simulated(below, self, [curve_look(number).colour for number in numbers])
            below.set(xlabel="time, s", ylabel="torque, N m (band: simulated)")
            label_curves(dict.fromkeys((above, below), "driven hinge"))


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


def _greatest(torques: np.ndarray) -> list[float]:
    greatest: list[float] = np.abs(torques).max(axis=0).tolist()
    return greatest


ENVELOPE_PART_COUNT = 60
"""Number of time intervals; the mean, least and greatest simulated torque in each are drawn."""
LINE_SIMPLIFICATION_PIXELS = 0.5
"""Greatest deviation of a simplified line, in pixels."""


def _draw_simulated(axes: Axes, drive: Drive, colours: Sequence[str]) -> None:
    """Draw the simulated torques of each driven hinge: a faint band from the least to the greatest, and their mean."""
    driven = drive.deployment.driven
    if driven is None:
        return
    centres, mean, least, greatest = envelope(drive.deployment.motion.times, driven.torques)
    for number, colour in enumerate(colours):
        axes.fill_between(centres, least[:, number], greatest[:, number], color=colour, alpha=0.2, linewidth=0.0)
        axes.plot(centres, mean[:, number], color=colour, alpha=0.6, linewidth=0.4)


def envelope(times: Reals, values: Reals, parts: int = ENVELOPE_PART_COUNT) -> tuple[Reals, Reals, Reals, Reals]:
    """Return centres of equal time intervals that hold states, and mean, least and greatest of values, (k, n), in each.

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


DRIVE_TORQUE_TOLERANCE = 0.05
"""A drive follows its plan if the greatest torque of each driven hinge is within this share of the planned one."""
MIN_COMPARED_TORQUE_SHARE = 0.01
"""Lower bound of the planned torque in that comparison, as a share of the greatest of all hinges."""
DRIVE_ANGLE_TOLERANCE = 0.02
"""Greatest deviation of a hinge from its planned angle (rad) with which a drive follows."""
DEAD_POINT_SINGULAR_VALUE = 0.05
"""Least singular value of the reduced Jacobian below which a dead point is near."""
SINGULAR_CLOSURE_VALUE = 0.01
"""Least singular value of the closure Jacobian below which loops are nearly singular."""


@dataclass(frozen=True)
class Following:
    """The comparison of a drive with its plan.

    follows : whether it follows. share : greatest difference between the greatest torques of a driven hinge under
    control and planned, over the planned one. sentence : both, with a remedy where it does not follow.
    """

    follows: bool
    share: float
    sentence: str


def judge_following(drive: Drive) -> Following:
    """Compare a drive with its plan."""
    planned, greatest = np.abs(drive.torques.torques).max(axis=0), drive.greatest
    shares = np.abs(greatest - planned) / np.maximum(
        np.maximum(planned, MIN_COMPARED_TORQUE_SHARE * planned.max(initial=0.0)), 1e-12
    )
    worst = int(shares.argmax())
    share = float(shares[worst])
    if share <= DRIVE_TORQUE_TOLERANCE and drive.missed <= DRIVE_ANGLE_TOLERANCE:
        return Following(True, share, f"follows: greatest torques are within {_percent(share)} of those planned")
    cause = f"hinges miss their planned angles by up to {drive.missed:.2g} rad"
    if share > DRIVE_TORQUE_TOLERANCE:
        hinge = labels_of(drive.linkage).hinges[drive.drives.hinges[worst]]
        cause = f"hinge {hinge} takes {greatest[worst]:.3g} N m where {planned[worst]:.3g} are planned"
    return Following(False, share, f"does not follow: {cause}; {_remedy(drive)}")


def _remedy(drive: Drive) -> str:
    """Return a remedy for a drive that does not follow, or the advice where there is none.

    Where loops are nearly singular, the manifold of closed states bends sharply, and the torques that a controller adds
    there depend on rounding.
    """
    assert drive.deployment.driven is not None
    drives, driven = drive.drives, drive.deployment.driven
    times = np.linspace(0.0, drive.timed.seconds, 5000)
    interpolated, plan = drives.interpolated(times), drives.at(times)
    interpolation_torque = _most(
        interpolated[2]
        - plan[2]
        + drives.stiffness * (interpolated[0] - plan[0])
        + drives.damping * (interpolated[1] - plan[1])
    )
    if interpolation_torque > 0.5 * _most(driven.torques - driven.planned):
        return "give a shorter --period, or a smaller --rate"
    if drive.choice.least_value < DEAD_POINT_SINGULAR_VALUE:
        return "a dead point is near: drive more hinges (a greater --firm)"
    if drive.choice.closure_value < SINGULAR_CLOSURE_VALUE:
        location = f"{drive.choice.closure_place:.2g} of the path"
        return f"its loops are nearly singular at {location}: size motors by simulated torques, or try other panels"
    return "give a smaller --rate and --acceleration, or drive more hinges (a greater --firm)"


def _most(values: Reals) -> float:
    return float(np.abs(values).max(initial=0.0))


def _percent(share: float) -> str:
    return f"{max(100.0 * share, 0.1):.2g} %"
