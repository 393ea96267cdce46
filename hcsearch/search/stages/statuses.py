"""What is known of foldings in one word each, and which folding of a design is its best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.vocabulary import STATUSES, WAYS, Status
from hcsearch.designs.records import NO_NUMBER, StagedDesigns, play_of_batch
from hcsearch.scenes import Scene
from hcsearch.search.stages.mobility import locked_in_every_way

IndexArray = NDArray[np.intp]


def folding_statuses(designs: StagedDesigns, scene: Scene | None = None) -> list[Status | None]:
    """The status of each folding, by the stages that have run; None where it is twisted, and where none judged it.

    Undecided : a path was looked for, and none is proved; before that stage only locks are known. Locked : for every
    way of joining flat pairs that the scene allows, at an end or kinematically; of them all where no scene is given. A
    folding whose pairs are merged is locked where one with rigid pairs is.
    """
    assert designs.mobility is not None
    locked = locked_in_every_way(designs.mobility, WAYS if scene is None else scene.flat_pairs)
    if designs.motion is not None:
        locked = locked | designs.motion.locked
    none = np.zeros(len(designs.folded), bool)
    deploys = none if designs.deployment is None else designs.deployment.deploys
    moves = none if designs.motion is None else designs.motion.moves
    twisted = none if designs.twists is None else designs.twists != 0
    place = np.select([deploys, moves, locked], [0, 1, 3], 2)
    unknown = twisted if designs.motion is not None else twisted | ~locked
    return [None if out else STATUSES[k] for k, out in zip(place.tolist(), unknown.tolist(), strict=True)]


def best_foldings(designs: StagedDesigns, statuses: list[Status | None] | None = None) -> IndexArray:
    """Index of the best untwisted folding of each design, shape (n_circuits,); -1 without one.

    The best has the best status, then the least needed margin of the motion that gives it that status, the lowest dof
    (undecided ones come last), the lowest crease. statuses : of the foldings, left out of the comparison unless given.
    """
    foldings, mobility = designs.folded, designs.mobility
    assert mobility is not None
    count = len(foldings)
    chosen = np.arange(count) if designs.twists is None else np.flatnonzero(designs.twists == 0)
    place = np.array([0 if word is None else STATUSES.index(word) for word in statuses or [None] * count], int)
    margin = np.zeros(count)
    if designs.motion is not None:
        margin = np.nan_to_num(play_of_batch(designs.motion, designs.deployment)[0], nan=np.inf)
    dof = np.where(mobility.dof == NO_NUMBER, np.iinfo(np.int32).max, mobility.dof)
    keys = (foldings.crease, dof, margin, place, foldings.row)
    order = chosen[np.lexsort([key[chosen] for key in keys])]
    best = np.full(len(designs), -1)
    best[foldings.row[order[::-1]]] = order[::-1]
    return best
