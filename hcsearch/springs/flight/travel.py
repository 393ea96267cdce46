"""The travel of a linkage from packed to flat: the closed states at which its figures are computed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.motion.planning.path_proofs import Prover
from hcsearch.scenes import Scene
from hcsearch.scenes.hardware import Hardware, hardware_of
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.play import course_of_deployment
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.springs.flight.path_margins import PathRates, path_rates

MIN_STATE_DISTANCE = 1e-6
"""Greatest change of a fold angle (rad) between states of a deployment that count as one."""
TravelSource = Literal["deployment", "path", "none"]
"""What gives the states: a simulated deployment, a proved path, or nothing."""


@dataclass(frozen=True, eq=False)
class Travel(ByValue):
    """The panels and hinges of a folding in a scene, and the states of its motion.

    setup, hardware : of the scene, evaluated for the linkage. source : of the states. states : (k, n_hinges), fold
    angles from packed to flat, rad, with both ends; none without a motion. deployment : the simulated one, or None.
    """

    linkage: Linkage
    setup: Setup
    hardware: Hardware
    source: TravelSource
    states: Reals
    deployment: Deployment | None = None

    @cached_property
    def course(self) -> tuple[Course, float | Reals]:
        """The motion at all times, and the greatest displacement of panels from it (m), at all times or in each step.

        HcsearchError without a motion, and where a path is proved no more.
        """
        if self.deployment is not None:
            return course_of_deployment(self.deployment.compiled, self.deployment.motion)
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

    def with_values(self, setup: Setup | None = None, hardware: Hardware | None = None) -> Travel:
        """Return the travel with other springs, density or hardware; what depends on the states alone is kept.

        setup : with the same margin.
        """
        changed = replace(self, setup=setup or self.setup, hardware=hardware or self.hardware)
        vars(changed).update({name: kept for name, kept in vars(self).items() if name in ("course", "rates")})
        return changed

    @property
    def shares(self) -> Reals:
        """The place of each state, (k,): the accumulated turn of all hinges over that of the whole travel."""
        turns = accumulated_turn(self.states)
        return turns / turns[-1] if turns[-1:].any() else turns


def travel_along(linkage: Linkage, scene: Scene, states: Reals | None = None) -> Travel:
    """Return the travel of a linkage in a scene along a proved path, or without a motion.

    states : of the path, (k, n_hinges).
    """
    setup = setup_of_scene(scene, linkage)
    hardware = hardware_of(scene, linkage, setup.held)
    if states is None:
        return Travel(linkage, setup, hardware, "none", np.empty((0, linkage.n_hinges)))
    return Travel(linkage, setup, hardware, "path", np.asarray(states, float))


def travel_by_springs(linkage: Linkage, scene: Scene) -> Travel:
    """Simulate a deployment of a linkage in a scene, and return its travel.

    A deployment starts beside the packed state and counts as flat a little before the flat one: both ends are added.
    """
    compiled = compile_scene(linkage, setup_of_scene(scene, linkage))
    return travel_of_deployment(simulate_compiled(compiled, certified=False), scene)


def travel_of_deployment(deployment: Deployment, scene: Scene) -> Travel:
    """Return the travel of a simulated deployment in a scene."""
    linkage, setup = deployment.compiled.linkage, deployment.compiled.setup
    hardware = hardware_of(scene, linkage, setup.held)
    states = np.vstack([linkage.folded, deployment.angles, linkage.flat])
    moved = np.abs(np.diff(states, axis=0)).max(axis=1, initial=0.0) > MIN_STATE_DISTANCE
    return Travel(linkage, setup, hardware, "deployment", states[np.append(True, moved)], deployment)
