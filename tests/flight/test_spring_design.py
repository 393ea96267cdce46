"""Designed springs pass, and less of them does not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import linear_law
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.path_margins import margins_along
from hcsearch.springs.flight.spring_design import SpringRule, choose_springs, least_preloads
from hcsearch.springs.flight.torque_margin import power_ratios
from tests.flight.paths import NAMES, rates_of, springs_of

REQUIRED = 7.5


@cache
def rule_of(name=NAMES[0], **options):
    path = rates_of(name)
    friction = np.full(path.linkage.n_hinges, 0.01)
    return SpringRule(path, friction, REQUIRED, np.arange(path.linkage.n_hinges), **options)


def linear(rule, stiffness=0.1):
    return law_torques([linear_law(stiffness)] * len(rule.friction), rule.path.angles)


def assert_ratios(rule, torques, design):
    """The rates of a design are closed, stops allow them, and have the margin that is claimed."""
    for working, rates in zip(rule.working, design.rates, strict=True):
        opened = np.einsum("krn,kn->kr", rule.path.rates.jacobians, rates)
        assert np.abs(opened).max() < 1e-7 * np.abs(rates).max()
        assert (rule.path.senses * rates >= -1e-7 * np.abs(rates).max()).all()
        assert power_ratios(torques * working, rule.friction, rates).min() >= design.margin


@pytest.mark.parametrize("options", [{}, {"redundant": True}])
def test_least_preloads_pass_and_one_percent_less_does_not(options):
    rule = rule_of(**options)
    torques = linear(rule)
    design = least_preloads(rule, torques, 1.0)
    assert design.margin >= REQUIRED
    assert design.margin == pytest.approx(REQUIRED, rel=1e-5)
    assert design.preloads.sum() == pytest.approx(design.total)
    assert 0.0 < design.lower_bound <= design.total
    assert_ratios(rule, torques + design.preloads, design)
    for hinge in np.flatnonzero(design.preloads > 1e-6):
        less = torques + np.where(np.arange(len(design.preloads)) == hinge, 0.99, 1.0) * design.preloads
        ratios = rule.ratios(less, design.rates)
        assert ratios.min() < REQUIRED
    less = rule.ratios(
        torques + 0.99 * design.preloads, rule.best_rates(torques + 0.99 * design.preloads, design.rates)
    )
    assert less.min() < REQUIRED


@pytest.mark.parametrize("name", NAMES)
def test_less_than_the_lower_bound_never_passes(name):
    """Preloads whose sum is below the lower bound, 100 of them at random, fail at some state."""
    rule, rng = rule_of(name), np.random.default_rng(3)
    torques = linear(rule)
    design = least_preloads(rule, torques, 1.0)
    for _ in range(100):
        shares = rng.dirichlet(np.full(len(rule.friction), rng.choice([0.05, 1.0])))
        preloads = shares * design.lower_bound * rng.uniform(0.9, 0.999)
        assert margins_along(rule.path, torques + preloads, rule.friction).bounds.min() < REQUIRED


def test_redundant_springs_survive_each_failure():
    rule = rule_of(redundant=True)
    torques = linear(rule)
    design = least_preloads(rule, torques, 1.0)
    assert design.total > least_preloads(rule_of(), torques, 1.0).total
    assert (margins_along(rule.path, torques + design.preloads, rule.friction).failed_bounds >= REQUIRED).all()


def test_hinges_of_a_group_have_equal_preloads_and_others_none():
    rule = replace(
        rule_of(), groups=np.where(np.arange(len(rule_of().friction)) < 4, np.arange(len(rule_of().friction)) // 2, -1)
    )
    design = least_preloads(rule, linear(rule, 0.5), 10.0)
    assert design.preloads[0] == design.preloads[1]
    assert design.preloads[2] == design.preloads[3]
    assert not design.preloads[4:].any()
    assert design.total >= least_preloads(rule_of(), linear(rule, 0.5), 10.0).lower_bound


def test_a_catalogue_is_chosen_from():
    rule = rule_of()
    kinds = [(0.0, 0.0), (0.05, 0.02), (0.1, 0.05), (0.1, 0.2), (0.1, 0.5)]
    costs = np.array([0.0, 1.0, 2.0, 3.0, 5.0])
    catalogue = np.array([law_torques([linear_law(*kind)] * len(rule.friction), rule.path.angles) for kind in kinds])
    given = np.zeros(rule.path.angles.shape)
    design = choose_springs(rule, given, catalogue, costs)
    torques = catalogue[design.springs, :, np.arange(len(rule.friction))].T
    assert design.margin >= REQUIRED
    assert design.cost == pytest.approx(costs[design.springs].sum())
    assert_ratios(rule, torques, design)
    cheaper = [k for k in range(len(kinds)) if costs[k] * len(rule.friction) < design.cost]
    for k in cheaper:  # one kind for all hinges
        assert margins_along(rule.path, catalogue[k], rule.friction).margins.min() < REQUIRED


def test_what_cannot_pass_is_refused():
    rule = rule_of()
    with pytest.raises(HcsearchError, match="allow greater ones"):
        least_preloads(rule, linear(rule), 1e-3)
    with pytest.raises(HcsearchError, match="add stronger ones"):
        choose_springs(rule, 0.0 * linear(rule), linear(rule)[None], np.ones(1))
    with pytest.raises(HcsearchError, match="give the group"):
        replace(rule, groups=np.full(len(rule.friction), -1))
    with pytest.raises(HcsearchError, match="give a number above 0"):
        replace(rule, required=0.0)


def test_springs_that_pass_already_need_no_preloads():
    rule = replace(rule_of(), required=0.5)
    design = least_preloads(rule, springs_of(NAMES[0], preload=0.1)[1], 1.0)
    assert (design.total, design.lower_bound) == (0.0, 0.0)
    assert design.margin > 0.5
