"""Single searches for a path beside OMPL's RRT-Connect: the same margin, the same time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.motion.collision.panel_prisms import margin_of
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.searching import Budget
from hcsearch_bench.peers import ompl_search
from hcsearch_bench.run.timing import Stopwatch
from hcsearch_bench.run.work_precision import OURS, UnableError

PathSearch = Callable[[Planner, int, float], tuple[Reals | None, float]]
JoinedFolding = tuple[str, Way]
"""A folding, and how its flat pairs are joined."""

ROUNDS = 80
"""Rounds of one of our searches; another one begins after them, with other random numbers."""


@dataclass(frozen=True)
class SearchRow:
    """Searches of one engine for a path of a folding.

    met : of the searches, those that come to a path in time; proved : of these, paths that are proved with the margin.
    median_s : processor time of those that met one.
    """

    folding: str
    flat_pairs: str
    engine: str
    searches: int
    met: int | None = None
    proved: int | None = None
    median_s: float | None = None
    note: str = ""


def ours(planner: Planner, seed: int, limit: float) -> tuple[Reals | None, float]:
    """Search for a path with our planner, until it finds one or for so many processor seconds."""
    watch, again = Stopwatch(), 0
    while watch.cpu < limit:
        with watch:
            plan = planner.plan(Budget(ROUNDS, seed=100 * seed + again))
        if plan.states is not None:
            return plan.states, watch.cpu
        again += 1
    return None, watch.cpu


ENGINES: dict[str, PathSearch] = {OURS: ours, "OMPL RRT-Connect": ompl_search.search}


def search_rows(subject: JoinedFolding, searches: int, limit: float) -> Iterator[SearchRow]:
    """Search for paths of a folding with every engine, several times each, within so many processor seconds."""
    name, way = subject
    folding = Folding.from_notation(name)
    linkage = folding.linkage(default_panel(folding.circuit.grid.name), flat_pairs=way)
    planner, prover = Planner(linkage, margin_of(linkage)), Prover(linkage)
    planner.plan(Budget(1))  # compiled
    for engine, search in ENGINES.items():
        try:
            results = [search(planner, seed, limit) for seed in range(searches)]
        except UnableError as error:
            yield SearchRow(name, way, engine, 0, note=str(error))
            continue
        paths = [states for states, _ in results if states is not None]
        times = [seconds for states, seconds in results if states is not None]
        yield SearchRow(
            folding=name,
            flat_pairs=way,
            engine=engine,
            searches=searches,
            met=len(paths),
            proved=sum(prover.prove(states, [planner.margin]).margin is not None for states in paths),
            median_s=float(np.median(times)) if times else None,
        )
