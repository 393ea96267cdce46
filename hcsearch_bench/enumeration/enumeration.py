"""The bench `enumeration`: circuits a second and memory in comparison with other programs, and cost as n grows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hcsearch_bench.enumeration import arrays, counting, listing
from hcsearch_bench.enumeration.circuit_plots import plot_arrays, plot_growth
from hcsearch_bench.run.bench import Bench, Limit, Say
from hcsearch_bench.run.table import Table

_TIMES = "Times are processor seconds on one core, medians of `runs`"


@dataclass(frozen=True)
class EnumerationResults:
    """All that one run of the bench measured."""

    limit: float
    one_array: list[arrays.ArrayRow]
    listed: list[listing.ListingRow]
    growth: list[listing.GrowthRow]
    counted: list[counting.CountRow]


def tables(results: EnumerationResults) -> list[Table]:
    """What is shown and saved, in order."""
    limit = (
        f"The process of another program has {results.limit:g} s of wall time; a program that exceeds this is not "
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
            results.one_array,
            hidden=("wall_s",),
        ),
        Table(
            "listing",
            "All arrays of n cells",
            f"{_TIMES}, with compiled kernels: for listing, the two-stack test and the twist. `fold_twist_us` "
            "is the time of the last two, in microseconds a free circuit.",
            results.listed,
            hidden=("wall_s",),
        ),
        Table(
            "growth",
            "Growth a cell",
            "Growth factors a cell, fitted to the points named, and the connective constant c, to which the "
            "factor of circuits converges from below (their number is about c^n / n^2.5).",
            results.growth,
        ),
        Table(
            "counting",
            "Counting square arrays",
            f"{_TIMES}. {limit} `states` is the number of frontier states of all steps of hcsearch, for all "
            "circuits; its time includes the classes.",
            results.counted,
        ),
    ]


def draw(results: EnumerationResults, folder: Path) -> None:
    """Write the pictures."""
    plot_growth(results.listed, results.growth, folder / "growth.png")
    plot_arrays(results.one_array, results.limit, folder / "arrays.png")


def measure(*, quick: bool, repeats: int, limit: float, say: Say) -> EnumerationResults:
    """Run the whole bench: minutes, or seconds when `quick`. Raises HcsearchError when counts disagree.

    limit : seconds on the wall for each process of a peer.
    """
    one_array = arrays.measure_arrays(arrays.QUICK if quick else arrays.ARRAYS, limit=limit, repeats=repeats, say=say)
    listed = listing.measure_listing(listing.QUICK if quick else listing.SIZES, repeats=repeats, say=say)
    counted = counting.measure_counting(
        counting.QUICK if quick else counting.SIZES, limit=limit, repeats=repeats, say=say
    )
    return EnumerationResults(limit, one_array, listed, listing.fit_growth(listed), counted)


ENUMERATION = Bench(
    "enumeration",
    "Measure how fast circuits are listed. Compares with Graphillion, networkx and a plain backtracker.\n"
    "\n"
    "Each program runs in its own process. Graphillion comes with an extra: pip install 'hcsearch[bench]'.",
    "hcsearch bench enumeration --output reports/bench-enumeration --json bench.json",
    measure,
    tables,
    draw,
    peers=("graphillion", "networkx"),
    repeats=True,
    limit=Limit("a peer", 60.0, 2.0),
)
