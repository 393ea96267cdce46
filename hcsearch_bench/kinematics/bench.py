"""The bench `kinematics`: error against time of path methods, branches, descents, cost of closure, extreme scenes."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from hcsearch.system.figures import figure_for
from hcsearch_bench.kinematics.extremes import ACCURATE, ExtremeRow, measure_extremes
from hcsearch_bench.kinematics.path_methods import (
    PANELS,
    QUICK_PANELS,
    UNITS,
    CostRow,
    KnownUnit,
    PathRow,
    SlopeRow,
    fit_costs,
    measure_costs,
    measure_paths,
)
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table

PEERS = ("scipy",)
DESIGNS = (("triangle", 10), ("triangle", 14), ("square", 12), ("hex", 10), ("hex", 12))
QUICK_DESIGNS = (("triangle", 10), ("square", 10))


@dataclass(frozen=True)
class BranchRow:
    """Motions that begin at an end of the motion, with hinges that turn either way or with stops.

    nullity : first-order motions; equations : of second order. isolated, families : directions that solve these, and
        the dimensions of families of them; finite : how many of those tried are motions, of which `within` keep the
        stops.
    """

    linkage: str
    state: str
    stops: str
    nullity: int
    equations: int
    isolated: int
    families: str
    tried: int
    finite: int
    within: int
    seconds: float


@dataclass(frozen=True)
class DescentRow:
    """Untwisted foldings of all designs of n panels, 50 mm and 6 mm thick, looked for a motion from stacks to flat.

    pairs : whether the two flat pairs are rigid or hinged. flat : with equal springs, and `flat_in_all` with any of the
        spring sets. descent_ms : median and greatest time of one descent, search_ms : of all sets together.
    """

    grid: str
    n: int
    pairs: str
    foldings: int
    flat: int
    flat_in_all: int
    stuck: int
    other: int
    descent_ms: float
    descent_max_ms: float
    search_ms: float
    search_max_ms: float


@dataclass(frozen=True)
class KinematicsReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "kinematics"

    paths: list[PathRow]
    branches: list[BranchRow]
    descents: list[DescentRow]
    costs: list[CostRow]
    slopes: list[SlopeRow]
    extremes: list[ExtremeRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved, in order."""
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
                self.paths,
            ),
            Table(
                "branches",
                "Motions that begin at the ends",
                "`equations` is the number of second-order equations. The directions that solve them are `isolated` or "
                "form `families` of a dimension; `tried` is the number of directions that were followed, `finite` the "
                "number of these that are motions, and `within` the number of motions within the stops.",
                self.branches,
            ),
            Table(
                "descents",
                "From stacks to flat by springs",
                "Untwisted foldings with panels of 50 mm, 6 mm thick; collisions are not checked. `flat` is the "
                "number that come flat with equal springs, `flat_in_all` with one of the spring sets. Times are "
                "wall times in milliseconds, medians and greatest, of one descent and of a search with all sets.",
                self.descents,
            ),
            Table(
                "costs",
                "One closure with its Jacobian",
                "Rings of 2 x k squares. Times in microseconds: closure and Jacobian, second-order term, singular "
                "values.",
                self.costs,
            ),
            Table("slopes", "Growth of these costs", "Power of the number of panels, by the larger half.", self.slopes),
            Table(
                "extremes",
                "Extreme scenes",
                "`bound` is an upper limit of the error of angles (rad), the closure residual over the least "
                f"singular value on the way; `error` is the error. Accurate: up to {ACCURATE:g} rad. The bench "
                "fails if an error exceeds its bound.",
                self.extremes,
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        plot_paths(self.paths, folder / "paths.png")


def measure(*, quick: bool = False, repeats: int = 3, say: Say = print) -> KinematicsReport:
    """Run the whole bench: minutes, or seconds when `quick`; HcsearchError when a scene claims more than is true."""
    machine = this_machine(PEERS)
    paths = measure_paths(UNITS[1:] if quick else UNITS, quick=quick, repeats=1 if quick else repeats, say=say)
    branches = measure_branches(say=say)
    descents = measure_descents(QUICK_DESIGNS if quick else DESIGNS, say=say)
    costs = measure_costs(QUICK_PANELS if quick else PANELS, say=say)
    extremes = measure_extremes(quick=quick, say=say)
    return KinematicsReport(machine, paths, branches, descents, costs, fit_costs(costs), extremes)


def measure_branches(*, say: Say) -> list[BranchRow]:
    """One row a unit, end and kind of hinge."""
    from hcsearch.motion.paths.branches import branches

    rows = []
    for name in UNITS:
        linkage = KnownUnit(name).linkage
        for state in ("folded", "flat"):
            for stops in (False, True):
                say(f"branches of unit {name}, {state}{', with stops' if stops else ''}")
                begin = time.perf_counter()
                search = branches(linkage, getattr(linkage, state), stops=stops)
                seconds = time.perf_counter() - begin
                dimensions = [branch.dimension for branch in search.branches]
                rows.append(
                    BranchRow(
                        f"unit {name}",
                        state,
                        "yes" if stops else "no",
                        search.nullity,
                        search.stresses,
                        dimensions.count(0),
                        ", ".join(map(str, sorted(set(dimensions) - {0}))) or "-",
                        len(search.branches),
                        len(search.finite),
                        sum(branch.within for branch in search.finite),
                        seconds,
                    )
                )
    return rows


def measure_descents(designs: Sequence[tuple[str, int]], *, say: Say) -> list[DescentRow]:
    """Two rows a grid and n: flat pairs rigid, and hinged."""
    from hcsearch.designs.folding import foldings
    from hcsearch.designs.twisting import twist
    from hcsearch.motion.paths.descent import descend, find_motion
    from hcsearch.search.enumeration import enumerate_circuits
    from hcsearch.shape.linkage import Linkage

    rows = []
    for grid, n in designs:
        subjects = [f for circuit in enumerate_circuits(grid, n=n) for f in foldings(circuit) if not twist(f)]
        for pairs in ("rigid", "hinged"):
            say(f"descents of {len(subjects)} foldings of {n} panels ({grid}), flat pairs {pairs}")
            once, searched, ends, all_ends = [], [], Counter[str](), Counter[str]()
            for folding in subjects:
                linkage = Linkage(folding.pattern((0.05, 0.05, 0.006), flat_pairs=pairs))
                descend(linkage, max_steps=1)  # what is cached is not counted
                begin = time.perf_counter()
                ends[descend(linkage).outcome] += 1
                middle = time.perf_counter()
                all_ends[find_motion(linkage).path.outcome] += 1
                once.append(1e3 * (middle - begin))
                searched.append(1e3 * (time.perf_counter() - middle))
            rows.append(
                DescentRow(
                    *(grid, n, pairs, len(subjects), ends["flat"], all_ends["flat"], all_ends["stuck"]),
                    len(subjects) - all_ends["flat"] - all_ends["stuck"],
                    *(float(np.median(once)), max(once), float(np.median(searched)), max(searched)),
                )
            )
    return rows


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
            axes.grid(alpha=0.3)
        figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=6, fontsize="small")
