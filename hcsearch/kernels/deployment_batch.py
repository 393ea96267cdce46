"""Batch check of many foldings in one call: simulate each, and search its motion for collisions.

Most motions that collide do so early. Where only clear motions matter, a motion is judged in parts, each a quarter as
long as all before it, and simulated no further once it collides.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

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
from hcsearch.kernels.multibody.drag import Drag
from hcsearch.kernels.multibody.endings import ENDING_FLAT, ENDING_NONE, ENDING_TIME_OUT
from hcsearch.kernels.multibody.events import (
    INTERPOLATED_STATE_RESIDUAL,
    StateSeries,
    largest_opening,
    open_state_share,
    refined_motion,
    step_openings,
)
from hcsearch.kernels.multibody.hinges import Hinges, Struts, no_targets
from hcsearch.kernels.multibody.integrators import IntegrationMethod
from hcsearch.kernels.multibody.paused_simulation import Simulation, new_pace
from hcsearch.kernels.multibody.recording import SimulationRecord
from hcsearch.kernels.multibody.simulation import continue_simulation, start_simulation
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.tree import BodyTree, work_for
from hcsearch.kernels.multibody.welds import CutHinges

FIRST_PART_STEPS, PART_GROWTH_SHARE = 32, 0.25
"""Steps in the first part of a motion judged in parts, and in each later part as a share of all steps before it."""


class SceneTables(NamedTuple):
    """Tables of one folding; in a stack every table has a leading axis, and every number is a table.

    start : (n_joints,), coordinates, at rest. joint_of : (n_hinges,), joint of each hinge. prisms, shrunk : of the
        panels, as they are and shrunk by the margin. pairs : that may collide.
    max_margin, residual_lever : m, margin at which a panel would vanish, and lever by which closure residuals
        (over size) are multiplied to bound the displacement of panels.
    """

    tree: BodyTree
    hinges: Hinges
    drag: Drag
    start: Reals
    joint_of: WholeNumbers
    chain: Chain
    prisms: Prisms
    shrunk: Prisms
    pairs: PrismPairs
    max_margin: float
    residual_lever: float


class CheckingRules(NamedTuple):
    """Settings shared by all foldings of a call: of the simulation, and of the measurement of gaps.

    struts, cuts : empty tables of the right type. margin, resolution : m, as of `ClearanceTolerances`.
    follow_collisions : whether motions that collide are simulated to their end, too.
    """

    method: IntegrationMethod
    stiff_method: IntegrationMethod
    plan: StepPlan
    struts: Struts
    cuts: CutHinges
    closure_stiffness: float
    closure_damping: float
    margin: float
    resolution: float
    follow_collisions: bool


class CheckFindings(NamedTuple):
    """Results of the checks of k foldings.

    endings : (k,), as of `simulate_motion`. stiff_times : (k,), s, from which on steps are those of the stiff method;
        infinite where none is. verdicts : (k,), as of `judge_clearance`. pairs : (k,), that collide.
    counts : (k, 4), states, evaluations, rejected steps, bounds of gaps. times : (k, 2), of the end, and of the
        collision (s). gaps : (k,), smallest gap (m) of motions that come flat and clear, else infinite.
    speeds : (k,), approach speed of the colliding panels, 0 in clear motions, m/s.
    remaining_angles : (k, 3), fold angles over pi: mean at the collision (at the end of clear motions), mean at the
        end, and greatest at the end.
    energy_drifts : (k,), error of the energy balance, as a share of the largest energy. closure_residuals : (k,),
        greatest. open_state_shares : (k,), share of states with open loops, 0 where springs close them.
    """

    endings: WholeNumbers
    stiff_times: Reals
    verdicts: WholeNumbers
    pairs: WholeNumbers
    counts: WholeNumbers
    times: Reals
    gaps: Reals
    speeds: Reals
    remaining_angles: Reals
    energy_drifts: Reals
    closure_residuals: Reals
    open_state_shares: Reals


@compiled
def check_foldings(stack: Any, rules: CheckingRules, record: SimulationRecord, findings: CheckFindings) -> None:
    """Check the foldings of a stack one after the other; each overwrites the record."""
    for i in range(len(findings.endings)):
        _check_folding(_tables_at(stack, i), rules, record, findings, i)


@compiled
def _check_folding(
    subject: SceneTables, rules: CheckingRules, record: SimulationRecord, findings: CheckFindings, i: int
) -> None:
    cubic = rules.closure_stiffness > 0.0  # with stiff springs, accelerations do not describe the motion
    plan, method, stiff_method = rules.plan, rules.method, rules.stiff_method
    implicit = method.diagonal > 0.0 or method.extrapolation_order > 0
    report = ClearanceReport(np.zeros(1), np.zeros(1, np.int64), np.empty(1), np.zeros(1, np.int64))
    tree, n = subject.tree, len(subject.start)
    mechanism = Mechanism(
        tree,
        subject.hinges,
        rules.struts,
        rules.cuts,
        np.zeros((0, 3)),
        rules.closure_stiffness,
        rules.closure_damping,
        False,
        no_targets(),
        subject.drag,
    )
    hold = _hold(subject)
    work, q, v = work_for(tree), subject.start.copy(), np.zeros(n)
    simulation = Simulation(mechanism, hold, method, stiff_method, plan, q, v, work, new_pace(n), record)
    course = Course(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), cubic)
    max_states = len(record.times) + 1 if rules.follow_collisions else FIRST_PART_STEPS
    clear_states, verdict = 0, MOTION_CLEAR
    start_simulation(simulation)
    while verdict != MOTION_COLLIDES and record.counts[4] == ENDING_NONE:
        continue_simulation(simulation, max_states)
        states, flat = record.counts[0], record.counts[4] == ENDING_FLAT
        clear_states = 0 if flat else clear_states  # a gap may dip across parts
        motion = _states(record, clear_states, states)
        if not cubic:
            implicit_time = 0.0 if implicit else _stiff_time(record)
            motion = refined_motion(mechanism, motion, INTERPOLATED_STATE_RESIDUAL, implicit_time, work)
        residual = max(findings.closure_residuals[i], largest_opening(tree, motion, cubic, work))
        findings.closure_residuals[i] = residual
        course = _course(subject, motion, cubic)
        openings = np.full(max(0, len(motion[0]) - 1), residual)
        if not cubic and residual > INTERPOLATED_STATE_RESIDUAL:
            openings = step_openings(tree, motion, False, INTERPOLATED_STATE_RESIDUAL, work)
        slacks = subject.residual_lever * openings
        tolerances = ClearanceTolerances(slacks, rules.margin, subject.max_margin, rules.resolution)
        verdict = judge_clearance(
            subject.chain, subject.prisms, subject.shrunk, subject.pairs, course, tolerances, flat, report
        )
        findings.counts[i, 3] += report.bound_counts[0]
        clear_states = states - 1 if verdict == MOTION_CLEAR else clear_states
        max_states = states + max(FIRST_PART_STEPS, int(PART_GROWTH_SHARE * states))
    findings.open_state_shares[i] = 0.0 if cubic else open_state_share(tree, record.q[: record.counts[0]], work)
    _report(record, verdict, report, findings, i)
    _report_end(subject, course, verdict, report, findings, i)


@compiled
def _states(record: SimulationRecord, begin: int, end: int) -> StateSeries:
    return record.times[begin:end], record.q[begin:end], record.v[begin:end], record.a[begin:end]


@compiled
def _stiff_time(record: SimulationRecord) -> float:
    """Return the time from which steps are those of the stiff method, s; infinite where none is."""
    return math.inf if record.counts[5] < 0 else record.times[max(0, record.counts[5] - 1)]


@compiled
def _hold(subject: SceneTables) -> DiscreteState:
    """Return the discrete state at the start: no joint held, each spring on its branch."""
    n = len(subject.start)
    slides = np.zeros(len(subject.hinges.friction), np.int8)
    hold = DiscreteState(np.zeros(n, np.int8), np.zeros(n, np.int8), np.zeros(0, np.int8), slides)
    for k in range(n):
        hold.branches[k] = 1 if subject.start[k] > subject.hinges.snaps_up[k] else 0
    return hold


@compiled
def _report(record: SimulationRecord, verdict: int, report: ClearanceReport, findings: CheckFindings, i: int) -> None:
    states = record.counts[0]
    findings.endings[i] = ENDING_TIME_OUT if record.counts[4] == ENDING_NONE else record.counts[4]
    findings.times[i, 0] = record.times[states - 1]
    findings.stiff_times[i] = _stiff_time(record)
    findings.energy_drifts[i] = _drift(record, states)
    findings.counts[i, 0], findings.counts[i, 1], findings.counts[i, 2] = states, record.counts[2], record.counts[3]
    findings.verdicts[i], findings.pairs[i], findings.times[i, 1] = verdict, report.pairs[0], report.times[0]
    findings.gaps[i] = report.gaps[0]


@compiled
def _report_end(
    subject: SceneTables, course: Course, verdict: int, report: ClearanceReport, findings: CheckFindings, i: int
) -> None:
    """Write the approach speed of colliding panels, and the remaining fold angles."""
    angles = course.angles[len(course.times) - 1].copy()
    findings.remaining_angles[i, 1] = np.abs(angles).mean() / math.pi
    findings.remaining_angles[i, 2] = np.abs(angles).max() / math.pi
    findings.speeds[i] = 0.0
    if verdict != MOTION_CLEAR and len(course.times) > 1:
        pair, time = report.pairs[0], report.times[0]
        findings.speeds[i] = approach_speed(subject.chain, subject.shrunk, subject.pairs, pair, course, time)
        angles_at(course, time, angles)
    findings.remaining_angles[i, 0] = np.abs(angles).mean() / math.pi


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


@compiled
def _tables_at(stack: Any, i: int) -> SceneTables:
    """Return the tables of the i-th folding of a stack, in which numbers are tables."""
    t, h, d, c, r, p = stack.tree, stack.hinges, stack.drag, stack.chain, stack.pairs, stack.prisms
    return SceneTables(
        BodyTree(t.bodies[i], t.links[i], t.welds[i], t.weld_places[i], t.rows[i], t.slots[i], t.gravity[i], t.size[i]),
        Hinges(
            h.pieces[i],
            h.breaks[i],
            h.cubics[i],
            h.energies[i],
            h.snaps_up[i],
            h.snaps_down[i],
            h.damping[i],
            h.lower[i],
            h.upper[i],
            h.stop_stiffness[i],
            h.stop_damping[i],
            h.friction[i],
            h.ramps[i],
            h.factors[i],
        ),
        Drag(d.bodies[i], d.pieces[i], d.normals[i], d.points[i]),
        stack.start[i],
        stack.joint_of[i],
        Chain(c.directions[i], c.points[i], c.order[i], c.parents[i], c.hinges[i], c.signs[i]),
        _prisms_at(p, i),
        _prisms_at(stack.shrunk, i),
        PrismPairs(r.prisms[i], r.hinges[i], r.nexts[i], r.reaches[i]),
        stack.max_margin[i],
        stack.residual_lever[i],
    )


@compiled
def _prisms_at(p: Prisms, i: int) -> Prisms:
    return Prisms(p.panels[i], p.counts[i], p.vertices[i], p.middles[i], p.reaches[i], p.normals[i], p.edges[i])
