"""Check of a deployment in one call: it is simulated, and its motion searched for collisions.

Most motions that collide do so early. Where only clear motions matter, a motion is judged in parts, each a quarter as
long as all before it, and simulated no further once it collides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.collision.clearance_search import (
    MOTION_CLEAR,
    MOTION_COLLIDES,
    ClearanceReport,
    ClearanceTolerances,
    judge_clearance,
)
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.collision.least_gaps import angles_at, approach_speed
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import Chain
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms
from hcsearch.kernels.multibody.accelerations import DiscreteState, Mechanism
from hcsearch.kernels.multibody.endings import ENDING_FLAT, ENDING_NONE, ENDING_TIME_OUT
from hcsearch.kernels.multibody.events import (
    INTERPOLATED_STATE_RESIDUAL,
    StateSeries,
    largest_opening,
    open_state_share,
    refined_motion,
    step_openings,
)
from hcsearch.kernels.multibody.integrators import IntegrationMethod, is_implicit
from hcsearch.kernels.multibody.paused_simulation import Simulation, new_pace
from hcsearch.kernels.multibody.recording import SimulationRecord, stiff_time
from hcsearch.kernels.multibody.simulation import continue_simulation, start_simulation
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.tree import work_for

FIRST_PART_STEPS, PART_GROWTH_SHARE = 32, 0.25
"""Steps in the first part of a motion judged in parts, and in each later part as a share of all steps before it."""


class SceneTables(NamedTuple):
    """Tables of a folding in a scene.

    hold, start : (n_joints,), discrete state and coordinates at the start, at rest. joint_of : (n_hinges,), joint of
        each hinge. prisms, shrunk : the panels as they are and shrunk by the margin. pairs : that may collide.
    max_margin, residual_lever : m, margin at which a panel would vanish, and lever by which closure residuals
        (over size) are multiplied to bound the displacement of panels.
    """

    mechanism: Mechanism
    hold: DiscreteState
    start: Reals
    joint_of: WholeNumbers
    chain: Chain
    prisms: Prisms
    shrunk: Prisms
    pairs: PrismPairs
    max_margin: float
    residual_lever: float


class CheckingRules(NamedTuple):
    """Settings of the simulation and of the measurement of gaps.

    margin, resolution : m, see `ClearanceTolerances`. follow_collisions : whether a motion that collides is simulated
        to its end, too.
    """

    method: IntegrationMethod
    stiff_method: IntegrationMethod
    plan: StepPlan
    margin: float
    resolution: float
    follow_collisions: bool


class CheckFindings(NamedTuple):
    """Results of a check.

    ending : see `simulate_motion`; end_time : s. verdict : see `judge_clearance`. pair : that collides, at
        collision_time (s) and approach_speed (m/s, 0 in a clear motion).
    bounds : number of bounds of gaps. gap : smallest gap (m) of a motion that comes flat and clear, else infinite.
    angle_then, angle_at_end, widest : fold angles over pi: mean at the collision, or at the end of a clear motion; mean
        at the end; and greatest at the end.
    energy_drift : error of the energy balance, as a share of the largest energy. closure_residual : greatest.
        open_share : share of states with open loops, 0 where springs close them.
    """

    ending: int
    end_time: float
    verdict: int
    pair: int
    collision_time: float
    approach_speed: float
    bounds: int
    gap: float
    angle_then: float
    angle_at_end: float
    widest: float
    energy_drift: float
    closure_residual: float
    open_share: float


@compiled
def check_folding(subject: SceneTables, rules: CheckingRules, record: SimulationRecord) -> CheckFindings:
    """Simulate a folding, write the record, and search its motion for collisions."""
    mechanism, plan, method, stiff_method = subject.mechanism, rules.plan, rules.method, rules.stiff_method
    cubic = mechanism.closure_stiffness > 0.0  # with stiff springs, accelerations do not describe the motion
    tree, n = mechanism.tree, len(subject.start)
    work, q, v = work_for(tree), subject.start.copy(), np.zeros(n)
    simulation = Simulation(mechanism, subject.hold, method, stiff_method, plan, q, v, work, new_pace(n), record)
    report = ClearanceReport(np.zeros(1), np.zeros(1, np.int64), np.empty(1), np.zeros(1, np.int64))
    course = Course(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), cubic)
    max_states = len(record.times) + 1 if rules.follow_collisions else FIRST_PART_STEPS
    clear_states, verdict, bounds, residual = 0, MOTION_CLEAR, 0, 0.0
    start_simulation(simulation)
    while verdict != MOTION_COLLIDES and record.counts[4] == ENDING_NONE:
        continue_simulation(simulation, max_states)
        states, flat = record.counts[0], record.counts[4] == ENDING_FLAT
        clear_states = 0 if flat else clear_states  # a gap may dip across parts
        motion = _states(record, clear_states, states)
        if not cubic:
            since = 0.0 if is_implicit(method) else stiff_time(record)
            motion = refined_motion(mechanism, motion, INTERPOLATED_STATE_RESIDUAL, since, work)
        residual = max(residual, largest_opening(tree, motion, cubic, work))
        course = _course(subject, motion, cubic)
        openings = np.full(max(0, len(motion[0]) - 1), residual)
        if not cubic and residual > INTERPOLATED_STATE_RESIDUAL:
            openings = step_openings(tree, motion, False, INTERPOLATED_STATE_RESIDUAL, work)
        slacks = subject.residual_lever * openings
        tolerances = ClearanceTolerances(slacks, rules.margin, subject.max_margin, rules.resolution)
        verdict = judge_clearance(
            subject.chain, subject.prisms, subject.shrunk, subject.pairs, course, tolerances, flat, report
        )
        bounds += report.bound_counts[0]
        clear_states = states - 1 if verdict == MOTION_CLEAR else clear_states
        max_states = states + max(FIRST_PART_STEPS, int(PART_GROWTH_SHARE * states))
    open_share = 0.0 if cubic else open_state_share(tree, record.q[: record.counts[0]], work)
    return _findings(subject, course, verdict, report, record, bounds, residual, open_share)


@compiled
def _states(record: SimulationRecord, begin: int, end: int) -> StateSeries:
    return record.times[begin:end], record.q[begin:end], record.v[begin:end], record.a[begin:end]


@compiled
def _findings(
    subject: SceneTables,
    course: Course,
    verdict: int,
    report: ClearanceReport,
    record: SimulationRecord,
    bounds: int,
    residual: float,
    open_share: float,
) -> CheckFindings:
    """Return the findings, with the approach speed of colliding panels and the remaining fold angles."""
    states, pair, time, speed = record.counts[0], report.pairs[0], report.times[0], 0.0
    angles = course.angles[len(course.times) - 1].copy()
    at_end, widest = np.abs(angles).mean() / math.pi, np.abs(angles).max() / math.pi
    if verdict != MOTION_CLEAR and len(course.times) > 1:
        speed = approach_speed(subject.chain, subject.shrunk, subject.pairs, pair, course, time)
        angles_at(course, time, angles)
    return CheckFindings(
        ENDING_TIME_OUT if record.counts[4] == ENDING_NONE else record.counts[4],
        record.times[states - 1],
        verdict,
        pair,
        time,
        speed,
        bounds,
        report.gaps[0],
        np.abs(angles).mean() / math.pi,
        at_end,
        widest,
        _drift(record, states),
        residual,
        open_share,
    )


@compiled
def _course(subject: SceneTables, motion: StateSeries, cubic: bool) -> Course:
    """Return the course of the fold angles in a motion of the joints."""
    times, q, v, a = motion
    states, hinges = len(times), len(subject.joint_of)
    course = Course(times, np.empty((states, hinges)), np.empty((states, hinges)), np.empty((states, hinges)), cubic)
    for s in range(states):
        for k in range(hinges):
            joint = subject.joint_of[k]
            course.angles[s, k], course.rates[s, k], course.accelerations[s, k] = q[s, joint], v[s, joint], a[s, joint]
    return course


@compiled
def _drift(record: SimulationRecord, states: int) -> float:
    first = record.energies[0].sum()
    largest_error = 0.0
    largest_energy = 1e-300
    for k in range(states):
        largest_error = max(largest_error, abs(record.energies[k].sum() - first))
        largest_energy = max(largest_energy, np.abs(record.energies[k]).max())
    return largest_error / largest_energy
