"""Rows of the bench `kinematics`: motions that begin at the ends, and descents from stacks to flat."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.designs.folding import foldings
from hcsearch.designs.twisting import twist
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.paths.descent import descend_energy, find_descent
from hcsearch.search.enumeration import enumerate_circuits
from hcsearch.shape.linkage import Linkage
from hcsearch_bench.kinematics.path_methods import UNITS, KnownUnit
from hcsearch_bench.run.bench import Say

DESIGNS = (("triangle", 10), ("triangle", 14), ("square", 12), ("hex", 10), ("hex", 12))
QUICK_DESIGNS = (("triangle", 10), ("square", 10))


@dataclass(frozen=True)
class BranchRow:
    """Motions that begin at an end of the motion, with hinges that turn either way or with stops.

    nullity : first-order motions; equations : of second order. isolated, families : directions that solve these, and
        the dimensions of families of them; finite : how many of those tried are motions, of which `within` keep the
        stops.
    """

    linkage: str
    state: str
    stops: str
    nullity: int
    equations: int
    isolated: int
    families: str
    tried: int
    finite: int
    within: int
    seconds: float


@dataclass(frozen=True)
class DescentRow:
    """Untwisted foldings of all designs of n panels, 50 mm, 6 mm thick, and the search for a motion to flat.

    pairs : whether the two flat pairs are rigid or hinged. flat : with equal springs, and `flat_in_all` with any of the
        spring sets. descent_ms : median and greatest time of one descent, search_ms : of all sets together.
    """

    grid: str
    n: int
    pairs: str
    foldings: int
    flat: int
    flat_in_all: int
    stuck: int
    other: int
    descent_ms: float
    descent_max_ms: float
    search_ms: float
    search_max_ms: float


def measure_branches(*, say: Say) -> list[BranchRow]:
    """One row a unit, end and kind of hinge."""
    rows = []
    for name in UNITS:
        linkage = KnownUnit(name).linkage
        for state in ("folded", "flat"):
            for stops in (False, True):
                say(f"branches of unit {name}, {state}{', with stops' if stops else ''}")
                begin = time.perf_counter()
                search = find_branches(linkage, getattr(linkage, state), stops=stops)
                seconds = time.perf_counter() - begin
                dimensions = [branch.dimension for branch in search.branches]
                rows.append(
                    BranchRow(
                        f"unit {name}",
                        state,
                        "yes" if stops else "no",
                        search.nullity,
                        search.stresses,
                        dimensions.count(0),
                        ", ".join(map(str, sorted(set(dimensions) - {0}))) or "-",
                        len(search.branches),
                        len(search.finite),
                        sum(branch.within_stops for branch in search.finite),
                        seconds,
                    )
                )
    return rows


def measure_descents(designs: Sequence[tuple[str, int]], *, say: Say) -> list[DescentRow]:
    """Two rows a grid and n: flat pairs rigid, and hinged."""
    rows = []
    for grid, n in designs:
        subjects = [f for circuit in enumerate_circuits(grid, n=n) for f in foldings(circuit) if not twist(f)]
        for pairs in ("rigid", "hinged"):
            say(f"descents of {len(subjects)} foldings of {n} panels ({grid}), flat pairs {pairs}")
            once, searched, ends, all_ends = [], [], Counter[str](), Counter[str]()
            for folding in subjects:
                linkage = Linkage(folding.pattern((0.05, 0.05, 0.006), flat_pairs=pairs))
                descend_energy(linkage, max_steps=1)  # what is cached is not counted
                begin = time.perf_counter()
                ends[descend_energy(linkage).outcome] += 1
                middle = time.perf_counter()
                all_ends[find_descent(linkage).path.outcome] += 1
                once.append(1e3 * (middle - begin))
                searched.append(1e3 * (time.perf_counter() - middle))
            rows.append(
                DescentRow(
                    *(grid, n, pairs, len(subjects), ends["flat"], all_ends["flat"], all_ends["stuck"]),
                    len(subjects) - all_ends["flat"] - all_ends["stuck"],
                    *(float(np.median(once)), max(once), float(np.median(searched)), max(searched)),
                )
            )
    return rows
