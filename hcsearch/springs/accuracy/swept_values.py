"""Values of a scene that are swept: their units, their own values, and scenes with other ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.collision.panel_prisms import margin_of
from hcsearch.scenes.laws import scaled_law
from hcsearch.scenes.setup import Setup, natural_seconds, with_dampings, with_resistance
from hcsearch.shape.linkage import Linkage

SPREAD_SEED = 0
"""Seed of the order in which springs become stiffer and softer where their spread is swept."""
SAME_NUMBER = 1e-9
"""Two numbers are the same where they differ by less than this share."""


@dataclass(frozen=True)
class ScenePoint:
    """A linkage in a scene with other values."""

    linkage: Linkage
    setup: Setup


@dataclass(frozen=True)
class SweptValue:
    """A value of a scene that can be swept.

    unit, meaning : for users. own : its value in a scene. change : a scene with another value.
    """

    unit: str
    meaning: str
    own: Callable[[ScenePoint], float]
    change: Callable[[ScenePoint, float], ScenePoint]

    def changed(self, point: ScenePoint, value: float) -> ScenePoint:
        """Return a scene with another value; the margin, and the simulated time, follow if they are those by default.

        HcsearchError for a value that no scene can have.
        """
        changed = self.change(point, value)
        before, after = point.setup, changed.setup
        if _same(before.margin, margin_of(point.linkage)):
            after = replace(after, margin=margin_of(changed.linkage))
        if _same(before.seconds, natural_seconds(before, point.linkage)):
            after = replace(after, seconds=natural_seconds(after, changed.linkage))
        return replace(changed, setup=after)


def _same(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=SAME_NUMBER)


def _own_damping(point: ScenePoint) -> float:
    return float(np.mean(point.setup.dampings))


def _damped(point: ScenePoint, value: float) -> ScenePoint:
    """Multiply all dampers so that their mean is a value; equal ones where there are none."""
    own = _own_damping(point)
    dampings = [value * damping / own if own > 0.0 else value for damping in point.setup.dampings]
    return replace(point, setup=with_dampings(point.setup, dampings))


def _stiffened(point: ScenePoint, factor: float) -> ScenePoint:
    laws = tuple(law if law.text == "free" else scaled_law(law, factor) for law in point.setup.laws)
    return replace(point, setup=replace(point.setup, laws=laws))


def _spread(point: ScenePoint, ratio: float) -> ScenePoint:
    """Multiply springs by factors from the root of the ratio to its inverse, evenly on a logarithmic scale."""
    if ratio < 1.0:
        raise HcsearchError(f"springs cannot have a spread of {ratio:g}: the stiffest is at least the softest, so 1")
    laws = point.setup.laws
    shares = np.random.default_rng(SPREAD_SEED).permutation(np.linspace(-0.5, 0.5, max(2, len(laws))))
    return replace(
        point,
        setup=replace(
            point.setup,
            laws=tuple(
                law if law.text == "free" else scaled_law(law, float(ratio**share))
                for law, share in zip(laws, shares, strict=False)
            ),
        ),
    )


def _thick(point: ScenePoint, millimetres: float) -> ScenePoint:
    return replace(point, linkage=resized_linkage(point.linkage, thickness=1e-3 * millimetres))


def _sized(point: ScenePoint, factor: float) -> ScenePoint:
    thickness = factor * point.linkage.pattern.thickness
    return replace(point, linkage=resized_linkage(point.linkage, factor, thickness))


def resized_linkage(linkage: Linkage, factor: float = 1.0, thickness: float | None = None) -> Linkage:
    """Return a linkage with its drawing larger by a factor, and panels of another thickness (m)."""
    pattern = linkage.pattern
    vertices = tuple((factor * x, factor * y) for x, y in pattern.vertices)
    resized = replace(pattern, vertices=vertices, thickness=pattern.thickness if thickness is None else thickness)
    twin = linkage.twin
    if twin is not None:
        twin = replace(twin, linkage=resized_linkage(twin.linkage, factor, thickness))
    return replace(linkage, pattern=resized, made_by="", twin=twin)


SWEPT_VALUES = {
    "damping": SweptValue("N m s/rad", "the mean damping of the hinges, all in proportion", _own_damping, _damped),
    "stiffness": SweptValue("", "a factor of all springs", lambda _point: 1.0, _stiffened),
    "thickness": SweptValue(
        "mm", "the thickness of all panels", lambda point: 1e3 * point.linkage.pattern.thickness, _thick
    ),
    "density": SweptValue(
        "kg/m^3",
        "the density of panels",
        lambda point: point.setup.density,
        lambda point, value: replace(point, setup=replace(point.setup, density=value)),
    ),
    "friction": SweptValue(
        "N m",
        "the friction of every hinge",
        lambda point: max(point.setup.resistance, default=0.0),
        lambda point, value: replace(point, setup=with_resistance(point.setup, value)),
    ),
    "spread": SweptValue("", "the ratio of the stiffest spring to the softest", lambda _point: 1.0, _spread),
    "size": SweptValue("", "a factor of all lengths of panels", lambda _point: 1.0, _sized),
}
"""Values that are swept, by name."""


def sweep_points(low: float, high: float, own: float, *, per_decade: float, most: int) -> list[float]:
    """Return values from one to another, evenly on a logarithmic scale, with the scene's own among them.

    per_decade : number of values in a decade, at least three in all. most : greatest number, without the own one, which
    is among them only where it is positive.
    """
    if not 0.0 < low < high < math.inf:
        raise HcsearchError(f"a sweep goes from a positive value to a greater one, not from {low:g} to {high:g}")
    count = min(most, max(3, round(per_decade * math.log10(high / low)) + 1))
    values = [float(f"{value:.3g}") for value in np.geomspace(low, high, count)]
    if own > 0.0 and not any(_same(own, value) for value in values):
        values.append(own)
    return sorted(values)
