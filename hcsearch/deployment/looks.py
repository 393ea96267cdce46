"""The looks that the stage `deployment` takes at a folding: ways to join its flat pairs, and spring sets, by name."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hcsearch.deployment.compiling import Compiled
from hcsearch.deployment.springs import range_of, spring_sets
from hcsearch.flat_pairs import ways
from hcsearch.folding import Folding
from hcsearch.scenes import Scene, joined_name, panel_of
from hcsearch.typing import Reals
from hcsearch.vocabulary import WAYS, Way

GRADES: dict[str, tuple[float, float, float]] = {
    "bottom first": (1.0, 0.0, 0.0),
    "top first": (-1.0, 0.0, 0.0),
    "mountains first": (0.0, -1.0, 0.0),
    "one stack first": (0.0, 0.0, 1.0),
    "other stack first": (0.0, 0.0, -1.0),
    "top of one stack first": (-1.0, 0.0, 1.0),
}
"""Graded spring sets: how softness grows with the layer, with valleys after mountains, and with the second stack."""
OUTER = "outer layers first"
"""The set graded by the distance from the middle layer."""
SPREAD = tuple(f"spread {number}" for number in range(1, 9))
"""Sets spread evenly over the logarithms of what springs may be."""
_TAKEN = (
    "bottom first",
    "spread 6",
    "spread 3",
    "spread 8",
    "top of one stack first",
    "other stack first",
    "mountains first",
    "spread 5",
    "top first",
    OUTER,
    "spread 1",
)
"""Sets that looks take, those first that bring the most of what is left flat. Of 161 foldings (hexagons of 10 and 12
panels, squares of 12 and 14, triangles of 18) that some set brings flat, the looks before bring 111, these the rest."""
GRADED = 40.0
"""Stiffest over softest spring of a graded set; the stiffest is that of the scene's range."""
PATIENT = 3.0
"""How long a second look lasts, over the scene's seconds: of 158 motions of 12 hexagons, clear and not at rest after
1 s, 11 come flat."""
_SETS = (*GRADES, OUTER, *SPREAD)


@dataclass(frozen=True)
class Look:
    """How flat pairs are joined, and which springs there are; `first` is the scene as it stands."""

    pairs: Way
    springs: str = ""
    first: bool = False

    def name(self, scene: Scene) -> str:
        """The name of a scene as it is tried; `hcsearch deploy --scene` takes it."""
        if self.first:
            return scene.name
        plain = self.pairs if self.pairs != first_look(scene).pairs else ""
        return joined_name(scene.name, plain, self.springs)


def look_parts(parts: list[str]) -> tuple[Way | None, str]:
    """Way and spring set that parts of a scene's name say, in this order; takes them off the list."""
    springs = parts.pop() if parts and parts[-1] in _SETS else ""
    pairs = next((pairs for pairs in WAYS if parts and parts[-1] == pairs), None)
    if pairs is not None:
        parts.pop()
    return pairs, springs


def first_look(scene: Scene) -> Look:
    """The scene as it stands, with the first of its ways."""
    return Look(ways(scene)[0], first=True)


def looks_at(scene: Scene) -> tuple[Look, ...]:
    """All that are taken in a scene, in this order: as it stands, joined otherwise, with other springs.

    What deploys in one is not tried in those after it.
    """
    first, *others = ways(scene)
    last: Way = "hinged" if "hinged" in others else first
    graded = () if last == first else (Look(first, "mountains first"),)
    return (first_look(scene), *(Look(way) for way in others), *graded, *(Look(last, springs) for springs in _TAKEN))


def scene_of(scene: Scene, look: Look) -> Scene:
    """A settled scene as a look takes it, but for the springs of the look."""
    if look.first:
        return scene
    assert scene.seconds is not None
    return replace(scene, name=look.name(scene), seconds=PATIENT * scene.seconds)


def described(springs: str) -> str:
    """What a set of springs is, for readers who know no names of sets."""
    if springs in SPREAD:
        number = SPREAD.index(springs) + 1
        return f"set {number} of {len(SPREAD)}, spread over the scene's range"
    return f"the stiffest {GRADED:g} times the softest, {springs}"


def springs_of(folding: Folding, compiled: Compiled, name: str) -> Reals:
    """Stiffnesses (N m/rad) of the joints of a folding in a set, shape (n_joints,), within the scene's range.

    Graded ones are geometric from the stiffest to a fortieth of it, those of `SPREAD` between the bounds.
    """
    softest, stiffest = range_of(compiled.scene)
    if name in SPREAD:
        sets: Reals = spring_sets(compiled.system.n_joints, len(SPREAD), softest, stiffest)
        spread: Reals = sets[SPREAD.index(name)]
        return spread
    places = _places(folding, compiled)
    if name == OUTER:
        softness = 1.0 - np.abs(2.0 * places[:, 0] - 1.0)
    else:
        weights = np.array(GRADES[name])
        towards = np.where(weights < 0.0, 1.0 - places, places)
        softness = towards @ np.abs(weights) / np.abs(weights).sum()
    softer = max(softest, stiffest / GRADED)
    springs: Reals = stiffest * (softer / stiffest) ** softness
    return springs


def _places(folding: Folding, compiled: Compiled) -> Reals:
    """Layer (0 lowest to 1), face (1 for a valley) and stack (1 for the second) of the hinge of each joint.

    As the folding has them that stands for all congruent ones: which stack is the first depends on how a circuit is
    written.
    """
    linkage, joint_of, twin = compiled.linkage, compiled.joint_of, compiled.linkage.twin
    if twin is not None:
        like = folding.likeness(panel_of(compiled.scene, folding.circuit.grid.name))
        assert like is not None
        folding, linkage, joint_of = like.folding, twin.linkage, joint_of[np.argsort(twin.hinges)]
    pattern, half = linkage.pattern, folding.circuit.n // 2
    first = set(folding.stacks[0])
    places = np.zeros((compiled.system.n_joints, 3))
    for pair, crease in pattern.creases.items():
        if crease.face is None:
            continue
        layers = [folding.layers[panel] for panel in pair]
        layer = min(layers) / max(1, half - 2)
        joint = joint_of[pattern.hinge_of(pair)]
        places[joint] = min(layer, 1.0), crease.face == "top", pair[0] not in first
    return places
