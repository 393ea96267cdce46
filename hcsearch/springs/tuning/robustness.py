"""Robustness of a deployment: samples of the scene within its tolerances, and the probability of a collision."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.setup import Setup, with_stiffnesses
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.deployment.spring_sets import stiffnesses_of
from hcsearch.springs.tuning.evaluation import Evaluator, with_parts
from hcsearch.springs.tuning.tuning_options import Spread

ROBUSTNESS_CONFIDENCE = 0.95


@dataclass(frozen=True)
class Robustness:
    """Counts of random samples by their outcome.

    samples : number of samples. collisions : samples that collide, or for which that is undecided. failures : samples
        that do not become flat and clear.
    """

    samples: int
    collisions: int
    failures: int

    @property
    def probability(self) -> float:
        """Share of samples that collide."""
        return self.collisions / self.samples

    @cached_property
    def interval(self) -> tuple[float, float]:
        """Clopper and Pearson's interval (1934) of the probability of collision, at `ROBUSTNESS_CONFIDENCE`."""
        return _interval(self.collisions, self.samples)

    @cached_property
    def failure_interval(self) -> tuple[float, float]:
        """The same interval of the probability of not becoming flat and clear."""
        return _interval(self.failures, self.samples)


def _interval(count: int, samples: int) -> tuple[float, float]:
    from scipy.stats import binomtest  # noqa: PLC0415 - takes longer to load than a check

    ends = binomtest(count, samples).proportion_ci(ROBUSTNESS_CONFIDENCE, method="exact")
    return float(ends.low), float(ends.high)


def sampled_setups(
    setup: Setup, parts: Sequence[float] | Reals, spread: Spread, samples: int, seed: int
) -> list[Setup]:
    """Draw samples of a setup with the springs and dampers of a table within the tolerances, determined by the seed.

    Relative deviations are lognormal, so that no value is negative; values of 0 stay 0. With the same seed the samples
    of two spring sets have the same deviations, so that few samples show which set is better.
    """
    rng = np.random.default_rng(seed)
    setup = with_parts(setup, parts)
    base = stiffnesses_of(setup)
    setups = []
    for _ in range(samples):
        # not by np.exp, whose last bits depend on the processor
        springs = base * [math.exp(deviation) for deviation in spread.stiffness * rng.standard_normal(len(base))]
        damping, mass = map(math.exp, [spread.damping, spread.mass] * rng.standard_normal(2))
        start = setup.start - spread.start * abs(rng.standard_normal())
        changed = replace(
            setup,
            density=setup.density * mass,
            damping_time=tuple(time * damping for time in setup.damping_time),
            damping=tuple(own * damping for own in setup.damping),
            start=float(start),
        )
        setups.append(with_stiffnesses(changed, springs))
    return setups


def robustness_of_sets(
    evaluator: Evaluator, sets: Sequence[Sequence[float] | Reals], spread: Spread, samples: int, seed: int
) -> list[Robustness]:
    """Return the robustness of spring sets in the evaluator's scene, from random samples evaluated together."""
    setups = [setup for parts in sets for setup in sampled_setups(evaluator.setup, parts, spread, samples, seed)]
    checks = evaluator.of_setups(setups)
    return [robustness_of_checks(checks[k : k + samples]) for k in range(0, len(checks), samples)]


def most_robust(
    evaluator: Evaluator,
    sets: Sequence[Sequence[float] | Reals],
    spread: Spread,
    stages: Sequence[tuple[int, int]],
    seed: int,
) -> list[tuple[int, Robustness]]:
    """Return the numbers and the robustness of the sets with the fewest failures, best first; ties in the order given.

    stages : numbers of sets and of samples of each, fewer sets and more samples each time: a few samples exclude most.
    """
    remaining = list(range(len(sets)))
    robustness: dict[int, Robustness] = {}
    for count, samples in stages:
        remaining = remaining[:count]
        robustness = dict(
            zip(
                remaining,
                robustness_of_sets(evaluator, [sets[k] for k in remaining], spread, samples, seed),
                strict=True,
            )
        )
        remaining = sorted(remaining, key=lambda k, of=robustness: (of[k].failures, k))  # type: ignore[misc]
    return [(k, robustness[k]) for k in remaining]


def robustness_of_checks(checks: Sequence[DeploymentCheck]) -> Robustness:
    """Count the outcomes of samples."""
    collisions = sum(check.clear is not True for check in checks)
    return Robustness(len(checks), collisions, sum(not check.deploys for check in checks))
