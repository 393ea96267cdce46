"""All designs of n panels listed, joined from half-chains, or counted: each a job for a process of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hcsearch_bench.run.timing import Row, Stopwatch, repeated, timed

if TYPE_CHECKING:
    from hcsearch.designs.records import Integers
    from hcsearch.search.enumeration import FoldedSearch


def list_polygons(grid: str, n: int, repeats: int) -> Row:
    """List, fold and twist all circuits of n panels; only the making of each is timed."""
    from hcsearch.designs.folding import fold
    from hcsearch.designs.grid import grid_named
    from hcsearch.designs.twisting import twist_batch
    from hcsearch.search.enumeration import PolygonSearch

    def run(n: int = n) -> Row:
        search = PolygonSearch(grid_named(grid), n)
        listing, folding, twisting = Stopwatch(), Stopwatch(), Stopwatch()
        free = fixed = two_stack = untwisted = 0
        for batch in timed(listing, search.batches()):
            with folding:
                folds = fold(batch)
            with twisting:
                twists = twist_batch(batch, folds)
            free += len(batch)
            fixed += int((search.group_order // batch.symmetry).sum())
            two_stack += _distinct(folds.row)
            untwisted += _distinct(folds.row[twists == 0])
        times = {"list_s": listing.cpu, "fold_s": folding.cpu, "twist_s": twisting.cpu}
        counts = {"free": free, "fixed": fixed, "two_stack": two_stack, "untwisted": untwisted}
        return counts | times | {"wall_s": listing.wall + folding.wall + twisting.wall}

    run(10)  # load the compiled kernels first
    return repeated(run, repeats)


def _distinct(rows: Integers) -> int:
    """Number of different values among ascending ones."""
    return int((rows[1:] != rows[:-1]).sum()) + (len(rows) > 0)


def join_polygons(grid: str, n: int, keep: str, repeats: int) -> Row:
    """Join half-chains to all designs, then fold and twist these; only the making of each is timed."""
    from hcsearch.designs.folding import fold
    from hcsearch.designs.twisting import twist_batch

    def run(n: int = n) -> Row:
        watch = Stopwatch()
        designs = 0
        with watch:
            batches = _search(grid, n, keep).batches()  # counts the half-chains
        for batch in timed(watch, batches):
            with watch:
                twist_batch(batch, fold(batch))
            designs += len(batch)
        return {"designs": designs, "seconds": watch.cpu}

    run(10)  # load the compiled kernels first
    return repeated(run, repeats)


def count_polygons(grid: str, n: int, keep: str, repeats: int) -> Row:
    """Count all designs by joining half-chains."""

    def run(n: int = n) -> Row:
        watch = Stopwatch()
        with watch:
            search = _search(grid, n, keep)
            designs = sum(search.count(shard)[0] for shard in search.counting_shards)
        return {"designs": designs, "seconds": watch.cpu}

    run(10)
    return repeated(run, repeats)


def _search(grid: str, n: int, keep: str) -> FoldedSearch:
    from hcsearch.designs.grid import grid_named
    from hcsearch.search.enumeration import FoldedSearch

    return FoldedSearch(grid_named(grid), n, untwisted=keep == "untwisted")
