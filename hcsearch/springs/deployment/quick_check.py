"""Quick checks of many deployments, each simulated and certified in one call of compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.kernels.collision.clearance_search import MOTION_CLEAR, MOTION_COLLIDES
from hcsearch.kernels.deployment_batch import CheckFindings, CheckingRules, SceneTables, check_foldings
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

MAX_MOTION_RECORD_BYTES = 2**29
"""Greatest size in bytes of the record of a motion."""


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


class CheckedMotion(NamedTuple):
    """A check of a deployment, and its motion with all states, where it becomes flat."""

    check: DeploymentCheck
    motion: Motion | None


class CheckOptions(TypedDict, total=False):
    """Options of a check.

    past_collisions : whether a motion that collides is followed to its end, too; not needed to find clear ones.
    max_steps : unless given those of `deploy`.
    """

    tolerance: float
    past_collisions: bool
    max_steps: int | None


def check_deployments(
    scenes: Sequence[CompiledScene],
    *,
    screens: Sequence[CheckedPanels] | None = None,
    threads: int = 1,
    **options: Unpack[CheckOptions],
) -> list[DeploymentCheck]:
    """Check compiled scenes; screens : the panels of each scene, if known; else they are shrunk by its own margin."""

    def run(compiled: CompiledScene, panels: CheckedPanels) -> DeploymentCheck:
        return check_motion(compiled, panels, **options).check

    if screens is None:
        screens = [checked_panels_of(compiled) for compiled in scenes]
    with ThreadPoolExecutor(threads) as pool:  # the kernel releases the global interpreter lock
        return list(pool.map(run, scenes, screens))


def check_motion(
    compiled: CompiledScene,
    panels: CheckedPanels,
    *,
    tolerance: float = 1e-6,
    past_collisions: bool = True,
    max_steps: int | None = None,
) -> CheckedMotion:
    """Check a compiled scene; it must be `constrained` or `compliant`, with a panel held."""
    setup, system = compiled.setup, compiled.system
    if setup.hold_downs or setup.law_times:
        raise HcsearchError("the quick check is of scenes without hold-downs and laws in time: leave them out")
    if compiled.formulation not in {"constrained", "compliant"} or setup.free:
        raise HcsearchError("the quick check is of scenes with a panel held, constrained or compliant")
    plan = plan_for(
        system,
        end=compiled.seconds,
        tolerance=tolerance,
        restitution=setup.restitution,
        flat=FLAT_FOLD_ANGLE,
        rest=REST_ANGLE_TOLERANCE,
    )
    methods = methods_of(compiled.formulation)
    method, stiff_method = map(method_named, methods)
    m = system.mechanism
    springs = m.struts, m.cuts, m.closure_stiffness, m.closure_damping
    exactness = panels.solids.margin, resolution_of(compiled.linkage)
    rules = CheckingRules(method, stiff_method, plan, *springs, *exactness, past_collisions)
    state_bytes = 3 * 8 * system.n_joints  # bytes of the angles, rates and accelerations of a state
    most = max_steps or MAX_DEPLOYMENT_STEPS[compiled.formulation]
    record = record_for(system.n_joints, min(most, max(1, MAX_MOTION_RECORD_BYTES // state_bytes)))
    findings = CheckFindings(
        endings=np.zeros(1, np.int64),
        stiff_times=np.zeros(1),
        verdicts=np.zeros(1, np.int64),
        pairs=np.zeros(1, np.int64),
        counts=np.zeros((1, 4), np.int64),
        times=np.zeros((1, 2)),
        gaps=np.zeros(1),
        speeds=np.zeros(1),
        remaining_angles=np.zeros((1, 3)),
        energy_drifts=np.zeros(1),
        closure_residuals=np.zeros(1),
        open_state_shares=np.zeros(1),
    )
    check_foldings(_stacked(_subject(compiled, panels)), rules, record, findings)
    check = _check(compiled, panels, findings)
    return CheckedMotion(check, motion_of_record(record, system, methods) if check.outcome == "flat" else None)


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


def _check(compiled: CompiledScene, panels: CheckedPanels, findings: CheckFindings) -> DeploymentCheck:
    """Return the check of a scene with its findings."""
    verdict, gap = int(findings.verdicts[0]), float(findings.gaps[0])
    collision = None
    if verdict == MOTION_COLLIDES:
        prisms = panels.solids.pairs.prisms[findings.pairs[0]]
        first, second = sorted(compiled.linkage.pattern.panel_of[prism] for prism in prisms)
        collision = (float(findings.times[0, 1]), (first, second))
    states, evaluations, _, looks = (int(number) for number in findings.counts[0])
    remaining, end_remaining, widest = map(float, findings.remaining_angles[0])
    return DeploymentCheck(
        outcome=outcome_of(SIMULATION_STOPS[int(findings.endings[0])]),
        end_time=float(findings.times[0, 0]),
        clear={MOTION_CLEAR: True, MOTION_COLLIDES: False}.get(verdict),
        collision=collision,
        gap=finite_or_none(gap),
        speed=float(findings.speeds[0]),
        remaining=remaining,
        end_remaining=end_remaining,
        widest=math.pi * widest,
        drift=float(findings.energy_drifts[0]),
        opening=float(findings.closure_residuals[0]),
        steps=states - 1,
        evaluations=evaluations,
        looks=looks,
        loose_share=float(findings.open_state_shares[0]),
        stiff_time=float(findings.stiff_times[0]),
    )


def _stacked(value: Any) -> Any:
    """Return nested tuples of arrays with a leading axis."""
    return type(value)(*map(_stacked, value)) if isinstance(value, tuple) else np.asarray(value)[None]
