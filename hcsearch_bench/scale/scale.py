"""The bench `scale`: the whole command with one and two processes, on a Dask cluster, and into databases."""

from __future__ import annotations

import re
import statistics
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from importlib.util import find_spec

from hcsearch.basics.errors import HcsearchError
from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.job import OWN_LIMIT
from hcsearch_bench.run.machine import MISSING
from hcsearch_bench.run.process import Finished, run_measured
from hcsearch_bench.run.table import Table
from hcsearch_bench.scale import cluster
from hcsearch_bench.scale.databases import Maker, Variables, new_postgresql, new_sqlite, nowhere

WORKERS = 2
LAST = "mobility"
"""The last stage: deployments take a thousand times longer than all before them, and have a bench of their own."""
_NO_SERVER = "not measured: no --postgresql"
_COUNTS = {"all": "non-isomorphic circuits", "two-stack": "two-stack", "untwisted": "untwisted"}


@dataclass(frozen=True)
class ScaleJob:
    """All designs of n panels that are kept."""

    grid: str
    n: int
    keep: str

    def run(self, options: Sequence[str], variables: Variables) -> Finished:
        """Run the command in a process of its own."""
        words = ["enumerate", "--grid", self.grid, "--n", str(self.n), "--until", LAST, "--keep", self.keep, *options]
        return run_measured([sys.executable, "-m", "hcsearch", *words], OWN_LIMIT, variables)


@dataclass(frozen=True)
class RunWay:
    """How a job is worked on.

    into : where results go, by a new environment for each run; at_once : equal commands started together.
    note : why this way is not measured.
    """

    how: str
    options: tuple[str, ...]
    into: str = "-"
    make: Maker = nowhere
    at_once: int = 1
    note: str = ""


@dataclass(frozen=True)
class ScaleRow:
    """One job done in one way; medians of `runs` commands.

    wall_s, cpu_s : of the command, its processes included, but not a cluster or a server. start_s : the wall time of
    10 cells, nearly all of it start. peak_mib : of the first process. speed_up : times the designs a second of one
    process with the same `into`; net_speed_up : the same without the start, None for runs that are hardly more.
    """

    grid: str
    n: int
    keep: str
    into: str
    how: str
    designs: int | None = None
    wall_s: float | None = None
    cpu_s: float | None = None
    start_s: float | None = None
    peak_mib: float | None = None
    designs_per_s: float | None = None
    speed_up: float | None = None
    net_speed_up: float | None = None
    runs: int | None = None
    note: str = ""


# dry runs, and one whose designs are stored; smaller ones stay in one process whatever --jobs says
DRY, STORED = (ScaleJob("hex", 22, "untwisted"), ScaleJob("hex", 20, "all")), ScaleJob("hex", 20, "untwisted")
QUICK_DRY, QUICK_STORED = (ScaleJob("hex", 12, "all"),), ScaleJob("hex", 12, "untwisted")


def tables(rows: list[ScaleRow]) -> list[Table]:
    """What is shown and saved."""
    return [
        Table(
            "scale",
            "The whole command: processes, a cluster, databases",
            f"The command is `hcsearch enumerate --until {LAST}`, including the start of the interpreter; the "
            "ways to run a job alternate, and times are medians of `runs`. The cluster is a Dask scheduler "
            f"with {WORKERS} workers of one process and one thread each on this machine, which have run a job "
            "before. `into` is - for a dry run; otherwise each run stores into a new database. `cpu_s` and "
            "`peak_mib` do not include the cluster or the server, and `peak_mib` is that of the first process "
            "only. `speed_up` is the number of designs a second relative to that of one process, within one "
            "job and `into`; `net_speed_up` is the same without `start_s`. Two commands of one process each, "
            "started together, show the greatest speed-up that the machine allows; other work on the same "
            "cores lowers all numbers.",
            rows,
        )
    ]


def measure(*, quick: bool, repeats: int, postgresql: str | None, say: Say) -> list[ScaleRow]:
    """Run the whole bench: half an hour, or half a minute when `quick`; HcsearchError when a command fails.

    postgresql : URL of a server on which databases may be made and dropped.
    """
    storing = ways_to_store(postgresql)
    for way in storing:  # a server that refuses is known before the long runs
        with way.make():
            pass
    rows: list[ScaleRow] = []
    with ExitStack() as stack:
        address = None
        if find_spec(cluster.PACKAGE) is not None:
            say(f"start a Dask cluster of {WORKERS} workers")
            address = stack.enter_context(cluster.running_cluster(WORKERS))
        for job in QUICK_DRY if quick else DRY:
            rows += measure_job(job, ways_to_list(address), repeats=repeats, say=say)
    return rows + measure_job(QUICK_STORED if quick else STORED, storing, repeats=repeats, say=say)


