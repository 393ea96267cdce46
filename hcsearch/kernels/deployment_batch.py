"""The quick check of many foldings in one call: each is simulated, and its motion searched for collisions.

Most motions that collide do so early. Where only clear ones are wanted, a motion is judged in parts, each half as
long as all before it, and one that collides is not followed further.
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
from hcsearch.kernels.multibody.events import (
    INTERPOLATED_STATE_RESIDUAL,
    StateSeries,
    largest_opening,
    open_state_share,
    refined_motion,
)
from hcsearch.kernels.multibody.hinges import Hinges, Struts, no_targets
from hcsearch.kernels.multibody.integrators import IntegrationMethod
from hcsearch.kernels.multibody.recording import SimulationRecord
from hcsearch.kernels.multibody.simulation import (
    ENDING_FLAT,
    ENDING_NONE,
    ENDING_TIME_OUT,
    Simulation,
    continue_simulation,
    new_pace,
    start_simulation,
)
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.tree import BodyTree, work_for
from hcsearch.kernels.multibody.welds import CutHinges

FIRST_PART_STEPS, PART_GROWTH_SHARE = 32, 0.25
"""Steps of the first part of a motion that is judged in parts, and of each after it as a share of those before."""


class SceneTables(NamedTuple):
    """One folding; in a stack every table has a leading axis, and every number is a table.

    start : (n_joints,), coordinates, at rest. joint_of : (n_hinges,). prisms, shrunk : of the panels, and with the
        margin taken off. pairs : that may collide. deepest, reach : m, the margin by which a panel
        would be gone, and what gaps of closure (over size) are multiplied by for what panels may be elsewhere.
    """

    tree: BodyTree
    hinges: Hinges
    start: Reals
    joint_of: WholeNumbers
    chain: Chain
    prisms: Prisms
    shrunk: Prisms
    pairs: PrismPairs
    deepest: float
    reach: float


class CheckingRules(NamedTuple):
    """What all foldings of a call share: how they are simulated, and how gaps are measured.

    struts, cuts : none of both, as tables of the right kind. margin, resolution : m, as of `ClearanceTolerances`.
    whole : whether motions that collide are followed to their end, too.
    """

    method: IntegrationMethod
    plan: StepPlan
    struts: Struts
    cuts: CutHinges
    closure_stiffness: float
    closure_damping: float
    margin: float
    resolution: float
    whole: bool


class CheckFindings(NamedTuple):
    """What became of k foldings.

    endings : (k,), as of `simulate`. verdicts : (k,), as of `judge`. pairs : (k,), that collide. counts : (k, 4),
        states, evaluations, rejected steps, gaps bounded. times : (k, 2), of the end, and of the collision (s).
    gaps : (k,), smallest (m), of those that come flat and clear, else infinite. speeds : (k,), at which the panels come
        together of those that are not clear, m/s. lefts : (k, 3), fold angles over pi: their mean then, or where it is
        clear at the end, their mean at the end, and the greatest at the end. drifts : (k,), of the energy balance, as a
        share of the largest energy. openings : (k,), greatest closure residual. looses : (k,), share of the states that
        leave loops open, 0 where springs close them.
    """

    endings: WholeNumbers
    verdicts: WholeNumbers
    pairs: WholeNumbers
    counts: WholeNumbers
    times: Reals
    gaps: Reals
    speeds: Reals
    lefts: Reals
    drifts: Reals
    openings: Reals
    looses: Reals


@compiled
def check_foldings(stack: Any, rules: CheckingRules, record: SimulationRecord, findings: CheckFindings) -> None:
    """Check the foldings of a stack one after the other; the record is written anew by each.

    numba compiles all that a kernel calls into it. So the large kernels are called from here: a kernel in between would
    take as long again to compile.
    """
    cubic = rules.closure_stiffness > 0.0  # stiff springs make accelerations that say nothing of the motion
    plan, method = rules.plan, rules.method
    answer = ClearanceReport(np.zeros(1), np.zeros(1, np.int64), np.empty(1), np.zeros(1, np.int64))
    for i in range(len(findings.endings)):
        subject = _nth(stack, i)
        tree, n = subject.tree, len(subject.start)
        mechanism, hold = _mechanism(subject, rules), _hold(subject)
        work, q, v = work_for(tree), subject.start.copy(), np.zeros(n)
        simulation = Simulation(mechanism, hold, method, plan, q, v, work, new_pace(n), record)
        course = Course(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), cubic)
        clear, most, verdict = 0, len(record.times) + 1 if rules.whole else FIRST_PART_STEPS, MOTION_CLEAR
        start_simulation(simulation)
        while verdict != MOTION_COLLIDES and record.counts[4] == ENDING_NONE:
            continue_simulation(simulation, most)
            states, flat = record.counts[0], record.counts[4] == ENDING_FLAT
            clear = 0 if flat else clear  # a gap may dip across parts
            motion = _states(record, clear, states)
            if not cubic:
                motion = refined_motion(mechanism, motion, INTERPOLATED_STATE_RESIDUAL, work)
            findings.openings[i] = max(findings.openings[i], largest_opening(tree, motion, cubic, work))
            course = _course(subject, motion, cubic)
            wanted = ClearanceTolerances(
                subject.reach * findings.openings[i], rules.margin, subject.deepest, rules.resolution
            )
            verdict = judge_clearance(
                subject.chain, subject.prisms, subject.shrunk, subject.pairs, course, wanted, flat, answer
            )
            findings.counts[i, 3] += answer.looks[0]
            clear = states - 1 if verdict == MOTION_CLEAR else clear
            most = states + max(FIRST_PART_STEPS, int(PART_GROWTH_SHARE * states))
        findings.looses[i] = 0.0 if cubic else open_state_share(tree, record.q[: record.counts[0]], work)
        _report(record, verdict, answer, findings, i)
        _report_end(subject, course, verdict, answer, findings, i)


@compiled
def _states(record: SimulationRecord, begin: int, end: int) -> StateSeries:
    return record.times[begin:end], record.q[begin:end], record.v[begin:end], record.a[begin:end]


@compiled
def _mechanism(subject: SceneTables, rules: CheckingRules) -> Mechanism:
    return Mechanism(
        subject.tree,
        subject.hinges,
        rules.struts,
        rules.cuts,
        np.zeros((0, 3)),
        rules.closure_stiffness,
        rules.closure_damping,
        False,
        no_targets(),
    )


@compiled
def _hold(subject: SceneTables) -> DiscreteState:
    """Nothing held, and each spring on its branch."""
    n = len(subject.start)
    hold = DiscreteState(np.zeros(n, np.int8), np.zeros(n, np.int8), np.zeros(0, np.int8))
    for k in range(n):
        hold.branches[k] = 1 if subject.start[k] > subject.hinges.snaps_up[k] else 0
    return hold


@compiled
def _report(record: SimulationRecord, verdict: int, answer: ClearanceReport, findings: CheckFindings, i: int) -> None:
    states = record.counts[0]
    findings.endings[i] = ENDING_TIME_OUT if record.counts[4] == ENDING_NONE else record.counts[4]
    findings.times[i, 0] = record.times[states - 1]
    findings.drifts[i] = _drift(record, states)
    findings.counts[i, 0], findings.counts[i, 1], findings.counts[i, 2] = states, record.counts[2], record.counts[3]
    findings.verdicts[i], findings.pairs[i], findings.times[i, 1] = verdict, answer.pairs[0], answer.times[0]
    findings.gaps[i] = answer.gaps[0]


@compiled
def _report_end(
    subject: SceneTables, course: Course, verdict: int, answer: ClearanceReport, findings: CheckFindings, i: int
) -> None:
    """Write how fast panels come together, and how much of the way is left."""
    angles = course.angles[len(course.times) - 1].copy()
    findings.lefts[i, 1], findings.lefts[i, 2] = np.abs(angles).mean() / math.pi, np.abs(angles).max() / math.pi
    findings.speeds[i] = 0.0
    if verdict != MOTION_CLEAR and len(course.times) > 1:
        pair, time = answer.pairs[0], answer.times[0]
        findings.speeds[i] = approach_speed(subject.chain, subject.shrunk, subject.pairs, pair, course, time)
        angles_at(course, time, angles)
    findings.lefts[i, 0] = np.abs(angles).mean() / math.pi


@compiled
def _course(subject: SceneTables, motion: StateSeries, cubic: bool) -> Course:
    """The motion of the fold angles."""
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
    first = record.books[0].sum()
    worst = 0.0
    largest = 1e-300
    for k in range(states):
        worst = max(worst, abs(record.books[k].sum() - first))
        largest = max(largest, np.abs(record.books[k]).max())
    return worst / largest


@compiled
def _nth(s: Any, i: int) -> SceneTables:
    """One subject of a stack, in which numbers are tables."""
    t, h, c, r, p = s.tree, s.hinges, s.chain, s.pairs, s.prisms
    return SceneTables(
        BodyTree(
            t.bodies[i],
            t.links[i],
            t.welds[i],
            t.weld_places[i],
            t.rows[i],
            t.slots[i],
            t.gravity[i],
            t.size[i],
        ),
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
        ),
        s.start[i],
        s.joint_of[i],
        Chain(c.directions[i], c.points[i], c.order[i], c.parents[i], c.hinges[i], c.signs[i]),
        _nth_prisms(p, i),
        _nth_prisms(s.shrunk, i),
        PrismPairs(r.prisms[i], r.hinges[i], r.nexts[i], r.reaches[i]),
        s.deepest[i],
        s.reach[i],
    )


@compiled
def _nth_prisms(p: Prisms, i: int) -> Prisms:
    return Prisms(p.panels[i], p.counts[i], p.vertices[i], p.middles[i], p.reaches[i], p.normals[i], p.edges[i])
