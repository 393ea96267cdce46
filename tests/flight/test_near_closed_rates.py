"""Closed rates near the states of a motion, against those of Jacobians there."""

from itertools import combinations

import numpy as np
import pytest

from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from hcsearch.springs.flight.near_closed_rates import NearClosedRates, StateBoxes
from hcsearch.springs.flight.torque_margin import closed_rates
from tests.flight.paths import NAMES
from tests.planned import along, planned

TWO_HOLES = "two holes"


def two_holes():
    """Thirteen squares around two holes, whose two loops share hinges."""
    cells = [(x, y) for x in range(5) for y in range(3) if (x, y) not in ((1, 1), (3, 1))]
    facets = tuple(((x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)) for x, y in cells)
    pairs = [(i, j) for (i, a), (j, b) in combinations(enumerate(cells), 2) if sum(abs(np.subtract(a, b))) == 1]
    creases = {pair: Crease(("top", "bottom")[number % 3 > 0]) for number, pair in enumerate(pairs)}
    return Linkage(Pattern.from_polygons(facets, creases, 0.1))


def linkage_and_state(name):
    """A linkage, and a state in which its closure has full rank."""
    if name == TWO_HOLES:
        linkage = two_holes()
        return linkage, np.random.default_rng(0).uniform(0.5, 2.5, linkage.n_hinges)
    sample = planned(name)
    return sample.linkage, along(sample, np.array([0.5 * sample.proof.motion.times[-1]]))[0]


def near(linkage, state, drift, rest, free):
    jacobian = linkage.closure(state)[1][None]
    boxes = StateBoxes(state[None], drift[None], rest[None])
    return NearClosedRates.of(linkage, jacobian, boxes, free[None], free[None])


def rates_at(linkage, state, rng):
    """Random rates that are closed at a state."""
    jacobian = linkage.closure(state)[1]
    basis = closed_rates(jacobian[None]).bases(np.array([0]), len(jacobian))[0]
    return basis @ rng.normal(size=basis.shape[1])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", [*NAMES, TWO_HOLES])
def test_changed_rates_are_as_near_to_closed_ones_as_stated(name, seed):
    """At states of boxes, closed to no order: the statement is about Jacobians."""
    (linkage, state), rng = linkage_and_state(name), np.random.default_rng(seed)
    rates, n, seen = rates_at(linkage, state, rng), linkage.n_hinges, []
    for widest, share in ((3e-3, 0.0), (1e-4, 0.0), (3e-3, 0.01), (1e-4, 1.0)):
        drift, rest = widest * rng.uniform(-1.0, 1.0, n), share * widest * rng.uniform(0.0, 1.0, n)
        free = np.arange(n) != seed
        found = near(linkage, state, drift, rest, free)
        assert found.firm[0] > 0.0
        (changes,), (off,) = found.changes(np.array([0]), rates[None])
        assert not changes[~free].any()
        for _ in range(100):
            u = rng.uniform(-1.0, 1.0)
            there = linkage.closure(state + u * drift + rest * rng.choice([-1.0, 1.0], n))[1]
            needed = np.linalg.pinv(there * free) @ (there @ (rates + u * changes))
            assert np.linalg.norm(there @ (rates + u * changes - needed)) < 1e-9
            seen.append(np.linalg.norm(needed) / off)
    assert 0.02 < max(seen) <= 1.0 + 1e-9


@pytest.mark.parametrize("name", [*NAMES, TWO_HOLES])
def test_a_drift_leaves_an_error_of_second_order(name):
    (linkage, state), rng = linkage_and_state(name), np.random.default_rng(1)
    rates, drift, off = rates_at(linkage, state, rng), rng.normal(size=linkage.n_hinges), []
    for size in (1e-4, 1e-5):
        found = near(linkage, state, size * drift, 0.0 * drift, np.ones(len(drift), bool))
        off.append(found.changes(np.array([0]), rates[None])[1][0])
    assert off[0] / off[1] == pytest.approx(100.0, rel=0.05)


def test_equations_that_depend_on_each_other_leave_rates_without_a_bound():
    linkage = planned(NAMES[0]).linkage
    still = np.zeros(linkage.n_hinges)
    found = near(linkage, linkage.flat, still, still + 1e-9, still == 0.0)
    assert found.dependent[0]
    assert found.changes(np.array([0]), still[None] + 1.0)[1][0] > 1.0
