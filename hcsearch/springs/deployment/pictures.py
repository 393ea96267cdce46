"""Pictures of deployments: fold angles and energies over time."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.deploying import Deployment
from hcsearch.springs.deployment.facts import energies
from hcsearch.springs.deployment.reasons import collision_sentence
from hcsearch.system.figures import figure_for

if TYPE_CHECKING:
    from hcsearch.system.figures import Axes

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Of Okabe and Ito, which colour-blind people tell apart."""
STYLES: tuple[Any, ...] = ("-", "--", ":", "-.", (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)))
WIDTH, WIDER = 1.4, 1.2
"""Of lines, pt, and by how much they are wider where colours and styles begin anew."""
TITLE = 92
"""Characters in a line of a title."""


def look(number: int) -> dict[str, Any]:
    """Colour, style and width of a line; those of two numbers differ, and of neighbours in colour and style."""
    # there are as many colours as styles and one more: all pairs come before one comes again
    return {
        "color": COLOURS[number % len(COLOURS)],
        "linestyle": STYLES[number % len(STYLES)],
        "linewidth": WIDTH + WIDER * (number // (len(COLOURS) * len(STYLES))),
    }


def legend(axes: Axes, title: str) -> None:
    """The legend of lines, beside the plot, in as many columns as they need."""
    lines = len(axes.get_legend_handles_labels()[0])
    if lines:
        where: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
        axes.legend(title=title, fontsize="x-small", ncols=1 + (lines - 1) // 20, handlelength=3.5, **where)


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


def head(axes: Axes, title: str) -> None:
    """The title, in lines that fit and keep numbers with their units."""
    joined = re.sub(r"(\d) (s|rad|mm)\b", "\\1\N{NO-BREAK SPACE}\\2", title)
    text = textwrap.fill(joined, TITLE).replace("\N{NO-BREAK SPACE}", " ")
    axes.set_title(text, fontsize="medium", parse_math=False)  # names of files may hold dollar signs


def picture(deployment: Deployment, path: str, title: str) -> None:
    """Draw fold angles and energies over time, as PNG, SVG or PDF by the file's ending."""
    motion = deployment.motion
    times = np.linspace(0.0, motion.times[-1], 400) if len(motion.times) > 1 else motion.times
    angles = deployment.compiled.of_hinges(motion.at(times), np.zeros((len(times), motion.q.shape[1])))[0]
    with figure_for(path, (9, 6)) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        for k, (name, column) in enumerate(zip(labels_of(deployment.compiled.linkage).hinges, angles.T, strict=True)):
            above.plot(times, column, label=name, **look(k))
        above.set(ylabel="fold angle, rad")
        head(above, title)
        legend(above, "hinge")
        for event in motion.events:
            if event.kind == "hit":
                above.axvline(event.time, color="grey", linewidth=0.3)
        mark_collision(above, deployment)
        for name, column in energies(deployment).items():
            if np.ptp(column) > 0.0:
                label = name.removesuffix("_J").replace("_", " ")
                below.plot(motion.times, column, label=label, **look(len(below.lines)))
        below.set(xlabel="time, s", ylabel="energy, J")
        legend(below, "energy")
        for axes in (above, below):
            axes.grid(alpha=0.3)
