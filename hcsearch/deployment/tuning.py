"""Stiffnesses of springs for a deployment that comes flat without a collision (thesis 4.4).

The thesis starts at equal springs and follows gradients; from where they lead nowhere it starts anew. The objective has
jumps where one collision takes the place of another, so here CMA-ES (Hansen 2016, the library `cma`) searches over
the logarithms of the stiffnesses, from equal springs first and then from random ones, and gradients serve where the
objective is smooth: up to the largest gap from where there is no collision. On the 4x4 array of the thesis under
gravity CMA-ES takes some hundred evaluations, where SciPy's differential evolution takes several times as many, or
finds nothing; descents from equal springs end at collisions there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.deployment.catalogue import Levels, catalogue_levels, descend, nearest_levels
from hcsearch.deployment.checking import Check
from hcsearch.deployment.compiling import Formulation
from hcsearch.deployment.deploying import Deployment, deploy
from hcsearch.deployment.evaluating import STRICT, Evaluator, Memory
from hcsearch.deployment.objective import objective
from hcsearch.deployment.robustness import Robustness, Spread, most_robust, robustness, sampled
from hcsearch.deployment.springs import SOFTEST, STIFFEST, scene_springs, stiffnesses_of, tied_hinges
from hcsearch.linkage import Linkage
from hcsearch.scenes import Scene

Reals = NDArray[np.float64]
Progress = Callable[[int, int, str], None]

EVALUATIONS, SAMPLES = 500, 64
"""Spring sets that a search tries, and samples of the tolerances that are drawn for what it found."""
GENERATION, GENERATIONS = 16, 40
"""Sets of a generation of CMA-ES, and generations until it starts anew."""
LATER, MORE = 2, 0.01
"""Generations without a gain, of this in the objective, after the first set that comes flat and clear."""
STAGES = ((8, 4), (3, 8))
"""Sets that are compared by samples of the tolerances, and how many samples each gets: the few best get more."""
STARTS = 31
"""Sets, beside the best, that are rounded to catalogue springs to begin the search for those with."""
TRIES = 6
"""Sets that are simulated precisely until one is confirmed."""
HARDENING = (8, 4)
"""Sets of a generation of the search for robust ones, and samples that each is judged by."""
APART = 0.05
"""Sets count as different where a stiffness differs by this share."""
GOOD = -0.999
"""Objective of a set whose gap is ample."""


@dataclass(frozen=True)
class SpringSet:
    """Springs and what they do.

    stiffnesses : of each hinge, N m/rad. check : the quick check. deployment : the scene itself, precisely; None where
    it was not simulated. robustness : None where no samples were drawn.
    """

    stiffnesses: tuple[float, ...]
    check: Check
    deployment: Deployment | None = None
    robustness: Robustness | None = None

    @property
    def value(self) -> float:
        """The objective, whatever the loops give way."""
        return objective(self.check)

    @property
    def confirmed(self) -> bool:
        """Whether the precise simulation comes flat, certified clear."""
        return self.deployment is not None and deploys(self.deployment)


@dataclass(frozen=True)
class Tuning:
    """What a tuning found.

    start : the springs it began with. best : the confirmed set least likely to collide, or else the one of the least
    objective. rounded : the same of catalogue springs; None where none were asked for.
    evaluations : spring sets and samples checked, recalled of them from a memory. interrupted : by Ctrl-C.
    """

    formulation: Formulation
    tied: tuple[tuple[int, ...], ...]
    start: SpringSet
    best: SpringSet
    rounded: SpringSet | None
    evaluations: int
    recalled: int
    interrupted: bool


def deploys(deployment: Deployment) -> bool:
    """Whether a deployment comes flat, certified clear."""
    return deployment.outcome == "flat" and deployment.clearance is not None and deployment.clearance.kind == "clear"


def tune(
    linkage: Linkage,
    scene: Scene,
    formulation: Formulation | None = None,
    *,
    catalogue: Sequence[float] = (),
    evaluations: int = EVALUATIONS,
    samples: int = SAMPLES,
    spread: Spread | None = None,
    seed: int = 0,
    memory: Memory | None = None,
    progress: Progress | None = None,
) -> Tuning:
    """Choose the stiffness of each hinge, from `SOFTEST` to `STIFFEST`, with dampers in proportion.

    formulation : unless given `constrained`, or `compliant` where only so any set comes flat at first. catalogue :
    stiffnesses of what can be bought (N m/rad). evaluations : spring sets tried, in all but the rounding; half as many
    samples may be drawn to harden what was found. samples : drawn of the tolerances
    in `spread`. memory : takes and gives evaluations, so that the same tuning again goes on where it stopped.
    The same arguments find the same springs.
    """
    tied = tied_hinges(linkage, scene)
    given = stiffnesses_of(linkage, scene)
    start = spread_out([np.clip(given[list(hinges)].mean(), SOFTEST, STIFFEST) for hinges in tied], tied)
    first = _first_generation(start, tied, seed)
    evaluator = _evaluator(linkage, scene, formulation, first, memory)
    search = _Search(evaluator, tied, evaluations, seed, progress or _silent)
    finder = _Finder(search, scene, samples, spread or Spread())
    interrupted = False
    rounded = None
    try:
        search.run(start, first)
        finder.choose(search.candidates())
        if catalogue:
            rounded = finder.round(catalogue_levels(catalogue, STIFFEST))
    except KeyboardInterrupt:
        interrupted = True
    begin = SpringSet(tuple(start.tolist()), evaluator.of_springs([start])[0])
    best = finder.best or search.best_set() or begin
    return Tuning(evaluator.formulation, tied, begin, best, rounded, evaluator.done, evaluator.recalled, interrupted)


def _silent(done: int, total: int, note: str) -> None:
    """Tell nobody."""


def _first_generation(start: Reals, tied: Sequence[tuple[int, ...]], seed: int) -> Reals:
    """Logarithms of stiffnesses, (GENERATION, len(tied)): the start, and a Latin hypercube within the bounds."""
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many checks

    low, high = math.log(SOFTEST), math.log(STIFFEST)
    points = qmc.LatinHypercube(len(tied), rng=seed).random(GENERATION)
    found: Reals = low + (high - low) * points
    found[0] = np.log([start[hinges[0]] for hinges in tied])
    return found


def _evaluator(
    linkage: Linkage, scene: Scene, formulation: Formulation | None, first: Reals, memory: Memory | None
) -> Evaluator:
    """The evaluator of the formulation that is asked for, or of exact closure unless only compliant arrays come flat.

    Exact closure can keep hinges shut that a real array lets go (docs/dynamics.md, known limits).
    """
    if formulation is not None:
        return Evaluator(linkage, scene, formulation, memory)
    exact = Evaluator(linkage, scene, "constrained", memory)
    tied = tied_hinges(linkage, scene)
    sets = [spread_out(np.exp(point), tied) for point in first]
    if any(check.outcome == "flat" for check in exact.of_springs(sets, whole=True)):
        return exact
    other = Evaluator(linkage, scene, "compliant", memory)
    return other if any(check.outcome == "flat" for check in other.of_springs(sets, whole=True)) else exact


def spread_out(values: Sequence[float] | Reals, tied: Sequence[tuple[int, ...]]) -> Reals:
    """Stiffnesses of all hinges from those of the tied groups, to four digits: nobody makes springs more precisely."""
    found = np.empty(sum(map(len, tied)))
    for value, hinges in zip(values, tied, strict=True):
        found[list(hinges)] = float(f"{value:.4g}")
    return found


class _SpentError(Exception):
    """The evaluations are spent."""


@dataclass(frozen=True)
class _Place:
    """A spring set that was seen: logarithms of the tied groups' stiffnesses, and its check."""

    point: Reals
    stiffnesses: Reals
    check: Check
    value: float