def ways_to_list(address: str | None) -> list[RunWay]:
    """Dry runs: with one and two processes, on the cluster of an address, and two commands at once."""
    on_cluster = ("--dry-run", "--scheduler", address or "")
    return [
        RunWay("--jobs 1", ("--dry-run", "--jobs", "1")),
        RunWay("--jobs 2", ("--dry-run", "--jobs", "2")),
        RunWay(f"cluster of {WORKERS}", on_cluster, note="" if address else f"{cluster.PACKAGE} {MISSING}"),
        RunWay("two commands", ("--dry-run", "--jobs", "1"), at_once=2),
    ]


def ways_to_store(postgresql: str | None) -> list[RunWay]:
    """Runs with one and two processes into SQLite, and into databases of a server if there is one."""
    server = RunWay("--jobs 1", ("--jobs", "1"), "PostgreSQL", note=_NO_SERVER)
    makers: list[tuple[str, Maker]] = [("SQLite", new_sqlite)]
    if postgresql is not None:
        makers.append(("PostgreSQL", new_postgresql(postgresql)))
    ways = [RunWay(f"--jobs {k}", ("--jobs", str(k)), into, make) for into, make in makers for k in (1, 2)]
    return ways if postgresql is not None else [*ways, server]


def measure_job(job: ScaleJob, ways: Sequence[RunWay], *, repeats: int, say: Say) -> list[ScaleRow]:
    """One row a way, run by turns; all must find the same number of designs."""
    done: dict[RunWay, list[Finished]] = {way: [] for way in ways}
    measured = [way for way in ways if not way.note]
    small = ScaleJob(job.grid, 10, job.keep)
    for way in measured:  # on a new machine this compiles the kernels, and workers load them
        if way is measured[0] or "--scheduler" in way.options:
            _run(small, way)
    start = statistics.median(_run(small, measured[0])[0].wall for _ in range(repeats))
    for _ in range(repeats):
        for way in measured:
            say(f"{job.grid} n={job.n} {job.keep}: {way.how}{'' if way.into == '-' else f' into {way.into}'}")
            done[way] += _run(job, way)
    designs = _designs(job, [run for runs in done.values() for run in runs])
    alone = {way.into: statistics.median(run.wall for run in done[way]) for way in measured if way.how == "--jobs 1"}
    return [_row(job, way, done[way], designs, start, alone) for way in ways]


def _run(job: ScaleJob, way: RunWay) -> list[Finished]:
    """Run a job in one way: as many commands at once as it says."""

    def once(_: int) -> Finished:
        with way.make() as variables:
            return job.run(way.options, variables)

    with ThreadPoolExecutor(way.at_once) as pool:
        return list(pool.map(once, range(way.at_once)))


def _row(
    job: ScaleJob, way: RunWay, runs: list[Finished], designs: int, start: float, alone: dict[str, float]
) -> ScaleRow:
    row = ScaleRow(job.grid, job.n, job.keep, way.into, way.how, note=way.note)
    if way.note:
        return row
    wall, one = statistics.median(run.wall for run in runs), alone[way.into]
    return replace(
        row,
        designs=designs,
        wall_s=wall,
        cpu_s=statistics.median(run.cpu for run in runs),
        start_s=start,
        peak_mib=max(run.peak_mib for run in runs),
        designs_per_s=way.at_once * designs / wall,
        speed_up=way.at_once * one / wall,
        net_speed_up=way.at_once * (one - start) / (wall - start) if min(one, wall) > 2 * start else None,
        runs=len(runs),
    )


def _designs(job: ScaleJob, runs: Sequence[Finished]) -> int:
    """The number that all runs print; HcsearchError when one failed or printed another."""
    label = _COUNTS[job.keep]
    numbers = set()
    for run in runs:
        match = re.search(rf"^ +{label} +([\d,]+)$", run.output, re.MULTILINE)
        if match is None:
            lines = run.error.strip().splitlines() or ["it took too long"]
            raise HcsearchError(f"enumerate {job.grid} n={job.n} {job.keep} failed: {lines[-1]}")
        numbers.add(int(match[1].replace(",", "")))
    if len(numbers) != 1:
        raise HcsearchError(f"enumerate {job.grid} n={job.n} {job.keep} found {sorted(numbers)} designs; report this")
    return numbers.pop()


SCALE = Bench(
    "scale",
    "Measure whole searches. Uses one and two processes, a Dask cluster of two workers, and databases.\n"
    "\n"
    "The command starts the cluster; Dask comes with an extra: pip install 'hcsearch[cluster]'.",
    "hcsearch bench scale --postgresql postgresql://USER@HOST/postgres",
    measure,
    tables,
    peers=(cluster.PACKAGE, "sqlalchemy", "psycopg"),
    repeats=True,
    server=True,
)
