"""The travel of a linkage from packed to flat: the closed states at which its figures are computed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.linkage.courses import COURSE_TERM_COUNT, course_polynomials
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.play import course_of_deployment
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.springs.flight.path_margins import PathRates, path_rates

MIN_STATE_DISTANCE = 1e-6
"""Greatest change of a fold angle (rad) between states of a travel that count as one."""
TravelSource = Literal["deployment", "path", "none"]
"""What gives the states: a simulated deployment, a proved path, or nothing."""


@dataclass(frozen=True, eq=False)
class Travel(ByValue):
    """The panels and hinges of a folding in a scene, and the states of its motion.

    setup : the scene, evaluated for the linkage. source : of the states. states : (k, n_hinges), fold angles, rad, from
    packed to flat, with both ends; none without a motion. deployment : the simulated one, or None.
    """

    linkage: Linkage
    setup: Setup
    source: TravelSource
    states: Reals
    deployment: Deployment | None = None

    @cached_property
    def course(self) -> tuple[Course, float | Reals]:
        """The motion at all times, and the greatest displacement of panels from it (m), at all times or in each step.

        HcsearchError without a motion, and where a path is proved no more.
        """
        if self.deployment is not None:
            compiled = self.deployment.compiled
            course, deviation = course_of_deployment(compiled, self.deployment.motion)
            if self.linkage is not compiled.linkage:
                hinges = _order_of(compiled.linkage)
                angles, rates, accelerations = (np.ascontiguousarray(values[:, hinges]) for values in course[1:4])
                course = Course(course.times, angles, rates, accelerations, course.cubic)
            return course, deviation
        prover = Prover(self.linkage)
        tubes, *_ = prover.tubes(self.states, [self.setup.margin]) if len(self.states) else ((),)
        if not tubes:
            raise HcsearchError("the path is not proved with this margin: plan it anew with hcsearch enumerate")
        motion, _, slack = prover.motion_in(tubes)
        return motion, slack

    @cached_property
    def rates(self) -> PathRates:
        """The rates that loops and stops allow at the states."""
        return path_rates(self.linkage, self.states)

    @property
    def standard_hinges(self) -> WholeNumbers:
        """The hinge of this linkage for each one of the standard travel, (n_hinges,)."""
        return _order_of(self.linkage)

    @cached_property
    def standard(self) -> Travel:
        """The travel of the linkage that is simulated in place of all congruent ones, without a craft."""
        if self.linkage.twin is None:
            return self
        states = np.ascontiguousarray(self.states[:, self.standard_hinges])
        setup = self.setup.of_congruent(self.linkage)
        return Travel(self.linkage.twin.linkage, setup, self.source, states, self.deployment)

    def with_states(self, times: Reals) -> Travel:
        """Return the travel along a proved path with the closed states at more times of its course.

        Those that count as one with a state of the travel, or with the added one before, are left out.
        """
        course, _ = self.course
        turns, more = accumulated_turn(course.angles), states_at(course, times)
        closed = np.array([close_linkage(self.linkage, state).angles for state in more])
        places = np.interp(times, course.times, turns / turns[-1])
        order = np.argsort(np.r_[self.shares, places], kind="stable")
        states, is_added = np.vstack([self.states, closed])[order], order >= len(self.states)
        near = np.abs(np.diff(states, axis=0)).max(axis=1) <= MIN_STATE_DISTANCE
        repeats = is_added & (np.append(False, near) | np.append(near & ~is_added[1:], False))
        changed = replace(self, states=states[~repeats])
        vars(changed)["course"] = self.course
        return changed

    def with_values(self, setup: Setup) -> Travel:
        """Return the travel with other springs, density or hardware; results that depend on the states alone are kept.

        setup : with the same margin.
        """
        changed = replace(self, setup=setup)
        vars(changed).update({name: kept for name, kept in vars(self).items() if name in ("course", "rates")})
        if self.linkage.twin is not None and "standard" in vars(self):
            vars(changed)["standard"] = self.standard.with_values(setup.of_congruent(self.linkage))
        return changed

    @property
    def shares(self) -> Reals:
        """The place of each state, (k,): the accumulated turn of all hinges over the turn in the whole travel."""
        turns = accumulated_turn(self.states)
        return turns / turns[-1] if turns[-1:].any() else turns


def _order_of(linkage: Linkage) -> WholeNumbers:
    """Return the hinge of a linkage for each one of its twin, or of its own."""
    return np.arange(linkage.n_hinges) if linkage.twin is None else np.argsort(linkage.twin.hinges)


def states_at(course: Course, times: Reals) -> Reals:
    """Return the fold angles of a course at some times, (k, n_hinges)."""
    steps = np.clip(np.searchsorted(course.times, times, side="right") - 1, 0, len(course.times) - 2)
    shares = (times - course.times[steps]) / np.diff(course.times)[steps]
    powers = shares[:, None] ** np.arange(COURSE_TERM_COUNT)
    states: Reals = np.einsum("khp,kp->kh", course_polynomials(*course)[steps], powers)
    return states


def travel_along(linkage: Linkage, scene: Scene, states: Reals | None = None) -> Travel:
    """Return the travel of a linkage in a scene along a proved path, or without a motion.

    states : of the path, (k, n_hinges).
    """
    setup = _checked(setup_of_scene(scene, linkage))
    if states is None:
        return Travel(linkage, setup, "none", np.empty((0, linkage.n_hinges)))
    return Travel(linkage, setup, "path", np.asarray(states, float))


def travel_by_springs(linkage: Linkage, scene: Scene) -> Travel:
    """Simulate a deployment of a linkage in a scene, and return its travel.

    A deployment starts beside the packed state and counts as flat a little before the flat one: both ends are added.
    """
    compiled = compile_scene(linkage, setup_of_scene(scene, linkage))
    return travel_of_deployment(simulate_compiled(compiled, certified=False))


def travel_of_deployment(deployment: Deployment) -> Travel:
    """Return the travel of a simulated deployment."""
    linkage, setup = deployment.compiled.linkage, _checked(deployment.compiled.setup)
    states = np.vstack([linkage.folded, deployment.angles, linkage.flat])
    moved = np.abs(np.diff(states, axis=0)).max(axis=1, initial=0.0) > MIN_STATE_DISTANCE
    return Travel(linkage, setup, "deployment", states[np.append(True, moved)], deployment)


def _checked(setup: Setup) -> Setup:
    """Return a setup; HcsearchError where springs do not act all the time, as figures of a travel have no time."""
    if setup.law_times:
        raise HcsearchError("figures for flight are of springs that always act: leave out the times of their laws")
    return setup
