"""The bench `enumeration`: circuits a second and memory in comparison with other programs, and cost as n grows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from hcsearch_bench.enumeration import arrays, counting, listing
from hcsearch_bench.enumeration.plots import plot_arrays, plot_growth
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table

PEERS = ("graphillion", "networkx")
LIMIT, QUICK_LIMIT = 60.0, 2.0

_TIMES = "Times are processor seconds on one core, medians of `runs`"


@dataclass(frozen=True)
class EnumerationReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "enumeration"

    limit: float
    one_array: list[arrays.ArrayRow]
    listed: list[listing.ListingRow]
    growth: list[listing.GrowthRow]
    counted: list[counting.CountRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved, in order."""
        limit = (
            f"The process of another program has {self.limit:g} s of wall time; a program that exceeds this is not "
            "tried on larger arrays."
        )
        return [
            Table(
                "arrays",
                "Circuits of one array",
                f"{_TIMES}: `build_s` is the time to build the data structure, `answer_s` the time to compute the "
                f"number or to iterate over the list. {limit} `times_ours` is the ratio of build and answer to "
                "those of hcsearch, counting compared with counting, and listing with edge sets. hcsearch lists "
                "one circuit for each class; no other program reduces by symmetry. `peak_mib` is the memory of the "
                "whole process; the smallest arrays show the share of the interpreter and the libraries.",
                self.one_array,
                hidden=("wall_s",),
            ),
            Table(
                "listing",
                "All arrays of n cells",
                f"{_TIMES}, with compiled kernels: for listing, the two-stack test and the twist. `fold_twist_us` "
                "is the time of the last two, in microseconds a free circuit.",
                self.listed,
                hidden=("wall_s",),
            ),
            Table(
                "growth",
                "Growth a cell",
                "Growth factors a cell, fitted to the points named, and the connective constant c, to which the "
                "factor of circuits converges from below (their number is about c^n / n^2.5).",
                self.growth,
            ),
            Table(
                "counting",
                "Counting square arrays",
                f"{_TIMES}. {limit} `states` is the number of frontier states of all steps of hcsearch, for all "
                "circuits; its time includes the classes.",
                self.counted,
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        plot_growth(self.listed, self.growth, folder / "growth.png")
        plot_arrays(self.one_array, self.limit, folder / "arrays.png")


def measure(
    *, quick: bool = False, repeats: int = 3, limit: float | None = None, say: Say = print
) -> EnumerationReport:
    """Run the whole bench: minutes, or seconds when `quick`. Raises HcsearchError when counts disagree.

    limit : seconds on the wall for each process of a peer.
    """
    machine = this_machine(PEERS)
    repeats = 1 if quick else repeats
    limit = limit or (QUICK_LIMIT if quick else LIMIT)
    one_array = arrays.measure_arrays(arrays.QUICK if quick else arrays.ARRAYS, limit=limit, repeats=repeats, say=say)
    listed = listing.measure_listing(listing.QUICK if quick else listing.SIZES, repeats=repeats, say=say)
    counted = counting.measure_counting(
        counting.QUICK if quick else counting.SIZES, limit=limit, repeats=repeats, say=say
    )
    return EnumerationReport(machine, limit, one_array, listed, listing.fit_growth(listed), counted)
