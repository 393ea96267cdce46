"""The search for springs with which an array becomes flat and clear (thesis 4.4), free or from a catalogue.

The thesis starts at equal springs, follows gradients, and restarts at local minima. The objective jumps where one
collision replaces another, so here CMA-ES (Hansen 2016, the library `cma`) searches over the logarithms of the
stiffnesses, from equal springs first and then from random ones. Gradients are used where the objective is smooth: from
a set without collisions to the largest gap. On the 4x4 array of the thesis under gravity CMA-ES takes some hundred
evaluations, where SciPy's differential evolution takes several times as many, or finds nothing; descents from equal
springs end at collisions there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.tuning.evaluation import Evaluator, PartBounds
from hcsearch.system.terminal import short_number
from hcsearch.system.work_steps import Progress

GENERATION_SIZE, MAX_GENERATIONS = 16, 40
"""Sets of a generation of CMA-ES, and generations until it restarts."""
MAX_IDLE_GENERATIONS, MIN_OBJECTIVE_GAIN = 2, 0.01
"""Greatest number of generations without this gain in the objective, after the first flat and clear set."""
DISTINCT_STIFFNESS_SHARE = 0.05
"""Sets are distinct where a stiffness differs by more than this share."""
AMPLE_GAP_OBJECTIVE = -0.999
"""Objective at or below which the gap of a set is ample."""


def stiffnesses_of_groups(values: Sequence[float] | Reals, tied: Sequence[tuple[int, ...]]) -> Reals:
    """Return the stiffnesses of all hinges, or a table of parts, from tied groups, rounded to four digits."""
    stiffnesses = np.empty(sum(map(len, tied)))
    for value, hinges in zip(values, tied, strict=True):
        stiffnesses[list(hinges)] = float(f"{value:.4g}")
    return stiffnesses


def first_generation(start: Reals, tied: Sequence[tuple[int, ...]], seed: int, bounds: PartBounds) -> Reals:
    """Return logarithms, (GENERATION_SIZE, len(tied)): the start, and a Latin hypercube within the bounds."""
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many checks

    low, high = np.log(bounds)
    points = qmc.LatinHypercube(len(tied), rng=seed).random(GENERATION_SIZE)
    logarithms: Reals = low + (high - low) * points
    logarithms[0] = np.log([start[hinges[0]] for hinges in tied])
    return logarithms


class EvaluationsSpentError(Exception):
    """The budget of evaluations is spent."""


@dataclass(frozen=True, eq=False)
class SeenSpringSet(ByValue):
    """An evaluated spring set: logarithms of the tied groups' values, table of parts, check and objective."""

    point: Reals
    parts: Reals
    check: DeploymentCheck
    value: float


