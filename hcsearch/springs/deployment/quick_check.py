"""Quick checks of many deployments, each simulated and certified in one call of compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.kernels.collision.clearance_search import MOTION_CLEAR, MOTION_COLLIDES
from hcsearch.kernels.deployment_check import CheckFindings, CheckingRules, SceneTables, check_folding
from hcsearch.kernels.multibody.accelerations import discrete_state_for
from hcsearch.kernels.multibody.recording import SimulationRecord, stiff_time
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


def check_deployments(
    scenes: Sequence[CompiledScene],
    *,
    screens: Sequence[CheckedPanels] | None = None,
    tolerance: float = 1e-6,
    past_collisions: bool = True,
    threads: int = 1,
) -> list[DeploymentCheck]:
    """Check compiled scenes; screens : the panels of each scene, if known; else they are shrunk by its own margin."""

    def run(compiled: CompiledScene, panels: CheckedPanels) -> DeploymentCheck:
        return check_motion(compiled, panels, tolerance=tolerance, past_collisions=past_collisions).check

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
    """Check a compiled scene; it must be `constrained` or `compliant`, with a panel held.

    past_collisions : whether a motion that collides is followed to its end, too; not needed to find clear ones.
    max_steps : unless given those of `deploy`.
    """
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
    margin, resolution = panels.solids.margin, resolution_of(compiled.linkage)
    method, stiff_method = map(method_named, methods)
    rules = CheckingRules(method, stiff_method, plan, margin, resolution, past_collisions)
    state_bytes = 3 * 8 * system.n_joints  # bytes of the angles, rates and accelerations of a state
    most = max_steps or MAX_DEPLOYMENT_STEPS[compiled.formulation]
    record = record_for(system.n_joints, min(most, max(1, MAX_MOTION_RECORD_BYTES // state_bytes)))
    findings = check_folding(_subject(compiled, panels), rules, record)
    check = _check(compiled, panels, findings, record)
    return CheckedMotion(check, motion_of_record(record, system, methods) if check.outcome == "flat" else None)


def _subject(compiled: CompiledScene, screen: CheckedPanels) -> SceneTables:
    mechanism, linkage, solids = compiled.system.mechanism, compiled.linkage, screen.solids
    return SceneTables(
        mechanism=mechanism,
        hold=discrete_state_for(mechanism, compiled.start),
        start=compiled.start,
        joint_of=compiled.joint_of,
        chain=linkage.chain,
        prisms=solids.prisms,
        shrunk=solids.shrunk,
        pairs=solids.pairs,
        max_margin=solids.max_margin,
        residual_lever=screen.reach,
    )


def _check(
    compiled: CompiledScene, panels: CheckedPanels, findings: CheckFindings, record: SimulationRecord
) -> DeploymentCheck:
    """Return the check of a scene with its findings."""
    collision = None
    if findings.verdict == MOTION_COLLIDES:
        prisms = panels.solids.pairs.prisms[findings.pair]
        first, second = sorted(compiled.linkage.pattern.panel_of[prism] for prism in prisms)
        collision = (findings.collision_time, (first, second))
    states, _, evaluations, *_ = map(int, record.counts)
    return DeploymentCheck(
        outcome=outcome_of(SIMULATION_STOPS[findings.ending]),
        end_time=findings.end_time,
        clear={MOTION_CLEAR: True, MOTION_COLLIDES: False}.get(findings.verdict),
        collision=collision,
        gap=finite_or_none(findings.gap),
        speed=findings.approach_speed,
        remaining=findings.angle_then,
        end_remaining=findings.angle_at_end,
        widest=math.pi * findings.widest,
        drift=findings.energy_drift,
        opening=findings.closure_residual,
        steps=states - 1,
        evaluations=evaluations,
        looks=findings.bounds,
        loose_share=findings.open_share,
        stiff_time=stiff_time(record),
    )