class _Search:
    """The search for springs: starts of CMA-ES until one finds what comes flat and clear, or evaluations are spent."""

    def __init__(
        self, evaluator: Evaluator, tied: Sequence[tuple[int, ...]], budget: int, seed: int, progress: Progress
    ) -> None:
        self.evaluator, self.tied, self.budget, self.seed, self.progress = evaluator, tied, budget, seed, progress
        self.spent = 0
        self.best: _Place | None = None
        self.found: list[_Place] = []
        self.success = False
        self.low, self.high = math.log(SOFTEST), math.log(STIFFEST)

    def run(self, start: Reals, first: Reals) -> None:
        """Search; ends quietly when the evaluations are spent."""
        try:
            self.values(first)
            number = 0
            while not self.success:
                self._round(number, first[0])
                number += 1
        except _SpentError:
            pass

    def candidates(self) -> list[Reals]:
        """Sets that came flat and clear, the best first, without those that hardly differ; else the best of all."""
        kept: list[Reals] = []
        for place in sorted(self.found, key=lambda place: place.value):
            if all(np.abs(np.log(place.stiffnesses / other)).max() > APART for other in kept):
                kept.append(place.stiffnesses)
        return kept or ([self.best.stiffnesses] if self.best else [])

    def best_set(self) -> SpringSet | None:
        """The set of the least objective; None where nothing was seen."""
        return None if self.best is None else SpringSet(tuple(self.best.stiffnesses.tolist()), self.best.check)

    def values(self, points: Reals) -> Reals:
        """Objectives of points, (k, len(tied)), checked together; those beyond the bounds count as on them."""
        if self.spent >= self.budget:
            raise _SpentError
        inside = np.clip(points, self.low, self.high)
        sets = [spread_out(np.exp(point), self.tied) for point in inside]
        self.spent += len(sets)
        places = [
            _Place(point, stiffnesses, check, self.evaluator.value(check))
            for point, stiffnesses, check in zip(inside, sets, self.evaluator.of_springs(sets), strict=True)
        ]
        self.found += [place for place in places if place.check.deploys]
        least = min(places, key=lambda place: place.value)
        if self.best is None or least.value < self.best.value:
            self.best = least
        if self._own is None or least.value < self._own.value:
            self._own = least
        self.progress(min(self.spent, self.budget), self.budget, told(self.best.check))
        return np.array([place.value for place in places])

    _own: _Place | None = None

    def _round(self, number: int, start: Reals) -> None:
        """One start of CMA-ES, and from the best set, where that comes flat and clear, up to its largest gap."""
        rng = np.random.default_rng([self.seed, number])
        self._own = None
        known = len(self.found)
        begin = start if number == 0 else rng.uniform(self.low, self.high, len(self.tied))
        self._evolve(begin, rng)
        own: Any = self._own
        if own is not None and own.check.deploys:
            self.success = True
            self._descend(own.point)
            # the middle of the sets that do is further from those that do not
            self.values(np.mean([place.point for place in self.found[known:]], axis=0)[None])

    def _evolve(self, start: Reals, rng: np.random.Generator) -> None:
        strategy = _strategy(start, 0.2, GENERATION, rng)
        idle, least = 0, math.inf
        while not strategy.stop() and idle < LATER:
            points = np.array(strategy.ask())
            values = self.values(points)
            strategy.tell(list(points), values.tolist())
            own: Any = self._own
            if own.value <= GOOD:
                return
            if own.check.deploys:
                idle = 0 if own.value < least - MORE else idle + 1
                least = min(least, own.value)

    def _descend(self, point: Reals) -> None:
        """Down the gradient, a few steps; differences to both sides, all in one call."""
        from scipy.optimize import minimize  # noqa: PLC0415 - takes longer to load than many checks

        step = 0.02

        def value_and_slope(x: Reals) -> tuple[float, Reals]:
            ways = step * np.eye(len(x))
            values = self.values(np.vstack([x, x + ways, x - ways]))
            up, down = values[1 : len(x) + 1], values[len(x) + 1 :]
            return float(values[0]), (up - down) / (2.0 * step)

        bounds = [(self.low, self.high)] * len(point)
        options = {"maxiter": 1, "maxls": 2}
        minimize(value_and_slope, point, jac=True, method="L-BFGS-B", bounds=bounds, options=options)


