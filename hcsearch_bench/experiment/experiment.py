"""The bench `experiment`: the thesis's deployment of the 4x4 array (4.5), with what its text does not fix.

The text does not say which way gravity acts, nor which panel the aluminium frame holds. The
array, its springs and the bounds of these are those of Tables 4.1 and 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table

if TYPE_CHECKING:
    from hcsearch_bench.experiment.experiment_rows import Claim, TunedRow, UniformRow
    from hcsearch_bench.experiment.filmed_collision import FilmedRow


@dataclass(frozen=True)
class ExperimentResults:
    """All that one run of the bench measured."""

    claims: list[Claim]
    uniform: list[UniformRow]
    tuned: list[TunedRow]
    filmed: list[FilmedRow]


def tables(results: ExperimentResults) -> list[Table]:
    """What is shown and saved."""
    return [
        Table(
            "experiment-claims",
            "The thesis's experiment: what it says, what comes out",
            "Thesis 4.5.1 and 4.5.4 to 4.5.5; numbers over all directions of gravity and panels held of the tables "
            "below.",
            results.claims,
        ),
        Table(
            "experiment-uniform",
            "Springs of 0.10 N m/rad at every hinge",
            "`held`: 0 is the merged pair at the end of the loop, 5 the one in its middle, 7 a large middle panel.",
            results.uniform,
        ),
        Table(
            "experiment-tuned",
            "Tuned springs, and those of the catalogue 0.07 and 0.10 N m/rad",
            "Springs by `hcsearch tune` with its defaults.",
            results.tuned,
        ),
        Table(
            "experiment-film",
            "What would make panels 0 and 7 meet first at 0.30 s, as in the film",
            "Searches within bounds: `measured` are those of the thesis's own measurements, of air and of light "
            "friction; `plausible` are up to twice the measured damping. Parameters that are not varied have the "
            "values of the thesis, gravity that of the scene `thesis`.",
            results.filmed,
        ),
    ]


def measure(*, quick: bool, say: Say) -> ExperimentResults:
    """Run the bench; quick: exact closure alone for equal springs, one tuning without samples, and short searches."""
    from hcsearch_bench.experiment.experiment_rows import claims, tuned_rows, uniform_rows
    from hcsearch_bench.experiment.filmed_collision import filmed_rows

    uniform, tuned = uniform_rows(quick=quick, say=say), tuned_rows(quick=quick, say=say)
    return ExperimentResults(claims(uniform, tuned), uniform, tuned, filmed_rows(quick=quick, say=say))


EXPERIMENT = Bench(
    "experiment",
    "Repeat the experiment of the thesis. The 4x4 array with equal, tuned and catalogue springs and gravity.",
    "hcsearch bench experiment --quick",
    measure,
    tables,
    heading="# Bench: the thesis's experiment",
)
