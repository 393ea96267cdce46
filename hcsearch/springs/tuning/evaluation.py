"""Evaluations of spring sets: the objective, checks on all cores, and a memory in the database."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Formulation
from hcsearch.motion.collision.panel_prisms import scale_of
from hcsearch.motion.collision.panel_reaches import slack_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene, with_stiffnesses
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment import DEPLOYMENT_VERSION
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.deployment.quick_check import CheckedPanels, check_deployments, checked_panels_of
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, with_springs
from hcsearch.store import Database, find_evaluations, record_evaluations
from hcsearch.system.machine import usable_cores

APPROACH_SPEED_SCALE = 5.0
"""Approach speed that is worth as much as all of the way from folded to flat, m/s: p of eq. 4.26 is its inverse."""
AMPLE_GAP = 2e-3
"""A gap that is as good as any larger one, m: q of eq. 4.26 is its inverse."""


class SceneScales(NamedTuple):
    """Lengths and times of a scene over those of `default`, for which `APPROACH_SPEED_SCALE` and `AMPLE_GAP` hold."""

    length: float = 1.0
    time: float = 1.0


DEFAULT_SCENE_SCALES = SceneScales()


def tuning_objective(check: DeploymentCheck, slack: float = 0.0, scales: SceneScales = DEFAULT_SCENE_SCALES) -> float:
    """The less, the better; least for what becomes flat and clear.

    slack : what panels may be elsewhere as the loops give way, m.

    The thesis minimises f = p v_a - q d_p (eq. 4.26): the approach speed at the first collision, less the smallest gap
    where there is none. That says nothing of deployments that stop short of flat, and equals 0 for collisions at any
    time that are slow enough. So here:

    - flat and clear: -q (d_p - slack), not less than -1, as gaps above `AMPLE_GAP` count as that, and less than 1: what
      is certain of the gap, which impacts that open the loops lessen;
    - else 1 + the mean fold angle over pi that is left when panels come together (or may do so), or where it
      is clear at the end, so that what gets further is better; what comes after a collision counts for nothing. To that
      p v_a, and 1 where the simulation gave up.
    """
    ample, speed = AMPLE_GAP * scales.length, APPROACH_SPEED_SCALE * scales.length / scales.time
    if check.deploys:
        gap = ample if check.gap is None else min(check.gap, ample)
        return min((slack - gap) / ample, 0.999)
    value = 1.0 + check.remaining + (0.0 if check.clear else check.speed / speed)
    value += check.outcome in {"diverged", "out of steps"}
    # a simulation that overflowed shows nothing
    return value if math.isfinite(value) else 10.0


TUNING_STEP_TOLERANCES: Mapping[Formulation, float] = {"constrained": 1e-4, "compliant": 3e-5}
"""Errors of a step while springs are searched for."""
TUNING_MARGIN_SHARE = 0.75
"""Share of the scene's margin by which panels are shrunk on every face while springs are searched for: less than what
is asked for in the end, so that a set that is clear in the search is clear in the scene itself, too."""
SOFTENED_SETUP_VALUES = {"cut_damping": 1e4, "stop_stiffness": 100.0, "stop_damping": 0.1}
"""Of compliant scenes while springs are searched for: stops give way by 0.2 degrees at most, loops as in the scene, and
steps are ten times longer. What is chosen is confirmed in the scene itself."""


class EvaluationKey(NamedTuple):
    """The key of an evaluation of one array: the setting (scene and method, as JSON), the springs."""

    setting: str
    springs: str


class EvaluationMemory(Protocol):
    """Where evaluations of one array are kept."""

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Those of the keys that are known."""

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Keep more checks, all of them or none."""


class RunMemory:
    """A memory of one run."""

    def __init__(self) -> None:
        self._known: dict[EvaluationKey, DeploymentCheck] = {}

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Those of the keys that are known."""
        return {key: self._known[key] for key in keys if key in self._known}

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Keep more checks."""
        self._known |= checks


class Evaluator:
    """Checks of one array in setups that differ in their springs, or in more.

    setup : that they differ from. strict : margin of the checks, m.
    done, samples : how many sets of springs, and how many other scenes, have been asked for, each once. recalled,
    samples_recalled : how many of these the memory knew before. before : evaluations of another formulation that the
    choice of this one took; they are in `done`.
    """

    def __init__(
        self, linkage: Linkage, scene: Scene | Setup, formulation: Formulation, memory: EvaluationMemory | None = None
    ) -> None:
        self.linkage, self.formulation = linkage, formulation
        setup = setup_of_scene(scene, linkage)
        self.setup = softened_setup(setup) if formulation == "compliant" else setup
        self.strict = TUNING_MARGIN_SHARE * setup.margin
        self.scales = SceneScales(scale_of(linkage), setup.seconds)
        self.reach = slack_of(linkage, 1.0) if formulation == "compliant" else 0.0
        self.recalled = self.samples_recalled = self.before = 0
        self._memory = RunMemory() if memory is None else memory
        self._sets: set[EvaluationKey] = set()
        self._samples: set[EvaluationKey] = set()
        self._base: CompiledScene | None = None
        self._screens: dict[frozenset[tuple[int, int]], CheckedPanels] = {}

    @property
    def done(self) -> int:
        """How many sets of springs have been asked for."""
        return self.before + len(self._sets)

    @property
    def samples(self) -> int:
        """How many scenes have been asked for that are no sets of springs."""
        return len(self._samples)

    def of_springs(self, sets: Iterable[Sequence[float] | Reals], whole: bool = False) -> list[DeploymentCheck]:
        """Check spring sets, each a stiffness (N m/rad) for every hinge; mirror hinges have equal ones.

        whole : whether motions that collide are followed to their end, too. What was once is not checked otherwise.
        """
        if self._base is None:
            # mirror hinges have equal springs in all sets, so that one with equal springs everywhere stands for all
            self._base = self._compiled(with_stiffnesses(self.setup, [0.1] * self.linkage.n_hinges))
        setups = [with_stiffnesses(self.setup, stiffnesses) for stiffnesses in sets]
        keys = [self._key(setup, True) for setup in setups]
        keys = [
            key if whole or key in self._sets else self._key(setup, False)
            for key, setup in zip(keys, setups, strict=True)
        ]
        known = dict(self._memory.recall(keys))
        self.recalled += len((set(keys) - self._sets) & set(known))
        self._sets |= set(keys)
        return self._checked(keys, setups, known, self._sprung, whole)

    def of_setups(self, setups: Sequence[Setup]) -> list[DeploymentCheck]:
        """Check setups that may differ in anything, all with linear springs."""
        keys = [self._key(setup, False) for setup in setups]
        known = dict(self._memory.recall(keys))
        fresh = set(keys) - self._samples - self._sets
        self.samples_recalled += len(fresh & set(known))
        self._samples |= fresh
        return self._checked(keys, setups, known, self._compiled, whole=False)

    def slack(self, check: DeploymentCheck) -> float:
        """What panels may be elsewhere as springs that close loops give way, m: checks leave it out of account."""
        return self.reach * check.opening

    def value(self, check: DeploymentCheck) -> float:
        """The objective."""
        return tuning_objective(check, self.slack(check), self.scales)

    def _sprung(self, setup: Setup) -> CompiledScene:
        assert self._base is not None
        stiffnesses = np.empty(self._base.system.n_joints)
        stiffnesses[self._base.joint_of] = stiffnesses_of(setup)
        return with_springs(self._base, stiffnesses)

    def _compiled(self, setup: Setup) -> CompiledScene:
        # whether folded stops can be reached depends on the springs, which change
        return compile_scene(self.linkage, setup, self.formulation, keep=frozenset({"stops"}))

    def _checked(
        self,
        keys: Sequence[EvaluationKey],
        setups: Sequence[Setup],
        known: dict[EvaluationKey, DeploymentCheck],
        compiled: Any,
        whole: bool,
    ) -> list[DeploymentCheck]:
        """The checks of setups, of which the memory knows some."""
        missing = {key: setup for key, setup in zip(keys, setups, strict=True) if key not in known}
        if missing:
            fresh = self._run([compiled(setup) for setup in missing.values()], whole)
            checks = dict(zip(missing, fresh, strict=True))
            self._memory.record(checks)
            known |= checks
        return [known[key] for key in keys]

    def _run(self, scenes: Sequence[CompiledScene], whole: bool) -> list[DeploymentCheck]:
        """All scenes, dealt out to as many threads as there are cores; the kernels run without Python's lock."""
        for scene in scenes:
            if scene.apart not in self._screens:
                own = checked_panels_of(scene, self.strict)
                # springs give way at impacts, for moments: with that for a slack at all times nothing would be certain
                self._screens[scene.apart] = own._replace(reach=0.0) if self.formulation == "compliant" else own
        screens = [self._screens[scene.apart] for scene in scenes]
        threads = max(1, min(usable_cores(), len(scenes)))
        tolerance = TUNING_STEP_TOLERANCES[self.formulation]
        return check_deployments(scenes, screens=screens, tolerance=tolerance, whole=whole, threads=threads)

    def _key(self, setup: Setup, whole: bool) -> EvaluationKey:
        values = {own.name: getattr(setup, own.name) for own in fields(setup)}
        for name in ("name", "laws", "spring_range"):
            del values[name]
        springs = stiffnesses_of(setup)
        values |= {"formulation": self.formulation, "tolerance": TUNING_STEP_TOLERANCES[self.formulation]}
        values |= {"margin": self.strict, "whole": whole, "version": DEPLOYMENT_VERSION}
        return EvaluationKey(json.dumps(values, sort_keys=True), " ".join(repr(float(value)) for value in springs))


