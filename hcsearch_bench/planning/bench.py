"""The bench `planning`: what is settled of all foldings of some sets, against work, margin and thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.system.figures import figure_for
from hcsearch.system.outputs import write_output
from hcsearch_bench.planning.beside_ompl import JoinedFolding, PeerRow, peer_rows
from hcsearch_bench.planning.efforts import EffortRow, effort_rows
from hcsearch_bench.planning.foldings import (
    BudgetRow,
    FoldingRow,
    Group,
    GroupRow,
    MarginRow,
    ThicknessRow,
    budget_rows,
    group_row,
    margin_rows,
    settle,
    thickness_row,
)
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table, frame

GROUPS = (Group("hex", "12", 4), Group("hex", "10", 2), Group("square", "6x5", 12))
QUICK = (Group("hex", "8"), Group("triangle", "10"), Group("square", "4x3"))
LISTS = (Group("square", "12"), Group("rectangle", "10"), Group("hex", "10"), Group("hex", "12"))
"""Lists that are settled effort by effort."""
QUICK_LISTS = (Group("square", "8"),)
EFFORTS, QUICK_EFFORTS = 4, 3
THICKNESSES, QUICK_THICKNESSES = (0.0015, 0.003, 0.012, 0.024), (0.003,)
"""Beside 6 mm, m."""
SUBJECTS: tuple[JoinedFolding, ...] = (
    ("hex:0234550132:4", "hinged"),
    ("square:012233230011:4", "rigid"),
    ("triangle:012343454505012321:3", "hinged"),
    ("hex:022443440011:1", "rigid"),
    ("square:012233332111123333300001210121:1", "rigid"),
    ("hex:0234340511:3", "hinged"),
)
LIMIT, QUICK_LIMIT = 5.0, 0.5
"""Processor seconds of one search beside a peer."""
SEARCHES = 3
PEERS = ("ompl",)


@dataclass(frozen=True)
class PlanningReport(BenchReport):
    """All that one run of the bench measured; rows : of single foldings, which are saved and not shown."""

    page: ClassVar[str] = "planning"

    groups: list[GroupRow]
    efforts: list[EffortRow]
    work: list[BudgetRow]
    margins: list[MarginRow]
    thicknesses: list[ThicknessRow]
    peers: list[PeerRow]
    rows: list[FoldingRow]

    def rows_of(self, group: GroupRow) -> list[FoldingRow]:
        """The foldings of a set, with the panels of the scene `default`."""
        return [row for row in self.rows if row.group == group.group][: group.foldings]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved, in order."""
        return [
            Table(
                "groups",
                "What is settled",
                "All untwisted foldings, up to symmetry, in the scene `default`, each by the stages `mobility` and "
                "`motion`. `movable`: a path from packed to flat is proved. `locked`: the folding is proved locked "
                "with every way of joining flat pairs. `share`: the share of both together. Times are processor "
                "times on one core.",
                self.groups,
            ),
            Table(
                "efforts",
                "Settled by effort",
                "All untwisted foldings of a list, by `motion_of` in the scene `default`, effort by effort "
                "(motion.md). `movable`: a path is proved; `locked`: it is proved that there is none. `spent_s` is the "
                "processor time of all efforts so far, on one core, `longest_s` that of a single folding.",
                self.efforts,
            ),
            Table(
                "work",
                "Share settled against work",
                "The search for each folding ends after `budget_s` of processor time. The table gives the number "
                "of settled foldings, and `spent_s`, the time for the whole set.",
                self.work,
            ),
            Table(
                "margins",
                "Share settled against margin",
                "Panels may have no more play than `margin_mm` on every face. The least margin at which the path "
                "of a folding is proved is an upper bound of the play that it needs.",
                self.margins,
            ),
            Table(
                "thicknesses",
                "Share settled against thickness",
                "Edges are 50 mm long. Of some sets a part is used, at equal intervals of the list. `tight`: "
                "movable with the least margin, 0.01 mm on every face. Locks are those of panels 6 mm thick: locks "
                "of first order depend on no length (theory.md, 27), and no thickness that was tried released one "
                "of the others.",
                self.thicknesses,
            ),
            Table(
                "peers",
                "Single searches in comparison with OMPL",
                f"With 0.1 mm of play on every face, a search has {LIMIT:g} s of processor time ({QUICK_LIMIT:g} s "
                "with `--quick`). `met` is the number of searches that reach a path in time, `median_s` their "
                "time, and `proved` the number of paths that the proof of hcsearch accepts. OMPL runs RRT-Connect "
                "on the closed states (ProjectedStateSpace), with the projection and the check of stops and gaps "
                "of hcsearch, but without its check between two states. Closure is singular at both ends, and "
                "projections do not leave them; so OMPL begins with the states near the ends that the planner of "
                "hcsearch generates, and this time counts. The time of hcsearch includes shortening the path and "
                "moving it away from contact.",
                self.peers,
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        single = Table("foldings", "", "", self.rows)
        write_output(folder / "foldings.csv", frame(single).to_csv(index=False))
        plot_planning(self, folder / "planning.png")


def measure(*, quick: bool = False, say: Say = print) -> PlanningReport:
    """Run the whole bench: three quarters of an hour, or seconds when `quick`."""
    machine = this_machine(PEERS)
    groups = QUICK if quick else GROUPS
    list(settle(QUICK[-1]))  # compiled
    rows, shown = [], []
    for group in groups:
        rows.append(list(settle(group)))
        shown.append(group_row(rows[-1]))
        say(f"{group.name}: {shown[-1].share:.0%} of {shown[-1].foldings} settled in {shown[-1].total_s:.3g} s")
    efforts: list[EffortRow] = []
    for group in QUICK_LISTS if quick else LISTS:
        efforts += effort_rows(group, QUICK_EFFORTS if quick else EFFORTS)
        say(f"{group.name}: {efforts[-1].share:.0%} settled by {efforts[-1].efforts} efforts")
    sweeps = []
    for group, own in zip(groups, rows, strict=True):
        sweeps.append([own[:: group.sampled]])
        for thickness in QUICK_THICKNESSES if quick else THICKNESSES:
            say(f"{group.name}, panels {1e3 * thickness:g} mm thick")
            sweeps[-1].append(list(settle(group, thickness, group.sampled)))
    peers: list[PeerRow] = []
    for subject in SUBJECTS[1:2] if quick else SUBJECTS:
        say(f"beside OMPL: {subject[0]}")
        peers += peer_rows(subject, 1 if quick else SEARCHES, QUICK_LIMIT if quick else LIMIT)
    return PlanningReport(
        machine,
        shown,
        efforts,
        [row for own in rows for row in budget_rows(own)],
        [row for own in rows for row in margin_rows(own)],
        [row for sweep in sweeps for row in sorted(map(thickness_row, sweep), key=lambda row: row.thickness_mm)],
        peers,
        [row for own in rows for row in own] + [row for sweep in sweeps for own in sweep[1:] for row in own],
    )


def plot_planning(report: PlanningReport, path: Path) -> None:
    """Share settled against processor seconds of a folding and of the set, against margin and against thickness."""
    with figure_for(path, (15, 8)) as figure:
        each, whole, effort, margin, thickness, empty = figure.subplots(2, 3, sharey=True).ravel()
        empty.set_axis_off()
        names = dict.fromkeys([row.group for row in report.groups] + [row.group for row in report.efforts])
        colours = {name: f"C{k}" for k, name in enumerate(names)}
        for name in dict.fromkeys(row.group for row in report.efforts):
            lines = [row for row in report.efforts if row.group == name]
            effort.plot([row.spent_s for row in lines], [row.share for row in lines], "o-", color=colours[name])
        effort.set(xlabel="processor seconds on all of a list, effort by effort")
        for group in report.groups:
            own, colour = report.rows_of(group), colours[group.group]
            budgets, shares, spent = curve(own)
            each.step(budgets, shares, where="post", color=colour)
            whole.step(spent, shares, where="post", color=colour)
            margins = [row for row in report.margins if row.group == group.group]
            margin.plot([row.margin_mm for row in margins], [row.share for row in margins], "o-", color=colour)
            sweep = [row for row in report.thicknesses if row.group == group.group]
            thickness.plot([row.thickness_mm for row in sweep], [row.share for row in sweep], "o-", color=colour)
        each.set(xlabel="processor seconds a folding may take", ylabel="share settled", ylim=(0.0, 1.02))
        whole.set(xlabel="processor seconds on all of the set")
        margin.set(xlabel="play on every face at most (mm)", ylabel="share settled")
        thickness.set(xlabel="thickness of panels (mm), edges 50 mm")
        for axes in (each, whole, effort, margin, thickness):
            axes.set_xscale("log")
            axes.grid(alpha=0.3)
        for axes, lengths in (
            (margin, {row.margin_mm for row in report.margins}),
            (thickness, {row.thickness_mm for row in report.thicknesses}),
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
