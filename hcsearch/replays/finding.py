"""The path that is driven, or shown: of the way that gave the folding its status, else of the path that is proved."""

from __future__ import annotations

from hcsearch.drive.driving import find_motion
from hcsearch.flat_pairs import scene_joined
from hcsearch.folding import Folding
from hcsearch.planning.motions import PlannedMotion
from hcsearch.scenes import Scene
from hcsearch.subjects.reading import read_folding
from hcsearch.subjects.requests import Request, known_of, settled, with_path


def find_path(request: Request) -> tuple[Folding, Scene, PlannedMotion, str]:
    """The folding that a request names, its scene, its motion, and what users should know of how flat pairs are joined.

    Springs may open a folding joined in one way, and its path be proved in another: a path is looked for in the first,
    so that all that is made of a folding is of one linkage, and only where none is proved in the other. A design whose
    best folding is opened by springs alone stands for the first folding with a proved path.
    """
    request = with_path(settled(request))
    known = known_of(request)
    folding, scene = read_folding(request)
    motion = find_motion(folding, scene)
    path = None if known.verdict is None else known.verdict.path
    if motion.margin is None and known.look is not None and path not in (None, known.look.pairs):
        assert path is not None
        other = scene_joined(scene, path)
        proved = find_motion(folding, other)
        if proved.margin is not None:
            said = f"flat pairs {path}, as in the proved path: none is proved with flat pairs {known.look.pairs}"
            return folding, other, proved, known.said(said)
    return folding, scene, motion, known.driven_sentence
