"""Pictures of the bench `planning`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.system.figures import figure_for
from hcsearch_bench.planning.folding_rows import FoldingRow
from hcsearch_bench.planning.planning_results import PlanningResults


def plot_planning(results: PlanningResults, path: Path) -> None:
    """Share settled against processor seconds of a folding and of the set, against margin and against thickness."""
    with figure_for(path, (15, 8)) as figure:
        each, whole, effort, margin, thickness, empty = figure.subplots(2, 3, sharey=True).ravel()
        empty.set_axis_off()
        names = dict.fromkeys([row.group for row in results.groups] + [row.group for row in results.efforts])
        colours = {name: f"C{k}" for k, name in enumerate(names)}
        for name in dict.fromkeys(row.group for row in results.efforts):
            lines = [row for row in results.efforts if row.group == name]
            effort.plot([row.spent_s for row in lines], [row.share for row in lines], "o-", color=colours[name])
        effort.set(xlabel="processor seconds on all of a list, effort by effort")
        for group in results.groups:
            own, colour = results.rows_of(group), colours[group.group]
            budgets, shares, spent = curve(own)
            each.step(budgets, shares, where="post", color=colour)
            whole.step(spent, shares, where="post", color=colour)
            margins = [row for row in results.margins if row.group == group.group]
            margin.plot([row.margin_mm for row in margins], [row.share for row in margins], "o-", color=colour)
            sweep = [row for row in results.thicknesses if row.group == group.group]
            thickness.plot([row.thickness_mm for row in sweep], [row.share for row in sweep], "o-", color=colour)
        each.set(xlabel="processor seconds a folding may take", ylabel="share settled", ylim=(0.0, 1.02))
        whole.set(xlabel="processor seconds on all of the set")
        margin.set(xlabel="play on every face at most (mm)", ylabel="share settled")
        thickness.set(xlabel="thickness of panels (mm), edges 50 mm")
        for axes in (each, whole, effort, margin, thickness):
            axes.set_xscale("log")
        for axes, lengths in (
            (margin, {row.margin_mm for row in results.margins}),
            (thickness, {row.thickness_mm for row in results.thicknesses}),
        ):
            ticks = sorted(lengths)
            axes.set_xticks(ticks, labels=[f"{tick:g}" for tick in ticks])
            axes.minorticks_off()
        empty.legend([empty.plot([], color=colour)[0] for colour in colours.values()], list(colours), loc="center left")


def curve(rows: Sequence[FoldingRow]) -> tuple[Reals, Reals, Reals]:
    """Seconds that each folding may take, rising; the share that is settled then, and the seconds spent on all."""
    budgets = np.sort([row.seconds for row in rows])
    settled = np.sort([row.seconds for row in rows if row.settled])
    shares = np.searchsorted(settled, budgets, side="right") / len(rows)
    return budgets, shares, np.minimum(budgets, budgets[:, None]).sum(axis=1)
