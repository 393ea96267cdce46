"""The bench `mobility`: the stage's time for each folding, which foldings are locked, and what would release them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table

if TYPE_CHECKING:
    from hcsearch_bench.mobility.lock_rows import LockRow, SpeedRow, TightRow


@dataclass(frozen=True)
class MobilityResults:
    """All that one run of the bench measured."""

    speed: list[SpeedRow]
    locks: list[LockRow]
    tight: list[TightRow]


def tables(results: MobilityResults) -> list[Table]:
    """What is shown and saved."""
    from hcsearch_bench.mobility.lock_rows import LISTED

    return [
        Table(
            "mobility-speed",
            "The stage mobility",
            "All untwisted designs up to symmetry with all their untwisted foldings. Times are medians on one "
            "core, with compiled kernels. `folding_us` is the time of the whole stage for one folding "
            "(freedoms, merges, proofs of locks), `freedom_us` the time for the ranks in the folded, the flat "
            "and a generic closed state.",
            results.speed,
        ),
        Table(
            "locks",
            "Locked foldings, and what releases them",
            "Untwisted foldings that are proved locked with rigid flat pairs, in the folded or the flat state, "
            "at first or second order (a folding may be in several columns). Of those `tried`, how many are "
            "still proved locked with hinged flat pairs, or with panels a tenth or ten times as thick. "
            "`exact`: proofs of locked ends that are checked in whole numbers. `gives`: the least opening of "
            "loops (mm) that releases one of them; `hair` and `held`: how many are released by less than 0.1 "
            "mm, and how many need more than a panel's thickness (measured, not proved). `merged`: of foldings "
            "with a mirror axis, how many are locked without and with their panels merged. `play`: the "
            "greatest angle by which a hinge can turn to first order, in multiples of the gap, when every stop "
            "has a gap, at the tightest and the loosest first-order lock. `margin`: the least amount by which "
            "an inequality of a proof holds, with screws and wrench of about unit length.",
            results.locks,
        ),
        Table(
            "tightness",
            "How tight the locks are",
            "Each end that is proved locked, with rigid or hinged flat pairs, for each grid and n with at most "
            f"{LISTED} locked foldings. The table gives the amount by which the loops must open to release the "
            "folding (`locks.tightness`): `opening_mm` on the best path of the search, and `least_mm`, an "
            "estimated lower limit for all paths, which may miss some. `turn` and `closed`: sums of turns "
            "(rad) at the widest opening and at the closed state behind it; if there is none, the search ended "
            "at an opening of a panel's thickness. These numbers are measured, not proved, and collisions of "
            "panels on the way are not checked.",
            results.tight,
        ),
    ]


def measure(*, quick: bool, repeats: int, say: Say) -> MobilityResults:
    """Run the whole bench: some minutes, or seconds when `quick`."""
    from hcsearch_bench.mobility.lock_rows import QUICK, SIZES, measure_mobility

    return MobilityResults(*measure_mobility(QUICK if quick else SIZES, repeats=repeats, say=say))


MOBILITY = Bench(
    "mobility",
    "Measure the stage mobility. Its time, which foldings are locked, and what frees them.",
    "hcsearch bench mobility --quick",
    measure,
    tables,
    repeats=True,
)