class SpringSearch:
    """The search for springs: CMA-ES with restarts until a set becomes flat and clear or the budget is spent."""

    def __init__(
        self,
        evaluator: Evaluator,
        tied: Sequence[tuple[int, ...]],
        budget: int,
        seed: int,
        progress: Progress,
        bounds: PartBounds,
    ) -> None:
        self.evaluator, self.tied, self.budget, self.seed, self.progress = evaluator, tied, budget, seed, progress
        self.spent = 0
        self.best: SeenSpringSet | None = None
        self.clear_sets: list[SeenSpringSet] = []
        self.success = False
        self._best_of_start: SeenSpringSet | None = None
        self.bounds = self.low, self.high = _logarithm(bounds[0]), _logarithm(bounds[1])

    def run(self, start: Reals, first: Reals) -> None:
        """Search until success, or until the budget of evaluations is spent."""
        try:
            self.values(first)
            number = 0
            while not self.success:
                self._run_start(number, first[0])
                number += 1
        except EvaluationsSpentError:
            pass

    def candidates(self) -> list[Reals]:
        """Return the distinct flat and clear sets, best first; if there are none, the best set of all."""
        distinct: list[Reals] = []
        for place in sorted(self.clear_sets, key=lambda place: place.value):
            if all(np.abs(np.log(place.parts / other)).max() > DISTINCT_STIFFNESS_SHARE for other in distinct):
                distinct.append(place.parts)
        return distinct or ([self.best.parts] if self.best else [])

    def values(self, points: Reals) -> Reals:
        """Return the objectives of points, (k, len(tied)), evaluated together; points are clipped to the bounds."""
        inside = np.clip(points[: self.budget - self.spent], self.low, self.high)
        if not len(inside):
            raise EvaluationsSpentError
        sets = [stiffnesses_of_groups(np.exp(point), self.tied) for point in inside]
        self.spent += len(sets)
        seen = [
            SeenSpringSet(point, parts, check, self.evaluator.value(check))
            for point, parts, check in zip(inside, sets, self.evaluator.of_springs(sets), strict=True)
        ]
        self.clear_sets += [place for place in seen if place.check.deploys]
        best = min(seen, key=lambda place: place.value)
        if self.best is None or best.value < self.best.value:
            self.best = best
        if self._best_of_start is None or best.value < self._best_of_start.value:
            self._best_of_start = best
        self.progress(self.spent, self.budget, check_summary(self.best.check))
        if len(inside) < len(points):
            raise EvaluationsSpentError
        return np.array([place.value for place in seen])

    def _run_start(self, number: int, start: Reals) -> None:
        """Run CMA-ES from one start, and from its best set, if flat and clear, descend to the largest gap."""
        rng = np.random.default_rng([self.seed, number])
        self._best_of_start = None
        n_clear = len(self.clear_sets)
        start_point = start if number == 0 else rng.uniform(self.low, self.high, len(self.tied))
        best = self._evolve(start_point, rng)
        if best.check.deploys:
            self.success = True
            self._descend(best.point)
            # the mean of the clear sets is further from those that are not
            self.values(np.mean([place.point for place in self.clear_sets[n_clear:]], axis=0)[None])

    def _evolve(self, start: Reals, rng: np.random.Generator) -> SeenSpringSet:
        """Run CMA-ES from one start, and return its best set."""
        strategy = strategy_from(start, 0.2, self.bounds, GENERATION_SIZE, rng)
        idle, least_value = 0, math.inf
        while not strategy.stop() and idle < MAX_IDLE_GENERATIONS:
            points = np.array(strategy.ask())
            values = self.values(points)
            strategy.tell(list(points), values.tolist())
            assert self._best_of_start is not None
            best = self._best_of_start
            if best.value <= AMPLE_GAP_OBJECTIVE:
                break
            if best.check.deploys:
                idle = 0 if best.value < least_value - MIN_OBJECTIVE_GAIN else idle + 1
                least_value = min(least_value, best.value)
        assert self._best_of_start is not None
        return self._best_of_start

    def _descend(self, point: Reals) -> None:
        """Take one step of L-BFGS-B with central differences, whose points are evaluated together."""
        from scipy.optimize import minimize  # noqa: PLC0415 - takes longer to load than many checks

        step = 0.02

        def value_and_slope(x: Reals) -> tuple[float, Reals]:
            steps = step * np.eye(len(x))
            values = self.values(np.vstack([x, x + steps, x - steps]))
            up, down = values[1 : len(x) + 1], values[len(x) + 1 :]
            return float(values[0]), (up - down) / (2.0 * step)

        low, high = (np.broadcast_to(bound, len(point)).tolist() for bound in self.bounds)
        bounds = list(zip(low, high, strict=True))
        options = {"maxiter": 1, "maxls": 2}
        minimize(value_and_slope, point, jac=True, method="L-BFGS-B", bounds=bounds, options=options)


def strategy_from(start: Reals, share: float, bounds: PartBounds, population: int, rng: np.random.Generator) -> Any:
    """Return a strategy of CMA-ES from a point; share : the initial step over the distance of the bounds."""
    import cma  # noqa: PLC0415 - takes seconds to load

    low, high = bounds
    of_each = isinstance(low, np.ndarray)
    options = {
        "bounds": [low, high],
        "popsize": population,
        "maxiter": MAX_GENERATIONS,
        "tolfun": 1e-3,
        "tolx": 1e-2,
        "verbose": -9,
        "randn": lambda *shape: rng.standard_normal(shape),  # else cma seeds NumPy's global generator
        "seed": math.nan,
        "CMA_stds": high - low if of_each else None,
    }
    return cma.CMAEvolutionStrategy(start, share if of_each else share * (high - low), options)


def _logarithm(bound: float | Reals) -> Any:
    """Return the logarithm of a bound of all groups, or of each."""
    return np.array([math.log(value) for value in bound]) if isinstance(bound, np.ndarray) else math.log(bound)


