"""Springs that pass a rule on torque margins: least preloads, and springs chosen from a catalogue.

A state has a margin of K at least if some rates v that loops and stops allow have tau . v >= K sum f_i |v_i|. With one
v chosen for each state this is linear in the preloads, so that the least ones follow from a linear program, and springs
of a catalogue from one in whole numbers. Then the best v for the new springs replace the old ones, and so on: the total
falls from round to round, and every round passes. At singular ends the best v are not always found, so that at last
springs are chosen anew until they pass by the v that are found for them alone. For preloads each single state gives a
lower bound of the total: its own least total (docs/explanation/flight_margins.md, 6).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.flight.path_margins import PathRates, best_rates_along
from hcsearch.springs.flight.torque_margin import power_ratios

MAX_DESIGN_ROUNDS = 30
"""Greatest number of rounds of choosing springs and rates in turn."""
MAX_SETTLING_ROUNDS, EXACT_ROUNDS, RAISE = 16, 8, 1.02
"""Greatest number of rounds until springs pass by the rates found for them alone; as springs may come back to earlier
ones, after some rounds each asks for a margin greater by this factor."""
DESIGN_TOLERANCE = 1e-7
"""Relative fall of the total below which rounds end, and by which margins are asked to exceed the rule."""
MAX_CATALOGUE_SECONDS = 20.0
"""Time limit of a program in whole numbers (s); its best springs so far are taken then."""
MAX_BOUNDING_STATES = 12
"""Number of states of least margin that bound the total of preloads from below."""


@dataclass(frozen=True, eq=False)
class SpringRule(ByValue):
    """What springs have to satisfy along a path.

    path : its rates, at k states. friction : (n_hinges,), N m, weighted by the factors of a rule. required : the least
    torque margin. groups : (n_hinges,), the number of the spring of each hinge, from 0 on; hinges with equal numbers
    have equal springs; -1 for hinges whose springs are given. redundant : whether the margin is also required with any
    one spring failed.
    """

    path: PathRates
    friction: Reals
    required: float
    groups: WholeNumbers
    redundant: bool = False

    def __post_init__(self) -> None:
        if self.groups.shape != self.friction.shape or self.groups.max(initial=-1) < 0:
            raise HcsearchError("no hinge has a spring to be chosen: give the group of each hinge, one of 0 or more")
        if not 0.0 < self.required < np.inf:
            raise HcsearchError(f"a required margin of {self.required:g}: give a number above 0")

    @cached_property
    def members(self) -> Reals:
        """Which hinges are in each group, (n_groups, n_hinges), 1 or 0."""
        return np.array(np.arange(self.groups.max() + 1)[:, None] == self.groups, float)

    @cached_property
    def working(self) -> Reals:
        """Which springs work in each case, (n_cases, n_hinges), 1 or 0: first all of them, then all but one."""
        n = len(self.friction)
        return np.r_[np.ones((1, n)), 1.0 - np.eye(n)] if self.redundant else np.ones((1, n))

    def ratios(self, torques: Reals, rates: Reals) -> Reals:
        """Return the ratios of rates, (n_cases, k, n_hinges), in all cases, for torques (k, n_hinges)."""
        pairs = zip(self.working, rates, strict=True)
        return np.array([power_ratios(torques * working, self.friction, own) for working, own in pairs])

    def best_rates(self, torques: Reals, known: Reals | None = None) -> Reals:
        """Return the best rates in all cases, (n_cases, k, n_hinges), for torques (k, n_hinges).

        known : others, which are kept where they are better: the best motions at singular ends are not always found.
        """
        rates = best_rates_along(self.path, torques, self.friction, self.working)
        if known is None:
            return rates
        better = self.ratios(torques, known) > self.ratios(torques, rates)
        return np.where(better[:, :, None], known, rates)


@dataclass(frozen=True, eq=False)
class _Found(ByValue):
    """Amounts of fields of torques, and rates with which they satisfy a rule, (n_cases, k, n_hinges)."""

    amounts: Reals
    rates: Reals


@dataclass(frozen=True, eq=False)
class PreloadDesign(ByValue):
    """Preloads that pass a rule.

    preloads : (n_hinges,), N m. total : their sum, N m. lower_bound : no preloads of a smaller sum pass, N m; equal to
    the total, but for rounding, where the design is proved to be the least. margin : the least torque margin, attained
    by the rates, (n_cases, k, n_hinges): first with all springs, then with each one failed if that is asked for.
    """

    preloads: Reals
    total: float
    lower_bound: float
    margin: float
    rates: Reals


@dataclass(frozen=True, eq=False)
class CatalogueDesign(ByValue):
    """Springs of a catalogue that pass a rule.

    springs : (n_hinges,), the number of the spring of each hinge in the catalogue, -1 where it is given. cost : the sum
    of their costs. margin, rates : as in `PreloadDesign`.
    """

    springs: WholeNumbers
    cost: float
    margin: float
    rates: Reals


def least_preloads(rule: SpringRule, torques: Reals, greatest: float, *, bounded: bool = True) -> PreloadDesign:
    """Find least preloads with which the springs of a path satisfy a rule.

    torques : of the springs without preloads, (k, n_hinges), N m. greatest : the greatest preload, N m. bounded :
    whether the lower bound is computed, which takes longest; else it is 0.
    The preloads pass, and are the least for the rates of the last round; `lower_bound` says how near they are to the
    least of all.
    HcsearchError where no preloads up to the greatest were found to pass.
    """
    fields = np.repeat(rule.members[:, None], len(torques), axis=1)
    together = np.array([1.0, 0.3, 0.1])[:, None] * rule.members.sum(axis=0)
    alone = () if rule.redundant else rule.members  # a spring that fails may not be alone
    starts = [torques + greatest * members for members in (*together, *alone)]
    found = _Program(rule, torques, fields, rule.members.sum(axis=1), greatest).run(starts)
    if found is None:
        raise HcsearchError(
            f"no preloads up to {greatest:g} N m were found with a torque margin of {rule.required:g}: allow greater "
            "ones, or give other springs, or less friction or harness"
        )
    at_hinges = found.amounts @ rule.members
    ratios = rule.ratios(torques + at_hinges, found.rates)
    lower_bound = _least_total(rule, torques, ratios) if bounded else 0.0
    return PreloadDesign(at_hinges, float(at_hinges.sum()), lower_bound, float(ratios.min()), found.rates)


def choose_springs(rule: SpringRule, torques: Reals, catalogue: Reals, costs: Reals) -> CatalogueDesign:
    """Choose springs of a catalogue, one for each group, that satisfy a rule at a low cost.

    torques : of the springs that are given, (k, n_hinges), N m. catalogue : torques of each spring at each hinge, (n,
    k, n_hinges), N m: one without torques stands for no spring. costs : (n,), of a spring.
    The springs pass, and cost least for the rates of the last round. HcsearchError where none were found to pass.
    """
    n_groups, n_springs = len(rule.members), len(catalogue)
    fields = (rule.members[:, None, None] * catalogue).reshape(-1, *torques.shape)
    prices = (rule.members.sum(axis=1)[:, None] * costs).ravel()
    chosen_once = np.repeat(np.eye(n_groups), n_springs, axis=1)
    starts = [torques + rule.members.sum(axis=0) * spring for spring in catalogue]
    found = _Program(rule, torques, fields, prices, 1.0, chosen_once).run(starts)
    if found is None:
        raise HcsearchError(
            f"no springs of the catalogue were found with a torque margin of {rule.required:g}: add stronger ones"
        )
    chosen = np.rint(found.amounts)
    numbers = chosen.reshape(n_groups, n_springs).argmax(axis=1)
    springs = np.where(rule.groups >= 0, numbers[rule.groups], -1)
    ratios = rule.ratios(torques + np.tensordot(chosen, fields, 1), found.rates)
    return CatalogueDesign(springs, float(prices @ chosen), float(ratios.min()), found.rates)


class _Program:
    """A program for the least costly amounts x of fields of torques with which the torques satisfy a rule.

    torques : (k, n_hinges), of x = 0. fields : (n, k, n_hinges). costs : (n,). greatest : the greatest amount.
    chosen_once : rows with row . x = 1 for whole x; amounts are not whole without them.
    """

    def __init__(
        self,
        rule: SpringRule,
        torques: Reals,
        fields: Reals,
        costs: Reals,
        greatest: float,
        chosen_once: Reals | None = None,
    ) -> None:
        self.rule, self.torques, self.fields, self.costs = rule, torques, fields, costs
        self.greatest, self.chosen_once = greatest, chosen_once

    def run(self, starts: list[Reals]) -> _Found | None:
        """Return the best amounts of rounds that begin with the best rates for some torques; None if none pass."""
        ends = [found for start in starts for found in [*self._rounds(start)][-1:]]
        ends.sort(key=lambda found: float(self.costs @ found.amounts))
        return next((settled for found in ends if (settled := self._settled(found)) is not None), None)

    def _settled(self, found: _Found) -> _Found | None:
        """Return amounts that pass by the best rates found for them alone, not by rates of other rounds, or None."""
        for number in range(MAX_SETTLING_ROUNDS):
            torques = self._torques_of(found.amounts)
            rates = self.rule.best_rates(torques)
            if self.rule.ratios(torques, rates).min() >= self.rule.required:
                return _Found(found.amounts, rates)
            raised = self.rule.required * (1.0 + DESIGN_TOLERANCE) * RAISE ** max(0, number - EXACT_ROUNDS)
            amounts = self._least_for(rates, raised)
            if amounts is None:
                return None
            found = _Found(amounts, rates)
        return None

    def _torques_of(self, amounts: Reals) -> Reals:
        torques: Reals = self.torques + np.tensordot(amounts, self.fields, 1)
        return torques

    def _rounds(self, start: Reals) -> Iterator[_Found]:
        """Yield amounts of ever lower cost, each the least for the best rates of the one before."""
        cost, rates = np.inf, self.rule.best_rates(start)
        for _ in range(MAX_DESIGN_ROUNDS):
            amounts = self._least_for(rates, self.rule.required * (1.0 + DESIGN_TOLERANCE))
            if amounts is None or self.costs @ amounts > cost * (1.0 - DESIGN_TOLERANCE):
                return
            yield _Found(amounts, rates)
            cost = float(self.costs @ amounts)
            rates = self.rule.best_rates(self._torques_of(amounts), rates)

    def _least_for(self, rates: Reals, required: float) -> Reals | None:
        """Return the amounts of least cost with which given rates have a ratio in all cases, or None."""
        from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415 - loads slowly

        if not rates.any(axis=2).all():  # a state that no spring leaves
            return None
        rows, least = [], []
        for working, own in zip(self.rule.working, rates, strict=True):
            losses = np.abs(own) @ self.rule.friction
            powers = own * working / np.where(losses > 0.0, losses, 1.0)[:, None]
            rows.append(np.einsum("jkn,kn->kj", self.fields, powers))
            least.append(np.where(losses > 0.0, required, 0.0) - (self.torques * powers).sum(axis=1))
        table, needed = np.concatenate(rows), np.concatenate(least)
        # rows of states at which hinges hardly resist are many times larger, which the solver does not bear
        sizes = np.abs(table).max(axis=1)
        if (needed > sizes * self.greatest * len(self.costs)).any():
            return None
        kept = sizes > 0.0
        constraints = [LinearConstraint(table[kept] / sizes[kept, None], needed[kept] / sizes[kept], np.inf)]
        whole = self.chosen_once is not None
        if self.chosen_once is not None:
            constraints.append(LinearConstraint(self.chosen_once, 1.0, 1.0))
        options = {"time_limit": MAX_CATALOGUE_SECONDS, "mip_rel_gap": 0.0}
        bounds, integrality = Bounds(0.0, self.greatest), np.full(len(self.costs), int(whole))
        found = milp(self.costs, constraints=constraints, bounds=bounds, integrality=integrality, options=options)
        return None if found.x is None else np.asarray(found.x, float)


def _least_total(rule: SpringRule, torques: Reals, ratios: Reals) -> float:
    """Return a lower bound of the sum of preloads that satisfy a rule: the greatest bound of a single state.

    ratios : of a design that satisfies it, (n_cases, k); the states are those where they are least.
    """
    worst = np.argsort(ratios.ravel(), kind="stable")[:MAX_BOUNDING_STATES]
    bounds = [_least_total_at(rule, torques, *divmod(int(state), len(torques))) for state in worst]
    return max(0.0, *bounds)


def _least_total_at(rule: SpringRule, torques: Reals, case: int, state: int) -> float:
    """Return the least sum of preloads with which one state satisfies a rule in one case, for rates of first order.

    All of it is in one group: the one whose least preload alone, times the number of its hinges, is the smallest.
    """
    from scipy.optimize import linprog  # noqa: PLC0415 - loads slowly

    path, working = rule.path, rule.working[case]
    basis = path.rates.bases(np.array([state]), int(path.rates.ranks[state]))[0]
    n, m = basis.shape
    senses = path.senses[state]
    # rates are basis z = opening - folding, both at least 0
    closed = np.c_[basis, -np.eye(n), np.eye(n)]
    opening = [(0.0, 0.0 if sense < 0 else None) for sense in senses]
    folding = [(0.0, 0.0 if sense > 0 else None) for sense in senses]
    bounds = [*[(None, None)] * m, *opening, *folding]
    pull = torques[state] * working
    cost = np.r_[np.zeros(m), rule.required * rule.friction - pull, rule.required * rule.friction + pull]
    least = np.inf
    for members in rule.members:
        power = np.r_[np.zeros(m), members * working, -members * working]
        table, ends = np.r_[closed, power[None]], np.r_[np.zeros(n), 1.0]
        # its presolve takes some programs for neither bounded nor unbounded, and says so on standard output
        found = linprog(cost, A_eq=table, b_eq=ends, bounds=bounds, options={"presolve": False})
        if found.status == 0:
            least = min(least, max(0.0, float(found.fun)) * float(members.sum()))
        elif found.status != 2:  # some rates need no preload, or the solver does not tell
            return 0.0
    return least if np.isfinite(least) else 0.0
