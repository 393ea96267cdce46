"""What one run of the bench `planning` measures."""

from __future__ import annotations

from dataclasses import dataclass

from hcsearch_bench.planning.effort_rows import EffortRow, effort_rows
from hcsearch_bench.planning.folding_rows import (
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
from hcsearch_bench.planning.search_rows import JoinedFolding, SearchRow, search_rows
from hcsearch_bench.run.bench import Say

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


@dataclass(frozen=True)
class PlanningResults:
    """All that one run of the bench measured; rows : of single foldings, which are saved and not shown."""

    groups: list[GroupRow]
    efforts: list[EffortRow]
    work: list[BudgetRow]
    margins: list[MarginRow]
    thicknesses: list[ThicknessRow]
    peers: list[SearchRow]
    rows: list[FoldingRow]

    def rows_of(self, group: GroupRow) -> list[FoldingRow]:
        """The foldings of a set, with the panels of the scene `default`."""
        return [row for row in self.rows if row.group == group.group][: group.foldings]


def measure_planning(*, quick: bool, say: Say) -> PlanningResults:
    """Run the whole bench: three quarters of an hour, or seconds when `quick`."""
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
    peers: list[SearchRow] = []
    for subject in SUBJECTS[1:2] if quick else SUBJECTS:
        say(f"beside OMPL: {subject[0]}")
        peers += search_rows(subject, 1 if quick else SEARCHES, QUICK_LIMIT if quick else LIMIT)
    return PlanningResults(
        shown,
        efforts,
        [row for own in rows for row in budget_rows(own)],
        [row for own in rows for row in margin_rows(own)],
        [row for sweep in sweeps for row in sorted(map(thickness_row, sweep), key=lambda row: row.thickness_mm)],
        peers,
        [row for own in rows for row in own] + [row for sweep in sweeps for own in sweep[1:] for row in own],
    )
