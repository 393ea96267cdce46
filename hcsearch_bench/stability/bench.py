"""The bench `stability`: scenes over many decades, each with a verdict: accurate, degraded by a bound, or refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from hcsearch.system.figures import figure_for
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table
from hcsearch_bench.stability.judging import (
    ALLOWED,
    ROUNDING,
    SAFETY,
    VERDICTS,
    StabilityRow,
    judge,
    tally,
)
from hcsearch_bench.stability.processors import CORES, ProcessorRow, measure_processors
from hcsearch_bench.stability.sweeps import cases
from hcsearch_bench.stability.truths import STATES

PEERS = ("scipy",)
COLOURS = {"accurate": "#7fc97f", "degraded": "#ffd54a", "refused": "#b8c4d0", "wrong": "#e8342a"}


@dataclass(frozen=True)
class StabilityReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "stability"

    rows: list[StabilityRow]
    processors: list[ProcessorRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved, in order."""
        return [
            Table(
                "counts",
                "Verdicts",
                "`wrong`: the simulation reports success, but the error is beyond the bound or a number is not "
                "finite. `worst` is the greatest error of those that are accurate or degraded.",
                tally(self.rows),
            ),
            Table(
                "stability",
                "Extreme scenes",
                f"`error` (rad) is the greatest distance from `truth` at up to {STATES} states, or the closure "
                "residual if that is greater; where the truth is the energy, it is a share of the largest energy. "
                f"Accurate: at most {ALLOWED:g} tolerances, plus {ROUNDING:g} for rounding. Degraded: within "
                f"`bound`, {SAFETY:g} times the closure residual plus the distance to the same simulation at ten "
                "times the tolerance (penalty: a tenth of the stiffness, or ten times it). Refused: the simulation "
                "itself reports that it has no answer. `energy` is the error of the energy balance over the "
                "largest energy, `gap` the closure residual of the fold angles.",
                self.rows,
            ),
            Table(
                "processors",
                "Processors",
                f"The same computations with the linear algebra that OpenBLAS has for {', '.join(CORES)} "
                "(`kernels`: those that it used), compared with that of this processor. `differ` is the number of "
                "rows with another verdict, number of freedoms or branch; `off` is the greatest relative "
                "difference of times and clearances.",
                self.processors,
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        plot_heat(self.rows, folder / "heat.png")


def measure(*, quick: bool = False, say: Say = print) -> StabilityReport:
    """Run the whole bench: minutes; quick: every third value."""
    machine = this_machine(PEERS)
    say("stability: kernels are compiled")
    judge(next(cases(quick=True)))
    rows, sweep = [], ""
    for case in cases(quick=quick):
        if case.sweep != sweep:
            sweep = case.sweep
            say(f"stability: {sweep}")
        rows.append(judge(case))
    return StabilityReport(machine, rows, measure_processors(quick=quick, say=say))


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
