"""The bench `mobility`: the stage's time for each folding, and which foldings are locked and what would free them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from hcsearch_bench.mobility.measuring import LISTED, QUICK, SIZES, LockRow, SpeedRow, TightRow, measure_mobility
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table


@dataclass(frozen=True)
class MobilityReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "mobility"

    speed: list[SpeedRow]
    locks: list[LockRow]
    tight: list[TightRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved."""
        return [
            Table(
                "mobility-speed",
                "The stage mobility",
                "All untwisted designs up to symmetry with all their untwisted foldings, on one core, compiled before, "
                "medians. `folding_us` is the whole stage for one folding (freedoms, merges, proofs of locks), "
                "`freedom_us` the ranks folded, flat and at a generic closed state.",
                self.speed,
            ),
            Table(
                "locks",
                "Locked foldings, and what frees them",
                "Untwisted foldings that are proved locked with flat pairs rigid, in the folded or the flat state, by "
                "first or second order (a folding may be in several columns); of those `tried`, how many are still "
                "proved locked with flat pairs hinged, or with panels a tenth or ten times as thick; `exact`: of the "
                "locked ends, proofs that are checked in whole numbers; `gives`: the least opening of loops (mm) that "
                "undoes one of them, `hair` and `held`: how many less than 0.1 mm undoes, and how many need more than "
                "a panel's thickness (measured, not proved); `merged`: of "
                "foldings with a mirror axis, how many are locked without and with their panels merged; `play`: the "
                "most a hinge can turn to first order, in multiples of the gap, when every stop has a gap, at the "
                "tightest and the loosest first-order lock; `margin`: the least by which an inequality of a proof "
                "holds, screws and wrench being of about unit length.",
                self.locks,
            ),
            Table(
                "tightness",
                "How tight the locks are",
                "Each end that is proved locked, with flat pairs rigid or hinged, where no more than "
                f"{LISTED} foldings of a grid and n are; by how much its loops must give way to let it out "
                "(`locks.tightness`): `opening_mm` on the best way that was found, `least_mm` on any, but for "
                "what was overlooked; `turn` and `closed`: sums of turns (rad) of the widest opening and of the closed "
                "state behind it; where there is none the search ended at an opening of a panel's thickness. Measured, "
                "not proved; panels that collide on the way are not asked about.",
                self.tight,
            ),
        ]


def measure(*, quick: bool = False, repeats: int = 3, say: Say = print) -> MobilityReport:
    """Run the whole bench: some minutes, or seconds when `quick`."""
    machine = this_machine()
    return MobilityReport(
        machine, *measure_mobility(QUICK if quick else SIZES, repeats=1 if quick else repeats, say=say)
    )
