"""The bench `kinematics`: error against time of path methods, branches, descents, cost of closure, extreme scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.system.figures import figure_for
from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table

if TYPE_CHECKING:
    from hcsearch_bench.kinematics.extremes import ExtremeRow
    from hcsearch_bench.kinematics.motion_rows import BranchRow, DescentRow
    from hcsearch_bench.kinematics.path_methods import CostRow, PathRow, SlopeRow


@dataclass(frozen=True)
class KinematicsResults:
    """All that one run of the bench measured."""

    paths: list[PathRow]
    branches: list[BranchRow]
    descents: list[DescentRow]
    costs: list[CostRow]
    slopes: list[SlopeRow]
    extremes: list[ExtremeRow]


def tables(results: KinematicsResults) -> list[Table]:
    """What is shown and saved, in order."""
    from hcsearch_bench.kinematics.extremes import ACCURATE

    return [
        Table(
            "paths",
            "Path methods on units I and II",
            "Errors relative to the exact motion (thesis 5.24, base angle 70 degrees). `step`: fixed steps "
            "(rad; increments: of the fastest hinge), from 0.1 rad beside the folded state to 0.1 rad beside "
            "the flat one; `tolerance`: adaptive steps, from folded to flat, which are both singular. "
            "`corrections`: Newton corrections a step. `off_path` is the greatest error of a fold angle "
            "relative to that of the first hinge (rad); `at_end` is the distance from the end that the arc "
            "length gives.",
            results.paths,
        ),
        Table(
            "branches",
            "Motions that begin at the ends",
            "`equations` is the number of second-order equations. The directions that solve them are `isolated` or "
            "form `families` of a dimension; `tried` is the number of directions that were followed, `finite` the "
            "number of these that are motions, and `within` the number of motions within the stops.",
            results.branches,
        ),
        Table(
            "descents",
            "From stacks to flat by springs",
            "Untwisted foldings with panels of 50 mm, 6 mm thick; collisions are not checked. `flat` is the "
            "number that come flat with equal springs, `flat_in_all` with one of the spring sets. Times are "
            "wall times in milliseconds, medians and greatest, of one descent and of a search with all sets.",
            results.descents,
        ),
        Table(
            "costs",
            "One closure with its Jacobian",
            "Rings of 2 x k squares. Times in microseconds: closure and Jacobian, second-order term, singular values.",
            results.costs,
        ),
        Table("slopes", "Growth of these costs", "Power of the number of panels, by the larger half.", results.slopes),
        Table(
            "extremes",
            "Extreme scenes",
            "`bound` is an upper limit of the error of angles (rad), the closure residual over the least "
            f"singular value on the way; `error` is the error. Accurate: up to {ACCURATE:g} rad. The bench "
            "fails if an error exceeds its bound.",
            results.extremes,
        ),
    ]


def draw(results: KinematicsResults, folder: Path) -> None:
    """Write the pictures."""
    plot_paths(results.paths, folder / "paths.png")


def measure(*, quick: bool, repeats: int, say: Say) -> KinematicsResults:
    """Run the whole bench: minutes, or seconds when `quick`; HcsearchError when a scene claims more than is true."""
    from hcsearch_bench.kinematics.extremes import measure_extremes
    from hcsearch_bench.kinematics.motion_rows import DESIGNS, QUICK_DESIGNS, measure_branches, measure_descents
    from hcsearch_bench.kinematics.path_methods import (
        PANELS,
        QUICK_PANELS,
        UNITS,
        fit_costs,
        measure_costs,
        measure_paths,
    )

    paths = measure_paths(UNITS[1:] if quick else UNITS, quick=quick, repeats=repeats, say=say)
    branches = measure_branches(say=say)
    descents = measure_descents(QUICK_DESIGNS if quick else DESIGNS, say=say)
    costs = measure_costs(QUICK_PANELS if quick else PANELS, say=say)
    extremes = measure_extremes(quick=quick, say=say)
    return KinematicsResults(paths, branches, descents, costs, fit_costs(costs), extremes)


def plot_paths(rows: Sequence[PathRow], path: Path) -> None:
    """Work and precision: error off the path, and closure, against seconds, a line a method and way to correct."""
    unit = rows[-1].unit
    with figure_for(path, (12, 5)) as figure:
        pictures = figure.subplots(1, 2)
        styles = {"0": ":", "1": "--", "closed": "-"}
        colours = {name: f"C{k}" for k, name in enumerate(dict.fromkeys(row.method for row in rows))}
        for method, colour in colours.items():
            for corrections, style in styles.items():
                shown = [
                    row
                    for row in rows
                    if (row.unit, row.method, row.corrections) == (unit, method, corrections)
                    and row.tolerance is None
                    and row.off_path is not None
                ]
                label = method if corrections == "closed" else None
                for axes, column in zip(pictures, ("off_path", "residual"), strict=True):
                    points = sorted((row.seconds, getattr(row, column)) for row in shown)
                    axes.plot(
                        [s for s, _ in points], [e for _, e in points], "o" + style, color=colour, ms=4, label=label
                    )
        pictures[0].set(ylabel="error off the path (rad)", title=f"Unit {unit}, fixed steps")
        pictures[1].set(ylabel="closure residual", title="dotted: uncorrected; dashed: corrected once; solid: closed")
        for axes in pictures:
            axes.set(xlabel="seconds", xscale="log", yscale="log")
        figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=6, fontsize="small")


KINEMATICS = Bench(
    "kinematics",
    "Measure the kinematics of linkages. Errors and times of path methods, branches, descents, extreme scenes.",
    "hcsearch bench kinematics --quick",
    measure,
    tables,
    draw,
    peers=("scipy",),
    repeats=True,
)
