"""Reports of a deployment, as in `hcsearch deploy`: plain data, a table and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.vocabulary import Formulation, Verdict, finite_or_none, millimetres, play_sentence
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup
from hcsearch.shape.angle_curves import draw_angle_curves
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.agreement import Agreement, confirm_deployment
from hcsearch.springs.deployment.drives import Drives
from hcsearch.springs.deployment.error_estimates import error_facts
from hcsearch.springs.deployment.outcomes import collision_sentence, reason_with_clearance
from hcsearch.springs.deployment.simulated_deployment import Deployment, hinge_arrivals, simulate_deployment
from hcsearch.system.figures import figure_for, label_curves, line_style, set_title
from hcsearch.system.notebooks import notebook_view

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.system.figures import Axes


def deployment_facts(deployment: Deployment, agreement: Agreement | None = None) -> dict[str, Any]:
    """Return a deployment as plain data; keys name their units, and numbers that are not finite are None.

    agreement : with the same deployment at tighter tolerances; its verdict, time and outcome are used.
    """
    return {name: finite_or_none(value) for name, value in _facts(deployment, agreement).items()}


def _facts(deployment: Deployment, agreement: Agreement | None) -> dict[str, Any]:
    compiled, motion = deployment.compiled, deployment.motion
    clearance = deployment.clearance
    energies = deployment_energies(deployment)
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
        "method": motion.method,
        "panels": compiled.linkage.n_panels,
        "hinges": compiled.linkage.n_hinges,
        "merged_panels": list(labels.merged),
        "loops": len(compiled.linkage.loops),
        "joints_simulated": compiled.system.n_joints,
        "seconds": compiled.seconds,
        "outcome": deployment.outcome if agreement is None else agreement.outcome,
        "flat_time_s": flat_time,
        "end_time_s": float(motion.times[-1]) if flat_time is None and not untimed else flat_time,
        "other_tolerances": None if agreement is None else [other.tolerance for other in agreement.others],
        "other_outcomes": None if agreement is None else [other.outcome for other in agreement.others],
        "errors": None if agreement is None or agreement.errors is None else error_facts(agreement.errors),
        "widest_angle_rad": float(np.abs(deployment.angles[-1]).max(initial=0.0)),
        "energy_start_J": float(sum(energies[name][0] for name in ("kinetic_J", "stored_J", "height_J"))),
        "energy_damped_J": float(energies["damped_J"][-1]),
        "energy_lost_at_stops_J": float(energies["lost_J"][-1]),
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
            {
                "time_s": arrival.time,
                "stop": arrival.stop,
                "hinges": [hinges[k] for k in arrival.hinges],
                "speed_rad_s": arrival.speed,
            }
            for arrival in hinge_arrivals(deployment)
        ],
        "steps": motion.steps,
        "rejected_steps": motion.rejected,
        "evaluations": motion.evaluations,
        "left_out": [
            {"name": omission.name, "what": omission.what, "why": omission.why} for omission in compiled.omissions
        ],
    }


def play_facts(deployment: Deployment, agreement: Agreement | None = None) -> dict[str, Any]:
    """Return the gaps of a deployment, mm, and the play to leave between faces; agreement : as in `deployment_facts`.

    Where panels as built overlap, the smallest gap is the overlap, with a negative sign.
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
    """Return work, greatest torque and greatest error of the drives, if there are any."""
    driven = deployment.driven
    if driven is None:
        return {}
    return {
        "drive_work_J": float(driven.work[-1]),
        "drive_torque_N_m": float(driven.greatest_torques.max(initial=0.0)),
        "drive_missed_rad": float(np.abs(driven.angle_errors).max(initial=0.0)),
    }


def deployment_table(deployment: Deployment) -> pd.DataFrame:
    """Return the states of a deployment: time, energies, fold angles and rates of all hinges, by their names."""
    import pandas as pd  # noqa: PLC0415 - only where a table is wanted

    columns = {"time_s": deployment.motion.times, **deployment_energies(deployment)}
    names = labels_of(deployment.compiled.linkage).hinges
    columns |= {f"angle_{name}_rad": deployment.angles[:, k] for k, name in enumerate(names)}
    columns |= {f"rate_{name}_rad_s": deployment.rates[:, k] for k, name in enumerate(names)}
    return pd.DataFrame(columns)


def deployment_energies(deployment: Deployment) -> dict[str, np.ndarray]:
    """Return the energies at the states of a motion, J, an omitted half included."""
    motion, factor = deployment.motion, deployment.compiled.factor
    return {
        "kinetic_J": factor * motion.kinetic,
        "stored_J": factor * motion.stored,
        "height_J": factor * motion.height,
        "in_stops_J": factor * motion.in_stops,
        "damped_J": factor * motion.damped,
        "lost_J": factor * motion.lost,
    }


