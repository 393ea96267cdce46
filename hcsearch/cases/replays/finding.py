"""The path that is driven, or shown: of the way that gave the folding its status, else of the path that is proved."""

from __future__ import annotations

from dataclasses import replace

from hcsearch.cases.case import Case
from hcsearch.motion.planning.motions import PlannedMotion
from hcsearch.scenes import Scene
from hcsearch.springs.drive.driving import find_drive_motion


def find_path(case: Case) -> tuple[Scene, PlannedMotion, str]:
    """Find the motion of a case's folding, with its scene, and what users should know of how flat pairs are joined.

    Springs may open a folding joined in one way, and its path be proved in another: a path is looked for in the first,
    so that all that is made of a folding is of one linkage, and only where none is proved in the other.
    """
    folding, scene = case.to_move(), replace(case.scene, flat_pairs=case.allowed)
    motion = find_drive_motion(folding, scene)
    path = None if case.stored is None or case.stored.verdict is None else case.stored.verdict.path
    if motion.margin is None and case.look_of == "verdict" and path not in (None, case.look.pairs):
        assert path is not None
        other = replace(scene, flat_pairs=(path,))
        proved = find_drive_motion(folding, other)
        if proved.margin is not None:
            said = f"flat pairs {path}, as in the proved path: none is proved with flat pairs {case.look.pairs}"
            return other, proved, case.told(said)
    return scene, motion, case.driven_sentence