def _strategy(start: Reals, share: float, population: int, rng: np.random.Generator) -> Any:
    """CMA-ES from a point, with steps that are a share of the bounds to begin with."""
    import cma  # noqa: PLC0415 - takes seconds to load

    low, high = math.log(SOFTEST), math.log(STIFFEST)
    options = {
        "bounds": [low, high],
        "popsize": population,
        "maxiter": GENERATIONS,
        "tolfun": 1e-3,
        "tolx": 1e-2,
        "verbose": -9,
        "randn": lambda *shape: rng.standard_normal(shape),  # else the generator that all of NumPy shares is seeded
        "seed": math.nan,
    }
    return cma.CMAEvolutionStrategy(start, share * (high - low), options)


class _Finder:
    """From sets that were seen to those that are told: confirmed, and the least likely to collide."""

    def __init__(self, search: _Search, scene: Scene, samples: int, spread: Spread) -> None:
        self.search, self.scene, self.samples, self.spread = search, scene, samples, spread
        self.evaluator = search.evaluator
        self.best: SpringSet | None = None

    def choose(self, sets: Sequence[Reals]) -> None:
        """Set `best` to the one of these that is confirmed and the least likely to fail, once hardened."""
        self.best = self._chosen([*self._hardened(sets), *sets])

    def _hardened(self, sets: Sequence[Reals]) -> list[Reals]:
        """Sets near the most robust one of these that are better in the mean over some samples, the best first.

        Among sets that come flat and clear the objective tells little of how near they are to those that do not; its
        mean over samples of the tolerances does.
        """
        clear = [one for one, check in zip(sets, self.evaluator.of_springs(sets), strict=True) if check.deploys]
        if not self.samples or not clear:
            return []
        chances = most_robust(self.evaluator, clear, self.spread, STAGES, self.search.seed)
        first, chance = chances[0]
        if not chance.failures:
            return []
        tied, seed = self.search.tied, self.search.seed
        begin = np.log([clear[first][hinges[0]] for hinges in tied])
        strategy = _strategy(begin, 0.04, HARDENING[0], np.random.default_rng([seed, 1_000_000]))
        found: list[tuple[float, int, Reals]] = []
        least, idle = math.inf, 0
        generations = max(1, self.search.budget // (2 * HARDENING[0] * HARDENING[1]))
        for k in range(generations):
            points = np.array(strategy.ask())
            near = [spread_out(np.exp(point), tied) for point in points]
            means = self._means(near)
            strategy.tell(list(points), means)
            found += [(mean, len(found) + n, one) for n, (mean, one) in enumerate(zip(means, near, strict=True))]
            self.search.progress(self.search.budget, self.search.budget, f"hardening, {k + 1} of {generations}")
            least, idle = (min(means), 0) if min(means) < least - MORE else (least, idle + 1)
            if strategy.stop() or idle == 2:
                break
        middle = spread_out(np.exp(strategy.result.xfavorite), tied)
        return [middle, *(one for _, _, one in sorted(found)[: STAGES[0][0] // 2])]

    def _means(self, sets: Sequence[Reals]) -> list[float]:
        """Mean objective of each set over the same few samples."""
        count = HARDENING[1]
        scenes = [
            scene
            for one in sets
            for scene in sampled(self.evaluator.scene, one, self.spread, count, self.search.seed + 1)
        ]
        values = [self.evaluator.value(check) for check in self.evaluator.of_scenes(scenes)]
        return [float(np.mean(values[k : k + count])) for k in range(0, len(values), count)]

    def round(self, levels: Sequence[float]) -> SpringSet:
        """Catalogue springs near the best set."""
        assert self.best is not None
        tied = self.search.tied
        # sets that were found further off may round to better ones
        near = [np.array(self.best.stiffnesses), *self.search.candidates()[:STARTS]]
        starts = [nearest_levels([one[hinges[0]] for hinges in tied], levels) for one in near]

        def sets(chosen: Sequence[Levels]) -> list[Reals]:
            return [spread_out([levels[level] for level in one], tied) for one in chosen]

        def costs(chosen: list[Levels]) -> list[float]:
            found = [self.evaluator.value(check) for check in self.evaluator.of_springs(sets(chosen))]
            self.search.progress(self.search.budget, self.search.budget, f"catalogue springs, {len(chosen)} sets")
            return found

        seen = descend(starts, len(levels), costs, budget=self.search.budget // 4)
        ranked = sorted(seen, key=lambda chosen: (seen[chosen], chosen))
        clear = [chosen for chosen in ranked if seen[chosen] < 1.0]
        return self._chosen(sets(clear or ranked[:1]))

    def _chosen(self, sets: Sequence[Reals]) -> SpringSet:
        """Of sets, the best first, the confirmed one that is least likely to fail; else the first."""
        total = self.search.budget
        checks = self.evaluator.of_springs(sets)
        places = [SpringSet(tuple(one.tolist()), check) for one, check in zip(sets, checks, strict=True)]
        clear = [place for place in places if place.check.deploys]
        # packed neighbours have two margins between them: where loops give way by more, nothing is certain
        clear = [place for place in clear if self.evaluator.slack(place.check) < 2.0 * STRICT] or clear
        if self.samples and len(clear) > 1:
            self.search.progress(total, total, "comparing by samples")
            springs = [place.stiffnesses for place in clear]
            order = [k for k, _ in most_robust(self.evaluator, springs, self.spread, STAGES, self.search.seed)]
            clear = [clear[k] for k in order] + [place for k, place in enumerate(clear) if k not in order]
        tried: list[SpringSet] = []
        for place in clear[:TRIES]:
            self.search.progress(total, total, "confirming")
            tried.append(self._precise(place))
            if tried[-1].confirmed:
                return self._sampled(tried[-1])
        return (tried or places)[0]

    def _precise(self, place: SpringSet) -> SpringSet:
        """With the deployment in the scene itself, as `hcsearch deploy` simulates it."""
        scene = scene_springs(self.scene, place.stiffnesses)
        return replace(place, deployment=deploy(self.evaluator.linkage, scene, self.evaluator.formulation))

    def _sampled(self, place: SpringSet) -> SpringSet:
        if not self.samples:
            return place
        total = self.search.budget
        self.search.progress(total, total, "drawing samples")
        (found,) = robustness(self.evaluator, [place.stiffnesses], self.spread, self.samples, self.search.seed)
        return replace(place, robustness=found)


def told(check: Check) -> str:
    """A check in a few words."""
    if check.deploys:
        return "flat, clear" if check.gap is None else f"flat, clear by {1e3 * check.gap:.2g} mm"
    verdict = {True: "clear", False: "collides", None: "undecided"}[check.clear]
    return f"{check.outcome}, {verdict}"
