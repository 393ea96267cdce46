"""The bench `stability`: scenes over many decades, each with a verdict: accurate, degraded by a bound, or refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table

if TYPE_CHECKING:
    from hcsearch_bench.stability.judging import StabilityRow
    from hcsearch_bench.stability.processors import ProcessorRow


@dataclass(frozen=True)
class StabilityResults:
    """All that one run of the bench measured."""

    rows: list[StabilityRow]
    processors: list[ProcessorRow]


def tables(results: StabilityResults) -> list[Table]:
    """What is shown and saved, in order."""
    from hcsearch.springs.accuracy.stability_points import (
        ACCURATE_TOLERANCES,
        ANGLE_FLOOR,
        BOUND_FACTOR,
        MAX_JUDGED_STATES,
    )
    from hcsearch_bench.stability.judging import tally
    from hcsearch_bench.stability.processors import CORES

    return [
        Table(
            "counts",
            "Verdicts",
            "`wrong`: the simulation reports success, but the error is beyond the bound or a number is not "
            "finite. `worst` is the greatest error of those that are accurate or degraded.",
            tally(results.rows),
        ),
        Table(
            "stability",
            "Extreme scenes",
            f"`error` (rad) is the greatest distance from `truth` at up to {MAX_JUDGED_STATES} states, or the closure "
            "residual if that is greater; where the truth is the energy, it is a share of the largest energy. "
            f"Accurate: at most {ACCURATE_TOLERANCES:g} tolerances, plus {ANGLE_FLOOR:g} for rounding. Degraded: "
            f"within `bound`, {BOUND_FACTOR:g} times the closure residual plus the distance to the same simulation at "
            "ten times the tolerance (penalty: a tenth of the stiffness, or ten times it). Refused: the simulation "
            "itself reports that it has no answer. `energy` is the error of the energy balance over the "
            "largest energy, `gap` the closure residual of the fold angles.",
            results.rows,
        ),
        Table(
            "processors",
            "Processors",
            f"The same computations with the linear algebra that OpenBLAS has for {', '.join(CORES)} "
            "(`kernels`: those that it used), and with NumPy's AVX-512 or without (`avx512`), compared with those of "
            "this processor. `differ` is the number of rows with another verdict, sentence, number of freedoms or "
            "branch; `off` is the greatest relative difference of any other number.",
            results.processors,
        ),
    ]


def draw(results: StabilityResults, folder: Path) -> None:
    """Write the pictures."""
    from hcsearch_bench.stability.heat_map import plot_heat

    plot_heat(results.rows, folder / "heat.png")


def measure(*, quick: bool, say: Say) -> StabilityResults:
    """Run the whole bench: minutes; quick: every third value."""
    from hcsearch_bench.stability.judging import judge
    from hcsearch_bench.stability.processors import measure_processors
    from hcsearch_bench.stability.sweeps import cases

    say("stability: kernels are compiled")
    judge(next(cases(quick=True)))
    rows, sweep = [], ""
    for case in cases(quick=quick):
        if case.sweep != sweep:
            sweep = case.sweep
            say(f"stability: {sweep}")
        rows.append(judge(case))
    return StabilityResults(rows, measure_processors(quick=quick, say=say))


STABILITY = Bench(
    "stability",
    "Measure the dynamics of extreme scenes. Each is accurate, less accurate within a bound, or refused.\n"
    "\n"
    "Stiffness, damping, thickness, masses, panels, starts, tolerances and restitution vary over many decades.\n"
    "Branches and verdicts are also computed as other processors would.",
    "hcsearch bench stability --quick --json stability.json",
    measure,
    tables,
    draw,
    peers=("scipy",),
)