def softened_setup(setup: Setup) -> Setup:
    """A setup with the stops and dampers that `compliant` is searched with."""
    return replace(setup, **SOFTENED_SETUP_VALUES)  # type: ignore[arg-type]


class DatabaseMemory:
    """The evaluations of a subject (its notation and sizes, in one text) in a database: a memory of an evaluator."""

    def __init__(self, database: Database, subject: str) -> None:
        self._database, self._subject = database, subject
        rows = find_evaluations(database, subject)
        self._known = {EvaluationKey(row["setting"], row["springs"]): check_of_row(row) for row in rows}

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Those of the keys that are known."""
        return {key: self._known[key] for key in keys if key in self._known}

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Store more checks, in one transaction."""
        record_evaluations(self._database, [self.row(self._subject, key, check) for key, check in checks.items()])
        self._known |= checks

    @staticmethod
    def row(subject: str, key: EvaluationKey, check: DeploymentCheck) -> dict[str, Any]:
        """A row of the table."""
        time, panels = (None, (None, None)) if check.collision is None else check.collision
        return {
            "subject": subject,
            "setting": key.setting,
            "springs": key.springs,
            "outcome": check.outcome,
            "clear": None if check.clear is None else int(check.clear),
            "end_time": check.end_time,
            "collision_time": time,
            "first_panel": panels[0],
            "second_panel": panels[1],
            **{name: _finite(getattr(check, name)) for name in _REALS},
            **{name: getattr(check, name) for name in _COUNTS},
        }


_REALS = ("gap", "speed", "remaining", "end_remaining", "widest", "drift", "opening")
_COUNTS = ("steps", "evaluations", "looks")


def check_of_row(row: Mapping[str, Any]) -> DeploymentCheck:
    """The check that a row of the table holds."""
    collision = None
    if row["collision_time"] is not None:
        collision = (row["collision_time"], (row["first_panel"], row["second_panel"]))
    reals: dict[str, Any] = {name: math.nan if row[name] is None and name != "gap" else row[name] for name in _REALS}
    return DeploymentCheck(
        outcome=row["outcome"],
        end_time=row["end_time"],
        clear=None if row["clear"] is None else bool(row["clear"]),
        collision=collision,
        **reals,
        **{name: row[name] for name in _COUNTS},
    )


def _finite(value: float | None) -> float | None:
    """A number, or None for what overflowed: not all databases keep such."""
    return value if value is not None and math.isfinite(value) else None
