"""Whole deployments, beyond the first impact, and the quick check of many designs."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hcsearch.bench.dynamics_subjects import SCENE, Case, Subject
from hcsearch.bench.dynamics_work import gap_of
from hcsearch.deployment.arrivals import arrivals
from hcsearch.deployment.compiling import compile_scene
from hcsearch.deployment.deploying import deploy, run
from hcsearch.deployment.subjects import folding_linkage

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hcsearch.folding import Folding

ORDER = 6
"""Arrivals that are told."""
QUICK_TOLERANCE = 1e-4


@dataclass(frozen=True)
class DeploymentRow:
    """A whole deployment with stops and damping.

    end : s, when flat or given up. first_arrival : s. arrivals : the first hinges that come to a stop, in order, with
        times in ms. energy : error of the balance, J. gap : greatest of loops, m. seconds : on the wall, one run.
    """

    subject: str
    formulation: str
    method: str
    tolerance: float
    outcome: str
    end: float
    first_arrival: float | None
    arrivals: str
    events: int
    energy: float
    gap: float
    steps: int
    seconds: float


@dataclass(frozen=True)
class QuickRow:
    """The quick check of all untwisted foldings of n cells: linkage, simulation at a tolerance of 1e-4, clearance.

    Milliseconds on the wall. simulation_ms, clearance_ms : medians of the parts; motions are followed
    to their first collision.
    """

    designs: str
    foldings: int
    median_ms: float
    tenth_ms: float
    worst_ms: float
    simulation_ms: float
    clearance_ms: float
    outcomes: str


def deployment_rows(subject: Subject, seconds: float) -> Iterator[DeploymentRow]:
    """With exact loops and hard stops, and by the thesis's springs and method; seconds : the longest, s."""
    for formulation, method, tolerance in (
        ("constrained", "dormand-prince", 1e-6),
        ("penalty", "bogacki-shampine", 1e-5),
    ):
        compiled = subject.compiled(formulation)
        compiled = replace(compiled, scene=replace(compiled.scene, seconds=seconds))
        warm = replace(compiled, scene=replace(compiled.scene, seconds=1e-6))
        run(warm, method=method, tolerance=tolerance, margin=None)
        found = run(compiled, method=method, tolerance=tolerance, margin=None)
        arrived = arrivals(found)
        yield DeploymentRow(
            *(subject.name, formulation, method, tolerance, found.outcome, float(found.motion.times[-1])),
            first_arrival=arrived[0].time if arrived else None,
            arrivals=" ".join(f"{'+'.join(map(str, a.hinges))}@{1e3 * a.time:.2f}" for a in arrived[:ORDER]),
            events=len(found.motion.events),
            energy=compiled.factor * found.motion.drift,
            gap=gap_of(Case(subject.name, formulation, compiled, seconds), found.motion.q),
            steps=found.motion.steps,
            seconds=found.seconds,
        )


def quick_row(name: str, designs: Sequence[Folding]) -> QuickRow:
    """The quick check of some foldings, the first one also to compile."""
    deploy(folding_linkage(designs[0]), SCENE, tolerance=QUICK_TOLERANCE)
    whole, simulation, clearance = [], [], []
    outcomes: Counter[str] = Counter()
    for folding in designs:
        begin = time.perf_counter()
        linkage = folding_linkage(folding)
        compiled = compile_scene(linkage, SCENE)
        built = time.perf_counter()
        found = run(compiled, tolerance=QUICK_TOLERANCE)
        end = time.perf_counter()
        whole.append(1e3 * (end - begin))
        simulation.append(1e3 * found.seconds)
        clearance.append(1e3 * (end - built - found.seconds))
        kind = "" if found.clearance is None or found.clearance.kind == "clear" else f", {found.clearance.kind}"
        outcomes[found.outcome + kind] += 1
    told = "; ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
    return QuickRow(
        *(name, len(designs), float(np.median(whole)), float(np.quantile(whole, 0.9)), max(whole)),
        *(float(np.median(simulation)), float(np.median(clearance)), told),
    )
