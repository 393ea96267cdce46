"""Sets of springs and dampers as tables: stiffnesses of all hinges, and their dampings where dampers are chosen, too.

A table has the shape (n_hinges,), or (2 n_hinges,) with dampings after stiffnesses. A damping that is not a number
stands for a hinge without a damper of its own, which keeps the damping of the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.setup import Setup, natural_seconds, with_dampings, with_stiffnesses
from hcsearch.shape.linkage import Linkage

DAMPING_DIGITS = 12
"""Significant digits of dampings that are multiplied."""
PartBounds = tuple[float, float] | tuple[Reals, Reals]
"""The least and the greatest value, of all groups or of each, or their logarithms."""


def with_parts(setup: Setup, parts: Sequence[float] | Reals) -> Setup:
    """Return a setup with the springs (N m/rad) and dampers (N m s/rad) of a table."""
    table, n = np.asarray(parts, float), len(setup.laws)
    damped = with_dampings(setup, table[n:]) if len(table) > n else setup
    return with_stiffnesses(damped, table[:n])


def tied_parts(tied: Sequence[tuple[int, ...]]) -> tuple[tuple[int, ...], ...]:
    """Return the tied groups of springs, and those of dampers after them, by their places in a table."""
    n = sum(map(len, tied))
    return (*tied, *(tuple(n + hinge for hinge in hinges) for hinges in tied))


def part_bounds(
    spring_range: tuple[float, float], n_groups: int, damper_range: tuple[float, float] | None
) -> PartBounds:
    """Return the bounds of all springs, or where there is a range of dampers, those of each group of both."""
    if damper_range is None:
        return spring_range
    low, high = (np.repeat([spring_range[k], damper_range[k]], n_groups) for k in (0, 1))
    return low, high


def damped_more(setup: Setup, factor: float, linkage: Linkage) -> Setup:
    """Return a setup with dampers at all hinges that multiply their damping by a factor."""
    dampings = [float(f"{factor * damping:.{DAMPING_DIGITS}g}") for damping in setup.dampings]
    return in_time(with_dampings(setup, dampings), setup, linkage)


def in_time(changed: Setup, setup: Setup, linkage: Linkage) -> Setup:
    """Return a changed setup with the time that it needs, unless another than the natural one was given.

    setup : the setup before the change.
    """
    is_natural = setup.seconds == natural_seconds(setup, linkage)
    return replace(changed, seconds=natural_seconds(changed, linkage)) if is_natural else changed
