"""Rows of the bench `dynamics`: one subject, formulation, engine, method and tolerance or step, before any impact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.accuracy.reference_motions import REFERENCES
from hcsearch.springs.dynamics.time_integration import Motion
from hcsearch_bench.peers import dense_system
from hcsearch_bench.peers.measured_runs import Comparison, our_motion
from hcsearch_bench.peers.multibody import Peer, peers
from hcsearch_bench.peers.states import Trajectory, closure, places
from hcsearch_bench.run.work_precision import MeasuredRow, UnableError, level_of
from hcsearch_bench.subjects.deployments import WHOLE, Case, DeploymentSubject

OUTPUTS = 100
"""Equal spaces between the times at which the error is taken: the coarsest step of engines with fixed steps."""
MAX_STEPS = {"constrained": 100_000, "penalty": 400_000, "quasistatic": 100_000, WHOLE: 100_000}
REFERENCE, REFERENCE_TOLERANCE = REFERENCES[0][0]
SEEN = 2_000
"""Most states of which the gap is taken."""
LEVELS = (("precise", 1e-8), ("high", 2e-5), ("low", 1e-2))
"""Verdicts by the greatest error of a hinge angle, rad; `high` is that of the goals."""


@dataclass(frozen=True, kw_only=True)
class CaseRow(MeasuredRow):
    """A run of a subject in a formulation.

    error : greatest of a hinge angle at all output times, rad. gap : greatest of loops, m.
    """

    subject: str
    formulation: str
    gap: float | None = None


@dataclass(frozen=True)
class ReferenceRow:
    """A reference solution, and how far others are from it.

    end : of the comparison, s. scipy_end, scipy_tolerance : of SciPy's run on dense matrices; apart : between both,
    rad. whole_apart : from the reference of the scene with nothing left out, rad. drift : of energy, J.
    """

    subject: str
    formulation: str
    end: float
    steps: int
    drift: float
    whole_apart: float | None
    scipy_tolerance: float | None
    scipy_end: float | None
    apart: float | None
    note: str = ""


@dataclass(frozen=True)
class Reference:
    """Fold angles (k, n_hinges) at times (k,), s."""

    times: Reals
    angles: Reals
    motion: Motion


def our_settings(quick: bool, formulation: str) -> dict[str, tuple[float, ...]]:
    """Methods and tolerances, the coarsest first; few where steps follow stiff springs, not the tolerance."""
    if formulation == "penalty":
        if quick:
            return {"bogacki-shampine": (1e-5,)}
        return {
            "bogacki-shampine": (1e-5, 1e-7),  # the first is the thesis's
            "dormand-prince": (1e-5, 1e-7),
            "dormand-prince-8": (1e-5, 1e-9),
            "implicit": (1e-5, 1e-7),
        }
    if quick:
        return {"bogacki-shampine": (1e-5,), "dormand-prince": (1e-4, 1e-6), "dormand-prince-8": (1e-9,)}
    return {
        "bogacki-shampine": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
        "dormand-prince": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
        "dormand-prince-8": (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11),
        "implicit": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    }


def scipy_peers(quick: bool) -> list[Peer]:
    """SciPy's solvers on accelerations from dense matrices."""
    tolerances = (1e-6,) if quick else (1e-4, 1e-6, 1e-8, 1e-10)
    return [
        Peer("SciPy", method, tolerances, partial(dense_system.run, method=method), by_tolerance=True)
        for method in (("DOP853",) if quick else ("RK45", "DOP853", "LSODA"))
    ]


def reference_of(case: Case) -> Reference:
    """The reference solution of a case: short steps, so that states between them are as precise."""
    times = np.linspace(0.0, case.end, OUTPUTS + 1)
    motion = our_motion(case, REFERENCE, REFERENCE_TOLERANCE, MAX_STEPS[case.formulation], longest=case.end / OUTPUTS)
    if motion.ending != "time":
        raise UnableError(f"no reference: {motion.ending} at {motion.times[-1]:.3g} s")
    return Reference(times, case.angles(motion.at(times)), motion)


def comparison_of(case: Case, reference: Reference) -> Comparison[CaseRow]:
    """What the hinge angles of a case are compared with."""

    def judged(row: CaseRow, q: Reals, motion: Motion | Trajectory) -> CaseRow:
        error = float(np.abs(case.angles(q) - reference.angles).max())
        return replace(row, verdict=level_of(error, LEVELS), error=error, gap=gap_of(case, motion.q))

    blank = partial(CaseRow, subject=case.subject, formulation=case.formulation)
    return Comparison(case, reference.times, MAX_STEPS[case.formulation], blank, judged, case.compiled.factor)


