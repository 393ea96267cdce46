"""Rows of the bench `deployability`: verdicts on the untwisted foldings of some arrays."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from hcsearch.designs.folding import folding_at
from hcsearch.designs.records import CircuitBatch, DeploymentBatch, FoldingBatch, MobilityBatch, MotionBatch
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS
from hcsearch.scenes import SCENES
from hcsearch.scenes.looks import SPREAD_SPRING_SETS, scene_variants
from hcsearch.search.enumeration import Search
from hcsearch.search.stages.mobility import mobility_of_batch
from hcsearch.search.stages.motion import motions_of_batch
from hcsearch.springs.deployment.deployment_verdicts import deploy_foldings
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.foldings import packed, search_of, untwisted

SIZES = {"hex": range(6, 17, 2), "square": range(4, 21, 2), "triangle": range(10, 27, 4)}
QUICK = {"hex": range(6, 9, 2), "square": range(4, 9, 2), "triangle": range(10, 11)}
ARRAYS = (
    *(("square", spec) for spec in ("4x4", "6x5")),
    *(("rectangle", spec) for spec in ("4x4", "6x4", "6x5", "6x6", "8x6")),
    *(("hex", spec) for spec in ("3-4-3", "4-5-4-5", "3-4-5-4", "p4x4", "p5x4")),
)
SCENE = SCENES["default"]
SAMPLE, LARGE, SAMPLE_OF_LARGE = 140, 30, 24
"""Foldings that are looked at, at most: of up to 30 panels, and of more."""
HELPS = ("default", "hinged", "merged", "graded", "spread")
SETS = len({look.springs for look in scene_variants(SCENE)} & set(SPREAD_SPRING_SETS))
"""Spring sets spread over all that springs may be, of which looks are taken."""


@dataclass(frozen=True)
class DeployabilityRow:
    """Untwisted foldings of all arrays of n cells, or of one array: all of them, or a sample.

    untwisted : how many there are. foldings : how many were looked at, evenly over the list.
    default : certified clear to flat in the scene `default`; hinged : in none before, but so with hinged flat pairs;
    merged : with mirror pairs made one; graded, spread : with such springs. movable : of the rest, those with a proved
    path. tight : of all with a path, those within the least play of `CERTIFIED_MARGINS`. locked : of the rest,
    those proved so with rigid, hinged and merged flat pairs. designs : of the foldings; deployable : those
    of which a folding deploys or is movable. best : the folding that deploys, else moves, with the least play (mm), the
    lowest crease and the first circuit; empty without one.
    """

    grid: str
    cells: str
    untwisted: int
    foldings: int
    default: int
    hinged: int
    merged: int
    graded: int
    spread: int
    movable: int
    undecided: int
    locked: int
    tight: int
    designs: int
    deployable: int
    best: str
    play: float | None
    seconds: float


def deployability_rows(*, quick: bool, say: Say) -> list[DeployabilityRow]:
    """A row for n cells, or an array; each is said when it is finished."""
    rows = []
    for named in _searches(quick):
        rows.append(_row(*named))
        say(_line(rows[-1]))
    return rows


def _searches(quick: bool) -> Iterator[tuple[str, str, Search]]:
    for grid, sizes in (QUICK if quick else SIZES).items():
        for n in sizes:
            yield grid, f"n = {n}", search_of(grid, str(n))
    for grid, spec in () if quick else ARRAYS:
        yield grid, spec, search_of(grid, spec)


def _line(row: DeployabilityRow) -> str:
    """A row as it is printed when it is finished: those after it may take half an hour."""
    grid, cells, *numbers = asdict(row).items()
    return f"{grid[1]} {cells[1]}: " + ", ".join(f"{name} {value}" for name, value in numbers)


def _row(grid: str, cells: str, search: Search) -> DeployabilityRow:
    begin = time.process_time()
    total = sum(len(foldings) for _, foldings in untwisted(search))
    limit = SAMPLE if search.n <= LARGE else SAMPLE_OF_LARGE
    tally: Counter[str] = Counter()
    best: list[_Best] = []
    for circuits, foldings in packed(untwisted(search, max(1, math.ceil(total / limit)))):
        known = mobility_of_batch(circuits, foldings, np.zeros(len(foldings), np.int16))
        moves = motions_of_batch(circuits, foldings, (known.locked, known.locked_hinged), SCENE, threads=2)
        judged = deploy_foldings(circuits, foldings, known.locked, moves.met, SCENE)
        tally.update(_helped(judged, moves, known))
        tally["tight"] += int((moves.margin <= CERTIFIED_MARGINS[0]).sum())
        able = judged.deploys | moves.moves
        tally.update({"designs": len(np.unique(foldings.row)), "deployable": len(np.unique(foldings.row[able]))})
        best += _able(circuits, foldings, judged, moves)
    counts = {name: tally[name] for name in (*HELPS, "movable", "undecided", "locked")}
    _, play, crease, name = min(best, default=(False, math.inf, 0, ""))
    return DeployabilityRow(
        grid=grid,
        cells=cells,
        untwisted=total,
        foldings=sum(counts.values()),
        **counts,
        tight=tally["tight"],
        designs=tally["designs"],
        deployable=tally["deployable"],
        best=f"{name}:{crease}" if name else "",
        play=round(1e3 * play, 6) if math.isfinite(play) else None,
        seconds=time.process_time() - begin,
    )


_Best = tuple[bool, float, int, str]
"""Whether a folding does not deploy, its play (m), crease and circuit."""


def _able(
    circuits: CircuitBatch, foldings: FoldingBatch, judged: DeploymentBatch, moves: MotionBatch
) -> Iterator[_Best]:
    """The foldings that deploy or move."""
    play = np.nan_to_num(moves.margin, nan=math.inf)
    for i in np.flatnonzero(judged.deploys | moves.moves).tolist():
        folding = folding_at(circuits, foldings, i)
        yield not judged.deploys[i], float(play[i]), folding.crease, folding.circuit.notation


def _helped(judged: DeploymentBatch, moves: MotionBatch, known: MobilityBatch) -> Iterator[str]:
    """For each folding what helped it, or its status."""
    helped = {trial.folding: trial.scene for trial in judged.trials if trial.status == "deploys"}
    for i, movable in enumerate(moves.moves.tolist()):
        if (scene := helped.get(i)) is not None:
            yield _help(scene)
        else:
            yield "movable" if movable else "locked" if known.locked_hinged[i] else "undecided"


def _help(scene: str) -> str:
    if scene in HELPS:
        return scene
    return "spread" if scene.removeprefix("hinged, ") in SPREAD_SPRING_SETS else "graded"
