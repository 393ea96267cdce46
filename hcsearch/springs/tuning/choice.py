"""The choice among the spring sets of a search: a confirmed set that is least likely to collide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.laws import linear_law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import Labels
from hcsearch.springs.deployment.agreement import Agreement, confirm_deployment
from hcsearch.springs.deployment.deployment_facts import play_facts
from hcsearch.springs.deployment.outcomes import DeploymentCheck, reason_with_clearance
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.springs.tuning.evaluation import (
    DEFAULT_SCENE_SCALES,
    Evaluator,
    SceneScales,
    tied_parts,
    tuning_objective,
    with_parts,
)
from hcsearch.springs.tuning.robustness import Robustness, most_robust, robustness_of_sets, sampled_setups
from hcsearch.springs.tuning.spring_search import (
    MIN_OBJECTIVE_GAIN,
    CatalogueLevels,
    SpringSearch,
    descend_levels,
    nearest_levels,
    stiffnesses_of_groups,
    strategy_from,
)
from hcsearch.springs.tuning.tuning_options import TuningOptions

SAMPLING_STAGES = ((8, 4), (3, 8))
"""Stages of the comparison by samples of the tolerances: number of sets, and samples of each; the few best get more."""
CATALOGUE_START_COUNT = 31
"""Sets, besides the best, that are rounded to catalogue springs as starts of the search of catalogue springs."""
MAX_CONFIRMATIONS = 6
"""Greatest number of sets simulated precisely until one is confirmed."""
ROBUST_SET_COUNT = SAMPLING_STAGES[0][0] // 2 + 1
"""Number of sets that the search for robust ones returns for evaluation."""
ROBUST_SEARCH_SIZES = (8, 4)
"""Sets of a generation of the search for robust ones, and samples by which each is judged."""


@dataclass(frozen=True)
class SpringSet:
    """A spring set and the results of its simulations.

    stiffnesses : of each hinge, N m/rad. dampings : of each hinge, N m s/rad, where dampers were chosen, too; NaN where
        that of the scene stays. damped : the scene with more damping of all hinges, where this is a set of that scene.
    check : the quick check. deployment : the precise simulation in the scene
        itself; None where it was not run. agreement : of the deployment with simulations at tighter tolerances, where
        it becomes flat, as in `hcsearch deploy`. robustness : None where no samples were drawn. scales : of its scene.
    """

    stiffnesses: tuple[float, ...]
    check: DeploymentCheck
    dampings: tuple[float, ...] = ()
    damped: Setup | None = None
    deployment: Deployment | None = None
    robustness: Robustness | None = None
    scales: SceneScales = DEFAULT_SCENE_SCALES
    agreement: Agreement | None = None

    @property
    def parts(self) -> tuple[float, ...]:
        """The springs and dampers as a table of parts."""
        return self.stiffnesses + self.dampings

    def setup_in(self, setup: Setup) -> Setup:
        """Return the scene of a tuning with these springs and dampers."""
        return with_parts(self.damped or setup, self.parts)

    @property
    def value(self) -> float:
        """The objective, without slack for compliant loops."""
        return tuning_objective(self.check, 0.0, self.scales)

    @property
    def confirmed(self) -> bool:
        """Whether the precise simulation becomes flat and is certified clear."""
        return self.deployment is not None and self.deployment.deploys

    @property
    def suffices(self) -> bool:
        """Whether it is confirmed at all tolerances, and no sample fails."""
        return self.confirmed and not self.doubt and not (self.robustness and self.robustness.failures)

    @property
    def doubt(self) -> str:
        """The reason why simulations at tighter tolerances do not confirm the deployment; empty where they do."""
        agreed = self.agreement is None or self.agreement.verdict == "deploys"
        return "" if self.agreement is None or agreed else self.agreement.reason

    @property
    def flat_time(self) -> float | None:
        """The time at which the precise simulation is flat, s, in the digits on which all tolerances agree."""
        if self.agreement is not None:
            return self.agreement.flat_time
        return None if self.deployment is None else self.deployment.flat_time

    def sentence(self, labels: Labels) -> str:
        """Return a sentence on the outcome."""
        check, precise, chance = self.check, self.deployment, self.robustness
        if precise is None:
            text = f"{check.reason(labels)} (by a quick simulation)"
        else:
            reason = precise.reason if self.agreement is None else self.agreement.reason
            text = reason_with_clearance(reason, precise.outcome, precise.clearance, labels)
            clear = precise.clearance is not None and precise.clearance.kind == "clear"
            text += f", {'' if clear else 'not '}certified clear"
            play = play_facts(precise)["play"]
            text += f"; {play}" if play else ""
        if chance is not None:
            low, high = chance.interval
            text += f"; collides in {chance.collisions} of {chance.samples} samples, {low:.0%} to {high:.0%} at 95 %"
            others = chance.failures - chance.collisions
            text += f"; {others} others do not become flat" if others else ""
        return text


class EvaluationShares(NamedTuple):
    """The numbers of evaluations for the search, and for catalogue springs; the rest is for robust sets."""

    search: int
    catalogue: int


def evaluation_shares(options: TuningOptions, spent: int) -> EvaluationShares:
    """Divide the evaluations that are not spent into shares; the search gets one at least."""
    evaluations = options.evaluations - spent
    catalogue = min(max(1, evaluations // 4), evaluations - 1) if options.catalogue else 0
    robust = min(ROBUST_SET_COUNT, evaluations // 8) if options.samples else 0
    return EvaluationShares(max(1, evaluations - robust - catalogue), catalogue)


class SpringSetFinder:
    """Chooses the reported sets among the sets of a search: confirmed ones that are least likely to collide."""

    def __init__(
        self,
        search: SpringSearch,
        setup: Setup,
        options: TuningOptions,
        shares: EvaluationShares,
        tied: Sequence[tuple[int, ...]],
    ) -> None:
        self.search, self.setup, self.options, self.shares, self.tied = search, setup, options, shares, tied
        self.evaluator, self.spread = search.evaluator, options.spread
        self.best: SpringSet | None = None
        self._searched: SpringSet | None = None

    def choose(self, sets: Sequence[Reals], start: SpringSet, damped: SpringSet | None) -> None:
        """Set `best` to a confirmed set that is least likely to fail, among these sets and more robust ones nearby.

        It is never worse than the set at the start of the search, or the one with more damping, if these are confirmed.
        """
        best = self._chosen([*self._more_robust(sets), *sets])
        self._searched = min(best, self.with_samples(start) if start.confirmed else best, key=_risk)
        self.best = self._searched
        if damped is not None and damped.confirmed and (self._searched.doubt or not damped.doubt):
            self.best = min(damped, self._searched, key=_risk)

    def _more_robust(self, sets: Sequence[Reals]) -> list[Reals]:
        """Search sets near the most robust one of these for a better mean over samples; return the best ones in order.

        Among sets that become flat and clear the objective hardly depends on their distance from sets that do not; its
        mean over samples of the tolerances does.
        """
        clear = [
            stiffnesses
            for stiffnesses, check in zip(sets, self.evaluator.of_springs(sets), strict=True)
            if check.deploys
        ]
        if not self.options.samples or not clear:
            return []
        chances = most_robust(self.evaluator, clear, self.spread, SAMPLING_STAGES, self.search.seed)
        first, chance = chances[0]
        if not chance.failures:
            return []
        tied, seed = self.search.tied, self.search.seed
        start = np.log([clear[first][hinges[0]] for hinges in tied])
        rng = np.random.default_rng([seed, 1_000_000])
        strategy = strategy_from(start, 0.04, self.search.bounds, ROBUST_SEARCH_SIZES[0], rng)
        trials: list[tuple[float, int, Reals]] = []
        least_mean, idle = math.inf, 0
        generations = max(1, self.options.evaluations // (2 * ROBUST_SEARCH_SIZES[0] * ROBUST_SEARCH_SIZES[1]))
        for k in range(generations):
            points = np.array(strategy.ask())
            neighbours = [stiffnesses_of_groups(np.exp(point), tied) for point in points]
            means = self._means(neighbours)
            strategy.tell(list(points), means)
            trials += [
                (mean, len(trials) + n, stiffnesses)
                for n, (mean, stiffnesses) in enumerate(zip(means, neighbours, strict=True))
            ]
            self.search.progress(self.search.budget, self.search.budget, f"hardening, {k + 1} of {generations}")
            least_mean, idle = (
                (min(means), 0) if min(means) < least_mean - MIN_OBJECTIVE_GAIN else (least_mean, idle + 1)
            )
            if strategy.stop() or idle == 2:
                break
        mean_set = stiffnesses_of_groups(np.exp(strategy.result.xfavorite), tied)
        remaining = self.options.evaluations - self.evaluator.evaluation_count - self.shares.catalogue
        return [mean_set, *(stiffnesses for _, _, stiffnesses in sorted(trials)[: ROBUST_SET_COUNT - 1])][
            : max(0, remaining)
        ]

    def _means(self, sets: Sequence[Reals]) -> list[float]:
        """Return the mean objective of each set over the same few samples."""
        count = ROBUST_SEARCH_SIZES[1]
        setups = [
            setup
            for stiffnesses in sets
            for setup in sampled_setups(self.evaluator.setup, stiffnesses, self.spread, count, self.search.seed + 1)
        ]
        values = [self.evaluator.value(check) for check in self.evaluator.of_setups(setups)]
        return [float(np.mean(values[k : k + count])) for k in range(0, len(values), count)]

    def round_to_catalogue(self, levels: Sequence[float]) -> SpringSet | None:
        """Round the best set to catalogue springs and dampers by local search; None where no evaluation is left."""
        remaining = self.options.evaluations - self.evaluator.evaluation_count
        if remaining < 1:
            return None
        tied, starts = self.tied, self._catalogue_starts(levels)
        offered = [levels] * len(tied)
        if self.options.damper_catalogue:
            tied = tied_parts(tied)
            offered += [(math.nan, *self.options.damper_catalogue)] * len(offered)

        def sets(chosen: Sequence[CatalogueLevels]) -> list[Reals]:
            values = [[of[level] for of, level in zip(offered, one, strict=True)] for one in chosen]
            return [stiffnesses_of_groups(of_groups, tied) for of_groups in values]

        def costs(chosen: list[CatalogueLevels]) -> list[float]:
            values = [self.evaluator.value(check) for check in self.evaluator.of_springs(sets(chosen))]
            self.search.progress(self.search.budget, self.search.budget, f"catalogue springs, {len(chosen)} sets")
            return values

        budget = min(remaining, max(self.shares.catalogue, CATALOGUE_START_COUNT + 1))
        visited = descend_levels(starts, [len(of) for of in offered], costs, budget=budget)
        ranked = sorted(visited, key=lambda chosen: (visited[chosen], chosen))
        clear = [chosen for chosen in ranked if visited[chosen] < 1.0]
        return self._chosen(sets(clear or ranked[:1]))

    def _catalogue_starts(self, levels: Sequence[float]) -> list[CatalogueLevels]:
        """Return the levels of springs and dampers with which the search among them begins."""
        assert self._searched is not None
        n = len(self._searched.stiffnesses)
        # sets further from the best one may round to better ones
        nearby = [np.array(self._searched.parts), *self.search.candidates()[:CATALOGUE_START_COUNT]]
        springs = [nearest_levels([parts[hinges[0]] for hinges in self.tied], levels) for parts in nearby]
        dampers = self.options.damper_catalogue
        if not dampers:
            return springs
        groups = len(self.tied)
        equal = [(level,) * groups for level in range(1, len(levels))]
        starts = [of + (damper,) * groups for of in (springs[0], *equal) for damper in range(len(dampers), -1, -1)]
        for parts, of in zip(nearby, springs, strict=True):
            own = [self.setup.damping_of(hinges[0], linear_law(parts[hinges[0]])) for hinges in self.tied]
            damping = [parts[n + hinges[0]] if len(parts) > n else own[k] for k, hinges in enumerate(self.tied)]
            nearest = (nearest_levels([c], (own[k], *dampers))[0] for k, c in enumerate(damping))
            starts.append((*of, *nearest))
        return starts

    def _chosen(self, sets: Sequence[Reals]) -> SpringSet:
        """Return the confirmed set that is least likely to fail; if none is confirmed, the first. sets : best first."""
        total = self.search.budget
        checks = self.evaluator.of_springs(sets)
        scales = self.evaluator.scales
        spring_sets = [
            spring_set_of(parts, check, self.setup, scales) for parts, check in zip(sets, checks, strict=True)
        ]
        clear = [spring_set for spring_set in spring_sets if spring_set.check.deploys]
        # packed neighbours have two margins between them: where loops open by more, nothing is certain
        clear = [
            spring_set for spring_set in clear if self.evaluator.slack(spring_set.check) < 2.0 * self.evaluator.margin
        ] or clear
        if self.options.samples and len(clear) > 1:
            self.search.progress(total, total, "comparing by samples")
            springs = [spring_set.parts for spring_set in clear]
            order = [k for k, _ in most_robust(self.evaluator, springs, self.spread, SAMPLING_STAGES, self.search.seed)]
            clear = [clear[k] for k in order] + [spring_set for k, spring_set in enumerate(clear) if k not in order]
        tried: list[SpringSet] = []
        for spring_set in clear[:MAX_CONFIRMATIONS]:
            self.search.progress(total, total, "confirming")
            tried.append(self.with_deployment(spring_set))
            if tried[-1].confirmed:
                return self.with_samples(tried[-1])
        return (tried or spring_sets)[0]

    def with_deployment(self, spring_set: SpringSet) -> SpringSet:
        """Add the precise simulation in the scene itself, as `hcsearch deploy` runs it."""
        return with_deployment(spring_set, self.evaluator, self.setup)

    def with_samples(self, spring_set: SpringSet) -> SpringSet:
        """Add the robustness from samples of the tolerances, if samples are to be drawn."""
        if self.options.samples:
            self.search.progress(self.search.budget, self.search.budget, "drawing samples")
        return with_samples(spring_set, self.evaluator, self.options)


def spring_set_of(
    parts: Reals, check: DeploymentCheck, setup: Setup, scales: SceneScales, damped: Setup | None = None
) -> SpringSet:
    """Return the set of a table of parts; setup : of its tuning."""
    n = len(setup.laws)
    values = tuple(parts.tolist())
    return SpringSet(values[:n], check, values[n:], damped, scales=scales)


def with_deployment(spring_set: SpringSet, evaluator: Evaluator, setup: Setup) -> SpringSet:
    """Add the precise simulation in a setup, as `hcsearch deploy` runs it."""
    deployment = simulate_deployment(evaluator.linkage, spring_set.setup_in(setup), evaluator.formulation)
    return replace(spring_set, deployment=deployment, agreement=confirm_deployment(deployment))


def with_samples(spring_set: SpringSet, evaluator: Evaluator, options: TuningOptions) -> SpringSet:
    """Add the robustness from samples of the tolerances, if samples are to be drawn."""
    if not options.samples:
        return spring_set
    (chance,) = robustness_of_sets(evaluator, [spring_set.parts], options.spread, options.samples, options.seed)
    return replace(spring_set, robustness=chance)


def _risk(spring_set: SpringSet) -> tuple[bool, int]:
    """Return the sort key of a set: confirmed sets first, then by the number of failing samples."""
    return not spring_set.confirmed, 0 if spring_set.robustness is None else spring_set.robustness.failures
