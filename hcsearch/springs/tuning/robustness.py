"""How sure a deployment is: samples of the scene within its tolerances, and the probability of a collision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.setup import Setup, with_stiffnesses
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.tuning.evaluation import Evaluator

ROBUSTNESS_CONFIDENCE = 0.95


@dataclass(frozen=True)
class Spread:
    """Tolerances of what is built: standard deviations, relative but for the start.

    stiffness : of each spring on its own. damping, mass : of all dampers, of all panels. start : of the share of the
        folded angles at which it starts, only ever less folded.
    """

    stiffness: float = 0.05
    damping: float = 0.05
    mass: float = 0.05
    start: float = 0.001


SPREAD_NAMES = tuple(field.name for field in fields(Spread))


@dataclass(frozen=True)
class Robustness:
    """What became of random samples.

    samples : how many there were. collisions : those that collided, or of which that is undecided. failures : those
        that did not come flat and clear.
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
        """The same of the probability that it does not come flat and clear."""
        return _interval(self.failures, self.samples)


def _interval(count: int, samples: int) -> tuple[float, float]:
    from scipy.stats import binomtest  # noqa: PLC0415 - takes longer to load than a check

    ends = binomtest(count, samples).proportion_ci(ROBUSTNESS_CONFIDENCE, method="exact")
    return float(ends.low), float(ends.high)


def sampled_setups(
    setup: Setup, stiffnesses: Sequence[float] | Reals, spread: Spread, samples: int, seed: int
) -> list[Setup]:
    """Setups within the tolerances of one, the same for the same seed.

    Relative values are lognormal, so that none is negative; what is 0 stays 0. Where samples of two spring sets have
    one seed, they differ from their middle alike, so that few samples show which is better.
    """
    rng = np.random.default_rng(seed)
    base = np.asarray(stiffnesses, float)
    setups = []
    for _ in range(samples):
        springs = base * np.exp(spread.stiffness * rng.standard_normal(len(base)))
        damping, mass = np.exp([spread.damping, spread.mass] * rng.standard_normal(2))
        start = setup.start - spread.start * abs(rng.standard_normal())
        changed = replace(
            setup,
            density=setup.density * float(mass),
            damping_time=setup.damping_time * float(damping),
            damping=setup.damping * float(damping),
            start=float(start),
        )
        setups.append(with_stiffnesses(changed, springs))
    return setups


def robustness_of_sets(
    evaluator: Evaluator, sets: Sequence[Sequence[float] | Reals], spread: Spread, samples: int, seed: int
) -> list[Robustness]:
    """The probability of collision of spring sets in the evaluator's scene, from random samples, all in one call."""
    setups = [setup for one in sets for setup in sampled_setups(evaluator.setup, one, spread, samples, seed)]
    checks = evaluator.of_setups(setups)
    return [robustness_of_checks(checks[k : k + samples]) for k in range(0, len(checks), samples)]


def most_robust(
    evaluator: Evaluator,
    sets: Sequence[Sequence[float] | Reals],
    spread: Spread,
    stages: Sequence[tuple[int, int]],
    seed: int,
) -> list[tuple[int, Robustness]]:
    """Numbers of the sets that fail least, the best first, with their samples; of equal ones those given first.

    stages : how many sets get how many samples, fewer sets and more samples each time: most sets are out after a few.
    """
    left = list(range(len(sets)))
    chances: dict[int, Robustness] = {}
    for kept, samples in stages:
        left = left[:kept]
        chances = dict(
            zip(left, robustness_of_sets(evaluator, [sets[k] for k in left], spread, samples, seed), strict=True)
        )
        left = sorted(left, key=lambda k, of=chances: (of[k].failures, k))  # type: ignore[misc]
    return [(k, chances[k]) for k in left]


def robustness_of_checks(checks: Sequence[DeploymentCheck]) -> Robustness:
    """Samples counted by what became of them."""
    collisions = sum(check.clear is not True for check in checks)
    return Robustness(len(checks), collisions, sum(not check.deploys for check in checks))
