"""Pictures of drives: fold angles and torques over time, as planned and as simulated under control."""

from __future__ import annotations

import numpy as np

from hcsearch.deployment.pictures import head, legend, look, mark_collision
from hcsearch.deployment.reasons import reason_with_clearance
from hcsearch.drive.driving import Drive
from hcsearch.labels import labels_of
from hcsearch.system.outputs import PICTURES, replacing


def picture(drive: Drive, path: str) -> None:
    """Draw fold angles and torques over time, as planned and as simulated under control."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - only where a picture is wanted

    own, motion, driven = drive.torques, drive.deployment.motion, drive.deployment.driven
    labels, deployment = labels_of(drive.linkage), drive.deployment
    figure = Figure(figsize=(9, 7), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    for number, k in enumerate(own.driven):
        above.plot(own.times, own.angles[:, k], label=labels.hinges[k], zorder=3.0, **look(number))
    for number, column in enumerate(np.delete(own.angles, own.driven, axis=1).T):
        above.plot(own.times, column, linewidth=0.6, color="grey", alpha=0.6, label="_others" if number else "others")
    above.set(ylabel="fold angle, rad")
    reason = reason_with_clearance(deployment.reason, deployment.outcome, deployment.clearance, labels)
    head(above, f"{drive.folding.notation}: {reason}")
    mark_collision(above, deployment)
    for number, column in enumerate(own.torques.T):
        below.plot(own.times, column, label=labels.hinges[own.driven[number]], **look(number))
        if driven is not None:
            thin = look(number) | {"linewidth": 0.4, "linestyle": "-", "alpha": 0.6}
            below.plot(motion.times, driven.torques[:, number], **thin)
    below.set(xlabel="time, s", ylabel="torque, N m")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        legend(axes, "driven hinge")
    with replacing(path, PICTURES) as part:
        figure.savefig(part, dpi=120)