def our_rows(case: Case, reference: Reference, quick: bool, repeats: int, patience: float) -> Iterator[CaseRow]:
    """A row a method and tolerance."""
    return comparison_of(case, reference).our_rows(our_settings(quick, case.formulation), repeats, patience)


def subject_rows(
    subject: DeploymentSubject, quick: bool, repeats: int, patience: float
) -> tuple[list[CaseRow], list[ReferenceRow]]:
    """All rows of a subject."""
    end = subject.horizon("constrained")
    case, whole = subject.case("constrained", end), subject.case(WHOLE, end)
    reference = reference_of(case)
    rows = list(our_rows(case, reference, quick, repeats, patience))
    if left_out(case, whole):
        rows += our_rows(whole, reference, quick, repeats, patience)
    rows += our_rows(subject.case("penalty", end), reference, quick, 1, patience)
    beside = comparison_of(whole, reference)
    for peer in scipy_peers(quick):
        rows += beside.peer_rows(peer, 1, patience)
    for peer in peers(quick, OUTPUTS):
        if peer.fits(whole):
            rows += beside.peer_rows(peer, repeats, patience)
    slow = subject.case("quasistatic", subject.horizon("quasistatic"))
    slow_reference = reference_of(slow)
    rows += our_rows(slow, slow_reference, quick, repeats, patience)
    return rows, [
        compared(case, whole, reference, 1e-8 if quick else 1e-12),
        ReferenceRow(
            *(subject.name, slow.formulation, slow.end, slow_reference.motion.steps, slow_reference.motion.drift),
            *(None, None, None, None, "reference of its own"),
        ),
    ]


def left_out(case: Case, whole: Case) -> bool:
    """Whether the compiler left out joints or closure rows."""
    return len(case.system.joints) < len(whole.system.joints) or len(case.system.mechanism.tree.rows) < len(
        whole.system.mechanism.tree.rows
    )


def compared(case: Case, whole: Case, reference: Reference, tolerance: float) -> ReferenceRow:
    """The reference beside that of the whole array, and beside SciPy's tightest run on dense matrices."""
    apart = float(np.abs(reference_of(whole).angles - reference.angles).max())
    drift = case.compiled.factor * reference.motion.drift
    row = ReferenceRow(
        *(case.subject, case.formulation, case.end, reference.motion.steps, drift, apart, tolerance, None, None)
    )
    # dense evaluations of many panels are slow: the first half of the time where there are many
    part = OUTPUTS if whole.system.n_joints <= 20 else OUTPUTS // 2
    times = reference.times[: part + 1]
    try:
        motion = dense_system.run(whole.system, whole.q, whole.v, times, tolerance=tolerance)
    except UnableError as error:
        return replace(row, note=str(error))
    apart = float(np.abs(whole.angles(motion.q) - reference.angles[: part + 1]).max())
    return replace(row, scipy_end=float(times[-1]), apart=apart)


def gap_of(case: Case, q: Reals) -> float:
    """Greatest gap of the loops, m; of cut hinges, between the ends of their lines."""
    q = q[:: -(-len(q) // SEEN)]
    worst = closure(case.system, q)
    placed = places(case.system, q)
    for cut in case.system.cuts:
        for end in cut.ends:
            gap = placed.point(cut.second, end)[0] - placed.point(cut.first, end)[0]
            worst = max(worst, float(np.linalg.norm(gap, axis=1).max()))
    return worst


def seconds_at(rows: Sequence[CaseRow], error: float) -> float | None:
    """Seconds at which a method comes to an error: between two of its runs by powers, else of its fastest below.

    None where none of its runs is that precise.
    """
    points = sorted((row.error, row.seconds) for row in rows if row.error is not None and row.seconds is not None)
    below = [point for point in points if point[0] <= error]
    above = [point for point in points if point[0] > error]
    if not below:
        return None
    fine, slow = min(below, key=lambda point: point[1])
    faster = [point for point in above if point[1] < slow]
    if not faster:
        return slow
    coarse, fast = faster[0]
    share = np.log(error / fine) / np.log(coarse / fine)
    return float(slow * (fast / slow) ** share)
