"""The picture of the bench `stability`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from hcsearch.system.figures import figure_for
from hcsearch_bench.stability.judging import VERDICTS, StabilityRow

COLOURS = {"accurate": "#7fc97f", "degraded": "#ffd54a", "refused": "#b8c4d0", "wrong": "#e8342a"}
"""Of cells, light enough for the numbers that stand on them."""


def plot_heat(rows: Sequence[StabilityRow], path: Path) -> None:
    """A line a sweep, subject and method; a cell a value: coloured by verdict, with value and decade of the error."""
    lines: dict[str, list[StabilityRow]] = {}
    for row in rows:
        lines.setdefault(_line(row), []).append(row)
    widest = max(map(len, lines.values()))
    with figure_for(path, (4.5 + 0.75 * widest, 1.0 + 0.36 * len(lines)), dpi=150) as figure:
        from matplotlib.patches import Patch, Rectangle

        axes = figure.subplots()
        for y, line in enumerate(lines.values()):
            for x, row in enumerate(sorted(line, key=lambda row: row.value)):
                axes.add_patch(Rectangle((x, y), 0.96, 0.92, color=COLOURS[row.verdict], lw=0))
                axes.text(x + 0.05, y + 0.44, f"{row.value:g}", fontsize=5.5, va="bottom", color="0.25")
                if row.error is not None and row.verdict != "refused":
                    decade = math.log10(max(row.error, 1e-16))
                    axes.text(x + 0.9, y + 0.86, f"{decade:.1f}", fontsize=7, ha="right", va="bottom", weight="bold")
        axes.set(
            xlim=(0, widest),
            ylim=(len(lines), 0),
            xticks=[],
            yticks=[y + 0.46 for y in range(len(lines))],
            yticklabels=list(lines),
            title="small: the value swept; bold: log10 of the error",
        )
        axes.grid(visible=False)
        axes.tick_params(length=0, labelsize=7)
        for side in axes.spines.values():
            side.set_visible(False)
        figure.legend(
            handles=[Patch(color=COLOURS[verdict], label=verdict) for verdict in VERDICTS],
            loc="outside lower center",
            ncols=len(VERDICTS),
        )


def _line(row: StabilityRow) -> str:
    """The line of the heat map that a row is on: all numbers of panels, and both singular starts, are on one."""
    subject = row.subject.removesuffix(", flat")
    if row.sweep == "panels":
        subject = subject.partition(" of ")[0]
    formulation = "" if row.formulation == "constrained" else f", {row.formulation}"
    return f"{row.sweep}: {subject}, {row.method}{formulation}"
