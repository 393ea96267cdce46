"""The bench `folding`: designs that fold: joining them from half-chains, or listing all circuits and filtering."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hcsearch.basics.errors import HcsearchError
from hcsearch.system.figures import figure_for
from hcsearch_bench.run.bench import Bench, Limit, Say
from hcsearch_bench.run.job import JobResult, run_job
from hcsearch_bench.run.table import Table
from hcsearch_bench.run.timing import Row
from hcsearch_bench.subjects.polygons import count_polygons, join_polygons, list_polygons

SIZES: dict[str, tuple[int, ...]] = {
    "hex": (12, 14, 16, 18, 20, 22, 24),
    "square": (16, 18, 20, 22, 24, 26, 28, 30, 32),
    "triangle": (28, 30, 32, 34, 36, 38, 40, 42, 44, 46, 48),
}
QUICK: dict[str, tuple[int, ...]] = {"hex": (10, 12), "square": (14,), "triangle": (22,)}
KEEPS = ("two-stack", "untwisted")


@dataclass(frozen=True)
class FoldableRow:
    """All designs of n panels that fold, or all untwisted ones, three ways; None where one takes too long.

    filter_s : list all circuits, fold and twist them. join_s : join half-chains, fold and twist the circuits: the
    same data. count_s : count joined half-chains. Processor seconds on one core, medians of `runs` (of the way with
    fewest). filter_per_join, filter_per_count : their ratios. peak_mib of each way : of its whole process.
    """

    grid: str
    n: int
    keep: str
    designs: int
    filter_s: float | None
    join_s: float | None
    count_s: float | None
    filter_per_join: float | None
    filter_per_count: float | None
    filter_mib: float | None
    join_mib: float | None
    count_mib: float | None
    runs: int


@dataclass(frozen=True)
class FoldingResults:
    """All that one run of the bench measured; limit : seconds on the wall for a process."""

    limit: float
    rows: list[FoldableRow]


def tables(results: FoldingResults) -> list[Table]:
    """What is shown and saved."""
    return [
        Table(
            "folding",
            "Designs that fold: joined from half-chains, or filtered from all circuits",
            "Times are processor seconds on one core, with compiled kernels, medians of `runs`. `filter_s`: "
            "all circuits are listed, and their foldings and twists computed; `join_s`: the designs are joined "
            "from half-chains, and their foldings and twists computed, so that both have canonical words, "
            "symmetries, foldings and twists; `count_s`: the number alone. Each method runs in separate "
            "processes, and `_mib` is their greatest memory, including interpreter and libraries. A process "
            f"has {results.limit:g} s of wall time; a method that exceeds this is not tried on larger n.",
            results.rows,
        )
    ]


def draw(results: FoldingResults, folder: Path) -> None:
    """Write the pictures."""
    plot_folding(results.rows, folder / "folding.png")


class _Ways:
    """Runs jobs, each kind on one grid until it is late."""

    def __init__(self, grid: str, limit: float, repeats: int) -> None:
        self.grid, self.limit, self.repeats = grid, limit, repeats
        self._late: set[tuple[str, ...]] = set()

    def run(self, job: Callable[..., Row], n: int, **keep: str) -> JobResult | None:
        """What a job gives; None when it takes too long, or did before. HcsearchError when it fails."""
        way = (job.__name__, *keep.values())
        if way in self._late:
            return None
        result = run_job(job, self.limit, grid=self.grid, n=n, repeats=self.repeats, **keep)
        if result.late:
            self._late.add(way)
            return None
        if result.note:
            raise HcsearchError(f"{job.__name__} {self.grid} n={n}: {result.note}; report this")
        return result


def measure(*, quick: bool, repeats: int, limit: float, say: Say) -> FoldingResults:
    """Run the whole bench: a quarter of an hour, or seconds when `quick`; HcsearchError when numbers differ.

    limit : seconds on the wall for each process.
    """
    rows = measure_folding(QUICK if quick else SIZES, limit=limit, repeats=repeats, say=say)
    return FoldingResults(limit, rows)


def measure_folding(sizes: Mapping[str, Sequence[int]], *, limit: float, repeats: int, say: Say) -> list[FoldableRow]:
    """One row a grid, n and keep, as far as one of the ways is in time."""
    rows = []
    for grid, ns in sizes.items():
        ways = _Ways(grid, limit, repeats)
        for n in ns:
            say(f"{grid} n={n}: list and filter, join, count")
            listed = ways.run(list_polygons, n)
            for keep in KEEPS:
                joined, counted = (ways.run(job, n, keep=keep) for job in (join_polygons, count_polygons))
                row = _row(grid, n, keep, listed, joined, counted)
                rows += [row] if row is not None else []
    return rows


def _row(
    grid: str, n: int, keep: str, listed: JobResult | None, joined: JobResult | None, counted: JobResult | None
) -> FoldableRow | None:
    designs = [result.row["designs"] for result in (joined, counted) if result is not None]
    filter_s = None
    if listed is not None:
        designs.append(listed.row[keep.replace("-", "_")])
        filter_s = sum(listed.row[stage] for stage in ("list_s", "fold_s", "twist_s"))
    if not designs:
        return None
    if len(set(designs)) > 1:
        raise HcsearchError(f"{grid} n={n} {keep}: joined, counted or listed, designs are {designs}; report this")
    join_s, count_s = (None if result is None else float(result.row["seconds"]) for result in (joined, counted))
    ways = [result for result in (listed, joined, counted) if result is not None]
    return FoldableRow(
        grid=grid,
        n=n,
        keep=keep,
        designs=designs[0],
        filter_s=filter_s,
        join_s=join_s,
        count_s=count_s,
        filter_per_join=_ratio(filter_s, join_s),
        filter_per_count=_ratio(filter_s, count_s),
        filter_mib=_memory(listed),
        join_mib=_memory(joined),
        count_mib=_memory(counted),
        runs=min(result.row["runs"] for result in ways),
    )


def _memory(result: JobResult | None) -> float | None:
    return None if result is None else result.peak_mib


def _ratio(seconds: float | None, less: float | None) -> float | None:
    return seconds / less if seconds and less else None


def plot_folding(rows: Sequence[FoldableRow], path: Path) -> None:
    """Seconds of the three ways to designs that fold against n, a picture a grid."""
    grids = list(dict.fromkeys(row.grid for row in rows))
    with figure_for(path, (12, 4.5)) as figure:
        pictures = figure.subplots(1, len(grids), squeeze=False, sharey=True)[0]
        for axes, grid in zip(pictures, grids, strict=True):
            for keep, marker in (("two-stack", "o-"), ("untwisted", "s--")):
                ours = [row for row in rows if (row.grid, row.keep) == (grid, keep)]
                ways = [("joined", "C0", "join_s"), ("counted", "C2", "count_s")]
                if keep == "two-stack":  # the same run as for untwisted ones
                    ways.insert(0, ("all circuits listed and filtered", "C1", "filter_s"))
                for way, colour, column in ways:
                    points = [(row.n, getattr(row, column)) for row in ours if getattr(row, column)]
                    label = way if column == "filter_s" else f"{keep} designs {way}"
                    axes.plot([n for n, _ in points], [s for _, s in points], marker, color=colour, ms=4, label=label)
            axes.set(xlabel="panels n", yscale="log", title=grid)
        pictures[0].set_ylabel("processor seconds, one core")
        figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize="small")


FOLDING = Bench(
    "folding",
    "Measure how fast designs that fold are listed. Compares half-chains with filtering all circuits.",
    "hcsearch bench folding --quick",
    measure,
    tables,
    draw,
    repeats=True,
    limit=Limit("a process", 180.0, 60.0),
)
