"""Pictures of drives: fold angles and torques over time, as planned and as simulated under control."""

from __future__ import annotations

import numpy as np

from hcsearch.drive.driving import Drive
from hcsearch.system.outputs import PICTURES, replacing


def picture(drive: Drive, path: str) -> None:
    """Draw fold angles and torques over time, as planned and as simulated under control."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - only where a picture is wanted

    own, motion, driven = drive.torques, drive.deployment.motion, drive.deployment.driven
    figure = Figure(figsize=(8, 7), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    for column in np.delete(own.angles, own.driven, axis=1).T:
        above.plot(own.times, column, linewidth=0.6, color="grey", alpha=0.6)
    for k in own.driven:
        above.plot(own.times, own.angles[:, k], linewidth=1.6, label=f"{k}")
    above.set(ylabel="fold angle, rad")
    above.set_title(f"{drive.folding.notation}: {drive.deployment.reason}", parse_math=False)
    for number, column in enumerate(own.torques.T):
        (line,) = below.plot(own.times, column, label=f"{own.driven[number]}")
        if driven is not None:
            below.plot(motion.times, driven.torques[:, number], color=line.get_color(), linewidth=0.4, alpha=0.6)
    below.set(xlabel="time, s", ylabel="torque, N m")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        if len(own.driven) <= 24 and own.driven:
            axes.legend(title="driven hinge", fontsize="x-small", ncols=2, loc="upper right")
    with replacing(path, PICTURES) as part:
        figure.savefig(part, dpi=120)
