"""What a run will take, before it begins: all circuits by the published growth, everything else by a probe."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass

from hcsearch.basics.errors import SizeError
from hcsearch.search.pipeline.amounts import duration, number, size
from hcsearch.search.pipeline.judging import seconds_of
from hcsearch.search.pipeline.run import Plan
from hcsearch.search.pipeline.shards import ShardJob
from hcsearch.search.pipeline.workers import Crew
from hcsearch.store import room_at

_PROBE = 8  # shards
_FOLDING_BYTES = 650  # a panel, mostly of paths: measured with hexagons, 7.6 kB a folding of n = 12, 9.4 kB of n = 14
_ROW_SECONDS = 1e-5  # measured: 100,000 designs a second go into a database


@dataclass(frozen=True)
class RunEstimate:
    """About how many circuits are listed and designs kept, core seconds to find them, bytes and seconds to store."""

    circuits: float
    designs: float
    core_seconds: float
    stored_bytes: float
    store_seconds: float

    def sentence(self, crew: Crew) -> str:
        """One line for people; one process writes while the others work."""
        if crew.scheduler is not None:
            time = f"{duration(self.core_seconds)} of core time on the cluster, {duration(self.store_seconds)} to store"
        else:
            time = f"{duration(max(self.core_seconds / crew.jobs, self.store_seconds))} with --jobs {crew.jobs}"
        room = f", {size(self.stored_bytes)} in the database" if self.stored_bytes else ""
        return f"about {number(self.circuits)} circuits to list, {number(self.designs)} to keep: {time}{room}"


def estimate(plan: Plan, *, stored: bool, finished: Collection[str] = ()) -> RunEstimate | None:
    """What the rest of a plan will take; None where that is a matter of seconds.

    finished : shards that are done already. A few of the others, spread over the search, are worked on as a probe; the
    first one is not timed, since it compiles.
    """
    search = plan.search
    shards = [shard for shard in search.prefixes if shard not in finished]
    if plan.small or not shards:
        return None
    expected = None if search.expected is None else search.expected * len(shards) / len(search.prefixes)
    # motions are not probed: a few shards of them would take as long as many of the others
    job = ShardJob(search, plan.listing, plan.keep, rows=stored, candidates=bool(plan.scenic))
    job(shards[-1])
    sample = shards[:: -(-len(shards) // _PROBE)]
    begun = time.perf_counter()
    outputs = [job(shard) for shard in sample]
    seconds = time.perf_counter() - begun
    listed = sum(output.results[0].passed for output in outputs)
    kept = sum(output.kept for output in outputs)
    share = len(shards) / len(sample) if expected is None or not listed else expected / listed
    designs = kept * share
    core_seconds, stored_bytes = seconds * share, designs * (60 + 5 * search.n)
    if plan.scenic:
        foldings = share * sum(len(output.candidates.folded) for output in outputs if output.candidates is not None)
        core_seconds += seconds_of(foldings, search.n)
        stored_bytes += foldings * _FOLDING_BYTES * search.n
    return RunEstimate(
        circuits=listed * share,
        designs=designs,
        core_seconds=core_seconds,
        stored_bytes=stored_bytes if stored else 0.0,
        store_seconds=designs * _ROW_SECONDS if stored else 0.0,
    )


def check_room(expected: RunEstimate, location: str) -> None:
    """SizeError when the disk of a database file has too little room; what the file holds already counts as room."""
    room = room_at(location)
    if room is not None and expected.stored_bytes > room:
        raise SizeError(
            f"about {number(expected.designs)} designs need {size(expected.stored_bytes)} and {location} has room for "
            f"{size(room)}: name a database elsewhere with --db, keep fewer with --keep or --n, or do without one: "
            "--dry-run, `hcsearch count`"
        )
