"""The travel of a folding from packed to flat: the closed states at which its figures are computed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.hardware import Hardware, hardware_of
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled

TravelSource = Literal["deployment", "path", "none"]
"""What gives the states: a simulated deployment, a proved path, or nothing."""


@dataclass(frozen=True, eq=False)
class Travel(ByValue):
    """A folding with its flat pairs joined, in a scene, and the states of its motion.

    setup, hardware : of the scene, evaluated for the linkage. source : of the states. states : (k, n_hinges), fold
    angles from packed to flat, rad, with both ends; none without a motion. deployment : the simulated one, or None.
    """

    linkage: Linkage
    scene: Scene
    setup: Setup
    hardware: Hardware
    source: TravelSource
    states: Reals
    deployment: Deployment | None = None

    @property
    def shares(self) -> Reals:
        """The place of each state, (k,): the accumulated turn of all hinges over that of the whole travel."""
        turns = np.abs(np.diff(self.states, axis=0)).sum(axis=1)
        length = np.concatenate([[0.0], np.cumsum(turns)])
        return length / length[-1] if len(length) and length[-1] > 0.0 else length


def still_travel(folding: Folding, scene: Scene, way: Way) -> Travel:
    """Return a folding in a scene without a motion: only the figures of its ends are known."""
    linkage, joined, setup, hardware = _evaluated(folding, scene, way)
    return Travel(linkage, joined, setup, hardware, "none", np.empty((0, linkage.n_hinges)))


def travel_along_path(folding: Folding, scene: Scene, way: Way, states: Reals) -> Travel:
    """Return the travel of a folding along a proved path, (k, n_hinges), with flat pairs joined in a way."""
    linkage, joined, setup, hardware = _evaluated(folding, scene, way)
    return Travel(linkage, joined, setup, hardware, "path", np.asarray(states, float))


def travel_by_springs(folding: Folding, scene: Scene, way: Way, *, tolerance: float = 1e-6) -> Travel:
    """Simulate a deployment of a folding, and return its travel; scene : with its springs.

    A scene starts beside the packed state and counts as flat a little before the flat one: both ends are added.
    """
    linkage, joined, setup, hardware = _evaluated(folding, scene, way)
    deployment = simulate_compiled(compile_scene(linkage, setup), tolerance=tolerance, certified=False)
    states = np.vstack([linkage.folded, deployment.angles, linkage.flat])
    moved = np.abs(np.diff(states, axis=0)).max(axis=1, initial=0.0) > 0.0
    return Travel(linkage, joined, setup, hardware, "deployment", states[np.append(True, moved)], deployment)


def _evaluated(folding: Folding, scene: Scene, way: Way) -> tuple[Linkage, Scene, Setup, Hardware]:
    panel = panel_of(scene, folding.circuit.grid.name)
    linkage = folding.linkage(panel, flat_pairs=way)
    setup = setup_of_scene(scene, linkage)
    joined = replace(scene, panel=panel, flat_pairs=(way,))
    return linkage, joined, setup, hardware_of(scene, linkage, setup.held)
