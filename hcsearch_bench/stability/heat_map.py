"""The picture of the bench `stability`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hcsearch.springs.accuracy.stability_report import decade_text, draw_judged_cell, finish_map
from hcsearch.system.figures import figure_for
from hcsearch_bench.stability.judging import StabilityRow


def plot_heat(rows: Sequence[StabilityRow], path: Path) -> None:
    """A line a sweep, subject and method; a cell a value: coloured by verdict, with value and decade of the error."""
    lines: dict[str, list[StabilityRow]] = {}
    for row in rows:
        lines.setdefault(_line(row), []).append(row)
    widest = max(map(len, lines.values()))
    with figure_for(path, (4.5 + 0.75 * widest, 1.0 + 0.36 * len(lines)), dpi=150) as figure:
        axes = figure.subplots()
        for y, line in enumerate(lines.values()):
            for x, row in enumerate(sorted(line, key=lambda row: row.value)):
                shown = "" if row.error is None or row.verdict == "refused" else decade_text(row.error)
                draw_judged_cell(axes, (x, y), row.verdict, shown)
                axes.text(x + 0.05, y + 0.44, f"{row.value:g}", fontsize=5.5, va="bottom", color="0.25")
        axes.set(
            xlim=(0, widest),
            ylim=(len(lines), 0),
            xticks=[],
            yticks=[y + 0.46 for y in range(len(lines))],
            yticklabels=list(lines),
            title="small: the value swept; bold: log10 of the error",
        )
        finish_map(axes)


def _line(row: StabilityRow) -> str:
    """The line of the heat map that a row is on: all numbers of panels, and both singular starts, are on one."""
    subject = row.subject.removesuffix(", flat")
    if row.sweep == "panels":
        subject = subject.partition(" of ")[0]
    formulation = "" if row.formulation == "constrained" else f", {row.formulation}"
    return f"{row.sweep}: {subject}, {row.method}{formulation}"
