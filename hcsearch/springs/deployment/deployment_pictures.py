"""Pictures of deployments: fold angles and energies over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.deployment_facts import deployment_energies
from hcsearch.springs.deployment.outcomes import collision_sentence
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.system.figures import figure_for, head, legend, line_style

if TYPE_CHECKING:
    from hcsearch.system.figures import Axes


def mark_collision(axes: Axes, deployment: Deployment) -> None:
    """A line where panels first collide, or come too near to tell, if they do."""
    clearance = deployment.clearance
    if clearance is None or clearance.time is None:
        return
    what = "undecided"
    if clearance.panels is not None and clearance.kind == "collides":
        what = collision_sentence(clearance.panels, clearance.time, labels_of(deployment.compiled.linkage))
    axes.axvline(clearance.time, color="red", linewidth=1.0)
    ground = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.0}
    axes.annotate(
        what, (clearance.time, 0.02), xycoords=axes.get_xaxis_transform(), color="red", fontsize="x-small", rotation=90,
        ha="right", va="bottom", bbox=ground,
    )  # fmt: skip


def draw_deployment(deployment: Deployment, path: str, title: str) -> None:
    """Draw fold angles and energies over time, as PNG, SVG or PDF by the file's ending."""
    motion = deployment.motion
    times = np.linspace(0.0, motion.times[-1], 400) if len(motion.times) > 1 else motion.times
    angles = deployment.compiled.of_hinges(motion.at(times), np.zeros((len(times), motion.q.shape[1])))[0]
    with figure_for(path, (9, 6)) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        for k, (name, column) in enumerate(zip(labels_of(deployment.compiled.linkage).hinges, angles.T, strict=True)):
            above.plot(times, column, label=name, **line_style(k))
        above.set(ylabel="fold angle, rad")
        head(above, title)
        legend(above, "hinge")
        for event in motion.events:
            if event.kind == "hit":
                above.axvline(event.time, color="grey", linewidth=0.3)
        mark_collision(above, deployment)
        for name, column in deployment_energies(deployment).items():
            if np.ptp(column) > 0.0:
                label = name.removesuffix("_J").replace("_", " ")
                below.plot(motion.times, column, label=label, **line_style(len(below.lines)))
        below.set(xlabel="time, s", ylabel="energy, J")
        legend(below, "energy")
