"""Springs that can be bought: each hinge gets none, one, or two in parallel, of those in a catalogue."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import HcsearchError

CatalogueLevels = tuple[int, ...]

STIFFNESS_TOLERANCE = 1e-9
"""Share by which two equal stiffnesses may differ: sums of decimals are rounded."""


def catalogue_levels(springs: Sequence[float], upper: float, softest: float = 0.0) -> tuple[float, ...]:
    """Stiffnesses (N m/rad) that a hinge can get, rising: 0, each spring, and two in parallel, up to a bound.

    softest : of the springs that are tuned, for the remedy where the catalogue has a stiffer one than the bound.
    """
    if not springs or not all(0.0 < spring < math.inf for spring in springs):
        raise HcsearchError("a catalogue has springs above 0 N m/rad: write --catalogue 0.07,0.10")
    stiffest = max(springs)
    if stiffest > upper * (1.0 + STIFFNESS_TOLERANCE):
        low = softest or stiffest / 200.0
        raise HcsearchError(
            f"the catalogue has a spring of {stiffest:g} N m/rad, and springs are tried up to {upper:g} N m/rad: add "
            f"--spring-range {low:g},{stiffest:g}, or leave that spring out"
        )
    return tuple(level for level in sorted(_made_of(springs)) if level <= upper * (1.0 + STIFFNESS_TOLERANCE))


def springs_for(stiffness: float, catalogue: Sequence[float]) -> tuple[float, ...]:
    """The springs of a catalogue that make a level of `catalogue_levels` in parallel: the fewest."""
    return next(
        made for level, made in _made_of(catalogue).items() if abs(level - stiffness) <= STIFFNESS_TOLERANCE * stiffness
    )


def _made_of(catalogue: Sequence[float]) -> dict[float, tuple[float, ...]]:
    """Springs by the stiffness that they make: none, one, or two; the fewest of each."""
    each = sorted(set(catalogue))
    made: dict[float, tuple[float, ...]] = {0.0: ()}
    for springs in [*((one,) for one in each), *combinations_with_replacement(each, 2)]:
        level = springs[0] if len(springs) == 1 else round(sum(springs), 12)
        made.setdefault(level, springs)
    return made


def nearest_levels(stiffnesses: Sequence[float] | Reals, levels: Sequence[float]) -> CatalogueLevels:
    """The level nearest to each stiffness."""
    return tuple(int(np.abs(np.array(levels) - value).argmin()) for value in stiffnesses)


def neighbouring_levels(chosen: CatalogueLevels, levels: int) -> list[CatalogueLevels]:
    """All sets that differ in one place, by one level."""
    return [
        (*chosen[:k], level + step, *chosen[k + 1 :])
        for k, level in enumerate(chosen)
        for step in (-1, 1)
        if 0 <= level + step < levels
    ]


def descend_levels(
    starts: Sequence[CatalogueLevels],
    levels: int,
    costs: Callable[[list[CatalogueLevels]], Sequence[float]],
    *,
    budget: int,
) -> dict[CatalogueLevels, float]:
    """Search the sets around some: from the best one seen whose neighbours have not been asked for, to these.

    Ends when all neighbours of the best sets are known or when the budget of sets, 1 or more, is spent; returns all of
    them that it saw.
    costs : of sets, together.
    """
    first = list(dict.fromkeys(starts))[:budget]
    seen = dict(zip(first, map(float, costs(first)), strict=True))
    opened: set[CatalogueLevels] = set()
    while len(seen) < budget:
        waiting = [chosen for chosen in seen if chosen not in opened]
        if not waiting:
            break
        best = min(waiting, key=lambda chosen: (seen[chosen], chosen))
        opened.add(best)
        fresh = [chosen for chosen in neighbouring_levels(best, levels) if chosen not in seen][: budget - len(seen)]
        if fresh:
            seen.update(zip(fresh, map(float, costs(fresh)), strict=True))
    return seen