def check_summary(check: DeploymentCheck) -> str:
    """Describe a check in a few words."""
    if check.deploys:
        return "flat, clear" if check.gap is None else f"flat, clear by {short_number(1e3 * check.gap, 2)} mm"
    verdict = {True: "clear", False: "collides", None: "undecided"}[check.clear]
    return f"{check.outcome}, {verdict}"


CatalogueLevels = tuple[int, ...]

STIFFNESS_TOLERANCE = 1e-9
"""Relative tolerance of equal stiffnesses, as sums of decimals are rounded."""


def catalogue_levels(springs: Sequence[float], upper: float, softest: float = 0.0) -> tuple[float, ...]:
    """Return the stiffnesses (N m/rad) available at a hinge, rising: 0, each spring, and two in parallel, to a bound.

    softest : lower bound of tuned springs, for the remedy where the catalogue has a spring above the upper bound.
    """
    if not springs or not all(0.0 < spring < math.inf for spring in springs):
        raise HcsearchError("a catalogue has springs above 0 N m/rad: write --catalogue 0.07,0.10")
    stiffest = max(springs)
    if stiffest > upper * (1.0 + STIFFNESS_TOLERANCE):
        low = softest or stiffest / 200.0
        raise HcsearchError(
            f"the catalogue has a spring of {stiffest:g} N m/rad, and springs are tried up to {upper:g} N m/rad: add "
            f"--spring-range {low:g},{stiffest:g}, or leave that spring out"
        )
    return tuple(level for level in sorted(_made_of(springs)) if level <= upper * (1.0 + STIFFNESS_TOLERANCE))


def springs_for(stiffness: float, catalogue: Sequence[float]) -> tuple[float, ...]:
    """Return the fewest springs of a catalogue that give a level of `catalogue_levels` in parallel."""
    return next(
        springs
        for level, springs in _made_of(catalogue).items()
        if abs(level - stiffness) <= STIFFNESS_TOLERANCE * stiffness
    )


def _made_of(catalogue: Sequence[float]) -> dict[float, tuple[float, ...]]:
    """Return the fewest springs, up to two in parallel, for each stiffness that a catalogue gives."""
    stiffnesses = sorted(set(catalogue))
    springs_of: dict[float, tuple[float, ...]] = {0.0: ()}
    for springs in [*((one,) for one in stiffnesses), *combinations_with_replacement(stiffnesses, 2)]:
        level = springs[0] if len(springs) == 1 else round(sum(springs), 12)
        springs_of.setdefault(level, springs)
    return springs_of


def nearest_levels(stiffnesses: Sequence[float] | Reals, levels: Sequence[float]) -> CatalogueLevels:
    """Return the number of the level nearest to each stiffness."""
    return tuple(int(np.abs(np.array(levels) - value).argmin()) for value in stiffnesses)


def neighbouring_levels(chosen: CatalogueLevels, levels: Sequence[int]) -> list[CatalogueLevels]:
    """Return all sets that differ from a set at one group by one level; levels : how many each group has."""
    return [
        (*chosen[:k], level + step, *chosen[k + 1 :])
        for k, (level, count) in enumerate(zip(chosen, levels, strict=True))
        for step in (-1, 1)
        if 0 <= level + step < count
    ]


def descend_levels(
    starts: Sequence[CatalogueLevels],
    levels: Sequence[int],
    costs: Callable[[list[CatalogueLevels]], Sequence[float]],
    *,
    budget: int,
) -> dict[CatalogueLevels, float]:
    """Best-first search of neighbouring sets of levels; return the costs of all visited sets.

    Each step visits the neighbours of the best set that has not been expanded. The search ends when all visited sets
    are expanded, or when the budget of sets, 1 or more, is spent. levels : how many each group has.
    costs : function that returns the costs of some sets, evaluated together.
    """
    start_sets = list(dict.fromkeys(starts))[:budget]
    visited = dict(zip(start_sets, map(float, costs(start_sets)), strict=True))
    expanded: set[CatalogueLevels] = set()
    while len(visited) < budget:
        open_sets = [chosen for chosen in visited if chosen not in expanded]
        if not open_sets:
            break
        best = min(open_sets, key=lambda chosen: (visited[chosen], chosen))
        expanded.add(best)
        neighbours = [chosen for chosen in neighbouring_levels(best, levels) if chosen not in visited][
            : budget - len(visited)
        ]
        if neighbours:
            visited.update(zip(neighbours, map(float, costs(neighbours)), strict=True))
    return visited
