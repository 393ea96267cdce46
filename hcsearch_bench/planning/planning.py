"""The bench `planning`: what is settled of all foldings of some sets, against work, margin and thickness."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.system.outputs import write_output
from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table, frame

if TYPE_CHECKING:
    from hcsearch_bench.planning.planning_results import PlanningResults


def tables(results: PlanningResults) -> list[Table]:
    """What is shown and saved, in order."""
    from hcsearch_bench.planning.planning_results import LIMIT, QUICK_LIMIT

    return [
        Table(
            "groups",
            "What is settled",
            "All untwisted foldings, up to symmetry, in the scene `default`, each by the stages `mobility` and "
            "`motion`. `movable`: a path from packed to flat is proved. `locked`: the folding is proved locked "
            "with every way of joining flat pairs. `share`: the share of both together. Times are processor "
            "times on one core.",
            results.groups,
        ),
        Table(
            "efforts",
            "Settled by effort",
            "All untwisted foldings of a list, by `motion_of` in the scene `default`, effort by effort "
            "(motion.md). `movable`: a path is proved; `locked`: it is proved that there is none. `spent_s` is the "
            "processor time of all efforts so far, on one core, `longest_s` that of a single folding.",
            results.efforts,
        ),
        Table(
            "work",
            "Share settled against work",
            "The search for each folding ends after `budget_s` of processor time. The table gives the number "
            "of settled foldings, and `spent_s`, the time for the whole set.",
            results.work,
        ),
        Table(
            "margins",
            "Share settled against margin",
            "Panels may have no more play than `margin_mm` on every face. The least margin at which the path "
            "of a folding is proved is an upper bound of the play that it needs.",
            results.margins,
        ),
        Table(
            "thicknesses",
            "Share settled against thickness",
            "Edges are 50 mm long. Of some sets a part is used, at equal intervals of the list. `tight`: "
            "movable with the least margin, 0.01 mm on every face. Locks are those of panels 6 mm thick: locks "
            "of first order depend on no length (theory.md, 27), and no thickness that was tried released one "
            "of the others.",
            results.thicknesses,
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
            results.peers,
        ),
    ]


def draw(results: PlanningResults, folder: Path) -> None:
    """Write the pictures, and the rows of single foldings, which are not shown."""
    from hcsearch_bench.planning.share_plots import plot_planning

    single = Table("foldings", "", "", results.rows)
    write_output(folder / "foldings.csv", frame(single).to_csv(index=False))
    plot_planning(results, folder / "planning.png")


def measure(*, quick: bool, say: Say) -> PlanningResults:
    """Run the whole bench: three quarters of an hour, or seconds when `quick`."""
    from hcsearch_bench.planning.planning_results import measure_planning

    return measure_planning(quick=quick, say=say)


PLANNING = Bench(
    "planning",
    "Measure the stage motion. Counts settled foldings by effort, margin and thickness, and compares with OMPL.\n"
    "\n"
    "OMPL comes with an extra: pip install 'hcsearch[bench]'.",
    "hcsearch bench planning --quick",
    measure,
    tables,
    draw,
    peers=("ompl",),
)
