"""Evaluations of spring sets: the objective, checks on all cores, and a cache in the database.

Sets of springs and dampers are tables of the shape (n_hinges,), or (2 n_hinges,) with dampings after stiffnesses. A
damping that is not a number stands for a hinge without a damper of its own, which keeps the damping of the scene.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Formulation, finite_or_none
from hcsearch.motion.collision.panel_prisms import scale_of, slack_of
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import HARDWARE_VALUES
from hcsearch.scenes.setup import Setup, natural_seconds, setup_of_scene, with_dampings, with_stiffnesses
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment import DEPLOYMENT_VERSION
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.deployment.quick_check import CheckedPanels, check_deployments, checked_panels_of
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, with_springs
from hcsearch.store import Database, find_evaluations, record_evaluations
from hcsearch.system.machine import usable_cores

DAMPING_DIGITS = 12
"""Significant digits of dampings that are multiplied."""
PartBounds = tuple[float, float] | tuple[Reals, Reals]
"""The least and the greatest value, for all groups or for each, or their logarithms."""


def with_parts(setup: Setup, parts: Sequence[float] | Reals) -> Setup:
    """Return a setup with the springs (N m/rad) and dampers (N m s/rad) of a table."""
    table, n = np.asarray(parts, float), len(setup.laws)
    damped = with_dampings(setup, table[n:]) if len(table) > n else setup
    return with_stiffnesses(damped, table[:n])


def tied_parts(tied: Sequence[tuple[int, ...]]) -> tuple[tuple[int, ...], ...]:
    """Return the tied groups of springs, and then of dampers, by their places in a table."""
    n = sum(map(len, tied))
    return (*tied, *(tuple(n + hinge for hinge in hinges) for hinges in tied))


def part_bounds(
    spring_range: tuple[float, float], n_groups: int, damper_range: tuple[float, float] | None
) -> PartBounds:
    """Return the bounds of all springs or, with a range of dampers, of each group of springs and of dampers."""
    if damper_range is None:
        return spring_range
    low, high = (np.repeat([spring_range[k], damper_range[k]], n_groups) for k in (0, 1))
    return low, high


def damped_more(setup: Setup, factor: float, linkage: Linkage) -> Setup:
    """Return a setup with dampers at all hinges that multiply their damping by a factor."""
    dampings = [float(f"{factor * damping:.{DAMPING_DIGITS}g}") for damping in setup.dampings]
    return in_time(with_dampings(setup, dampings), setup, linkage)


def in_time(changed: Setup, setup: Setup, linkage: Linkage) -> Setup:
    """Return a changed setup with the time that it needs, unless another than the natural one was given.

    setup : the setup before the change.
    """
    is_natural = setup.seconds == natural_seconds(setup, linkage)
    return replace(changed, seconds=natural_seconds(changed, linkage)) if is_natural else changed


APPROACH_SPEED_SCALE = 5.0
"""Approach speed that counts as much as the whole motion from folded to flat, m/s: p of eq. 4.26 is its inverse."""
AMPLE_GAP = 2e-3
"""Gap above which larger gaps count the same, m: q of eq. 4.26 is its inverse."""


class SceneScales(NamedTuple):
    """Lengths and times of a scene over the `default` ones, to which `APPROACH_SPEED_SCALE` and `AMPLE_GAP` refer."""

    length: float = 1.0
    time: float = 1.0


DEFAULT_SCENE_SCALES = SceneScales()


def tuning_objective(check: DeploymentCheck, slack: float = 0.0, scales: SceneScales = DEFAULT_SCENE_SCALES) -> float:
    """Return the objective to be minimised; it is least for deployments that become flat and clear.

    slack : greatest displacement of panels as compliant loops open, m.

    The thesis minimises f = p v_a - q d_p (eq. 4.26): the approach speed at the first collision, less the smallest gap
    where there is none. It does not distinguish deployments that stop short of flat, and is near 0 for slow collisions
    at any time. So here:

    - flat and clear: -q (d_p - slack), at least -1, as gaps above `AMPLE_GAP` count as that, and less than 1: the
      certain part of the gap, which impacts that open the loops reduce;
    - else 1 + the mean fold angle over pi that remains when panels meet (or may do so), or at the end of a clear
      motion, so that motions that get further are better; the motion after a collision does not count. To that are
      added p v_a, and 1 where the simulation failed.
    """
    ample, speed = AMPLE_GAP * scales.length, APPROACH_SPEED_SCALE * scales.length / scales.time
    if check.deploys:
        gap = ample if check.gap is None else min(check.gap, ample)
        return min((slack - gap) / ample, 0.999)
    value = 1.0 + check.remaining + (0.0 if check.clear else check.speed / speed)
    value += check.outcome in {"diverged", "out of steps", "branch-singular"}
    # a simulation that overflowed has no meaningful value
    return value if math.isfinite(value) else 10.0


TUNING_STEP_TOLERANCES: Mapping[Formulation, float] = {"constrained": 1e-4, "compliant": 3e-5}
"""Error tolerances of a step during the search."""
TUNING_MARGIN_SHARE = 0.75
"""Share of the scene's margin by which panels are shrunk on every face during the search: less than in the scene, so
that a set that is clear in the search is clear in the scene itself, too."""
SOFTENED_SETUP_VALUES = {"cut_damping": 1e4, "stop_stiffness": 100.0, "stop_damping": 0.1}
"""Values of compliant scenes during the search: stops yield by 0.2 degrees at most, loops as in the scene, and steps
are ten times longer. The chosen set is confirmed in the scene itself."""


class EvaluationKey(NamedTuple):
    """The key of an evaluation of an array: the setting (scene and method, as JSON), and the springs."""

    setting: str
    springs: str


class EvaluationMemory(Protocol):
    """A cache of the evaluations of one array."""

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Return the cached checks among those of some keys."""

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Store more checks, all of them or none."""


class RunMemory:
    """A cache in memory, for one run."""

    def __init__(self) -> None:
        self._known: dict[EvaluationKey, DeploymentCheck] = {}

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Return the cached checks among those of some keys."""
        return {key: self._known[key] for key in keys if key in self._known}

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Store more checks."""
        self._known |= checks


class Evaluator:
    """Evaluates spring sets and other setups of one array by quick checks, with a cache.

    setup : the setup from which they differ. margin : of the checks, m. slack_per_opening : greatest displacement of
    panels (m) over the opening of compliant loops; 0 with exact closure.
    evaluation_count, sample_count : numbers of distinct spring sets and of distinct other setups evaluated. recalled,
    samples_recalled : how many of these were cached. earlier_evaluations : evaluations of another formulation for the
    choice of this one; they are included in `evaluation_count`.
    """

    def __init__(
        self, linkage: Linkage, scene: Scene | Setup, formulation: Formulation, memory: EvaluationMemory | None = None
    ) -> None:
        self.linkage, self.formulation = linkage, formulation
        setup = setup_of_scene(scene, linkage)
        self.setup = softened_setup(setup) if formulation == "compliant" else setup
        self.margin = TUNING_MARGIN_SHARE * setup.margin
        self.scales = SceneScales(scale_of(linkage), setup.seconds)
        self.slack_per_opening = slack_of(linkage, 1.0) if formulation == "compliant" else 0.0
        self.recalled = self.samples_recalled = self.earlier_evaluations = 0
        self._memory = RunMemory() if memory is None else memory
        self._sets: set[EvaluationKey] = set()
        self._samples: set[EvaluationKey] = set()
        self._base: CompiledScene | None = None
        self._screens: dict[frozenset[tuple[int, int]], CheckedPanels] = {}

    @property
    def evaluation_count(self) -> int:
        """Number of distinct spring sets evaluated."""
        return self.earlier_evaluations + len(self._sets)

    @property
    def sample_count(self) -> int:
        """Number of distinct setups evaluated that are not spring sets."""
        return len(self._samples)

    def of_springs(
        self, sets: Iterable[Sequence[float] | Reals], past_collisions: bool = False
    ) -> list[DeploymentCheck]:
        """Check spring sets, each a table of parts; mirror hinges have equal springs and dampers.

        past_collisions : whether motions that collide are followed to their end, too. A set that has been checked so is
        not checked again otherwise.
        """
        if self._base is None:
            # mirror hinges have equal springs in all sets, so a set of equal springs is compiled for all
            self._base = self._compiled(with_stiffnesses(self.setup, [0.1] * self.linkage.n_hinges))
        setups = [with_parts(self.setup, parts) for parts in sets]
        keys = [self._key(setup, True) for setup in setups]
        keys = [
            key if past_collisions or key in self._sets else self._key(setup, False)
            for key, setup in zip(keys, setups, strict=True)
        ]
        known = dict(self._memory.recall(keys))
        self.recalled += len((set(keys) - self._sets) & set(known))
        self._sets |= set(keys)
        return self._checked(keys, setups, known, self._sprung, past_collisions)

    def of_setups(self, setups: Sequence[Setup]) -> list[DeploymentCheck]:
        """Check setups that may differ in anything, all with linear springs."""
        keys = [self._key(setup, False) for setup in setups]
        known = dict(self._memory.recall(keys))
        fresh = set(keys) - self._samples - self._sets
        self.samples_recalled += len(fresh & set(known))
        self._samples |= fresh
        return self._checked(keys, setups, known, self._compiled, past_collisions=False)

    def slack(self, check: DeploymentCheck) -> float:
        """Return the greatest displacement of panels as springs that close loops yield, m, which checks neglect."""
        return self.slack_per_opening * check.opening

    def value(self, check: DeploymentCheck) -> float:
        """Return the objective of a check."""
        return tuning_objective(check, self.slack(check), self.scales)

    def _sprung(self, setup: Setup) -> CompiledScene:
        assert self._base is not None
        stiffnesses = np.empty(self._base.system.n_joints)
        stiffnesses[self._base.joint_of] = stiffnesses_of(setup)
        damped = replace(self._base.setup, damping=setup.damping, damping_time=setup.damping_time)
        return with_springs(replace(self._base, setup=damped), stiffnesses)

    def _compiled(self, setup: Setup) -> CompiledScene:
        # the springs, which change, determine whether folded stops can be reached
        return compile_scene(self.linkage, setup, self.formulation, keep=frozenset({"stops"}))

    def _checked(
        self,
        keys: Sequence[EvaluationKey],
        setups: Sequence[Setup],
        known: dict[EvaluationKey, DeploymentCheck],
        compiled: Any,
        past_collisions: bool,
    ) -> list[DeploymentCheck]:
        """Return the checks of setups; those that are not known are run and cached."""
        missing = {key: setup for key, setup in zip(keys, setups, strict=True) if key not in known}
        if missing:
            fresh = self._run([compiled(setup) for setup in missing.values()], past_collisions)
            checks = dict(zip(missing, fresh, strict=True))
            self._memory.record(checks)
            known |= checks
        return [known[key] for key in keys]

    def _run(self, scenes: Sequence[CompiledScene], past_collisions: bool) -> list[DeploymentCheck]:
        """Check scenes in as many threads as there are cores; the kernels release the global interpreter lock."""
        for scene in scenes:
            if scene.separated_pairs not in self._screens:
                panels = checked_panels_of(scene, self.margin)
                # springs yield at impacts, for moments: with that as the slack at all times nothing would be certain
                self._screens[scene.separated_pairs] = (
                    panels._replace(reach=0.0) if self.formulation == "compliant" else panels
                )
        screens = [self._screens[scene.separated_pairs] for scene in scenes]
        threads = max(1, min(usable_cores(), len(scenes)))
        tolerance = TUNING_STEP_TOLERANCES[self.formulation]
        return check_deployments(
            scenes, screens=screens, tolerance=tolerance, past_collisions=past_collisions, threads=threads
        )

    def _key(self, setup: Setup, past_collisions: bool) -> EvaluationKey:
        left_out = {"name", "laws", "spring_range", "hold_downs", *HARDWARE_VALUES}  # no hold-downs are tuned
        names = [value_field.name for value_field in fields(setup) if value_field.name not in left_out]
        values = {name: getattr(setup, name) for name in names}
        if any(setup.resistance):  # else as in the keys of databases from before there was friction
            values["resistance"] = setup.resistance
        for name in ("damping_time", "damping"):  # nor dampers of single hinges
            if len(set(values[name])) == 1:
                values[name] = values[name][0]
        springs = stiffnesses_of(setup)
        values |= {"formulation": self.formulation, "tolerance": TUNING_STEP_TOLERANCES[self.formulation]}
        values |= {"margin": self.margin, "whole": past_collisions, "version": DEPLOYMENT_VERSION}
        return EvaluationKey(json.dumps(values, sort_keys=True), " ".join(repr(float(value)) for value in springs))


def softened_setup(setup: Setup) -> Setup:
    """Return a setup with the softer stops and stronger dampers used in searches in the formulation `compliant`."""
    return replace(setup, **SOFTENED_SETUP_VALUES)  # type: ignore[arg-type]


class DatabaseMemory(RunMemory):
    """A cache in a database of the evaluations of a subject (its notation and sizes, in one text)."""

    def __init__(self, database: Database, subject: str) -> None:
        self._database, self._subject = database, subject
        rows = find_evaluations(database, subject)
        self._known = {EvaluationKey(row["setting"], row["springs"]): check_of_row(row) for row in rows}

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Store more checks, in one transaction."""
        record_evaluations(self._database, [self.row(self._subject, key, check) for key, check in checks.items()])
        super().record(checks)

    @staticmethod
    def row(subject: str, key: EvaluationKey, check: DeploymentCheck) -> dict[str, Any]:
        """Return a row of the table of evaluations."""
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
            **{name: finite_or_none(getattr(check, name)) for name in _REALS},
            **{name: getattr(check, name) for name in _COUNTS},
        }


_REALS = ("gap", "speed", "remaining", "end_remaining", "widest", "drift", "opening")
_COUNTS = ("steps", "evaluations", "looks")


def check_of_row(row: Mapping[str, Any]) -> DeploymentCheck:
    """Return the check stored in a row of the table."""
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
