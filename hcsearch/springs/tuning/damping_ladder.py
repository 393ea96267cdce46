"""The first candidate of a tuning: the springs of the scene, equal ones as a rule, with more damping of all hinges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.setup import Setup
from hcsearch.springs.tuning.choice import SpringSet, spring_set_of, with_deployment, with_samples
from hcsearch.springs.tuning.evaluation import EvaluationMemory, Evaluator
from hcsearch.springs.tuning.part_sets import damped_more
from hcsearch.springs.tuning.robustness import robustness_of_sets
from hcsearch.springs.tuning.spring_search import TuningProgress
from hcsearch.springs.tuning.tuning_options import TuningOptions

DAMPING_FACTORS = (1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0, 10.0)
"""Multiples of the damping that are tried: preferred numbers, series R10 of ISO 3."""
FACTOR_SAMPLES, MAX_FACTOR_CONFIRMATIONS = 8, 3
"""Samples by which the multiples that become flat and clear are compared, and how many are confirmed at most, until no
sample of one fails."""


@dataclass(frozen=True)
class DampedSprings:
    """The springs of a scene with more damping.

    factor : multiple of the damping of the scene. springs : with the scene of that damping. factors : that were tried,
    each by one quick simulation. samples, samples_recalled : numbers of simulations within the tolerances, and of those
    that were known.
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
    progress: TuningProgress,
) -> DampedSprings | None:
    """Return the springs of the start with the damping that is least likely to fail, the least one of equal ones.

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
    order = [k for k in _in_order(sets, evaluators, table, options) if sets[k].check.deploys]
    chosen = min(range(len(sets)), key=lambda k: sets[k].value)
    for k in order[:MAX_FACTOR_CONFIRMATIONS]:
        progress(k, len(factors), f"confirming {factors[k]:g} times the damping")
        sets[k] = with_deployment(sets[k], evaluators[k], setups[k])
        if sets[k].confirmed:
            sets[k] = with_samples(sets[k], evaluators[k], options)
            chosen = min(chosen, k, key=lambda k: _risk(sets[k]))
        if sets[k].suffices:
            break
    return DampedSprings(
        factors[chosen],
        sets[chosen],
        factors=factors,
        samples=sum(own.sample_count for own in evaluators),
        samples_recalled=sum(own.samples_recalled for own in evaluators),
    )


def _risk(spring_set: SpringSet) -> tuple[bool, bool, int]:
    """Return the sort key of a set: confirmed ones first, at all tolerances, then by the number of failing samples."""
    failures = 0 if spring_set.robustness is None else spring_set.robustness.failures
    return not spring_set.confirmed, bool(spring_set.doubt), failures


def _in_order(sets: list[SpringSet], evaluators: list[Evaluator], table: Reals, options: TuningOptions) -> list[int]:
    """Return the numbers of sets, those with the fewest failing samples first, and of these the least damping."""
    count = min(options.samples, FACTOR_SAMPLES)
    failures = [0] * len(sets)
    for k, own in enumerate(evaluators):
        if count and sets[k].check.deploys:
            (chance,) = robustness_of_sets(own, [table], options.spread, count, options.seed)
            failures[k] = chance.failures
    return sorted(range(len(sets)), key=lambda k: (failures[k], k))
