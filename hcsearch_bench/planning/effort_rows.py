"""What the efforts of the search settle, one after the other, and how many processor seconds they take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.designs.folding import folding_at
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.scenes import SCENES, panel_of
from hcsearch_bench.planning.folding_rows import Group
from hcsearch_bench.run.timing import Stopwatch
from hcsearch_bench.subjects.foldings import untwisted

SCENE = SCENES["default"]


@dataclass(frozen=True)
class EffortRow:
    """What is settled of a list after so many efforts of the search (motion.md).

    movable, locked : foldings with a proved path, and with a proof that there is none. spent_s : processor time of
    these efforts and those before, of all foldings. longest_s : of the folding that took most.
    """

    group: str
    efforts: int
    foldings: int
    movable: int
    locked: int
    undecided: int
    share: float
    spent_s: float
    longest_s: float


def effort_rows(group: Group, most: int) -> list[EffortRow]:
    """What the first efforts, up to so many, settle of all untwisted foldings of a list."""
    panel, allowed = panel_of(SCENE, group.grid), SCENE.flat_pairs
    batches = untwisted(group.search())
    waiting = [folding_at(circuits, own, i) for circuits, own in batches for i in range(len(own))]
    seconds, counts, rows = dict.fromkeys(waiting, 0.0), {"movable": 0, "locked": 0}, []
    for effort in range(1, most + 1):
        left = []
        for folding in waiting:
            watch = Stopwatch()
            with watch:
                motion = plan_motion(folding, panel, allowed, SCENE.margin, budget=effort, done=effort - 1)
            seconds[folding] += watch.cpu
            if motion.margin is not None or motion.locked:
                counts["locked" if motion.locked else "movable"] += 1
            else:
                left.append(folding)
        waiting = left
        spent, longest = float(np.sum(list(seconds.values()))), max(seconds.values(), default=0.0)
        share = 1.0 - len(waiting) / max(len(seconds), 1)
        rows.append(EffortRow(group.name, effort, len(seconds), **counts, undecided=len(waiting), share=share,
                              spent_s=spent, longest_s=longest))  # fmt: skip
    return rows
