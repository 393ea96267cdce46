"""Springs that can be bought: each hinge gets none, one, or two in parallel, of those in a catalogue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement

import numpy as np

from hcsearch.errors import HcsearchError
from hcsearch.typing import Reals

Levels = tuple[int, ...]


def catalogue_levels(springs: Sequence[float], upper: float) -> tuple[float, ...]:
    """Stiffnesses (N m/rad) that a hinge can get, rising: 0, each spring, and two in parallel, up to a bound."""
    if not springs or not all(0.0 < spring <= upper for spring in springs):
        raise HcsearchError(f"a catalogue has springs above 0 and up to {upper:g} N m/rad: write --catalogue 0.07,0.10")
    pairs = (one + two for one, two in combinations_with_replacement(springs, 2))
    stiffnesses = {0.0, *springs, *(round(pair, 12) for pair in pairs)}
    return tuple(sorted(level for level in stiffnesses if level <= upper * (1.0 + 1e-9)))


def nearest_levels(stiffnesses: Sequence[float] | Reals, levels: Sequence[float]) -> Levels:
    """The level nearest to each stiffness."""
    return tuple(int(np.abs(np.array(levels) - value).argmin()) for value in stiffnesses)


def neighbours(chosen: Levels, levels: int) -> list[Levels]:
    """All sets that differ in one place, by one level."""
    return [
        (*chosen[:k], level + step, *chosen[k + 1 :])
        for k, level in enumerate(chosen)
        for step in (-1, 1)
        if 0 <= level + step < levels
    ]


def descend(
    starts: Sequence[Levels], levels: int, costs: Callable[[list[Levels]], Sequence[float]], *, budget: int
) -> dict[Levels, float]:
    """Search the sets around some: from the best one seen whose neighbours have not been asked for, to these.

    Ends when all neighbours of the best sets are known or when the budget of sets is spent; returns all that it saw.
    costs : of sets, together.
    """
    first = list(dict.fromkeys(starts))
    seen = dict(zip(first, map(float, costs(first)), strict=True))
    opened: set[Levels] = set()
    while len(seen) < budget:
        waiting = [chosen for chosen in seen if chosen not in opened]
        if not waiting:
            break
        best = min(waiting, key=lambda chosen: (seen[chosen], chosen))
        opened.add(best)
        fresh = [chosen for chosen in neighbours(best, levels) if chosen not in seen]
        if fresh:
            seen.update(zip(fresh, map(float, costs(fresh)), strict=True))
    return seen
