"""Quick checks of many deployments, simulated and certified together in calls of compiled code."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.kernels.collision.clearance_search import MOTION_CLEAR, MOTION_COLLIDES
from hcsearch.kernels.deployment_batch import CheckFindings, CheckingRules, SceneTables, check_foldings
from hcsearch.kernels.multibody.recording import SimulationRecord
from hcsearch.motion.collision.panel_prisms import Solids, collision_solids, resolution_of, slack_of
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.outcomes import (
    FLAT_FOLD_ANGLE,
    MAX_DEPLOYMENT_STEPS,
    REST_ANGLE_TOLERANCE,
    DeploymentCheck,
    methods_of,
    outcome_of,
)
from hcsearch.springs.dynamics.integration_methods import method_named
from hcsearch.springs.dynamics.time_integration import (
    SIMULATION_STOPS,
    Motion,
    motion_of_record,
    plan_for,
    record_for,
)

MAX_SCENES_PER_CALL = 16
"""Greatest number of scenes in one call of the kernel, so that threads end together and tables need little memory."""
MAX_SCENE_TABLE_BYTES, MAX_MOTION_RECORD_BYTES = 2**28, 2**29
"""Greatest size in bytes of the tables of the scenes in one call, and of the record of one motion."""


class CheckedPanels(NamedTuple):
    """The panels of a scene as tables of a check.

    reach : greatest displacement of panels (m) over the opening of loops, see `slack_of`; where springs close the
        loops, the check uses the largest opening of a motion for all of its times.
    """

    solids: Solids
    reach: float


def checked_panels_of(compiled: CompiledScene, margin: float | None = None) -> CheckedPanels:
    """Return the panels of a scene, shrunk by its margin or a given one (m); they do not depend on springs."""
    linkage = compiled.linkage
    solids = collision_solids(linkage, compiled.margin if margin is None else margin, compiled.separated_pairs)
    return CheckedPanels(solids, slack_of(linkage, 1.0))


def check_deployments(
    scenes: Sequence[CompiledScene],
    *,
    screens: Sequence[CheckedPanels] | None = None,
    tolerance: float = 1e-6,
    past_collisions: bool = True,
    max_steps: int | None = None,
    threads: int = 1,
) -> list[DeploymentCheck]:
    """Check compiled scenes; those whose tables have the same shapes are passed to the kernel together.

    screens : the panels of each scene, if known; else they are shrunk by its own margin. past_collisions : whether
        motions that collide are followed to the end, too; not needed to find clear ones. max_steps : of each scene,
        unless given those of `deploy`.
    Scenes must be `constrained` or `compliant`, with a panel held.
    """
    groups: dict[Any, list[int]] = defaultdict(list)
    if screens is None:
        screens = [checked_panels_of(compiled) for compiled in scenes]
    subjects = [_subject(compiled, panels) for compiled, panels in zip(scenes, screens, strict=True)]
    for i, (compiled, panels, subject) in enumerate(zip(scenes, screens, subjects, strict=True)):
        setup, exactness = compiled.setup, _exactness(compiled, panels)
        key = (compiled.formulation, compiled.seconds, setup.restitution, setup.cut_stiffness, setup.cut_damping)
        groups[(exactness, *key, *_shapes(subject))].append(i)
    calls = []
    for key, members in groups.items():
        batch = max(1, min(MAX_SCENES_PER_CALL, MAX_SCENE_TABLE_BYTES // _bytes(subjects[members[0]])))
        calls += [(key[0], members[k : k + batch]) for k in range(0, len(members), batch)]

    def run(call: tuple[tuple[float, float], list[int]]) -> list[DeploymentCheck]:
        exactness, members = call
        batch_scenes = [scenes[i] for i in members]
        record = _record(batch_scenes[0], max_steps)
        return _run(batch_scenes, [subjects[i] for i in members], tolerance, exactness, past_collisions, record)

    checks: dict[int, DeploymentCheck] = {}
    with ThreadPoolExecutor(threads) as pool:  # the kernel releases the global interpreter lock
        for (_, members), rows in zip(calls, pool.map(run, calls), strict=True):
            checks.update(zip(members, rows, strict=True))
    return [checks[i] for i in range(len(scenes))]


def check_with_motion(
    compiled: CompiledScene, screen: CheckedPanels, *, tolerance: float, max_steps: int | None = None
) -> tuple[DeploymentCheck, Motion]:
    """Check a compiled scene as `check_deployments` does, and return its motion, too."""
    record = _record(compiled, max_steps)
    subjects, exactness = [_subject(compiled, screen)], _exactness(compiled, screen)
    (check,) = _run([compiled], subjects, tolerance, exactness, past_collisions=True, record=record)
    return check, motion_of_record(record, compiled.system, methods_of(compiled.formulation))


def _exactness(compiled: CompiledScene, screen: CheckedPanels) -> tuple[float, float]:
    """Return margin and resolution of a check, m; HcsearchError for a scene of which there is none."""
    setup = compiled.setup
    if setup.hold_downs or setup.law_times:
        raise HcsearchError("the quick check is of scenes without hold-downs and laws in time: leave them out")
    if compiled.formulation not in {"constrained", "compliant"} or setup.free:
        raise HcsearchError("the quick check is of scenes with a panel held, constrained or compliant")
    return screen.solids.margin, resolution_of(compiled.linkage)


def _record(compiled: CompiledScene, max_steps: int | None) -> SimulationRecord:
    """Allocate a record of a motion."""
    n_joints = compiled.system.n_joints
    state_bytes = 3 * 8 * n_joints  # bytes of the angles, rates and accelerations of a state
    most = max_steps or MAX_DEPLOYMENT_STEPS[compiled.formulation]
    return record_for(n_joints, min(most, max(1, MAX_MOTION_RECORD_BYTES // state_bytes)))


def _subject(compiled: CompiledScene, screen: CheckedPanels) -> SceneTables:
    mechanism, linkage, solids = compiled.system.mechanism, compiled.linkage, screen.solids
    return SceneTables(
        tree=mechanism.tree,
        hinges=mechanism.hinges,
        drag=mechanism.drag,
        start=compiled.start,
        joint_of=compiled.joint_of,
        chain=linkage.chain,
        prisms=solids.prisms,
        shrunk=solids.shrunk,
        pairs=solids.pairs,
        max_margin=solids.max_margin,
        residual_lever=screen.reach,
    )


def _run(
    scenes: list[CompiledScene],
    subjects: list[SceneTables],
    tolerance: float,
    exactness: tuple[float, float],
    past_collisions: bool,
    record: SimulationRecord,
) -> list[DeploymentCheck]:
    """Check scenes whose tables have the same shapes; the record then is that of the last one.

    exactness : margin and resolution, m.
    """
    first, count = scenes[0], len(scenes)
    system, setup = first.system, first.setup
    plan = plan_for(
        system,
        end=first.seconds,
        tolerance=tolerance,
        restitution=setup.restitution,
        flat=FLAT_FOLD_ANGLE,
        rest=REST_ANGLE_TOLERANCE,
    )
    method, stiff_method = map(method_named, methods_of(first.formulation))
    m = system.mechanism
    springs = m.struts, m.cuts, m.closure_stiffness, m.closure_damping
    rules = CheckingRules(method, stiff_method, plan, *springs, *exactness, past_collisions)
    findings = CheckFindings(
        endings=np.zeros(count, np.int64),
        stiff_times=np.zeros(count),
        verdicts=np.zeros(count, np.int64),
        pairs=np.zeros(count, np.int64),
        counts=np.zeros((count, 4), np.int64),
        times=np.zeros((count, 2)),
        gaps=np.zeros(count),
        speeds=np.zeros(count),
        remaining_angles=np.zeros((count, 3)),
        energy_drifts=np.zeros(count),
        closure_residuals=np.zeros(count),
        open_state_shares=np.zeros(count),
    )
    check_foldings(_stacked(subjects), rules, record, findings)
    return [_check(scenes[i], subjects[i], findings, i) for i in range(count)]


def _check(compiled: CompiledScene, subject: SceneTables, findings: CheckFindings, i: int) -> DeploymentCheck:
    verdict, gap = int(findings.verdicts[i]), float(findings.gaps[i])
    collision = None
    if verdict == MOTION_COLLIDES:
        first, second = sorted(compiled.linkage.pattern.panel_of[f] for f in subject.pairs.prisms[findings.pairs[i]])
        collision = (float(findings.times[i, 1]), (first, second))
    states, evaluations, _, looks = (int(number) for number in findings.counts[i])
    return DeploymentCheck(
        outcome_of(SIMULATION_STOPS[int(findings.endings[i])]),
        float(findings.times[i, 0]),
        {MOTION_CLEAR: True, MOTION_COLLIDES: False}.get(verdict),
        collision,
        finite_or_none(gap),
        float(findings.speeds[i]),
        float(findings.remaining_angles[i, 0]),
        float(findings.remaining_angles[i, 1]),
        math.pi * float(findings.remaining_angles[i, 2]),
        float(findings.energy_drifts[i]),
        float(findings.closure_residuals[i]),
        states - 1,
        evaluations,
        looks,
        float(findings.open_state_shares[i]),
        float(findings.stiff_times[i]),
    )


def _bytes(value: Any) -> int:
    """Return the size in bytes of all tables of nested tuples."""
    return sum(map(_bytes, value)) if isinstance(value, tuple) else int(np.asarray(value).nbytes)


def _shapes(value: Any) -> tuple[Any, ...]:
    """Return the shapes of all tables of nested tuples."""
    if isinstance(value, tuple):
        return tuple(shape for part in value for shape in _shapes(part))
    return (np.shape(value),)


def _stacked(values: Sequence[Any]) -> Any:
    """Stack nested tuples of arrays of the same shapes along a new leading axis."""
    first: NamedTuple | Any = values[0]
    if isinstance(first, tuple):
        return type(first)(*(_stacked(parts) for parts in zip(*values, strict=True)))
    return np.stack([np.asarray(value) for value in values])
