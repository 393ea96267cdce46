"""The bench `collision`: distances of pairs of panels and of all pairs of whole deployments, compared with coal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Goal, Table

if TYPE_CHECKING:
    from hcsearch_bench.collision.pair_rows import PairRow
    from hcsearch_bench.collision.proximity_rows import ProximityRow

PAIRS, QUICK_PAIRS = 100_000, 2_000
"""Of each kind."""
GOAL = 0.2
"""Microseconds a pair in a whole deployment."""


@dataclass(frozen=True)
class CollisionResults:
    """All that one run of the bench measured."""

    pairs: list[PairRow]
    deployments: list[ProximityRow]

    @property
    def goals(self) -> list[Goal]:
        """The goals, by what was measured."""
        worst = max(row.pair_us for row in self.deployments)
        share = max(row.distances_ms / row.dynamics_ms for row in self.deployments)
        return [
            Goal("microseconds a pair and state, all distances exact, slowest deployment", worst, at_most=GOAL),
            Goal("of the time of the dynamics, slowest deployment", share, at_most=1.0),
        ]


def tables(results: CollisionResults) -> list[Table]:
    """What is shown and saved."""
    from hcsearch_bench.collision.pair_rows import AT_ONCE, SAME
    from hcsearch_bench.collision.proximity_rows import FAR

    return [
        Table(
            "pairs",
            "Pairs of panels",
            "`meet` is the share of pairs that touch or overlap, `exhaustive` the number of searches that "
            "ended in trying all directions. `difference` is the greatest difference between the distances of "
            f"hcsearch and coal, in widths of a panel; `beyond` is the number of differences above {SAME:g}, "
            "and `ours` and `theirs` the numbers of these in which hcsearch and coal are correct, by exact "
            "arithmetic. Times are processor times in microseconds a pair: hcsearch without a start (`cold`) "
            f"and started from the answer (`warm`), with panels already placed; coal for {AT_ONCE:,} pairs in "
            "one call through Pinocchio (`coal`, `coal_warm`), and pair by pair from Python (`coal_loop`). "
            "They are medians of `runs`.",
            results.pairs,
            hidden=("what",),
        ),
        Table(
            "deployments",
            "Whole deployments",
            "Distances of all pairs that no hinge joins, at all states of a deployment and at two between "
            "each, from fold angles to the dataset D. `touch` and `collide` are shares of pairs and states. "
            "`pair_us`: a pair of panels in a state, with all distances exact; `facet_us`: the same for a pair "
            "of facets; `near_us`: with a lower bound in place of distances beyond the thickness; "
            "`coal_facet_us`: coal for a pair of facets, with panels placed and distances computed in one call "
            "a state. `difference` (m) is the greatest difference; `beyond` is the number of differences above "
            f"{FAR:g} m, and `ours` and `theirs` the numbers of these in which hcsearch and coal are correct, "
            "by exact arithmetic. Times are processor times, medians of `runs`.",
            results.deployments,
        ),
        Table(
            "goals",
            "Goals",
            "Processor time, medians.",
            results.goals,
            columns=("goal", "at_most", "measured", "met"),
        ),
    ]


def measure(*, quick: bool, repeats: int, say: Say) -> CollisionResults:
    """Run the whole bench: minutes; `quick`: a fiftieth of the pairs, two deployments."""
    from hcsearch_bench.collision.pair_rows import pair_row
    from hcsearch_bench.collision.pairs import FAMILIES
    from hcsearch_bench.collision.proximity_rows import DEPLOYMENTS, QUICK_DEPLOYMENTS, proximity_row

    rows = []
    for number, family in enumerate(FAMILIES):
        say(f"{family.name}: {family.what}")
        rows.append(pair_row(family, QUICK_PAIRS if quick else PAIRS, repeats, seed=number))
    deployments = []
    for name in QUICK_DEPLOYMENTS if quick else DEPLOYMENTS:
        say(f"deployment of {name}")
        deployments.append(proximity_row(name, repeats))
    return CollisionResults(rows, deployments)


COLLISION = Bench(
    "collision",
    "Measure distances of panels. Compares random, degenerate, stacked and moving pairs with coal.\n"
    "\n"
    "coal comes with Pinocchio, in an extra: pip install 'hcsearch[bench]'.",
    "hcsearch bench collision --quick --json collision.json",
    measure,
    tables,
    peers=("coal", "pin"),
    repeats=True,
)
