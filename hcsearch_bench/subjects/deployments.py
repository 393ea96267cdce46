"""What the bench `dynamics` deploys, each until a time before anything hits a stop, and in every formulation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Formulation, Way
from hcsearch.designs.folding import Folding
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import SCENES, Scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, CompiledScene, compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.dynamics.system import System

SCENE = replace(SCENES["default"], name="bench", spring="linear:0.1", damping=0.0043)
"""Uniform springs and dampers, no gravity: those of the measured 14-panel loop that the goals come from."""
SHARE = 0.9
"""Of the time of the first event: the motion that is compared ends before it."""
TIGHT = 1e-8
"""Tolerance at which the first event is looked for."""
WHOLE = "constrained, whole"
"""Nothing left out: the system that other engines get too. `constrained` is what the compiler makes of a scene."""


@dataclass(frozen=True)
class DeploymentSubject:
    """Something to deploy.

    until : s, no later than which the comparison ends; by the first event unless it is sooner.
    """

    name: str
    what: str
    build: Callable[[], Linkage]
    until: float = math.inf

    @cached_property
    def linkage(self) -> Linkage:
        """Its panels and hinges."""
        return self.build()

    def compiled(self, formulation: str, scene: Scene = SCENE) -> CompiledScene:
        """A scene in a formulation, or `constrained` with nothing left out."""
        if formulation == WHOLE:
            return compile_scene(self.linkage, scene, keep=frozenset(OMISSIONS) - {"stops"})
        names: dict[str, Formulation] = {name: name for name in ("constrained", "penalty", "quasistatic")}
        return compile_scene(self.linkage, scene, names[formulation])

    def horizon(self, formulation: str) -> float:
        """Until when motions are compared, s: before the first event of a tight run, and before `until`."""
        motion = simulate_compiled(self.compiled(formulation), tolerance=TIGHT, certified=False).motion
        first = motion.events[0].time if motion.events else motion.times[-1]
        return min(SHARE * float(first), self.until)

    def case(self, formulation: str, end: float) -> Case:
        """What is followed in a formulation, until a time (s)."""
        return Case(self.name, formulation, self.compiled(formulation), end)


@dataclass(frozen=True)
class Case:
    """A subject in a formulation, until a time (s)."""

    subject: str
    formulation: str
    compiled: CompiledScene
    end: float

    @cached_property
    def system(self) -> System:
        """The system; without hard stops, which nothing touches until the end and other engines do not have."""
        system = self.compiled.system
        if self.formulation == "penalty":
            return system
        return replace(system, drives=tuple(replace(d, lower=-math.inf, upper=math.inf) for d in system.drives))

    @property
    def q(self) -> Reals:
        """Coordinates at the start."""
        return self.compiled.start

    @property
    def v(self) -> Reals:
        """Velocities at the start: none."""
        return np.zeros(self.system.n_joints)

    def angles(self, q: Reals) -> Reals:
        """Fold angles of all hinges, (k, n_hinges), of coordinates (k, n_joints)."""
        return self.compiled.of_hinges(q, np.zeros_like(q))[0]


LOOP = "loop of 14"


def subjects() -> list[DeploymentSubject]:
    """All of them.

    Which loop of 14 panels the goals were first measured on is not recorded. Ours has the properties that are: 16
    cells, two pairs on the mirror axis merged, one untwisted loop, symmetric, flat in the end. Among the foldings of 16
    squares on which nothing happens for 12 ms it is the only such one; its first hit is at 0.12 s.
    Unit I comes by a nearly singular state at 0.078 s, where steps become short and errors grow: the comparison ends
    before.
    """
    array = "square:012222222223333300000000012222222210000000012222222210000000:13"
    return [
        DeploymentSubject("thesis-4x4", "4x4 squares, 12 panels", lambda: assembly("thesis-4x4")),
        DeploymentSubject(LOOP, "16 squares, two pairs merged", lambda: design("square:0121222323030001:5", "merged")),
        DeploymentSubject("12 hexagons", "flat pairs rigid: 10 panels", lambda: design("hex:023224350400:4")),
        DeploymentSubject("10x6 squares", "60 cells, flat pairs rigid: 58 panels", lambda: design(array)),
        DeploymentSubject("unit-i", "21 panels, 4 loops", lambda: assembly("unit-i"), until=0.07),
    ]


def assembly(name: str) -> Linkage:
    """An assembly by its name, as the thesis has it."""
    entry = ASSEMBLIES[name]
    return Linkage(entry.build(entry.defaults))


def design(text: str, flat_pairs: Way = "rigid") -> Linkage:
    """The linkage of a folding by its notation, such as `hex:023224350400:4`."""
    return Folding.from_notation(text).linkage(flat_pairs=flat_pairs)
