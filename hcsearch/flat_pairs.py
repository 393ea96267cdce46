"""How the flat pairs of a folding are joined: the ways that a scene allows, and the linkage of each.

The two pairs of panels that lie flat beside each other in both states are rigid, or hinged; where the circuit has the
mirror symmetry of the folding, panels that meet on its axis can also be made one (theory.md, 29).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hcsearch.folding import Folding
from hcsearch.linkage import Linkage
from hcsearch.scenes import PanelSize, Scene
from hcsearch.vocabulary import Way


def ways(scene: Scene) -> tuple[Way, ...]:
    """How flat pairs may be joined in a scene, in the order in which they are tried."""
    if scene.merge is True:
        return ("merged",)
    allowed: tuple[Way, ...] = ("rigid", "hinged") if scene.flat_pairs == "either" else (scene.flat_pairs,)
    return (*allowed, "merged") if scene.merge == "either" else allowed


def widest_of(allowed: Sequence[Way]) -> tuple[Way, ...]:
    """The way whose motions are those of all others, too, by which hinges are joined; all ways where there is none."""
    return ("hinged",) if "hinged" in allowed else tuple(allowed)


def linkage_joined(folding: Folding, panel: PanelSize, way: Way) -> Linkage:
    """A folding as a linkage with its flat pairs joined in a way."""
    return folding.linkage(panel, flat_pairs="hinged" if way == "hinged" else "rigid", merged=way == "merged")


def scene_joined(scene: Scene, way: Way) -> Scene:
    """The scene in which flat pairs are joined in one way alone."""
    return replace(scene, flat_pairs="hinged" if way == "hinged" else "rigid", merge=way == "merged")


def can_be(folding: Folding, way: Way) -> bool:
    """Whether the flat pairs of a folding can be joined in a way: there may be no mirror pairs to merge."""
    return way != "merged" or bool(folding.mirror_pairs)
