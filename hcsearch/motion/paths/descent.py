"""Search for a motion from the stacks to flat by descent of the energy of springs that pull every hinge flat.

With many degrees of freedom there are many motions. Descent of 1/2 sum k rho^2 over the closed states within the stops
0 <= rho <= pi is the motion of slow springs; where it ends in a local minimum, other springs may not. Each step
minimises the energy within the tangent space, the stops and a bound on its length, closes the loops again within the
stops, and is accepted if closed states connect both ends. A reported motion may have panels that collide; where none
is reported there may still be one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.motion.kinematics.within_stops import close_within_stops, least_energy, states_are_linked
from hcsearch.motion.paths.motions import (
    STOP_TOLERANCE,
    MotionPath,
    PathEnding,
    joined_paths,
    motion_path_of,
    reversed_path,
)
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.labels import named_hinges
from hcsearch.shape.linkage import Linkage

DescentGoal = Literal["flat", "folded"]

FIRST_TRUST_RADIUS, MAX_TRUST_RADIUS, MIN_DESCENT_CHANGE = 0.2, 0.4, 1e-6
"""Greatest change of a hinge (rad) in the first step and in any step, and the change below which it counts as zero."""
DESCENT_GOAL_DISTANCE = 1e-5
"""The goal is reached where every hinge is this near to it (rad)."""
LOOSENING_STEP, LOOSENING_SINGULAR_VALUE, LOOSENING_INTERVAL = 0.01, 0.1, 0.02
"""Where steps are shorter than `LOOSENING_STEP` (rad), singular values below `LOOSENING_SINGULAR_VALUE` are taken for
zeros on trial, and not again until the path is longer by `LOOSENING_INTERVAL` (rad)."""
GOAL_CONE_RADIUS = 0.3
"""A stuck descent tries a straight step to its goal from within this distance (rad, every hinge)."""
MIN_PROMISED_SHARE = 1e-9
"""A state is a local minimum if the predicted decrease in its tangent space is below this share of its energy."""
MIN_DECREASE_SHARE = 0.1
"""A step must realise this share of the predicted decrease."""
REOPENED_ANGLE_SHARE, UNMOVED_START_DISTANCE = 0.999, 1e-3
"""Share of the folded state's angles from which a descent restarts if the one from the folded state itself ends within
`UNMOVED_START_DISTANCE` (rad) of it."""
SOFTEST_STIFFNESS_RATIO = 0.01
"""Stiffness of the softest spring in a set over the stiffness of the stiffest."""


@dataclass(frozen=True, eq=False)
class DescentSearch(ByValue):
    """Result of `find_descent`: a path from the stacks to flat, or the one that came nearest to flat.

    springs : stiffness of each hinge on that path (Nm/rad, or any unit).
    backwards : whether the descent began at the flat state, with springs that pull hinges into the stacks.
    attempts : names and outcomes of the attempts.
    """

    path: MotionPath
    springs: Reals
    backwards: bool
    attempts: tuple[tuple[str, str], ...]

    @property
    def success(self) -> bool:
        """Whether the path leads from the stacks to flat."""
        return self.path.outcome == "flat"


def find_descent(linkage: Linkage, *, random: int = 4, max_steps: int = 200) -> DescentSearch:
    """Descend with one spring set after another until one leads from folded to flat; then from flat to folded.

    The sets are: equal springs; springs that are stiffest at the outside of the folded package, so that it opens from
    outside in; the reverse; and `random` ones. Then the same with hinges held that are flat in the stacks, if any.
    """
    attempts: list[tuple[str, str]] = []
    best: tuple[MotionPath, Reals] | None = None
    for name, springs, held, goal in _attempts(linkage, random):
        path = descend_energy(linkage, springs=springs, held=held, goal=goal, max_steps=max_steps)
        full_path = _extended_to_start(linkage, path, goal) if path.outcome == goal else None
        attempts.append(
            (name, path.outcome if full_path is not None or path.outcome != goal else "from beside the end")
        )
        if full_path is not None:
            forward = full_path if goal == "flat" else reversed_path(full_path, "flat")
            return DescentSearch(forward, springs, goal == "folded", tuple(attempts))
        if goal == "flat" and (best is None or path.end.sum() < best[0].end.sum()):
            best = (path, springs)
        if path.outcome == "lost closure":
            break
    assert best is not None
    return DescentSearch(*best, False, tuple(attempts))


def _extended_to_start(linkage: Linkage, path: MotionPath, goal: DescentGoal) -> MotionPath | None:
    """Extend a path to its goal back to the other end, if it began beside that; None where no descent leads there."""
    opposite: DescentGoal = "folded" if goal == "flat" else "flat"
    if (path.angles[0] == getattr(linkage, opposite)).all():
        return path
    return_path = descend_energy(linkage, path.angles[0], goal=opposite)
    return joined_paths(reversed_path(return_path, goal), path) if return_path.outcome == opposite else None


def _attempts(linkage: Linkage, random: int) -> Iterator[tuple[str, Reals, Flags | None, DescentGoal]]:
    """The attempts of a search: names, springs, held hinges and goals."""
    flat_pairs = np.array([not hinge.closes for hinge in linkage.pattern.hinges])
    spring_sets = list(descent_springs(linkage, random))
    goals: tuple[DescentGoal, DescentGoal] = ("flat", "folded")
    for goal in goals:
        for held in (None, flat_pairs) if flat_pairs.any() else (None,):
            for name, springs in spring_sets:
                suffix = ", flat pairs held" if held is not None else ""
                yield f"{name}{suffix}{', backwards' if goal == 'folded' else ''}", springs, held, goal


def descent_springs(linkage: Linkage, random: int) -> Iterator[tuple[str, Reals]]:
    """Named sets of stiffnesses from `SOFTEST_STIFFNESS_RATIO` to 1, the same in every call."""
    yield "uniform", np.ones(linkage.n_hinges)
    poses, points = linkage.poses(linkage.folded), linkage.points
    panels = [hinge.first for hinge in linkage.pattern.hinges]
    heights = np.einsum("ki,ki->k", poses[panels, 2, :3], points) + poses[panels, 2, 3]
    middle = 0.5 * (heights.max() + heights.min())
    outward = np.abs(heights - middle) / max(float(np.ptp(heights)) / 2, 1e-300)
    yield "outside in", SOFTEST_STIFFNESS_RATIO ** (1.0 - outward)
    yield "inside out", SOFTEST_STIFFNESS_RATIO**outward
    for seed in range(random):
        yield f"random {seed}", SOFTEST_STIFFNESS_RATIO ** np.random.default_rng(seed).uniform(size=linkage.n_hinges)


def descend_energy(
    linkage: Linkage,
    start: Reals | None = None,
    *,
    springs: Reals | None = None,
    held: Flags | None = None,
    goal: DescentGoal = "flat",
    max_steps: int = 200,
) -> MotionPath:
    """Minimise the energy of springs by descent over the closed states within the stops.

    start : fold angles near a closed state; None for the folded state or, where closure and stops allow no descent from
        it, for the closed state nearest to 0.999 of its angles.
    springs : stiffness of each hinge (Nm/rad); None for equal ones.
    held : hinges that do not turn, shape (n_hinges,).
    goal : state in which the springs are at rest; towards `folded` the start is the flat state.
    The outcome is the goal, `stuck` (a local minimum), `lost closure` (no closed state near the start) or `out of
    budget`.
    """
    stiffness = np.ones(linkage.n_hinges) if springs is None else np.asarray(springs, float)
    held_hinges = np.zeros(linkage.n_hinges, bool) if held is None else held
    opposite = linkage.folded if goal == "flat" else linkage.flat
    first_angles = opposite if start is None else np.asarray(start, float)
    path = _Descent(linkage, stiffness, held_hinges, goal, max_steps, first_angles).run()
    if start is None and path.outcome == "stuck" and np.abs(path.end - opposite).max() < UNMOVED_START_DISTANCE:
        restart_angles = (REOPENED_ANGLE_SHARE if goal == "flat" else 1.0 - REOPENED_ANGLE_SHARE) * linkage.folded
        restarted = _Descent(linkage, stiffness, held_hinges, goal, max_steps, restart_angles).run()
        if restarted.outcome != "lost closure" and np.abs(restarted.end - opposite).max() > 10 * UNMOVED_START_DISTANCE:
            return restarted
    return path


class _Descent(SteppedSearch[MotionPath]):
    """The state of a running descent. ending : why it ends; None while it goes on."""

    def __init__(
        self, linkage: Linkage, springs: Reals, held: Flags, goal: DescentGoal, max_steps: int, start: Reals
    ) -> None:
        self.goal, self.target = goal, linkage.flat if goal == "flat" else linkage.folded
        self.linkage, self.springs, self.held, self.max_steps = linkage, springs, held, max_steps
        self.lengths = [0.0]
        self.trust_radius, self.rejected = FIRST_TRUST_RADIUS, 0
        self.loosened_length = -math.inf
        self.ending: PathEnding | None = None
        local, self.evaluations = close_within_stops(linkage, start, held=held)
        if local is None:
            local = local_at(linkage, np.clip(start, 0.0, math.pi))
            sentence = f"no closed state within the stops near the start, which is open by {local.residual:.1e}"
            self.ending = PathEnding("lost closure", sentence)
        self.states, self.energies = [local], [self._energy(local.angles)]

    @property
    def done(self) -> bool:
        return self.ending is not None

    def step(self, budget: Budget) -> None:
        self.ending = self._try()

    @property
    def result(self) -> MotionPath:
        assert self.ending is not None
        effort: dict[str, Any] = {"rejected": self.rejected, "evaluations": self.evaluations}
        return motion_path_of(self.states, self.lengths, self.ending, **effort, energies=self.energies)

    def _energy(self, angles: Reals) -> float:
        return 0.5 * float(self.springs @ (angles - self.target) ** 2)

    def _try(self) -> PathEnding | None:
        """Make a step, or reject one; return the reason for which the path ends, if it does."""
        last, energy = self.states[-1], self.energies[-1]
        if np.abs(last.angles - self.target).max() < DESCENT_GOAL_DISTANCE:
            if (last.angles != self.target).any():
                self._add(local_at(self.linkage, self.target), 0.0)
            return PathEnding(self.goal, f"{self.goal} after {len(self.states) - 1} steps")
        if len(self.states) > self.max_steps:
            return PathEnding("out of budget", f"{self.max_steps} steps were not enough: raise max_steps")
        change, promised = self._best_change(last, last.null_space(), self.trust_radius)
        size = float(np.abs(change).max())
        is_minimum = size < MIN_DESCENT_CHANGE or promised < MIN_PROMISED_SHARE * energy
        if not is_minimum and self._try_step(last, change, promised, self.trust_radius):
            return None
        may_loosen = self.lengths[-1] >= self.loosened_length + LOOSENING_INTERVAL
        if (is_minimum or (size < LOOSENING_STEP and may_loosen)) and self._try_loosened(last):
            return None
        if is_minimum:
            return self._local_minimum(last, energy)
        self.rejected += 1
        self.trust_radius = 0.4 * size
        return None

    def _best_change(self, last: LocalState, basis: Reals, trust: float) -> tuple[Reals, float]:
        """The change of least energy in the space of a basis, and the predicted decrease of energy."""
        low, high = np.maximum(-last.angles, -trust), np.minimum(math.pi - last.angles, trust)
        low[self.held] = high[self.held] = 0.0
        change = least_energy(basis, self.springs, last.angles - self.target, low, high)
        return change, self.energies[-1] - self._energy(last.angles + change)

    def _try_step(self, last: LocalState, change: Reals, promised: float, trust: float) -> bool:
        """Make a step if the closed state after it decreases the energy enough; return whether it was made."""
        local, count = close_within_stops(self.linkage, last.angles + change, held=self.held)
        self.evaluations += count
        new_energy = math.inf if local is None else self._energy(local.angles)
        gain = self.energies[-1] - new_energy
        if local is None or gain < MIN_DECREASE_SHARE * promised:
            return False
        linked, evaluations = states_are_linked(self.linkage, last.angles, local.angles, held=self.held)
        self.evaluations += evaluations
        if not linked:  # a jump, perhaps to states that no motion leads to
            return False
        self.trust_radius = min(2.0 * trust, MAX_TRUST_RADIUS) if gain > 0.7 * promised else trust
        self._add(local, new_energy)
        return True

    def _try_loosened(self, last: LocalState) -> bool:
        """Try steps with the last one or two singular values taken for zeros; return whether one was made.

        Near singular states tangents turn within a step of the size of the least singular value: longer steps may go
        where the tangent space forbids it.
        """
        self.loosened_length = self.lengths[-1]
        for dropped in (1, 2):
            if last.kept_rank <= dropped or last.values[-dropped] > LOOSENING_SINGULAR_VALUE:
                break
            basis = np.hstack([last.null_space(), last.right[-dropped:].T])
            for trust in (0.3, 0.1, 0.03, 0.01):
                change, promised = self._best_change(last, basis, trust)
                if promised > MIN_PROMISED_SHARE * self.energies[-1] and self._try_step(last, change, promised, trust):
                    return True
        # near the goal the closed states are nearly a cone: step towards its tip
        offset = last.angles - self.target
        change = np.where(self.held, 0.0, -0.5 * offset)
        near = bool(np.abs(offset).max() < GOAL_CONE_RADIUS)
        return near and self._try_step(last, change, 0.75 * self.energies[-1], FIRST_TRUST_RADIUS)

    def _add(self, local: LocalState, energy: float) -> None:
        self.lengths.append(self.lengths[-1] + float(np.linalg.norm(local.angles - self.states[-1].angles)))
        self.states.append(local)
        self.energies.append(energy)

    def _local_minimum(self, last: LocalState, energy: float) -> PathEnding:
        flat = np.flatnonzero(last.angles <= STOP_TOLERANCE)
        closed = np.flatnonzero(last.angles >= math.pi - STOP_TOLERANCE)
        energy_share = energy / (0.5 * float(self.springs @ self.linkage.folded**2))
        sentence = (
            f"a local minimum with {energy_share:.1%} of the energy of the other end; hinges at pi: "
            f"{named_hinges(self.linkage, closed)}; at 0: {named_hinges(self.linkage, flat)}"
        )
        return PathEnding("stuck", sentence, tuple(map(int, np.union1d(flat, closed))))
