"""The first candidate of a tuning: the springs of the scene, equal ones as a rule, with more damping of all hinges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.setup import Setup
from hcsearch.springs.tuning.choice import SpringSet, spring_set_of, with_deployment, with_samples
from hcsearch.springs.tuning.evaluation import EvaluationMemory, Evaluator, damped_more
from hcsearch.springs.tuning.robustness import robustness_of_sets
from hcsearch.springs.tuning.tuning_options import TuningOptions
from hcsearch.system.work_steps import Progress

DAMPING_FACTORS = (1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0, 10.0)
"""Multiples of the damping that are tried: preferred numbers, series R10 of ISO 3."""
FACTOR_SAMPLES, MAX_FACTOR_CONFIRMATIONS = 8, 3
"""Samples by which the multiples that become flat and clear are compared, and greatest number of multiples that are
confirmed until no sample of one fails."""


@dataclass(frozen=True)
class DampedSprings:
    """The springs of a scene with more damping.

    factor : multiple of the damping of the scene. springs : with the scene of that damping. factors : the multiples
    tried, each by one quick simulation. samples, samples_recalled : number of simulations within the tolerances, and
    how many of them were known.
    """

    factor: float
    springs: SpringSet
    factors: tuple[float, ...]
    samples: int
    samples_recalled: int

    @property
    def sentence(self) -> str:
        """Where the springs are not confirmed, a sentence on it; empty where they are."""
        if self.springs.confirmed:
            return ""
        return f"none becomes flat, certified clear, with {self.factors[0]:g} to {self.factors[-1]:g} times the damping"


def damping_factors(setup: Setup, options: TuningOptions) -> tuple[float, ...]:
    """Return the multiples of the damping of a scene that options allow."""
    most, greatest = options.most_damping, max(setup.dampings, default=0.0)
    if options.damper_range is not None and greatest:
        most = min(most, options.damper_range[1] / greatest)
    return tuple(factor for factor in DAMPING_FACTORS if factor <= most and greatest)


def damped_springs(
    start: SpringSet,
    evaluator: Evaluator,
    setup: Setup,
    options: TuningOptions,
    memory: EvaluationMemory | None,
    progress: Progress,
) -> DampedSprings | None:
    """Return the springs of the start with the least damping that is as unlikely to fail as any other multiple.

    If none becomes flat, certified clear, the one with the least objective is returned; None where there is no damping
    to be multiplied, and without multiples. evaluator, setup : of the tuning.
    """
    factors = damping_factors(setup, options)
    if not factors:
        return None
    linkage, table = evaluator.linkage, np.array(start.stiffnesses)
    setups = [damped_more(setup, factor, linkage) for factor in factors]
    evaluators = [Evaluator(linkage, damped, evaluator.formulation, memory) for damped in setups]
    sets = []
    for k, (damped, own) in enumerate(zip(setups, evaluators, strict=True)):
        progress(k, len(factors), f"{factors[k]:g} times the damping")
        sets.append(spring_set_of(table, own.of_springs([table])[0], damped, own.scales, damped))
    for k in _in_order(sets, evaluators, table, options)[:MAX_FACTOR_CONFIRMATIONS]:
        progress(k, len(factors), f"confirming {factors[k]:g} times the damping")
        sets[k] = with_deployment(sets[k], evaluators[k], setups[k])
        if sets[k].confirmed:
            sets[k] = with_samples(sets[k], evaluators[k], options)
        if sets[k].suffices:
            break
    chosen = _least_likely_to_fail(sets)
    return DampedSprings(
        factors[chosen],
        sets[chosen],
        factors=factors,
        samples=sum(own.sample_count for own in evaluators),
        samples_recalled=sum(own.samples_recalled for own in evaluators),
    )


def _in_order(sets: list[SpringSet], evaluators: list[Evaluator], table: Reals, options: TuningOptions) -> list[int]:
    """Return the numbers of the sets that become flat and clear: the least damping, then sets with few failures."""
    deploying = [k for k, one in enumerate(sets) if one.check.deploys]
    count = min(options.samples, FACTOR_SAMPLES)
    if not count:
        return deploying
    chances = {k: robustness_of_sets(evaluators[k], [table], options.spread, count, options.seed) for k in deploying}
    return deploying[:1] + sorted(deploying[1:], key=lambda k: (chances[k][0].failures, k))


def _least_likely_to_fail(sets: list[SpringSet]) -> int:
    """Return the number of the confirmed set with the fewest failures, or of one of less damping that is as good.

    A set is as good if the interval of its share of failures overlaps that of the best one. If none is confirmed, the
    set with the least objective.
    """
    confirmed = [k for k, one in enumerate(sets) if one.suffices] or [k for k, one in enumerate(sets) if one.confirmed]
    confirmed = [k for k in confirmed if not sets[k].doubt] or confirmed
    if not confirmed:
        return min(range(len(sets)), key=lambda k: sets[k].value)
    chances = [(k, sets[k].robustness) for k in confirmed]
    most = min((chance.failure_interval[1] for _, chance in chances if chance is not None), default=1.0)
    return next(k for k, chance in chances if chance is None or chance.failure_interval[0] <= most)
