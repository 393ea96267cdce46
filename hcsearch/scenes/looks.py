"""The looks that the stage `deployment` takes at a folding: ways to join its flat pairs, and spring sets, by name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.scenes.scene import Scene, joined_name

if TYPE_CHECKING:
    from hcsearch.scenes.setup import Setup

SPRING_SET_GRADES: dict[str, tuple[float, float, float]] = {
    "bottom first": (1.0, 0.0, 0.0),
    "top first": (-1.0, 0.0, 0.0),
    "mountains first": (0.0, -1.0, 0.0),
    "one stack first": (0.0, 0.0, 1.0),
    "other stack first": (0.0, 0.0, -1.0),
    "top of one stack first": (-1.0, 0.0, 1.0),
}
"""Graded spring sets: how softness grows with the layer, with valleys after mountains, and with the second stack."""
OUTER_FIRST_SET = "outer layers first"
"""The set graded by the distance from the middle layer."""
SPREAD_SPRING_SETS = tuple(f"spread {number}" for number in range(1, 9))
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
    OUTER_FIRST_SET,
    "spread 1",
)
"""Sets that looks take, those first that bring the most of what is left flat. Of 161 foldings (hexagons of 10 and 12
panels, squares of 12 and 14, triangles of 18) that some set brings flat, the looks before bring 111, these the rest."""
GRADED_STIFFNESS_RATIO = 40.0
"""Stiffest over softest spring of a graded set; the stiffest is that of the scene's range."""
VARIANT_TIME_FACTOR = 3.0
"""How long a second look lasts, over the scene's seconds: of 158 motions of 12 hexagons, clear and not at rest after
1 s, 11 come flat."""
_SETS = (*SPRING_SET_GRADES, OUTER_FIRST_SET, *SPREAD_SPRING_SETS)


@dataclass(frozen=True)
class SceneVariant:
    """How flat pairs are joined, and which springs there are; `first` is the scene as it stands."""

    pairs: Way
    springs: str = ""
    first: bool = False

    @property
    def is_known(self) -> bool:
        """Whether this program knows the set of springs, as another version of it may not."""
        return not self.springs or self.springs in _SETS

    def name(self, scene: Scene) -> str:
        """The name of a scene as it is tried; `hcsearch deploy --scene` takes it."""
        if self.first:
            return scene.name
        plain = self.pairs if self.pairs != first_variant(scene).pairs else ""
        return joined_name(scene.name, plain, self.springs)


def variant_parts(parts: list[str]) -> tuple[Way | None, str]:
    """Way and spring set that parts of a scene's name say, in this order; takes them off the list."""
    springs = parts.pop() if parts and parts[-1] in _SETS else ""
    pairs = next((pairs for pairs in WAYS if parts and parts[-1] == pairs), None)
    if pairs is not None:
        parts.pop()
    return pairs, springs


def first_variant(scene: Scene) -> SceneVariant:
    """The scene as it stands, with the first of its ways."""
    return SceneVariant(scene.flat_pairs[0], first=True)


def scene_variants(scene: Scene) -> tuple[SceneVariant, ...]:
    """All that are taken in a scene, in this order: as it stands, joined otherwise, with other springs.

    What deploys in one is not tried in those after it.
    """
    first, *others = scene.flat_pairs
    last: Way = "hinged" if "hinged" in others else first
    graded = () if last == first else (SceneVariant(first, "mountains first"),)
    return (
        first_variant(scene),
        *(SceneVariant(way) for way in others),
        *graded,
        *(SceneVariant(last, springs) for springs in _TAKEN),
    )


def setup_of_variant(setup: Setup, scene: Scene, look: SceneVariant) -> Setup:
    """Return the setup of a scene as a look takes it, but for the springs of the look."""
    return setup if look.first else replace(setup, name=look.name(scene), seconds=VARIANT_TIME_FACTOR * setup.seconds)


def describe_spring_set(springs: str) -> str:
    """What a set of springs is, for readers who know no names of sets."""
    if springs in SPREAD_SPRING_SETS:
        number = SPREAD_SPRING_SETS.index(springs) + 1
        return f"set {number} of {len(SPREAD_SPRING_SETS)}, spread over the scene's range"
    return f"the stiffest {GRADED_STIFFNESS_RATIO:g} times the softest, {springs}"
