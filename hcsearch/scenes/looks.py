"""Variants of a scene that the stage `deployment` tries on a folding: flat-pair joints, and named spring sets."""

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
"""Graded spring sets: weights by which the softness grows with the layer, from mountains to valleys, and from the first
stack to the second."""
OUTER_FIRST_SET = "outer layers first"
"""The set graded by the distance from the middle layer."""
SPREAD_SPRING_SETS = tuple(f"spread {number}" for number in range(1, 9))
"""Sets spread evenly over the logarithms of the scene's spring range."""
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
"""Spring sets that variants try, in greedy order: each brings flat the most of the foldings that remain. Of 161
foldings (hexagons of 10 and 12 panels, squares of 12 and 14, triangles of 18) that some set brings flat, the variants
without these sets bring 111 flat, these sets the rest."""
GRADED_STIFFNESS_RATIO = 40.0
"""Ratio of the stiffest to the softest spring of a graded set; the stiffest is at the end of the scene's range."""
VARIANT_TIME_FACTOR = 3.0
"""Simulated time of a variant over the scene's seconds: of 158 motions of 12 hexagons that are clear and not at
rest after 1 s, 11 become flat with it."""
_SETS = (*SPRING_SET_GRADES, OUTER_FIRST_SET, *SPREAD_SPRING_SETS)


@dataclass(frozen=True)
class SceneVariant:
    """A joint of the flat pairs and a spring set (empty: the scene's own); `as_written` is the scene unchanged."""

    pairs: Way
    springs: str = ""
    as_written: bool = False

    @property
    def is_known(self) -> bool:
        """Whether this version of the program knows the spring set."""
        return not self.springs or self.springs in _SETS

    def name(self, scene: Scene) -> str:
        """Return the name of the scene in this variant, as `hcsearch deploy --scene` takes it."""
        if self.as_written:
            return scene.name
        joint = self.pairs if self.pairs != first_variant(scene).pairs else ""
        return joined_name(scene.name, joint, self.springs)


def variant_parts(parts: list[str]) -> tuple[Way | None, str]:
    """Remove the trailing flat-pair joint and spring set from the parts of a scene's name, and return them."""
    springs = parts.pop() if parts and parts[-1] in _SETS else ""
    pairs = next((pairs for pairs in WAYS if parts and parts[-1] == pairs), None)
    if pairs is not None:
        parts.pop()
    return pairs, springs


def first_variant(scene: Scene) -> SceneVariant:
    """Return the variant of a scene as written, with the first of its flat-pair joints."""
    return SceneVariant(scene.flat_pairs[0], as_written=True)


def scene_variants(scene: Scene) -> tuple[SceneVariant, ...]:
    """Return all variants of a scene in order of trial: as written, with other flat-pair joints, with other springs.

    A folding that deploys in one variant is not tried in later ones.
    """
    first, *alternatives = scene.flat_pairs
    flat_pairs: Way = "hinged" if "hinged" in alternatives else first
    graded = () if flat_pairs == first else (SceneVariant(first, "mountains first"),)
    return (
        first_variant(scene),
        *(SceneVariant(pairs) for pairs in alternatives),
        *graded,
        *(SceneVariant(flat_pairs, springs) for springs in _TAKEN),
    )


def setup_of_variant(setup: Setup, scene: Scene, variant: SceneVariant) -> Setup:
    """Return the setup of a variant of a scene, except for the variant's springs."""
    return (
        setup
        if variant.as_written
        else replace(setup, name=variant.name(scene), seconds=VARIANT_TIME_FACTOR * setup.seconds)
    )


def describe_spring_set(springs: str) -> str:
    """Describe a spring set for readers who do not know the names of sets."""
    if springs in SPREAD_SPRING_SETS:
        number = SPREAD_SPRING_SETS.index(springs) + 1
        return f"set {number} of {len(SPREAD_SPRING_SETS)}, spread over the scene's range"
    return f"the stiffest {GRADED_STIFFNESS_RATIO:g} times the softest, {springs}"
