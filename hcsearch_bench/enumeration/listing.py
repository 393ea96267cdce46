"""All arrays of n cells: listing, folding and twist in one process."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hcsearch.basics.errors import HcsearchError
from hcsearch_bench.run.bench import Say
from hcsearch_bench.run.job import OWN_LIMIT, run_job
from hcsearch_bench.subjects.polygons import list_polygons

SIZES: dict[str, tuple[int, ...]] = {
    "hex": (10, 12, 14, 16, 18),
    "square": (14, 16, 18, 20, 22, 24, 26),
    "triangle": (24, 26, 28, 30, 32, 34, 36, 38, 40),
}
QUICK: dict[str, tuple[int, ...]] = {"hex": (10, 12), "square": (14, 16), "triangle": (22, 24)}

# circuits of n cells grow by about this factor a cell: the connective constants of the cells' adjacency lattices
CONNECTIVE = {
    "hex": 4.150797,  # triangular lattice; Jensen, J. Phys. A 37 (2004) 11521
    "square": 2.638159,  # Clisby and Jensen, J. Phys. A 45 (2012) 115202
    "triangle": math.sqrt(2 + math.sqrt(2)),  # honeycomb, exact; Duminil-Copin and Smirnov, Ann. Math. 175 (2012) 1653
}


@dataclass(frozen=True)
class ListingRow:
    """All circuits of n panels on a grid. Times are processor seconds of the kernels on one core, medians of `runs`.

    fold_twist_us : microseconds a free circuit for the two-stack test and the twist together.
    """

    grid: str
    n: int
    free: int
    fixed: int
    two_stack: int
    untwisted: int
    list_s: float
    wall_s: float
    circuits_per_s: float
    fold_s: float
    twist_s: float
    fold_twist_us: float
    peak_mib: float
    runs: int


@dataclass(frozen=True)
class GrowthRow:
    """Factors by which circuits and seconds grow a cell, fitted to the `points` largest sizes."""

    grid: str
    points: str
    connective: float
    circuits_factor: float
    seconds_factor: float


def measure_listing(sizes: Mapping[str, Sequence[int]], *, repeats: int, say: Say) -> list[ListingRow]:
    """One row a grid and n; HcsearchError when one does not finish."""
    rows = []
    for grid, ns in sizes.items():
        for n in ns:
            say(f"{grid} n={n}: list, fold, twist")
            result = run_job(list_polygons, OWN_LIMIT, grid=grid, n=n, repeats=repeats)
            if result.note:
                raise HcsearchError(
                    f"listing {grid} n={n}: {result.note}; take smaller sizes with --quick, and report this"
                )
            row = result.row
            rows.append(
                ListingRow(
                    grid=grid,
                    n=n,
                    circuits_per_s=row["free"] / row["list_s"],
                    fold_twist_us=1e6 * (row["fold_s"] + row["twist_s"]) / row["free"],
                    peak_mib=result.peak_mib,
                    **row,
                )
            )
    return rows


def fit_growth(listed: Sequence[ListingRow], points: int = 4) -> list[GrowthRow]:
    """Least-squares factors a cell over each grid's `points` largest sizes."""
    rows = []
    for grid in dict.fromkeys(row.grid for row in listed):
        ours = [row for row in listed if row.grid == grid][-points:]
        ns = [row.n for row in ours]
        rows.append(
            GrowthRow(
                grid=grid,
                points=f"{ns[0]}..{ns[-1]}",
                connective=CONNECTIVE[grid],
                circuits_factor=growth_factor(ns, [row.free for row in ours]),
                seconds_factor=growth_factor(ns, [row.list_s for row in ours]),
            )
        )
    return rows


def growth_factor(ns: Sequence[int], values: Sequence[float]) -> float:
    """The factor f of the best fit c f^n, by least squares of logarithms."""
    slope, _ = statistics.linear_regression(ns, [math.log(value) for value in values])
    return math.exp(slope)
