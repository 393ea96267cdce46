"""Whole deployments, beyond the first impact, and the quick check of many designs."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import (
    Arrival,
    Deployment,
    hinge_arrivals,
    simulate_compiled,
    simulate_deployment,
)
from hcsearch_bench.dynamics.case_rows import gap_of
from hcsearch_bench.subjects.deployments import SCENE, Case, DeploymentSubject

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hcsearch.designs.folding import Folding
    from hcsearch.scenes import Scene

ORDER, COMPARED = 6, 3
"""Arrivals that are shown, and those that must come at equal times."""
BOUNCE = 0.5
"""Restitution that is compared with the thesis's stops, springs of 1e6 N m/rad with dampers of 1 N m s/rad: from those
a hinge with the inertia of a panel comes back with about 0.4 of its speed, with that of several panels 0.8."""
STIFFER = 100.0
"""Springs at the cut hinge of the second `penalty`, times those of the thesis: it gives way a hundredth as far."""
LONG = 4_000_000
"""Steps that `penalty` may take."""
QUICK_TOLERANCE = 1e-4


@dataclass(frozen=True)
class DeploymentRow:
    """A whole deployment with stops and damping.

    cut : N/m, of the springs at a cut hinge. end : s, when flat or given up. arrivals : the first hinges that come to a
    stop, in order, with times in ms. apart : share of the time by which the first `COMPARED` of them come earlier or
    later than in the constrained deployment with stops that bounce. energy : error of the balance, J. gap : greatest
    of loops, m. seconds : on the wall, one run.
    """

    subject: str
    formulation: str
    method: str
    tolerance: float
    restitution: float | None
    cut: float | None
    outcome: str
    end: float
    arrivals: str
    apart: float | None
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


def deployment_rows(subject: DeploymentSubject, seconds: float, *, stiffer: bool) -> Iterator[DeploymentRow]:
    """With exact loops and hard stops that bounce or do not, and by the thesis's springs and method.

    seconds : the longest, s. stiffer : also by stiffer springs, which takes minutes.
    """
    bouncing = replace(SCENE, restitution=BOUNCE)
    ours = _deployed(subject, "constrained", bouncing, seconds)
    yield _row(subject, _deployed(subject, "constrained", SCENE, seconds), None)
    yield _row(subject, ours, None)
    yield _row(subject, _deployed(subject, "penalty", SCENE, seconds), ours)
    if stiffer:
        damping = math.sqrt(STIFFER) * SCENE.cut_damping
        scene = replace(SCENE, cut_stiffness=STIFFER * SCENE.cut_stiffness, cut_damping=damping)
        yield _row(subject, _deployed(subject, "penalty", scene, seconds), ours)


METHODS: dict[str, tuple[str, float]] = {"constrained": ("dormand-prince", 1e-6), "penalty": ("bogacki-shampine", 1e-5)}


def _deployed(subject: DeploymentSubject, formulation: str, scene: Scene, seconds: float) -> Deployment:
    """A deployment, once compiled."""
    method, tolerance = METHODS[formulation]
    compiled = subject.compiled(formulation, replace(scene, seconds=seconds))
    warm = replace(compiled, setup=replace(compiled.setup, seconds=1e-6))
    simulate_compiled(warm, method=method, tolerance=tolerance, certified=False)
    steps = LONG if formulation == "penalty" else None
    return simulate_compiled(compiled, method=method, tolerance=tolerance, certified=False, max_steps=steps)


def _row(subject: DeploymentSubject, deployment: Deployment, ours: Deployment | None) -> DeploymentRow:
    compiled, setup = deployment.compiled, deployment.compiled.setup
    springs = compiled.formulation == "penalty"
    arrived, names = hinge_arrivals(deployment), labels_of(compiled.linkage).hinges
    return DeploymentRow(
        *(subject.name, compiled.formulation, *METHODS[compiled.formulation]),
        *(None if springs else setup.restitution, setup.cut_stiffness if springs else None),
        *(deployment.outcome, float(deployment.motion.times[-1])),
        arrivals=" ".join(f"{'+'.join(names[k] for k in a.hinges)}@{1e3 * a.time:.2f}" for a in arrived[:ORDER]),
        apart=None if ours is None else arrivals_apart(hinge_arrivals(ours), arrived),
        events=len(deployment.motion.events),
        energy=compiled.factor * deployment.motion.drift,
        gap=gap_of(Case(subject.name, compiled.formulation, compiled, compiled.seconds), deployment.motion.q),
        steps=deployment.motion.steps,
        seconds=deployment.seconds,
    )


def arrivals_apart(ours: Sequence[Arrival], theirs: Sequence[Arrival]) -> float | None:
    """Greatest share of the time by which the first of our arrivals come at other times elsewhere; None without."""
    shares = []
    for arrival in ours[:COMPARED]:
        own = [other for other in theirs if other.stop == arrival.stop and set(other.hinges) >= set(arrival.hinges)]
        if not own:
            return None
        shares.append(min(abs(other.time - arrival.time) for other in own) / arrival.time)
    return max(shares, default=None)


def quick_row(name: str, designs: Sequence[Folding]) -> QuickRow:
    """The quick check of some foldings, the first one also to compile."""
    simulate_deployment(designs[0].linkage(), SCENE, tolerance=QUICK_TOLERANCE)
    whole, simulation, clearance = [], [], []
    outcomes: Counter[str] = Counter()
    for folding in designs:
        begin = time.perf_counter()
        linkage = folding.linkage()
        compiled = compile_scene(linkage, SCENE)
        built = time.perf_counter()
        deployment = simulate_compiled(compiled, tolerance=QUICK_TOLERANCE)
        end = time.perf_counter()
        whole.append(1e3 * (end - begin))
        simulation.append(1e3 * deployment.seconds)
        clearance.append(1e3 * (end - built - deployment.seconds))
        kind = (
            ""
            if deployment.clearance is None or deployment.clearance.kind == "clear"
            else f", {deployment.clearance.kind}"
        )
        outcomes[deployment.outcome + kind] += 1
    summary = "; ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
    return QuickRow(
        *(name, len(designs), float(np.median(whole)), float(np.quantile(whole, 0.9)), max(whole)),
        *(float(np.median(simulation)), float(np.median(clearance)), summary),
    )
