"""The Pareto front: its naive twin, and laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive_ranks import dominates, front

from hcsearch.search.ranking import pareto_front

# Few different values, so that rows tie and dominate each other; some missing.
VALUES = st.one_of(st.none(), st.integers(-2, 3), st.sampled_from([0.1, -np.inf, np.inf, 1e300, 5e-324]))


@st.composite
def tables(draw, values=VALUES):
    """Rows with up to five criteria, and which way is better in each."""
    width = draw(st.integers(1, 5))
    rows = draw(st.lists(st.lists(values, min_size=width, max_size=width), max_size=25))
    return rows, draw(st.lists(st.sampled_from(["higher", "lower"]), min_size=width, max_size=width))


def front_of(rows, better):
    return pareto_front(np.array(rows, float).reshape(len(rows), len(better)), better).tolist()


@given(tables())
def test_front_is_that_of_all_pairs(table):
    rows, better = table
    assert front_of(rows, better) == front(rows, better)


@given(tables(), st.randoms(use_true_random=False))
def test_order_of_rows_and_of_criteria_changes_nothing(table, chance):
    rows, better = table
    order, places = list(range(len(rows))), list(range(len(better)))
    chance.shuffle(order)
    chance.shuffle(places)
    shuffled = front_of([[rows[i][k] for k in places] for i in order], [better[k] for k in places])
    whole = front_of(rows, better)
    assert shuffled == [whole[i] for i in order]


@given(tables(st.one_of(st.none(), st.floats(-1e3, 1e3, width=16))), st.sampled_from([1e-3, 0.25, 60.0, 1e6]))
def test_unit_of_a_criterion_changes_nothing(table, unit):
    rows, better = table
    scaled = [[None if row[0] is None else row[0] * unit, *row[1:]] for row in rows]
    assert front_of(scaled, better) == front_of(rows, better)


@given(tables())
def test_other_direction_is_the_negative(table):
    rows, better = table
    negated = [[None if value is None else -value for value in row] for row in rows]
    other = [{"higher": "lower", "lower": "higher"}[way] for way in better]
    assert front_of(negated, other) == front_of(rows, better)


@given(tables())
def test_whoever_is_not_on_the_front_is_dominated_by_one_who_is(table):
    rows, better = table
    on_front = front_of(rows, better)
    assert any(on_front) == bool(rows)
    best = [row for row, there in zip(rows, on_front, strict=True) if there]
    assert all(
        any(dominates(b, row, better) for b in best) for row, there in zip(rows, on_front, strict=True) if not there
    )


def test_a_missing_value_is_worse_than_any():
    assert front_of([[1.0, None], [1.0, -np.inf], [None, None]], ["higher", "higher"]) == [False, True, False]
    assert front_of([[None], [None]], ["lower"]) == [True, True]
    assert front_of([[2.0, None], [1.0, 5.0]], ["higher", "higher"]) == [True, True]


@pytest.mark.parametrize("shape", [(0, 3), (4, 0)])
def test_without_rows_or_without_criteria_nothing_is_dominated(shape):
    assert pareto_front(np.zeros(shape), ["lower"] * shape[1]).tolist() == [True] * shape[0]


@pytest.mark.parametrize("width", [2, 7])
def test_many_rows_of_which_none_is_dominated(width):
    """What all pairs would take minutes for: 100,000 rows on a sphere, and a copy of each that is a little worse."""
    rng = np.random.default_rng(7)
    rows = np.abs(rng.standard_normal((50_000, width)))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    both = pareto_front(np.concatenate([rows, 0.9999 * rows]), ["higher"] * width)
    assert both[:50_000].all()
    assert not both[50_000:].any()
