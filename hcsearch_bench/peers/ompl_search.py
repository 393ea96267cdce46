"""Paths by OMPL: RRT-Connect on the closed states of a linkage, which are asked for its projections and its gaps."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.planning.closed_states import close_state, largest_closure_residual, new_closing
from hcsearch.kernels.planning.space import pick_state, place_state
from hcsearch.kernels.planning.tree_search import MAX_SEARCH_PIECE, StateTree, fan_out, new_tree
from hcsearch.motion.planning.planner import MAX_ROOT_TRIES, ROOT_START_COUNT, TREE_STATE_CAPACITY, Planner
from hcsearch_bench.run.machine import MISSING
from hcsearch_bench.run.work_precision import UnableError

TOLERANCE, STEPS = 1e-6, 50
"""Closure residual of its states, and steps of a projection; proofs close states to rounding."""


def search(planner: Planner, seed: int, limit: float) -> tuple[Reals | None, float]:
    """Search for a path with a planner's rules for so many processor seconds; UnableError where there is no OMPL.

    States of the path, (k, n_hinges), from packed to flat, or None, and the seconds. Closure is singular at both ends,
    which projections do not leave: the path begins and ends in states that our own planner throws out from there.
    """
    try:
        from ompl import base, geometric, util
    except ImportError as error:
        raise UnableError(MISSING) from error
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)  # 0 is no seed
    rules = _Rules(planner)
    rules.valid(rules.project(planner.space.folded.copy()))  # compiled before the clock runs
    begin = time.process_time()
    trees = _fanned(planner, seed)
    if any(tree.size[0] == 1 for tree in trees):
        return None, time.process_time() - begin
    problem = _problem(base, rules, [_outer(tree) for tree in trees])
    engine = geometric.RRTConnect(problem.getSpaceInformation())
    engine.setProblemDefinition(problem)
    engine.setup()
    engine.solve(base.PlannerTerminationCondition(lambda: time.process_time() - begin > limit))
    seconds = time.process_time() - begin
    if not problem.hasExactSolution():
        return None, seconds
    path = problem.getSolutionPath()
    path.interpolate()
    states = np.array([_angles(state, rules.size) for state in path.getStates()])
    inner, outer = (_branch(tree, state) for tree, state in zip(trees, (states[0], states[-1]), strict=True))
    return np.concatenate([inner[::-1], states, outer]), seconds


class _Rules:
    """Which fold angles are closed and clear, by the kernels of our own planner."""

    def __init__(self, planner: Planner) -> None:
        self.space = planner.space
        self.size = planner.linkage.n_hinges
        self.work = new_closing(planner.space.loops)
        self.state = pick_state(planner.stack, 0)

    def project(self, angles: Reals) -> Reals | None:
        """The nearest closed angles within the stops, or None."""
        closed: Reals = np.array(angles)
        return closed if close_state(self.space.loops, closed, TOLERANCE, 0.0, STEPS, self.work) else None

    def closed(self, angles: Reals) -> bool:
        """Whether angles are closed."""
        return bool(largest_closure_residual(self.space.loops, np.array(angles), self.work) < TOLERANCE)

    def valid(self, angles: Reals | None) -> bool:
        """Whether angles are within the stops, and panels apart."""
        if angles is None or angles.min() < 0.0 or angles.max() > math.pi:
            return False
        return bool(place_state(self.space, angles, self.space.min_gap, self.state))


def _problem(base: Any, rules: _Rules, ends: list[list[Reals]]) -> Any:
    """The problem as OMPL takes it: from any of the first states to any of the others."""
    angles = base.RealVectorStateSpace(rules.size)
    stops = base.RealVectorBounds(rules.size)
    stops.setLow(0.0)
    stops.setHigh(math.pi)
    angles.setBounds(stops)
    space = base.ProjectedStateSpace(angles, _closure(base, rules))
    space.setDelta(MAX_SEARCH_PIECE)
    information = base.ConstrainedSpaceInformation(space)
    information.setStateValidityChecker(_checker(base, rules, information))
    information.setup()
    problem, goal = base.ProblemDefinition(information), base.GoalStates(information)
    for side, put in zip(ends, (problem.addStartState, goal.addState), strict=True):
        for end in side:
            state = information.allocState()
            state.copy(end.tolist())
            put(state)
    problem.setGoal(goal)
    return problem


def _closure(base: Any, rules: _Rules) -> Any:
    """The loops as a constraint, with our projection: its own would ask Python at every step of Newton."""

    class Closure(base.Constraint):  # type: ignore[misc]
        def project(self, x: Reals) -> bool:
            closed = rules.project(x)
            if closed is not None:
                x[:] = closed
            return closed is not None

        def isSatisfied(self, x: Reals) -> bool:  # noqa: N802 - OMPL's name
            return rules.closed(x)

    return Closure(rules.size, len(rules.work.residual), TOLERANCE)


def _checker(base: Any, rules: _Rules, information: Any) -> Any:
    """Stops and gaps as a check of states."""

    class Checker(base.StateValidityChecker):  # type: ignore[misc]
        def isValid(self, state: Any) -> bool:  # noqa: N802 - OMPL's name
            return rules.valid(_angles(state, rules.size))

    return Checker(information)


def _angles(state: Any, size: int) -> Reals:
    """Fold angles of a state, which its bindings give one by one."""
    return np.array([state[h] for h in range(size)])


def _fanned(planner: Planner, seed: int) -> tuple[StateTree, StateTree]:
    """Trees of states near the packed and near the flat state, as our own planner begins with."""
    roots = planner.space.folded, np.zeros(planner.linkage.n_hinges)
    trees = new_tree(TREE_STATE_CAPACITY, roots[0]), new_tree(TREE_STATE_CAPACITY, roots[1])
    for side, tree in enumerate(trees):
        fan_out(planner.space, tree, ROOT_START_COUNT, MAX_ROOT_TRIES, 2 * seed + side, planner.stack, planner.work)
    return trees


def _outer(tree: StateTree) -> list[Reals]:
    """The states of a tree that no other hangs on."""
    size = int(tree.size[0])
    inner = set(tree.parents[:size].tolist())
    return [tree.angles[node] for node in range(size) if node not in inner]


def _branch(tree: StateTree, state: Reals) -> Reals:
    """The states of a tree from the one before a state to the root."""
    node = int(np.abs(tree.angles[: int(tree.size[0])] - state).max(axis=1).argmin())
    states = []
    while (node := int(tree.parents[node])) >= 0:
        states.append(tree.angles[node])
    return np.array(states)
