"""Rows of the bench `collision`: distances of many pairs of one kind, by our search and by coal."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch_bench.collision.pairs import Family, Sample
from hcsearch_bench.collision.proofs import settle
from hcsearch_bench.kernels.hull_gaps import write_hull_gaps
from hcsearch_bench.peers import coal_distances
from hcsearch_bench.run.timing import Stopwatch, median_time

AT_ONCE = 1_000
"""Pairs that coal gets at once."""
SAME = 1e-9
"""Distances that differ by no more, in widths of a panel, agree."""


@dataclass(frozen=True)
class PairRow:
    """Pairs of one kind.

    meet : share that touches or overlaps. exhaustive : of ours, searches that ended in trying all directions.
    difference : greatest between ours and coal's distance, in widths. beyond : pairs that differ by more than SAME;
    ours, theirs : of these, where ours is right, and where coal's, in exact arithmetic.
    cold_us, warm_us : of a pair, ours, from nowhere and from the answer. coal_us, coal_warm_us : AT_ONCE pairs at once.
    coal_loop_us : pair by pair from Python.
    """

    kind: str
    what: str
    pairs: int
    meet: float
    exhaustive: int
    difference: float | None
    beyond: int | None
    ours: int | None
    theirs: int | None
    cold_us: float
    warm_us: float
    coal_us: float | None
    coal_warm_us: float | None
    coal_loop_us: float | None
    runs: int


@dataclass
class _Answers:
    """Of our searches: gaps (k,), ways (k, 3), corners (k, 4)."""

    gaps: Reals
    ways: Reals
    corners: WholeNumbers


def pair_row(family: Family, n: int, repeats: int, seed: int) -> PairRow:
    """Measure n distances of a kind."""
    sample = family.make(np.random.default_rng(seed), n)
    solids, counts = sample.vertices(), sample.counts
    answers, cold, runs = _search(solids, counts, None, repeats)
    _, warm, _ = _search(solids, counts, answers, repeats)
    row = dict.fromkeys(("difference", "beyond", "ours", "theirs", "coal_us", "coal_warm_us", "coal_loop_us"))
    if coal_distances.installed():
        row |= _beside_coal(sample, solids, counts, answers, repeats)
    return PairRow(
        kind=family.name,
        what=family.what,
        pairs=n,
        meet=float((answers.gaps <= 0.0).mean()),
        exhaustive=int((answers.corners[:, 0] < 0).sum()),
        cold_us=1e6 * cold / n,
        warm_us=1e6 * warm / n,
        runs=runs,
        **row,
    )


def _search(solids: Reals, counts: WholeNumbers, start: _Answers | None, repeats: int) -> tuple[_Answers, float, int]:
    """Answers, from nowhere or from others, median processor seconds, and how many runs there were."""
    n = len(counts[0])
    answers = _Answers(np.empty(n), np.empty((n, 3)), np.empty((n, 4), np.int64))

    def run() -> float:
        answers.ways[:] = 0.0 if start is None else start.ways
        answers.corners[:] = -1 if start is None else start.corners
        watch = Stopwatch()
        with watch:
            write_hull_gaps(solids[0], counts[0], solids[1], counts[1], answers.ways, answers.corners, answers.gaps)
        return watch.cpu

    run()  # compiled
    return answers, *median_time(run, repeats)


def _beside_coal(
    sample: Sample, solids: Reals, counts: WholeNumbers, answers: _Answers, repeats: int
) -> dict[str, float | int]:
    """What coal says and takes, and who is right where it differs."""
    theirs, seconds = coal_distances.one_by_one(sample.shapes, sample.which, sample.turns, sample.shifts)
    ours = np.maximum(answers.gaps, 0.0)
    apart = np.abs(ours - theirs) / sample.width
    beyond = np.flatnonzero(apart > SAME)
    hulls = [(solids[0, k, : counts[0, k]], solids[1, k, : counts[1, k]]) for k in beyond]
    right = settle(hulls, ours[beyond], theirs[beyond], sample.width)
    n = min(AT_ONCE, len(theirs))
    scene = coal_distances.CoalScene(
        [sample.shapes[k] for k in sample.which[:n].ravel()], np.arange(2 * n).reshape(n, 2), moving=False
    )
    scene.place(sample.turns[:n].reshape(-1, 3, 3), sample.shifts[:n].reshape(-1, 3))
    return {
        "difference": float(apart.max()),
        **asdict(right),
        "coal_us": 1e6 * median_time(lambda: scene.seconds(warm=False), repeats)[0] / n,
        "coal_warm_us": 1e6 * median_time(lambda: scene.seconds(warm=True), repeats)[0] / n,
        "coal_loop_us": 1e6 * seconds / len(theirs),
    }
