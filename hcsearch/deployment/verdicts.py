"""Stage `deployment`: which foldings come flat without a collision, in the scene `default` or with a few spring sets.

The first look is at the scene `default`. Foldings that do not deploy in it get a second, cheap look: their flat pairs
hinged, their mirror pairs merged, spring sets graded over the layers, the faces or the stacks, so that panels open one
after the other, and sets spread over all that springs may be (docs/tables.md tells how many each finds). A full
search is `hcsearch tune`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcsearch.collision.clearance import MARGIN
from hcsearch.deployment.checking import Check, Solids, check, solids_of
from hcsearch.deployment.compiling import Compiled, compile_scene
from hcsearch.deployment.springs import spring_sets, with_springs
from hcsearch.deployment.subjects import folding_linkage
from hcsearch.folding import Folding, folding_at
from hcsearch.linkage import Linkage
from hcsearch.records import CircuitBatch, DeploymentBatch, FoldingBatch, MobilityBatch, Trial
from hcsearch.scenes import SCENES, Scene, default_panel

Reals = NDArray[np.float64]
Pairs = Literal["rigid", "hinged", "merged"]

STIFF, SOFT = 0.2, 0.005
"""Stiffnesses that graded sets run between, N m/rad."""

GRADES: dict[str, tuple[float, float, float]] = {
    "bottom first": (1.0, 0.0, 0.0),
    "top first": (-1.0, 0.0, 0.0),
    "mountains first": (0.0, -1.0, 0.0),
    "one stack first": (0.0, 0.0, 1.0),
    "other stack first": (0.0, 0.0, -1.0),
    "top of one stack first": (-1.0, 0.0, 1.0),
}
"""Graded spring sets: how softness grows with the layer, with valleys after mountains, and with the second stack."""
OUTER = "outer layers first"
"""The set graded by the distance from the middle layer."""
SPREAD = tuple(f"spread {number}" for number in range(1, 9))
"""Sets spread evenly over the logarithms of what springs may be. Of 12 hexagons they find 4 after 37."""


@dataclass(frozen=True)
class Look:
    """A scene that a folding is tried in: how its flat pairs are joined, and which springs it has."""

    pairs: Pairs = "rigid"
    springs: str = ""

    @property
    def scene(self) -> str:
        """Its name, `default` for the first look."""
        parts = [self.pairs if self.pairs != "rigid" else "", self.springs]
        return ", ".join(part for part in parts if part) or "default"


FIRST = Look()
ROUNDS: tuple[tuple[Look, ...], ...] = (
    (FIRST,),
    (Look("hinged"), Look("merged")),
    tuple(Look("rigid", springs) for springs in GRADES),
    tuple(Look("hinged", springs) for springs in (*GRADES, OUTER, *SPREAD)),
)
"""The first look and the second, in this order; those of a round are simulated together, on all threads.
What deploys in one does not count as tried in those after it."""
PATIENT = 3.0
"""How long the second look lasts, s: of 158 motions of 12 hexagons, clear and not at rest after 1 s, 11 come flat."""
SCREENED, BRIEF, LARGE = 1e-5, 4000, 12
"""Tolerance of the second look, steps that it may take, and panels above which more, as the square of their number.
Of 12 hexagons few motions that deploy take a fifth of these steps; a few that do not would take most of the time. Of 22
triangles some that deploy take 10,000. What deploys in it is simulated again as in the first look."""
TOGETHER = 256
"""Foldings whose scenes are held in memory together."""
Tried = tuple[int, Look]


def verdicts(
    circuits: CircuitBatch, foldings: FoldingBatch, twists: NDArray[np.int16], found: MobilityBatch, threads: int = 1
) -> DeploymentBatch:
    """Verdicts on a batch of foldings. Locked ones are tried with hinged or merged pairs: the proof is of rigid ones.

    Deploys: flat and certified clear. Collides: with every set tried. Undecided: it did neither with some set.
    """
    return _Verdicts(circuits, foldings, twists == 0, found.locked, threads).run()


class _Verdicts:
    """The verdicts on a batch while they are found; foldings are numbers in the batch."""

    def __init__(
        self,
        circuits: CircuitBatch,
        foldings: FoldingBatch,
        untwisted: NDArray[np.bool_],
        locked: NDArray[np.bool_],
        threads: int,
    ) -> None:
        self.panel = default_panel(circuits.grid)
        steps = round(BRIEF * max(1.0, circuits.words.shape[1] / LARGE) ** 2)
        self.second: dict[str, Any] = {"whole": False, "tolerance": SCREENED, "max_steps": steps}
        self.foldings = {i: folding_at(circuits, foldings, i) for i in np.flatnonzero(untwisted).tolist()}
        self.count, self.threads = len(foldings), threads
        self.locked = {i for i in self.foldings if locked[i]}
        self.compiled: dict[tuple[int, Pairs], tuple[Compiled, Solids]] = {}
        self.tried: dict[int, list[Check]] = {i: [] for i in self.foldings}
        self.deploys: dict[int, Trial] = {}
        self.first: dict[int, Trial] = {}

    def run(self) -> DeploymentBatch:
        numbers = list(self.foldings)
        for begin in range(0, len(numbers), TOGETHER):
            for looks in ROUNDS:
                self._round(looks, numbers[begin : begin + TOGETHER])
            self.compiled.clear()
        status: list[str | None] = [None] * self.count
        clearance, time = np.full(self.count, np.nan), np.full(self.count, np.nan)
        for i in self.foldings:
            status[i] = self._status(i)
            if (trial := self.deploys.get(i)) is not None:
                clearance[i] = trial.clearance
                time[i] = trial.deploy_time
        trials = [trial for i in self.foldings for trial in self._trials(i)]
        return DeploymentBatch(status, clearance, time, tuple(trials))

    def _round(self, looks: tuple[Look, ...], some: list[int]) -> None:
        """Try those of some foldings that are left in some scenes."""
        left = [i for i in some if i not in self.deploys]
        scenes = {(i, look): self._compiled(i, look) for look in looks for i in left if self._can(i, look)}
        if FIRST in looks:
            found = self._check(scenes, {})
        else:
            found = self._check(scenes, self.second)
            found |= self._check({tried: scenes[tried] for tried in scenes if found[tried].deploys}, {})
        for (i, look), one in found.items():
            if i not in self.deploys:
                self._keep(i, look, scenes[i, look][0], one)

    def _check(self, scenes: dict[Tried, tuple[Compiled, Solids]], options: dict[str, Any]) -> dict[Tried, Check]:
        compiled, solids = [scene for scene, _ in scenes.values()], [own for _, own in scenes.values()]
        return dict(zip(scenes, check(compiled, solids=solids, threads=self.threads, **options), strict=True))

    def _keep(self, i: int, look: Look, compiled: Compiled, found: Check) -> None:
        self.tried[i].append(found)
        trial = self._trial(i, look, compiled, found)
        if look == FIRST:
            self.first[i] = trial
        if found.deploys:
            self.deploys[i] = trial

    def _can(self, i: int, look: Look) -> bool:
        if look.pairs == "merged":
            return bool(self.foldings[i].mirror_pairs)
        return look.pairs == "hinged" or i not in self.locked

    def _compiled(self, i: int, look: Look) -> tuple[Compiled, Solids]:
        key = (i, look.pairs)
        if key not in self.compiled:
            linkage = folding_linkage(
                self.foldings[i], self.panel, hinged=look.pairs == "hinged", merged=look.pairs == "merged"
            )
            compiled = compile_scene(linkage, SCENES["default"], keep=frozenset({"stops"}))
            self.compiled[key] = compiled, solids_of(compiled)
        compiled, solids = self.compiled[key]
        if look.springs:
            compiled = with_springs(compiled, springs_of(self.foldings[i], compiled, look.springs))
        if look != FIRST:
            compiled = replace(compiled, scene=replace(compiled.scene, seconds=PATIENT))
        return compiled, solids

    def _trial(self, i: int, look: Look, compiled: Compiled, found: Check) -> Trial:
        length, width, thickness = self.panel
        size = compiled.linkage.pattern.size
        values = scene_values(compiled.scene) | {
            "panel_mm": f"{1e3 * length:g}x{1e3 * width:g}x{1e3 * thickness:g}",
            "flat_pairs": "hinged" if look.pairs == "hinged" else "rigid",
            "merge": look.pairs == "merged",
            "margin_mm": 1e3 * MARGIN,
        }
        return Trial(
            folding=i,
            scene=look.scene,
            values=json.dumps(values, sort_keys=True),
            formulation=compiled.formulation,
            status=status_of(found),
            reason=found.reason,
            clearance=min(math.inf if found.gap is None else found.gap, size) if found.deploys else None,
            first_contact=None if found.collision is None else found.collision[0],
            deploy_time=found.end_time if found.outcome == "flat" else None,
            energy_error=found.drift,
            closure_error=found.opening * size,
        )

    def _status(self, i: int) -> str:
        if i in self.deploys:
            return "deploys"
        if i in self.locked:
            return "locked"
        return "collides" if all(found.clear is False for found in self.tried[i]) else "undecided"

    def _trials(self, i: int) -> Iterator[Trial]:
        """What is kept of a folding: the first look, and the one in which it deploys."""
        first, deploys = self.first.get(i), self.deploys.get(i)
        if first is not None:
            yield first
        if deploys is not None and deploys is not first:
            yield deploys


def status_of(found: Check) -> str:
    """What one check says of its scene."""
    if found.deploys:
        return "deploys"
    return "collides" if found.clear is False else "undecided"


def scene_values(scene: Scene) -> dict[str, object]:
    """The values of a scene as its TOML file has them, without those of other formulations."""
    names = ("density", "spring", "damping_time", "damping", "gravity", "held", "start", "restitution", "seconds")
    values = {name: getattr(scene, name) for name in names}
    return {k: v for k, v in values.items() if v is not None} | {"springs": {str(h): law for h, law in scene.springs}}


def springs_of(folding: Folding, compiled: Compiled, name: str) -> Reals:
    """Stiffnesses (N m/rad) of the joints of a folding in a set, shape (n_joints,).

    Graded ones are geometric between `STIFF` and `SOFT`, those of `SPREAD` between the bounds of `hcsearch tune`.
    """
    if name in SPREAD:
        sets: Reals = spring_sets(compiled.system.n_joints, len(SPREAD))
        spread: Reals = sets[SPREAD.index(name)]
        return spread
    places = _places(folding, compiled)
    if name == OUTER:
        softness = 1.0 - np.abs(2.0 * places[:, 0] - 1.0)
    else:
        weights = np.array(GRADES[name])
        towards = np.where(weights < 0.0, 1.0 - places, places)
        softness = towards @ np.abs(weights) / np.abs(weights).sum()
    found: Reals = STIFF * (SOFT / STIFF) ** softness
    return found


def _places(folding: Folding, compiled: Compiled) -> Reals:
    """Layer (0 lowest to 1), face (1 for a valley) and stack (1 for the second) of the hinge of each joint."""
    linkage: Linkage = compiled.linkage
    pattern, half = linkage.pattern, folding.circuit.n // 2
    first = set(folding.stacks[0])
    found = np.zeros((compiled.system.n_joints, 3))
    for pair, crease in pattern.creases.items():
        if crease.face is None:
            continue
        layers = [folding.layers[panel] for panel in pair]
        layer = min(layers) / max(1, half - 2)
        joint = compiled.joint_of[pattern.hinge_of(pair)]
        found[joint] = min(layer, 1.0), crease.face == "top", pair[0] not in first
    return found
