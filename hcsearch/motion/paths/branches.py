"""Branches at a state: which first-order motions are finite, by second-order equations and nudges; and where one leads.

At a singular state more velocities keep the loops closed to first order than belong to motions (thesis 5.2.4 and
appendix: four at the ends of unit II). A velocity v of the null space of the Jacobian J extends to second order when
some acceleration w has J w = -bend(v), that is when bend(v) does no work on any self-stress y (y' J = 0). These are
quadratic equations in the null space. States nudged along each solution by ever shorter steps are closed: along a
motion the closed state deviates from the straight line by the square of the step or less (after Calladine and
Pellegrino).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Until, counted
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.motion.kinematics.numerical_rank import NEAR_ZERO_SHARE
from hcsearch.motion.paths.following import PathGoal, PathLimits, Stepping, follow_path
from hcsearch.motion.paths.motions import (
    STOP_TOLERANCE,
    MotionPath,
    PathEnding,
    PathOutcome,
    motion_path_of,
    stop_margins,
)
from hcsearch.motion.paths.quadrics import (
    FAMILY_MEMBER_DISTANCE,
    LOCATED_STATE_RESIDUAL,
    SAME_SOLUTION_DISTANCE,
    SOLVED_RESIDUAL,
    second_order_forms,
    solution_near,
    solve_quadrics,
)
from hcsearch.motion.paths.start_states import near_singular_threshold
from hcsearch.shape.linkage import Linkage

BranchStatus = Literal["finite", "infinitesimal", "undecided"]

NUDGE_STEPS = (0.04, 0.02, 0.01, 0.005)
"""Steps (rad) of the nudges."""
MIN_FINITE_POWER, MAX_INFINITESIMAL_POWER = 1.7, 1.3
"""Orders, in the step, of the distance from the line: at least the first for motions, at most the second for
infinitesimal ones."""
MIN_TANGENT_SHARE = 0.99
"""Share of a direction of closed states that lies in the null space, at least."""
LIMIT_CLOSURE_RESIDUAL, MAX_LIMIT_STEPS = 1e-15, 100
"""Closed states that give a direction are closed as well as rounding admits, since the error of a state is of the order
of the square root of its residual."""
EVEN_OPENING_SUM = 1e-6
"""Hinges open as much as they close where the entries of a unit velocity sum to less than this."""
STRAIGHT_LINE_CURVATURE = 0.02
"""A motion that leaves the line by less than this times the square of the step counts as straight."""
BLURRED_DISTANCE = 10.0 * CLOSED_LOOP_RESIDUAL**0.5
"""Distances below this (rad) are not significant: where closure is of second order, the error of a state is of the
order of the square root of its residual."""


@dataclass(frozen=True, eq=False)
class Branch(ByValue):
    """A velocity that keeps the loops closed to second order, and whether it belongs to a finite motion.

    direction : unit velocity of the fold angles, shape (n_hinges,).
    dimension : of the family of such directions around it; 0 when it is isolated.
    residual : of the second-order equations.
    power : order, in the step, of the distance of the nudged and closed states from the line.
    within_stops : whether the nudged states lie within the stops 0 and pi.
    """

    direction: Reals
    dimension: int
    residual: float
    status: BranchStatus
    power: float
    within_stops: bool


@dataclass(frozen=True)
class Branches:
    """The motions that begin at a state.

    nullity : number of first-order motions, -1 where the rank is not decided; then there are no branches.
    stresses : number of independent self-stresses, which is the number of second-order equations.
    keeps_stops : whether only velocities within the stops were searched, each in its own sense; else v and -v count as
    one.
    branches : the isolated ones first, in an order that does not depend on where the search began.
    cover_radius : every velocity that solves the second-order equations is within this distance of a start of the
        search; at 0.05 (`quadrics.MIN_CELL_RADIUS`) no isolated one is missed, at much more some may be.
    """

    nullity: int
    stresses: int
    keeps_stops: bool
    branches: tuple[Branch, ...]
    sentence: str
    cover_radius: float = 0.0

    @property
    def finite(self) -> tuple[Branch, ...]:
        """The branches that are finite motions."""
        return tuple(branch for branch in self.branches if branch.status == "finite")


def find_branches(linkage: Linkage, angles: Reals, *, stops: bool = False, zero_below: float | None = None) -> Branches:
    """Find the motions that begin at a closed state, singular or not.

    zero_below : singular values below it count as zero, where the state is near a singular one, such as an event of a
        path; else the rank must be decided.
    stops : whether hinges stop at 0 and pi; then only velocities that leave the stops are searched.
    """
    angles = np.asarray(angles, float)
    local = local_at(linkage, angles)
    if zero_below is not None:
        local = local_at(linkage, angles, kept_rank=int(np.count_nonzero(local.rank.singular_values > zero_below)))
    elif local.rank.rank is None:
        sentence = f"the rank is not decided: a gap of {local.rank.gap:.1e} in the singular values"
        return Branches(-1, 0, stops, (), sentence)
    basis = local.null_space()
    forms = second_order_forms(local, basis)
    cone = None
    if stops:
        inward = (angles <= STOP_TOLERANCE).astype(float) - (angles >= math.pi - STOP_TOLERANCE)
        cone = (inward[:, None] * basis)[inward != 0.0]
    tolerance = SOLVED_RESIDUAL if zero_below is None else LOCATED_STATE_RESIDUAL
    solutions, cover_radius = solve_quadrics(forms, cone, both=not stops, solved=tolerance)
    nudged = []
    for solution in solutions:
        direction = basis @ solution.vector
        direction /= np.linalg.norm(direction)
        if not stops:
            direction = _opening(direction)
        nudged.append(_branch(local, direction, solution.dimension, solution.residual))
    if not any(branch.status == "finite" and (branch.within_stops or not stops) for branch in nudged):
        nudged += _closed_members(local, basis, forms, cone, nudged, tolerance)
    nudged.sort(key=lambda branch: (branch.dimension, *np.round(branch.direction, 6).tolist()))
    sentence = _sentence(basis.shape[1], len(forms), nudged, stops)
    return Branches(basis.shape[1], len(forms), stops, tuple(nudged), sentence, cover_radius)


def _branch(local: LocalState, direction: Reals, dimension: int, residual: float) -> Branch:
    """The branch of a direction, with the verdict of the nudges along it."""
    power, within = _nudged(local, direction)
    status: BranchStatus = "infinitesimal" if power <= MAX_INFINITESIMAL_POWER else "undecided"
    if power >= MIN_FINITE_POWER:
        status = "finite"
    return Branch(direction, dimension, residual, status, power, within)


def _closed_members(
    local: LocalState, basis: Reals, forms: Reals, cone: Reals | None, nudged: list[Branch], tolerance: float
) -> list[Branch]:
    """The finite branches to which nudges along members of families lead, if no listed member is finite.

    Equations of higher order hold for some members of such a family only, and the listed ones need not be among them,
    for example in eight hexagons if two panels stay parallel. Closed states beside the others lie on these motions; the
    directions in which they tend to the state, known up to the square of a step, lead to solutions.
    """
    members: list[Branch] = []
    for branch in nudged:
        direction = _limit_direction(local, branch.direction) if branch.dimension else None
        if direction is None:
            continue
        vector = basis.T @ direction
        size = float(np.linalg.norm(vector))
        vector, residual = solution_near(forms, cone, vector)
        direction = basis @ vector
        near = any(
            np.linalg.norm(direction - other.direction) < distance
            for listed, distance in ((members, FAMILY_MEMBER_DISTANCE), (nudged, SAME_SOLUTION_DISTANCE))
            for other in listed
        )
        if size < MIN_TANGENT_SHARE or near or residual >= tolerance:
            continue
        member = _branch(local, direction, branch.dimension, residual)
        if member.status == "finite":
            members.append(member)
    return members


def _limit_direction(local: LocalState, direction: Reals) -> Reals | None:
    """The direction in which closed states beside a nudge tend to the state, up to the square of the step.

    None if there are none, or if they stay near the state itself.
    """
    offset = NUDGE_STEPS[0] * direction
    offsets = []
    for _ in range(2):
        result = close_linkage(
            local.linkage, local.angles + offset, tolerance=LIMIT_CLOSURE_RESIDUAL, max_steps=MAX_LIMIT_STEPS
        )
        offset = result.angles - local.angles
        if result.residual > CLOSED_LOOP_RESIDUAL or np.linalg.norm(offset) < 0.1 * NUDGE_STEPS[0]:
            return None
        offsets.append(offset)
        offset = 0.5 * offset
    limit: Reals = 4.0 * offsets[1] - offsets[0]
    size = float(np.linalg.norm(limit))
    return limit / size if size > 0.0 else None


def _opening(direction: Reals) -> Reals:
    """Orient a direction so that hinges open in sum; if they open as much as they close, so that an early one opens."""
    total = float(direction.sum())
    lead = total if abs(total) > EVEN_OPENING_SUM else direction[np.abs(direction) > 0.6 * np.abs(direction).max()][0]
    return direction * (-1.0 if lead > 0 else 1.0)


def _nudged(local: LocalState, direction: Reals) -> tuple[float, bool]:
    """Order, in the step, of the distance of nudged and closed states from the line; whether they are within stops."""
    distances, within = [], True
    for step in NUDGE_STEPS:
        line = local.angles + step * direction
        result = close_linkage(local.linkage, line, max_steps=100)
        distance = float(np.linalg.norm(result.angles - line))
        if not result.closed or distance > 0.5 * step:
            return 0.0, False
        distances.append(distance)
        # a state that leaves a stop along the line may be beyond it by the square of the step: no motion within stops
        within = within and bool(stop_margins(result.angles).min() >= -1e-3 * step * step - STOP_TOLERANCE)
    steps, deviations = np.array(NUDGE_STEPS), np.array(distances)
    significant = deviations > np.maximum(STRAIGHT_LINE_CURVATURE * steps**2, BLURRED_DISTANCE)
    if np.count_nonzero(significant) < 2:
        return math.inf, within
    return float(np.polyfit(np.log(steps[significant]), np.log(deviations[significant]), 1)[0]), within


def _sentence(nullity: int, stresses: int, nudged: list[Branch], stops: bool) -> str:
    if not nullity:
        return "rigid: nothing moves to first order"
    isolated = sum(branch.dimension == 0 for branch in nudged)
    families = sorted({branch.dimension for branch in nudged} - {0})
    counts = [f"{isolated} isolated"] if isolated else []
    counts += [f"a family of dimension {dimension}" for dimension in families]
    finite = sum(branch.status == "finite" for branch in nudged)
    within_stops = " within the stops" if stops else ""
    solved = f"directions that solve them{within_stops}: {', '.join(counts) or 'none'}"
    equations = f"{counted(nullity, 'first-order motion')}, {counted(stresses, 'second-order equation')}"
    return f"{equations}; {solved}; {finite} of {len(nudged)} nudged are finite"


_GOALS: dict[Until, PathGoal] = {"flat": "flat", "folded": "folded", "stop": "none"}
REACHED_OUTCOMES: dict[Until, frozenset[PathOutcome]] = {
    "end": frozenset({"flat", "folded", "stopped", "length"}),
    "flat": frozenset({"flat"}),
    "folded": frozenset({"folded"}),
    "stop": frozenset({"stopped", "length"}),
    "event": frozenset({"branch", "singular"}),
    "bifurcation": frozenset({"branch"}),
}
"""The outcomes by which a motion has reached its goal, for each goal."""


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
    stops, length : as in `PathLimits`. max_step : as in `Stepping`. found : called with the branches once these are
        known.
    Errors: HcsearchError for a branch that does not exist, and for a goal at which the motion begins.
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
