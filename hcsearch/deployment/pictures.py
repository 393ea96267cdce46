"""Pictures of deployments: fold angles and energies over time."""

from __future__ import annotations

import numpy as np

from hcsearch.deployment.deploying import Deployment
from hcsearch.deployment.facts import energies
from hcsearch.system.outputs import PICTURES, replacing


def picture(deployment: Deployment, path: str, title: str) -> None:
    """Draw fold angles and energies over time, as PNG, SVG or PDF by the file's ending."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - only where a picture is wanted

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
    for name, column in energies(deployment).items():
        if np.ptp(column) > 0.0:
            below.plot(motion.times, column, label=name.removesuffix("_J").replace("_", " "))
    below.set(xlabel="time, s", ylabel="energy, J")
    if below.lines:
        below.legend(fontsize="x-small")
    for axes in (above, below):
        axes.grid(alpha=0.3)
    with replacing(path, PICTURES) as part:
        figure.savefig(part, dpi=120)
