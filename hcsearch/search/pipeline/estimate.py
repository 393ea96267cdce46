"""Estimates of a run's time and space."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass

from hcsearch import store
from hcsearch.basics.errors import SizeError
from hcsearch.search.pipeline.judging import judging_seconds
from hcsearch.search.pipeline.run import Plan
from hcsearch.search.pipeline.shards import ShardJob
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.system.terminal import bytes_text, duration_text, number_text

_PROBE = 8  # shards
_FOLDING_BYTES = 650  # per panel, mostly paths; measured with hexagons: 7.6 kB per folding of n = 12, 9.4 kB of n = 14
_ROW_SECONDS = 1e-5  # measured: 100,000 designs a second go into a database


@dataclass(frozen=True)
class RunEstimate:
    """Estimated numbers of listed circuits and kept designs, core seconds of search, bytes and seconds of storage."""

    circuits: float
    designs: float
    core_seconds: float
    stored_bytes: float
    store_seconds: float

    def sentence(self, crew: WorkerPool) -> str:
        """Return the estimate as a sentence; one process writes while the others compute."""
        if crew.scheduler is not None:
            cores, store = duration_text(self.core_seconds), duration_text(self.store_seconds)
            time = f"{cores} of core time on the cluster, {store} to store"
        else:
            time = f"{duration_text(max(self.core_seconds / crew.jobs, self.store_seconds))} with --jobs {crew.jobs}"
        room = f", {bytes_text(self.stored_bytes)} in the database" if self.stored_bytes else ""
        return f"about {number_text(self.circuits)} circuits to list, {number_text(self.designs)} to keep: {time}{room}"


def estimate_run(plan: Plan, *, stored: bool, finished: Collection[str] = ()) -> RunEstimate | None:
    """Estimate the remaining work of a plan; None where it takes only seconds.

    finished : shards that are done already. A sample of the others, spread over the search, is processed as a probe,
    after one shard that is not timed, since it compiles kernels.
    """
    search = plan.search
    shards = [shard for shard in search.prefixes if shard not in finished]
    if plan.is_small or not shards:
        return None
    expected = None if search.expected is None else search.expected * len(shards) / len(search.prefixes)
    # motions are not probed: they take far longer than listing
    job = ShardJob(search, plan.listing_stages, plan.keep, with_rows=stored, with_candidates=bool(plan.scene_stages))
    job(shards[-1])
    sample = shards[:: -(-len(shards) // _PROBE)]
    start_time = time.perf_counter()
    outputs = [job(shard) for shard in sample]
    seconds = time.perf_counter() - start_time
    listed = sum(output.results[0].passed for output in outputs)
    kept_count = sum(output.kept_count for output in outputs)
    share = len(shards) / len(sample) if expected is None or not listed else expected / listed
    designs = kept_count * share
    core_seconds, stored_bytes = seconds * share, designs * (60 + 5 * search.n)
    if plan.scene_stages:
        foldings = share * sum(len(output.candidates.folded) for output in outputs if output.candidates is not None)
        core_seconds += judging_seconds(foldings, search.n)
        stored_bytes += foldings * _FOLDING_BYTES * search.n
    return RunEstimate(
        circuits=listed * share,
        designs=designs,
        core_seconds=core_seconds,
        stored_bytes=stored_bytes if stored else 0.0,
        store_seconds=designs * _ROW_SECONDS if stored else 0.0,
    )


def check_disk_room(expected: RunEstimate, location: str) -> None:
    """Check that a database's disk has room for the estimate, its present contents included; SizeError otherwise."""
    room = store.room_at(location)
    if room is not None and expected.stored_bytes > room:
        raise SizeError(
            f"about {number_text(expected.designs)} designs need {bytes_text(expected.stored_bytes)} and {location} "
            f"has room for {bytes_text(room)}: "
            "name a database elsewhere with --db, keep fewer with --keep or --n, or do without one: "
            "--dry-run, `hcsearch count`"
        )