def mark_collision(axes: Axes, deployment: Deployment) -> None:
    """Draw a line at the time of the first certain or possible collision, if there is one."""
    clearance = deployment.clearance
    if clearance is None or clearance.time is None:
        return
    note = "undecided"
    if clearance.panels is not None and clearance.kind == "collides":
        note = collision_sentence(clearance.panels, clearance.time, labels_of(deployment.compiled.linkage))
    axes.axvline(clearance.time, color="red", linewidth=1.0)
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.0}
    axes.annotate(
        note, (clearance.time, 0.02), xycoords=axes.get_xaxis_transform(), color="red", fontsize="x-small", rotation=90,
        ha="right", va="bottom", bbox=box,
    )  # fmt: skip


def draw_deployment(deployment: Deployment, path: str, title: str) -> None:
    """Draw fold angles and energies over time, as PNG, SVG or PDF by the file's ending."""
    motion = deployment.motion
    times = np.linspace(0.0, motion.times[-1], 400) if len(motion.times) > 1 else motion.times
    angles = deployment.angles_at(times)
    with figure_for(path, (9, 6)) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        draw_angle_curves(above, times, angles, labels_of(deployment.compiled.linkage).hinges)
        set_title(above, title)
        for event in motion.events:
            if event.kind == "hit":
                above.axvline(event.time, color="grey", linewidth=0.3)
        mark_collision(above, deployment)
        for name, column in deployment_energies(deployment).items():
            if np.ptp(column) > 0.0:
                label = name.removesuffix("_J").replace("_", " ")
                below.plot(motion.times, column, label=label, **line_style(len(below.lines)))
        below.set(xlabel="time, s", ylabel="energy, J")
        label_curves({above: "hinge", below: "energy"})


@dataclass(frozen=True, repr=False)
class Deployed:
    """The result of `deploy`: the verdict, the reason for it, and the simulated motion.

    Parameters
    ----------
    name
        The name of the folding or assembly.
    deployment
        The simulation, with its states.
    agreement
        The agreement with simulations at tighter tolerances; None if the array is driven, or certainly does not become
        flat.
    """

    name: str
    deployment: Deployment
    agreement: Agreement | None

    @property
    def verdict(self) -> Verdict:
        """`deploys` (flat and certified free of collisions at all tolerances), `collides` or `undecided`."""
        return self.deployment.verdict if self.agreement is None else self.agreement.verdict

    @property
    def flat_time(self) -> float | None:
        """The time at which the array is flat, s, in the digits on which all tolerances agree; None if it never is."""
        return self.deployment.flat_time if self.agreement is None else self.agreement.flat_time

    @property
    def needed_margin(self) -> float | None:
        """The least margin on every face, m, at which it is certified clear at all tolerances; None unless it deploys.

        Twice this margin must be left between faces.
        """
        if self.verdict != "deploys" or self.deployment.play is None:
            return None
        return self.deployment.play.needed_margin if self.agreement is None else self.agreement.needed_margin

    @property
    def least_gap(self) -> float | None:
        """The least gap of the panels as built, m, below 0 where they overlap; None unless it deploys."""
        return None if self.needed_margin is None or self.deployment.play is None else self.deployment.play.least_gap

    @property
    def reason(self) -> str:
        """The reason for the verdict, in words that name panels and hinges."""
        return str(self.facts()["reason"])

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch deploy --json` prints them; keys name their units."""
        return deployment_facts(self.deployment, self.agreement)

    def table(self) -> pd.DataFrame:
        """A pandas table of times, energies, fold angles and rates, as `hcsearch deploy --output` writes it."""
        return deployment_table(self.deployment)

    def picture(self, path: str) -> None:
        """Draw fold angles and energies over time into a file .svg, .png or .pdf."""
        draw_deployment(self.deployment, path, f"{self.name}: {self.verdict}, {self.reason}")

    def _repr_html_(self) -> str | None:
        return notebook_view(self)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.verdict}, {self.reason}>"


def deploy_linkage(
    name: str,
    linkage: Linkage,
    scene: Scene | Setup,
    formulation: Formulation = "constrained",
    *,
    method: str | None = None,
    tolerance: float = 1e-6,
    drives: Drives | None = None,
) -> Deployed:
    """Deploy a linkage in a scene; simulate it at tighter tolerances, too, if its ending by springs may be doubtful."""
    deployment = simulate_deployment(linkage, scene, formulation, method=method, tolerance=tolerance, drives=drives)
    agreement = None if drives is not None else confirm_deployment(deployment, method=method, tolerance=tolerance)
    return Deployed(name, deployment, agreement)
