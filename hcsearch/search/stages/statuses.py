"""The status of each folding, and the best folding of each design."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.vocabulary import STATUSES, WAYS, Status
from hcsearch.designs.records import NO_NUMBER, StagedDesigns, play_of_batch
from hcsearch.scenes import Scene
from hcsearch.search.stages.mobility import locked_in_every_way

IndexArray = NDArray[np.intp]


def folding_statuses(designs: StagedDesigns, scene: Scene | None = None) -> list[Status | None]:
    """Return the status of each folding from the stages that have run; None where it is twisted or not yet judged.

    Undecided : a path was searched for and none is proved; before the motion stage only locks are known. Locked : for
    every joining of flat pairs that the scene allows (all of them without a scene), at an end or kinematically. A
    folding with merged pairs is locked where the one with rigid pairs is.
    """
    assert designs.mobility is not None
    locked = locked_in_every_way(designs.mobility, WAYS if scene is None else scene.flat_pairs)
    if designs.motion is not None:
        locked = locked | designs.motion.locked
    none = np.zeros(len(designs.folded), bool)
    deploys = none if designs.deployment is None else designs.deployment.deploys
    moves = none if designs.motion is None else designs.motion.moves
    twisted = none if designs.twists is None else designs.twists != 0
    status_index = np.select([deploys, moves, locked], [0, 1, 3], 2)
    unknown = twisted if designs.motion is not None else twisted | ~locked
    return [
        None if is_unknown else STATUSES[k]
        for k, is_unknown in zip(status_index.tolist(), unknown.tolist(), strict=True)
    ]


def best_foldings(designs: StagedDesigns, statuses: list[Status | None] | None = None) -> IndexArray:
    """Return the index of the best untwisted folding of each design, shape (n_circuits,); -1 without one.

    Foldings are compared by status, then by the needed margin of the motion on which the status rests, by dof (lowest
    first, undecided last), and by crease. statuses : of the foldings; not compared unless given.
    """
    foldings, mobility = designs.folded, designs.mobility
    assert mobility is not None
    count = len(foldings)
    chosen = np.arange(count) if designs.twists is None else np.flatnonzero(designs.twists == 0)
    status_index = np.array([0 if word is None else STATUSES.index(word) for word in statuses or [None] * count], int)
    margin = np.zeros(count)
    if designs.motion is not None:
        margin = np.nan_to_num(play_of_batch(designs.motion, designs.deployment)[0], nan=np.inf)
    dof = np.where(mobility.dof == NO_NUMBER, np.iinfo(np.int32).max, mobility.dof)
    keys = (foldings.crease, dof, margin, status_index, foldings.row)
    order = chosen[np.lexsort([key[chosen] for key in keys])]
    best = np.full(len(designs), -1)
    best[foldings.row[order[::-1]]] = order[::-1]
    return best
