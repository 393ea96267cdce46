"""The savings of the omissions of a compiled scene, and how little they change: each one is put back in turn.

The share of the work that all of them save is counted, without a simulation of what was left out.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from hcsearch.basics.vocabulary import Ending, Verdict
from hcsearch.springs.deployment.compiled_scene import CompiledScene, Omission, compile_scene
from hcsearch.springs.deployment.error_estimates import angle_distances, comparison_times, estimate_errors
from hcsearch.springs.deployment.simulated_deployment import Deployment, deployment_of_motion, simulate_compiled
from hcsearch.system.terminal import short_number

TIGHT_TOLERANCES = (1e-10, 1e-11)
"""Tolerances at which motions with and without an omission are compared, and their errors estimated."""
MAX_TIGHT_STEPS = 20_000
"""Greatest number of steps of these simulations."""
SAVING_REPEATS, QUICK_REPEATS, QUICK_SECONDS = 5, 15, 0.05
"""Number of runs with and without an omission, in turn, whose medians are taken; more where a run takes less than this
time (s)."""
EVERYTHING = "all"
"""Name of the row in which all omissions are put back together."""


@dataclass(frozen=True)
class OmissionSaving:
    """An omission, what it saves and what it changes; pairs are first with it put back, then without.

    joints, closure_equations, evaluations : of the simulations. milliseconds : processor time of simulation and
    certificate, medians. noise : sum of the median deviations from both medians, ms. outcomes, verdicts : of the
    deployments.
    difference : greatest distance of a fold angle between both, at the tightest of `TIGHT_TOLERANCES`, rad.
    bound : the sum of the estimated errors of both there, rad; all omissions are exact, so nothing else may differ.
    Both are None where these simulations do not end in `MAX_TIGHT_STEPS` steps.
    """

    omission: Omission
    joints: tuple[int, int]
    closure_equations: tuple[int, int]
    evaluations: tuple[int, int]
    milliseconds: tuple[float, float]
    noise: float
    outcomes: tuple[Ending, Ending]
    verdicts: tuple[Verdict, Verdict]
    difference: float | None
    bound: float | None

    @property
    def saved(self) -> float:
        """The time that the omission saves, ms."""
        return self.milliseconds[0] - self.milliseconds[1]

    @property
    def within(self) -> bool:
        """Whether the difference is within its bound, and the verdict is the same."""
        if self.verdicts[0] != self.verdicts[1]:
            return False
        return self.difference is None or self.bound is None or self.difference <= self.bound


def omission_savings(
    compiled: CompiledScene, *, method: str | None, tolerance: float, together: bool = False
) -> Iterator[OmissionSaving]:
    """Compare a compiled scene with each of its omissions put back; together : and with all of them put back, last.

    Without inertia no joint may be undamped, so that closure equations and the base are not put back there.
    """
    restored = [omission for omission in compiled.omissions if can_restore(compiled, omission.name)]
    without = _tight(compiled)
    for omission in restored:
        yield _saving(compiled, omission, frozenset({omission.name}), without, method, tolerance)
    if together and restored:
        names = frozenset(omission.name for omission in restored)
        every = Omission(EVERYTHING, "all of these", "each of them is exact")
        yield _saving(compiled, every, names, without, method, tolerance)


def can_restore(compiled: CompiledScene, name: str) -> bool:
    """Return whether an omission can be put back in the formulation of a scene."""
    return compiled.formulation != "quasistatic" or name not in {"closure", "base"}


def _saving(
    compiled: CompiledScene,
    omission: Omission,
    keep: frozenset[str],
    without: tuple[Deployment, ...],
    method: str | None,
    tolerance: float,
) -> OmissionSaving:
    full = compile_scene(compiled.linkage, compiled.setup, compiled.formulation, keep=keep)
    runs = [partial(_timed, scene, method, tolerance) for scene in (full, compiled)]
    kept, omitted = (run()[0] for run in runs)
    times: tuple[list[float], list[float]] = ([], [])
    while len(times[0]) < (QUICK_REPEATS if times[0][:1] < [QUICK_SECONDS] else SAVING_REPEATS):
        for run, taken in zip(runs, times, strict=True):  # in turn, so that both meet the same load of the machine
            taken.append(run()[1])
    difference, bound = _difference(_tight(full), without)
    return OmissionSaving(
        omission,
        (full.system.n_joints, compiled.system.n_joints),
        (full.system.n_equations, compiled.system.n_equations),
        (kept.motion.evaluations, omitted.motion.evaluations),
        (1e3 * statistics.median(times[0]), 1e3 * statistics.median(times[1])),
        1e3 * sum(map(_median_deviation, times)),
        (kept.outcome, omitted.outcome),
        (kept.verdict, omitted.verdict),
        difference,
        bound,
    )


def _median_deviation(values: list[float]) -> float:
    middle = statistics.median(values)
    return statistics.median(abs(value - middle) for value in values)


def _timed(compiled: CompiledScene, method: str | None, tolerance: float) -> tuple[Deployment, float]:
    """Return a deployment with its certificate, and their processor time, s."""
    begin = time.process_time()
    deployment = simulate_compiled(compiled, method=method, tolerance=tolerance, certified=False)
    certified = deployment_of_motion(compiled, deployment.motion)
    return certified, time.process_time() - begin


def _tight(compiled: CompiledScene) -> tuple[Deployment, ...]:
    """Simulate a scene at the tight tolerances, the loosest first."""
    run = partial(simulate_compiled, compiled, certified=False, max_steps=MAX_TIGHT_STEPS)
    return tuple(run(tolerance=tolerance) for tolerance in TIGHT_TOLERANCES)


def _difference(
    kept: tuple[Deployment, ...], omitted: tuple[Deployment, ...]
) -> tuple[float, float] | tuple[None, None]:
    """Return the greatest distance of a fold angle between two scenes, and the sum of their estimated errors, rad.

    Compared as long as both are reproducible.
    """
    estimates = [estimate_errors(pair, TIGHT_TOLERANCES[0]) for pair in (kept, omitted)]
    one, other = kept[-1], omitted[-1]
    if None in estimates or "out of steps" in {one.outcome, other.outcome}:
        return None, None
    partings = [estimate.reproducible_until for estimate in estimates if estimate is not None]
    ends = [float(motion.times[-1]) for motion in (one.motion, other.motion)]
    times = comparison_times(one.motion.times, min(*ends, *(end for end in partings if end is not None)))
    difference = float(angle_distances(one, other, times[:-1] if any(partings) else times).max(initial=0.0))
    return difference, sum(estimate.angle for estimate in estimates if estimate is not None)


def saving_facts(saving: OmissionSaving) -> dict[str, Any]:
    """Return a saving as plain data; pairs are first with the omission put back, then without."""
    return {
        "name": saving.omission.name,
        "joints": list(saving.joints),
        "closure_equations": list(saving.closure_equations),
        "evaluations": list(saving.evaluations),
        "milliseconds": list(saving.milliseconds),
        "noise_ms": saving.noise,
        "outcomes": list(saving.outcomes),
        "verdicts": list(saving.verdicts),
        "difference_rad": saving.difference,
        "bound_rad": saving.bound,
        "within": saving.within,
    }


def saving_sentence(facts: dict[str, Any]) -> str:
    """Return what an omission saves and changes, from the data of `saving_facts`, in one line."""
    names = ("joints", "closure_equations", "evaluations", "milliseconds")
    numbers = [f"{name.replace('_', ' ')} {' -> '.join(map(short_number, facts[name]))}" for name in names]
    if facts["difference_rad"] is None:
        change = "no difference measured: simulations at tight tolerances do not end"
    else:
        change = f"differs by {facts['difference_rad']:.1g} rad, errors {facts['bound_rad']:.1g} rad"
    if not facts["within"]:
        change += ": MORE THAN STATED" if facts["verdicts"][0] == facts["verdicts"][1] else ": ANOTHER VERDICT"
    return f"{', '.join(numbers)} (+- {short_number(facts['noise_ms'], 2)}); {change}"


LOOK_WORK = 1.8
"""Work of a comparison of two panels, in units of one joint or closure equation of an evaluation of the accelerations;
measured on foldings of hexagons, squares and triangles (docs/explanation/accuracy.md)."""
BASE_FREEDOMS = 6
"""Joints of a base that is put back, and equations that lock it."""
LOOP_EQUATIONS = 6
"""Closure equations of a loop with nothing left out, or of an open chain with a panel put back in halves."""


def saved_share(compiled: CompiledScene, evaluations: int, looks: int) -> float:
    """Return the share of the work that omissions save, 0 to 1, of the work with nothing left out.

    evaluations : of the accelerations; looks : pairs of panels that were compared. Both are taken to be as many per
    term with nothing left out. Processor time is saved in about this share; `hcsearch accuracy` measures it.
    """
    made = _work(evaluations, _terms(compiled), looks)
    whole = _work(evaluations, _all_terms(compiled), looks * _ratio_of_pairs(compiled))
    return 1.0 - made / whole if whole > 0.0 else 0.0


def _work(evaluations: int, terms: int, looks: float) -> float:
    return evaluations * terms + LOOK_WORK * looks


def _terms(compiled: CompiledScene) -> int:
    """Return the number of joints and closure equations."""
    return compiled.system.n_joints + compiled.system.n_equations


def _all_terms(compiled: CompiledScene) -> int:
    """Return the number of joints and closure equations with nothing left out.

    Panels in two halves close loops there, so that each hinge is a joint. Without inertia no base is put back.
    """
    n_loops, overdamped = len(compiled.linkage.loops), compiled.system.overdamped
    base = 0 if overdamped else BASE_FREEDOMS if compiled.setup.free else 2 * BASE_FREEDOMS
    if compiled.formulation == "penalty":  # springs close the loops
        return compiled.linkage.n_hinges - n_loops + base
    loops = n_loops or int(not overdamped)
    return compiled.linkage.n_hinges + LOOP_EQUATIONS * loops + base


def _ratio_of_pairs(compiled: CompiledScene) -> float:
    """Return the number of all pairs of panels over the number of pairs that are compared."""
    pairs = math.comb(compiled.linkage.n_panels, 2)
    return pairs / max(1, pairs - len(compiled.separated_pairs))
