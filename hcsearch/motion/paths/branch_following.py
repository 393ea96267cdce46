"""A motion from a closed state along one of the branches that begin there, until an end, a stop or a singular state."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Until
from hcsearch.motion.kinematics.local import local_at
from hcsearch.motion.kinematics.numerical_rank import NEAR_ZERO_SHARE
from hcsearch.motion.paths.branches import Branches, find_branches
from hcsearch.motion.paths.following import PathGoal, PathLimits, Stepping, follow_path
from hcsearch.motion.paths.motions import MotionPath, PathEnding, PathOutcome, motion_path_of
from hcsearch.motion.paths.start_states import near_singular_threshold
from hcsearch.shape.linkage import Linkage

_GOALS: dict[Until, PathGoal] = {"flat": "flat", "folded": "folded", "stop": "none"}
REACHED_OUTCOMES: dict[Until, frozenset[PathOutcome]] = {
    "end": frozenset({"flat", "folded", "stopped", "length"}),
    "flat": frozenset({"flat"}),
    "folded": frozenset({"folded"}),
    "stop": frozenset({"stopped", "length"}),
    "event": frozenset({"branch", "singular"}),
    "bifurcation": frozenset({"branch"}),
}
"""Outcomes with which a motion has come to where it was followed until."""


@dataclass(frozen=True, eq=False)
class FollowedBranch(ByValue):
    """The branches at a start, and the motion along one of them.

    number : of the branch, from 1 on, negative for its opposite sense; None where no finite motion begins at the start.
    """

    branches: Branches
    number: int | None
    path: MotionPath


def follow_branch(
    linkage: Linkage,
    start: Reals,
    *,
    branch: int | None = None,
    until: Until = "end",
    stops: bool = True,
    length: float = math.inf,
    max_step: float | None = None,
    found: Callable[[Branches], None] | None = None,
) -> FollowedBranch:
    """Follow a motion from a closed state, singular or not, along one of its branches.

    branch : from 1 on, in the order of `find_branches`; where hinges turn beyond their stops, -k is branch k in the
        opposite sense. None for the finite one that leads most directly to flat, or to folded if this is where the
        motion is to end, or if it begins flat.
    stops, length : as of `PathLimits`. max_step : as of `Stepping`. found : called with the branches once these are
        known.
    Errors: HcsearchError for a branch that there is not, and for a goal at which the motion begins.
    """
    ends = {"flat": linkage.flat, "folded": linkage.folded}
    begins = [name for name, end in ends.items() if not np.abs(start - end).any()]
    if until in begins:
        raise HcsearchError(f"the motion begins {until}: follow it until another state, such as --until end")
    # ends are exact, so that small singular values there are no zeros
    zero_below = None if begins else near_singular_threshold(linkage, start)
    branches = find_branches(linkage, start, stops=stops, zero_below=zero_below)
    if found is not None:
        found(branches)
    number = _most_direct(linkage, start, branches, until) if branch is None else _checked(branches, branch)
    if number is None:
        outcome: PathOutcome = "undecided" if branches.nullity < 0 else "rigid"
        within = " within the stops" if any(one.status == "finite" for one in branches.branches) else ""
        ending = PathEnding(outcome, f"no finite motion{within} was found at the start: {branches.sentence}")
        path = motion_path_of([local_at(linkage, start)], [0.0], ending, rejected=0, evaluations=1)
        return FollowedBranch(branches, None, path)
    limits = PathLimits(
        goal=_GOALS.get(until, "end"),
        stops=stops,
        at_bifurcation="stop" if until == "bifurcation" else "pass",
        at_event="stop" if until == "event" else "pass",
        length=length,
    )
    direction = np.sign(number) * branches.branches[abs(number) - 1].direction
    stepping = Stepping(max_step=max_step)
    path = follow_path(linkage, start, direction, stepping=stepping, limits=limits, zero_share=NEAR_ZERO_SHARE)
    return FollowedBranch(branches, number, path)


def _most_direct(linkage: Linkage, start: Reals, branches: Branches, until: Until) -> int | None:
    """The number of the finite branch at the least angle to the straight way to the goal; the first of equal ones."""
    to_folded = until == "folded" or not np.abs(start - linkage.flat).any()
    goal = (linkage.folded if to_folded else linkage.flat) - start
    numbers = [k for k, one in enumerate(branches.branches, 1) if one.status == "finite"]
    if branches.keeps_stops:
        numbers = [k for k in numbers if branches.branches[k - 1].within_stops]
    else:
        numbers = [sign * k for k in numbers for sign in (1, -1)]
    # rounded, as branches that differ by a symmetry lead there equally
    directness = {k: round(float(np.sign(k) * branches.branches[abs(k) - 1].direction @ goal), 6) for k in numbers}
    return max(numbers, key=directness.__getitem__, default=None)


def _checked(branches: Branches, number: int) -> int:
    """Return the number of a branch; HcsearchError where there is no such branch."""
    count = len(branches.branches)
    if not count:
        raise HcsearchError(f"no branch begins at the start ({branches.sentence}): leave out --branch")
    if number < 0 and branches.keeps_stops:
        raise HcsearchError(f"branch {number} is in the opposite sense, which stops exclude: give --no-stops, too")
    if not 1 <= abs(number) <= count:
        known = f"1 to {count}" if count > 1 else "1 alone"
        raise HcsearchError(f"there is no branch {number} at the start: the branches are {known}")
    return number
